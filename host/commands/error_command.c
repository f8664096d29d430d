/* matrig error: its options. What runs it is host/study/error_run.c, in matrig-study. */
#include "host/commands/studies.h"

#include "host/commands/commands.h"

#define VALUES struct error_request
static const struct command_part parts[] = {
    HELP_ITEM("SCENE", "scene file, JSON, of model report or consistent; the chain has one solver"),
    OPTION_TEXT("--plot", "F", plot,
                "draw error against run time (.svg, .png, .pdf). Errors are in ft, also with --si"),
    HELP_NOTE("\n"
              "Each solver that the scene's model has runs over tolerances or steps, against a "
              "reference that two different\n"
              "methods agree on; when they do not, there is no table: exit 5."),
    HELP_EXAMPLE("matrig error host/scenes/consistent_fig3_7.json --plot error.svg"),
};

const struct command command_error = {
    "error",
    study_start,
    "SCENE [--plot F]",
    "every solver's error against its run time",
    COMMAND_PARTS(parts),
    {1, 1, "SCENE"},
};
