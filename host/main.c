/* matrig: collects, simulates, compares and shows landings on a model landing-mat runway. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/help.h"
#include "host/output.h"
#include "host/store/store.h"

static int fail_usage(const char *what, const char *where)
{
    struct error error = {0};
    error_set(&error, MR_USAGE, "%s: '%s'; see matrig --help", what, where);
    return cli_fail(&error);
}

/* What was printed must have arrived, or the exit code says so. */
static int finish_output(void)
{
    struct error error = {0};
    struct output standard;
    output_begin(&standard, NULL, false, &error);
    return output_end(&standard, &error) == MR_OK ? 0 : cli_fail(&error);
}

static void tell_migration(const char *line)
{
    fprintf(stderr, "matrig: %s\n", line);
}

int main(int argc, char **argv)
{
    struct command_before before = {.help = false};
    struct error error = {0};
    int i = command_begin(argc, argv, &before, &error);
    const struct cli cli = before.cli;
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (before.help)
        help_overview(&command_table);
    if (before.version)
        help_version(&cli);
    if (before.help || before.version)
        return finish_output();
    if (i == argc)
        return fail_usage("no command given", "matrig");
    if (strcmp(argv[i], "help") == 0) {
        int exit_code = help_words(argc - i, argv + i, &command_table, &cli);
        return exit_code ? exit_code : finish_output();
    }
    store_on_migration(cli.quiet ? NULL : tell_migration);
    const struct command *command = help_find(&command_table, argv[i]);
    if (!command)
        return fail_usage("unknown command", argv[i]);
    for (int k = i + 1; k < argc; k++) {
        if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) {
            help_command(command);
            return finish_output();
        }
    }
    int exit_code = command->run(argc - i, argv + i, &cli);
    return exit_code ? exit_code : finish_output();
}
