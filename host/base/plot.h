/* Plots in separate files, drawn by gnuplot (Debian: gnuplot-nox): panels of lines, points and
 * bands over linear or logarithmic axes. The suffix of the file selects SVG, PNG or PDF.
 *
 *     struct plot *plot = plot_new("residuals", 900, 420, 2);
 *     plot_begin_panel(plot, NULL, (struct plot_axis){"station (ft)"},
 *                      (struct plot_axis){"u (in)"});
 *     plot_add_series(plot, &(struct plot_series){.kind = PLOT_LINE, .key = "measured", .x = x,
 *                                                 .y = y, .count = n});
 *     return plot_write(plot, path, error); */
#ifndef MATRIG_HOST_BASE_PLOT_H
#define MATRIG_HOST_BASE_PLOT_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

struct plot;

struct plot_axis {
    const char *label; /* label with its unit; NULL: none */
    /* limits of the axis. Equal: gnuplot computes them from the data. low > high: the axis is
     * reversed */
    double low, high;
    bool is_logarithmic;
};

enum plot_kind {
    PLOT_LINE, /* a line through the points; a NaN interrupts it, and thinning preserves peaks */
    PLOT_POINTS,
    PLOT_LINE_POINTS,
    PLOT_BAND,            /* the area between y and high; a NaN interrupts it */
    PLOT_VERTICAL_LINES,  /* a vertical line through the panel at every x */
    PLOT_HORIZONTAL_LINES /* a horizontal line through the panel at every y */
};

#define PLOT_COLOUR_COUNT 8
#define PLOT_GREY         7u
/* in this order: circle, square, triangle up, diamond, triangle down, pentagon */
#define PLOT_SHAPE_COUNT  6

struct plot_series {
    enum plot_kind kind;
    const char *key; /* text in the key; NULL: the series is not in the key */
    unsigned colour,
        shape; /* index of colour and shape, modulo PLOT_COLOUR_COUNT and PLOT_SHAPE_COUNT */
    bool is_dashed, is_hollow; /* the line is dashed; the shape is not filled */
    const double *x, *y, *y_high;
    size_t count;
};

/* Makes a plot. `columns`: panels side by side. Width and height are in pixels for SVG and PNG; a
 * PDF has 96 pixels per inch. */
struct plot *plot_new(const char *title, unsigned width, unsigned height, unsigned columns);
/* Begins the next panel. Series of later plot_add_series calls belong to it. */
void plot_begin_panel(struct plot *plot, const char *title, struct plot_axis x, struct plot_axis y);
/* Adds a series to the current panel. Copies the values. */
void plot_add_series(struct plot *plot, const struct plot_series *series);
/* Writes the plot into the file and frees it. MR_USAGE: unknown suffix, or the file may not be
 * overwritten. MR_IO: gnuplot is missing or failed. */
enum mr_status plot_write(struct plot *plot, const char *path, struct error *error);

/* Checks before a long computation that plot_write would accept `path` and that gnuplot is
 * installed. `path` NULL: nothing is drawn. `input`: as for output_check. */
enum mr_status plot_check(const char *path, const char *input, struct error *error);

#endif
