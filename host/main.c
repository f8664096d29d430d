/* matrig: collects, simulates, compares and shows landings on a model landing-mat runway. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/cli.h"
#include "host/output.h"

struct command {
    const char *name;
    int (*run)(int argc, char **argv, const struct cli *cli);
    const char *words; /* what follows the name */
    const char *summary;
    const char *details; /* lines for COMMAND --help */
};

static const struct command commands[] = {
    {"log", log_command, "--can LINK --serial LINK --db DB [--for S]", "collect landings from a board",
     "  --can LINK     the board's CAN bus\n"
     "  --serial LINK  the board's serial port; either link may be left out\n"
     "  --db DB        campaign database, made when it does not exist\n"
     "  --for S        stop after S seconds; else at the end of the links, or on Ctrl-C\n"
     "\n"
     "LINK is one of\n"
     "  unix:PATH      a socket on which an emulated board listens (waited for up to 5 s)\n"
     "  file:PATH      a recorded candump log (CAN) or recorded bytes (serial)\n"
     "  can:IFACE      a CAN interface of this computer (SocketCAN), up, at 1 Mbit/s\n"
     "  slcan:TTY[:BAUD]\n"
     "                 a LAWICEL adapter on a serial port, for CAN\n"
     "  serial:TTY[:BAUD]\n"
     "                 a serial port, 8N1, 2000000 baud unless given\n"
     "A device that goes away is waited for, 10 s; what it lost is counted and said.\n"},
    {"board", board_command, "--serial LINK list | read N [-o FILE] [--db DB [--run RUN]] | free N",
     "what a board's black box holds; read it out, free it",
     "  --serial LINK  the board's serial port (see matrig log --help); the board must be idle\n"
     "  list           its records, and how much room there is\n"
     "  read N         record N: --db fills what is missing of its landing in a campaign database (the landing of the same\n"
     "                 board, number and arming, or RUN; made when there is none), -o keeps its pages in a file. When the link broke,\n"
     "                 the same command with -o goes on where it was. Exit 1 when a page cannot be read\n"
     "  free N         give its space back; nothing is ever overwritten that was not freed\n"},
    {"sim", sim_command, "SCENE [--solver S] [--rtol R] [--dt H] [--csv F] [--no-prune] [--progress]", "run a mat scene",
     "  SCENE          scene file, JSON\n"
     "  --solver S     auto (the default) chooses and says why; event, implicit, cvode, rk4, rkgs, hamming for the\n"
     "                 planar models, fixed for the chain. Each answer is checked by a second run\n"
     "  --rtol R       tolerance of the solver; fixed: the error estimate allowed, of the largest movement\n"
     "  --dt H         step, s, of rk4 and fixed\n"
     "  --no-prune     integrate every mat all the time, also those at rest\n"
     "  --csv F        write the history of the mats in u_mats (or all): displacements, heights of their left ends\n"
     "  --progress     say how far the run is\n"
     "Ctrl-C ends a run and leaves what was computed (status interrupted, exit 5).\n"},
    {"error", error_command, "SCENE [--plot F.svg]", "every solver's error against its run time",
     "  SCENE          scene file, JSON\n"
     "  --plot F.svg   draw error against run time. Errors are in ft, also with --si\n"
     "\n"
     "Each solver that the scene's model has runs over tolerances or steps, against a reference that two different\n"
     "methods agree on; when they do not, there is no table: exit 5\n"},
    {"compare", compare_command, "DB RUN [--scene S] [--limit IN]",
     "measured against simulated, per transducer",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  --scene S      scene file that gives the runway; else the model runway\n"
     "  --limit IN     exit 1 when a channel's rms difference exceeds IN inches\n"},
    {"bundle", bundle_command, "DB RUN -o F", "one landing as a campaign of its own, to pass on",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  -o F           where to write it: a database in which the landing is RUN 1; must not be there yet\n"},
    {"replay", replay_command, "DB RUN [--speed max|real] [--elf F] [--board F] [--exact]",
     "a recorded landing through the firmware again, and whether it says the same",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  --speed S      max (the default), or real: by the wall clock\n"
     "  --elf F        firmware image; else firmware/matrig.elf beside matrig\n"
     "  --board F      the emulated board; else matrig-board beside matrig\n"
     "  --exact        every field must be equal, also when another image recorded the landing; else such a landing\n"
     "                 is compared within tolerances, which the output states\n"
     "Exit 1 when anything differs.\n"},
    {"predict", predict_command, "DB RUN", "the predictor of zones and warnings on a recorded landing",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "A row for each change: longest closed zone ahead of the wheel with its 95 % intervals, longest zone that the\n"
     "wheel will meet or push together before it stops, compression ahead, verdict. It knows at each time what the\n"
     "board knew then: edges so far, readings so far, the survey.\n"},
    {"report", report_command, "DB [-o F.html]", "the campaign as one page, with plots",
     "  DB             campaign database\n"
     "  -o F           where to write the page; else the database's name with .html\n"},
    {"export", export_command, "DB RUN --format csv|candump [-o F]", "one landing for other tools",
     "  DB RUN         campaign database and number of the landing in it, from 1\n"
     "  --format csv   time, gear position, displacements and tensions at 1 kHz\n"
     "  --format candump\n"
     "                 the CAN frames as `candump -L` writes them, stamped with board time\n"
     "                 (plus 1000000000 s, so that other tools take it for a date)\n"
     "  -o F           where to write; else standard output\n"},
    {"dbc", dbc_command, "[-o F]", "the CAN messages as a Vector DBC file",
     "  -o F           where to write; else standard output\n"},
    {"scale", scale_command, "[NAME=VALUE... | SCENE] [--to model|prototype] [--n N] [--keep density|modulus] [-o F]",
     "quantities and scenes between model and prototype",
     "  NAME=VALUE     a quantity, by name or symbol; without any, all ratios are listed. Dimensionless terms that the\n"
     "                 given quantities make up are shown for both sides\n"
     "  SCENE          scene file, JSON: every key is scaled, defaults that scale are written out\n"
     "  --to SIDE      prototype (the default: what is given is the model's) or model\n"
     "  --n N          prototype length / model length; else 7\n"
     "  --keep density the 1/7 model's rule: forces by n^3 (the default)\n"
     "  --keep modulus the pilot model's rule: forces by n^2\n"
     "  -o F           where to write the scene; else standard output\n"
     "Units are those of the scene keys (ft, lb, slug, s), also with --si.\n"},
    {"params", params_command, "READINGS [-o F]", "readings of simple tests to scene parameters",
     "  READINGS       JSON with any of these tests; a reading is a number, {\"value\": V, \"error\": E} or\n"
     "                 {\"readings\": [...], \"error\": E}, with standard errors\n"
     "                 inertia     weight_lb, spacing_ft and cord_ft of two cords, period_s of turning: W and I\n"
     "                 tension     joint_in, slope_lb_in_in; or joint_in, strip_in, lists force_lb, stretch_in: KL\n"
     "                 hinge       lists angle_deg, moment_ft_lb [, strip_in, joint_in]: KT and TAD_deg\n"
     "                 pull        pull_lb, weight_lb: f\n"
     "                 deflection  load_lb, deflection_in [, mats]: KV\n"
     "  -o F           write the parameters as the beginning of a scene\n"
     "Units are those of the scene keys (ft, lb, slug, s), also with --si.\n"},
};

#define COMMAND_COUNT (sizeof commands / sizeof commands[0])

static void print_help(void)
{
    puts("usage: matrig [--json] [--quiet] [--si] COMMAND ...\n");
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        printf("  %-8s %s\n", commands[i].name, commands[i].summary);
    puts("\n"
         "  --json   the result as one JSON object on standard output\n"
         "  --quiet  no progress and no notes\n"
         "  --si     metres, seconds and newtons instead of feet, inches and pounds\n"
         "\n"
         "matrig COMMAND --help tells more about a command.\n"
         "Exit: 0 ok, 1 a comparison or limit failed, 2 usage, 3 input/output or device,\n"
         "4 malformed or truncated input, 5 numerics refused or failed.");
}

static int print_command_help(const struct command *command)
{
    printf("usage: matrig [--json] [--quiet] [--si] %s %s\n\n%s.\n\n%s", command->name, command->words,
           command->summary, command->details);
    return 0;
}

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
    return output_close(stdout, NULL, &error) == MR_OK ? 0 : cli_fail(&error);
}

int main(int argc, char **argv)
{
    struct cli cli = {0};
    int i = 1;
    for (; i < argc && argv[i][0] == '-'; i++) {
        if (strcmp(argv[i], "--help") == 0 || strcmp(argv[i], "-h") == 0) {
            print_help();
            return 0;
        } else if (strcmp(argv[i], "--json") == 0) {
            cli.json = true;
        } else if (strcmp(argv[i], "--quiet") == 0) {
            cli.quiet = true;
        } else if (strcmp(argv[i], "--si") == 0) {
            cli.si = true;
        } else {
            return fail_usage("unknown option", argv[i]);
        }
    }
    if (i == argc)
        return fail_usage("no command given", "matrig");
    for (size_t c = 0; c < COMMAND_COUNT; c++) {
        if (strcmp(argv[i], commands[c].name) != 0)
            continue;
        for (int k = i + 1; k < argc; k++) {
            if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0)
                return print_command_help(&commands[c]);
        }
        int exit_code = commands[c].run(argc - i, argv + i, &cli);
        return exit_code ? exit_code : finish_output();
    }
    return fail_usage("unknown command", argv[i]);
}
