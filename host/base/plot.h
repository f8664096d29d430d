/* Plots in separate files, drawn by gnuplot (Debian: gnuplot-nox): panels of lines, points and
 * bands over linear or logarithmic axes. The suffix of the file selects SVG, PNG or PDF.
 *
 *     struct plot *plot = plot_new("residuals", 900, 420, 2);
 *     plot_panel(plot, NULL, (struct plot_axis){"station (ft)"}, (struct plot_axis){"u (in)"});
 *     plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE, .key = "measured", .x = x, .y = y,
 *                                           .count = n});
 *     return plot_write(plot, path, error); */
#ifndef MATRIG_HOST_BASE_PLOT_H
#define MATRIG_HOST_BASE_PLOT_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

struct plot;

struct plot_axis {
    const char *label; /* label with its unit; NULL: none */
    double low, high;  /* equal: computed from the data; low > high: the axis is reversed */
    bool log;
};

enum plot_kind {
    PLOT_LINE, /* a NaN breaks the line; spikes survive thinning */
    PLOT_POINTS,
    PLOT_LINE_POINTS,
    PLOT_BAND,  /* the area between y and high; a NaN breaks it */
    PLOT_RULES, /* a vertical line through the panel at every x */
    PLOT_LEVELS /* a horizontal line through the panel at every y */
};

#define PLOT_COLOURS 8
#define PLOT_GREY    7u
#define PLOT_SHAPES  6 /* circle, square, triangle up, diamond, triangle down, pentagon */

struct plot_series {
    enum plot_kind kind;
    const char *key;        /* NULL: the series is not in the key */
    unsigned colour, shape; /* modulo PLOT_COLOURS and PLOT_SHAPES */
    bool dashed, hollow;    /* a dashed line; a shape that is not filled */
    const double *x, *y, *high;
    size_t count;
};

/* Makes a plot. `columns`: number of panels in a row. Pixels apply to SVG and PNG; a PDF has 96
 * pixels per inch. */
struct plot *plot_new(const char *title, unsigned width, unsigned height, unsigned columns);
/* Begins the next panel; later plot_draw calls add to it. */
void plot_panel(struct plot *plot, const char *title, struct plot_axis x, struct plot_axis y);
/* Adds a series to the panel. Copies the values. */
void plot_draw(struct plot *plot, const struct plot_series *series);
/* Writes the plot into the file and frees it. MR_USAGE: unknown suffix, or the file may not be
 * overwritten. MR_IO: gnuplot is missing or failed. */
enum mr_status plot_write(struct plot *plot, const char *path, struct error *error);

/* Checks, before work that takes long, that plot_write would accept `path` and that gnuplot is
 * installed. `path` NULL: nothing is drawn. `input`: as for output_check. */
enum mr_status plot_check(const char *path, const char *input, struct error *error);

#endif
