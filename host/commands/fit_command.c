/* matrig fit: its options. What runs it is host/study/fit_run.c, in matrig-study. */
#include "host/commands/studies.h"

#include "host/commands/commands.h"

#define VALUES struct fit_request
static const struct command_part parts[] = {
    HELP_ITEM("DB [RUN...]",
              "campaign database and landings in it; else all whose motion is known. Exit 1 when "
              "the model cannot be the data's"),
    OPTION_TEXT("--scene", "S", scene,
                "scene file that gives the runway (model chain) and the priors' values; else the "
                "model runway"),
    OPTION_TEXT("--fit", "NAMES", fitted,
                "of gap,grit,f,share,KL: these are fitted, the others stay as they are; else all"),
    OPTION_TEXT("--prior", "NAME=V:E,...", prior,
                "what is known beforehand: value and standard error (lb, in, lb/ft). Else grit, KL "
                "and an unsurveyed gap are\n"
                "the scene's, known to 50 %, f to 20 %, share 1/12 to 15 %, a surveyed gap the "
                "survey's to 3 %"),
    OPTION_WHOLE("--draws", "N", draws, FIT_LEAST_DRAWS, 1e5, 300.0,
                 "simulated data sets a round, at least {low}; else {standard}"),
    OPTION_WHOLE("--seed", "N", seed, 0.0, 1e9, 1.0,
                 "of what is drawn; else {standard}. The same seed gives the same answer"),
    OPTION_TEXT("--plot", "F", plot, "a plot of the residuals, SVG, PNG or PDF (gnuplot)"),
    OPTION_TEXT("-o", "F", out_scene, "the scene with the fitted values"),
    OPTION_FORCE(force),
    HELP_EXAMPLE("matrig fit campaign.db 1 --fit grit,f --prior f=0.5:0.05 --plot fit.svg"),
};

const struct command command_fit = {
    "fit",
    study_start,
    "DB [RUN...] [--scene S] [--fit NAMES] [--prior NAME=V:E,...] [--draws N] [--seed N] "
    "[--plot F] [-o F] [--force]",
    "gaps, resistance, friction, thrust share and stiffness from landings, with their errors",
    COMMAND_PARTS(parts),
    {1, 1 + FIT_RUNS_MAX, "DB [RUN...]"},
};
