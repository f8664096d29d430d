/* The command matrig demo: starts host/demo.sh and passes it the programs and files that it
 * needs. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/base/data_dir.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"

struct request {
    const char *folder, *elf;
};

static int demo_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.folder = NULL};
    struct error error = {0};
    char script[PATH_MAX], matrig[PATH_MAX], board[PATH_MAX], image[PATH_MAX], runs[PATH_MAX];
    if (command_parse(&command_demo, argc, argv, cli, &r, &r.folder, &error) != MR_OK)
        return cli_fail(&error);
    data_dir_find(DATA_DEMO_SCRIPT, script, sizeof script);
    data_dir_find(DATA_BOARD_PROGRAM, board, sizeof board);
    data_dir_find(DATA_FIRMWARE, image, sizeof image);
    data_dir_find(DATA_RECORDED_LANDINGS, runs, sizeof runs);
    data_dir_program_path(matrig, sizeof matrig);
    const char *words[20] = {"sh",   script, r.folder ? r.folder : "matrig-demo",
                             matrig, board,  r.elf ? r.elf : image,
                             runs};
    program_global_options(words + 7, cli);
    fflush(NULL);
    execv("/bin/sh", (char **)words);
    error_set(&error, MR_IO, "cannot start /bin/sh: %s", strerror(errno));
    return cli_fail(&error);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DIR", "folder for campaign.db and report.html, created if missing; default: "
                     "./matrig-demo. An existing campaign is not overwritten (exit 2)"),
    OPTION_TEXT("--elf", "F", elf, "firmware image; default: the one installed with matrig"),
    HELP_NOTE("Plays a test day with synthetic landings on matrig-board: two landings, a survey, "
              "and advice against the plan of the next landing. That landing is then played three "
              "times: as planned, as advised, and with hard braking from touchdown."),
    HELP_EXAMPLE("matrig demo first"),
};

const struct command command_demo = {
    "demo",
    demo_command,
    "[DIR] [--elf F]",
    "play a test day on the emulated board: landings, survey, advice, a warning, the report",
    COMMAND_PARTS(parts),
    {0, 1, "DIR"},
};
