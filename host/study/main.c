/* The program matrig-study: the commands of matrig that need GSL or SUNDIALS, and those that run
 * many simulations. Users type matrig, which starts this program (host/commands/studies.h). matrig
 * handles --help and help itself. */
#include <stdio.h>
#include <string.h>

#include "common/version.h"
#include "host/commands/commands.h"
#include "host/base/data_dir.h"
#include "host/commands/program.h"
#include "host/commands/studies.h"

static int (*find_study_command(const char *name))(int argc, char **argv, const struct cli *cli)
{
    static const struct {
        const struct command *command;
        int (*run)(int argc, char **argv, const struct cli *cli);
    } studies[] = {
        {&command_study, study_command},
        {&command_error, error_command},
        {&command_fit, fit_command},
        {&command_sweep, sweep_command},
    };
    for (size_t i = 0; i < sizeof studies / sizeof studies[0]; i++) {
        if (strcmp(studies[i].command->name, name) == 0)
            return studies[i].run;
    }
    /* matrig-study also runs sim, because only this program has all solvers */
    return strcmp(command_sim.name, name) == 0 ? command_sim.run : NULL;
}

/* Refuses to run for a matrig of another version, which may use the same arguments differently. */
static enum mr_status check_version(const char *version, const char *matrig, struct error *error)
{
    if (strcmp(version, VERSION_TEXT) == 0)
        return MR_OK;
    return error_set(
        error, MR_USAGE,
        "matrig-study is version %s, but %s is version %s; install both from one build "
        "(make install)",
        VERSION_TEXT, matrig, version);
}

static int run_study(int argc, char **argv)
{
    struct global_options before = {.help = false};
    struct error error = {0};
    if (argc > 3 && strcmp(argv[1], STUDY_STARTED_BY) == 0) {
        if (check_version(argv[2], argv[3], &error) != MR_OK)
            return cli_fail(&error);
        data_dir_set_program(argv[3]);
        argc -= 3;
        argv += 3;
    }
    int i = command_parse_global_options(argc, argv, &before, &error);
    cli_begin(&before.cli);
    if (error.status != MR_OK)
        return cli_fail(&error);
    int (*run)(int argc, char **argv,
               const struct cli *cli) = i < argc ? find_study_command(argv[i]) : NULL;
    if (!run) {
        error_set(&error, MR_USAGE,
                  "unknown study: '%s'; run matrig, which starts matrig-study when needed",
                  i < argc ? argv[i] : "matrig-study");
        return cli_fail(&error);
    }
    return program_run(run, argc - i, argv + i, &before.cli);
}

int main(int argc, char **argv)
{
    return cli_end(run_study(argc, argv));
}
