#include "host/help.h"

#include <stdio.h>
#include <string.h>

#include "firmware/version.h"

void help_overview(const struct command_table *table)
{
    puts("usage: matrig [--json] [--quiet] [--si] COMMAND ...\n");
    for (size_t i = 0; i < table->count; i++)
        printf("  %-9s %s\n", table->commands[i].name, table->commands[i].summary);
    puts("\n"
         "  --json    the result as one JSON object on standard output\n"
         "  --quiet   no progress and no notes\n"
         "  --si      metres, seconds and newtons instead of feet, inches and pounds\n"
         "  --version\n"
         "\n"
         "matrig COMMAND --help tells more about a command, with an example; man matrig has it all.\n"
         "Exit: 0 ok, 1 a comparison or limit failed, 2 usage, 3 input/output or device,\n"
         "4 malformed or truncated input, 5 numerics refused or failed.\n"
         "NO_COLOR=1 turns colours off.\n"
         "\n"
         "Example: matrig log --can can:can0 --serial serial:/dev/ttyUSB0 --db campaign.db && matrig report campaign.db");
}

void help_command(const struct command *command)
{
    printf("usage: matrig [--json] [--quiet] [--si] %s %s\n\n%s.\n\n%s", command->name, command->words, command->summary, command->details);
}

void help_version(const struct cli *cli)
{
    char version[40];
    snprintf(version, sizeof version, "%d.%d.%d", FIRMWARE_MAJOR, FIRMWARE_MINOR, FIRMWARE_PATCH);
    if (cli->json)
        cli_print_json(json_pack("{s:s}", "version", version), 0);
    else
        printf("matrig %s\n", version);
}

static const struct command *find(const struct command_table *table, const char *name)
{
    for (size_t i = 0; i < table->count; i++) {
        if (strcmp(table->commands[i].name, name) == 0)
            return &table->commands[i];
    }
    return NULL;
}

/* The table for a program. */
static int print_json(const struct command_table *table, const struct command *only)
{
    json_t *list = json_array();
    for (size_t i = 0; i < table->count; i++) {
        const struct command *c = &table->commands[i];
        if (!only || only == c)
            json_array_append_new(list, json_pack("{s:s,s:s,s:s,s:s}", "name", c->name, "words", c->words, "summary", c->summary,
                                                  "details", c->details));
    }
    return cli_print_json(json_pack("{s:o}", "commands", list), 0);
}

int help_words(int argc, char **argv, const struct command_table *table, const struct cli *cli)
{
    struct error error = {0};
    bool man = false, bash = false, help = false;
    const char *words[1] = {NULL};
    const struct cli_option options[] = {{"--man", NULL, &man}, {"--bash", NULL, &bash}, {"--help", NULL, &help}};
    const struct command *command = NULL;
    if (cli_parse(argc, argv, options, sizeof options / sizeof options[0], words, 0, 1, "", &error) != MR_OK)
        return cli_fail(&error);
    if (words[0])
        command = find(table, words[0]);
    if ((words[0] && !command) || man + bash + !!command > 1) {
        error_set(&error, MR_USAGE, words[0] && !command ? "unknown command: '%s'; see matrig --help" : "too much at once: matrig help%s; give "
                  "a command, --man or --bash", words[0] && !command ? words[0] : "");
        return cli_fail(&error);
    }
    if (man)
        help_man(table);
    else if (bash)
        help_bash(table);
    else if (cli->json)
        return print_json(table, command);
    else if (command)
        help_command(command);
    else
        help_overview(table);
    return 0;
}
