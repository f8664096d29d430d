/* matrig study: its options. What runs it is host/study/study_run.c, in matrig-study. */
#include "host/commands/studies.h"

#include "host/landing_series/series.h"
#include "host/commands/commands.h"

#define VALUES struct study_request
static const struct command_part parts[] = {
    HELP_ITEM(
        "FILE",
        "study file, JSON (host/landing_series/README.md): runway, landings, modifications, seeds"),
    OPTION_WHOLE("--seeds", "N", seeds, 1.0, SERIES_SEEDS_MAX, 0.0,
                 "that many seeds from the file's first one on, instead of the file's number"),
    OPTION_CHOICE(
        "--ground", "G", ground, "ground", "weightless|elastic",
        "weightless: the gear has thrust and no weight. elastic: axle lines with weight on "
        "ground that gives way (the file's key elastic). Else as the file says"),
    OPTION_TEXT("--plot", "F", plot,
                "draw movement and buckles along the runway (.svg, .png, .pdf)"),
    HELP_NOTE("Results are distributions over the seeds: median and 5th to 95th percentile."),
    HELP_EXAMPLE(
        "matrig study host/landing_series/series/friction.json --ground elastic --seeds 4"),
    HELP_EXAMPLE("matrig study host/landing_series/series/standard.json --plot standard.svg"),
};

const struct command command_study = {
    "study",
    study_start,
    "FILE [--seeds N] [--ground weightless|elastic] [--plot F]",
    "a series of landings on an ensemble of runways: which one survives",
    COMMAND_PARTS(parts),
    {1, 1, "FILE"},
};
