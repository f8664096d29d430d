/* matrig: record, simulate, compare and display landings on a model landing-mat runway. */
#include <string.h>

#include "host/commands/commands.h"
#include "host/base/help.h"
#include "host/commands/program.h"

static int fail_usage(const char *what, const char *where)
{
    struct error error = {0};
    error_set(&error, MR_USAGE, "%s: '%s'; see matrig --help", what, where);
    return cli_fail(&error);
}

static int run(int argc, char **argv)
{
    struct global_options before = {.help = false};
    struct error error = {0};
    int i = command_parse_global_options(argc, argv, &before, &error);
    const struct cli cli = before.cli;
    cli_begin(&cli);
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (before.help)
        help_print_overview(&command_table);
    if (before.version)
        help_print_version(&cli);
    if (before.help || before.version)
        return program_end(0);
    if (i == argc)
        return fail_usage("no command given", "matrig");
    if (strcmp(argv[i], "help") == 0)
        return program_end(help_run(argc - i, argv + i, &command_table, &cli));
    const struct command *command = help_find(&command_table, argv[i]);
    if (!command) {
        help_refuse_unknown(&command_table, argv[i], &error);
        return cli_fail(&error);
    }
    /* an older name is replaced, because matrig-study knows only the present names; the cast is
     * safe because argv[i] is only read */
    argv[i] = (char *)command->name;
    for (int k = i + 1; k < argc; k++) {
        if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) {
            help_print_command(command);
            return program_end(0);
        }
    }
    return program_run(command->run, argc - i, argv + i, &cli);
}

int main(int argc, char **argv)
{
    return cli_end(run(argc, argv));
}
