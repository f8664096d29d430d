/* Figures 3.6 to 3.12 of the 1973 report, redrawn as its text describes them, by R* and by the best
 * reading that was found. */
#ifndef MATRIG_TESTS_FIGURES_FIGURES_H
#define MATRIG_TESTS_FIGURES_FIGURES_H

#include "tests/figures/found.h"

/* Each figure to FOLDER/fig3_N.svg (R*) and FOLDER/best3_N.svg. */
enum mr_status draw_figures(const char *folder, const struct found *found, struct error *error);

#endif
