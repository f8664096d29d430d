#include "host/commands/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "host/base/command.h"
#include "host/base/output.h"

int program_end(int exit_code)
{
    struct error error = {0};
    struct output standard;
    if (exit_code != 0)
        return exit_code;
    output_begin(&standard, NULL, &error);
    return output_end(&standard, &error) == MR_OK ? 0 : cli_fail(&error);
}

int program_run(int (*run)(int argc, char **argv, const struct cli *cli), int argc, char **argv,
                const struct cli *cli)
{
    return program_end(run(argc, argv, cli));
}

static struct store *campaign;

static void close_campaign(void)
{
    store_close(campaign);
}

struct store *program_open_campaign(const char *db, enum store_mode mode)
{
    store_open(db, mode, &campaign, fatal);
    atexit(close_campaign);
    return campaign;
}

bool program_is_new_campaign(const char *db)
{
    if (access(db, F_OK) == 0)
        return false;
    if (!cli_confirm("%s does not exist. Begin a new campaign?", db))
        error_set(fatal, MR_USAGE, "the campaign %s does not exist, and none was created", db);
    return true;
}

void program_note_new_campaign(const struct cli *cli, const char *db)
{
    cli_note(cli, "a new campaign: %s", db);
}

struct store *program_open_or_create_campaign(const struct cli *cli, const char *db)
{
    bool is_new = program_is_new_campaign(db);
    struct store *store = program_open_campaign(db, STORE_CREATE);
    if (is_new)
        program_note_new_campaign(cli, db);
    return store;
}

size_t program_global_options(const char *words[], const struct cli *cli)
{
    struct global_options before = {.cli = *cli};
    size_t count = 0;
    for (size_t i = 0; i < command_matrig.part_count; i++) {
        const struct command_option *option = &command_matrig.parts[i].option;
        if (option->name && *(const bool *)((const char *)&before + option->offset))
            words[count++] = option->name;
    }
    return count;
}
