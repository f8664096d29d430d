/* Plots of a page, as data that charts.js draws. A figure consists of adjacent plots with a common
 * key, which are zoomed together. The page contains the data once, thinned: for each pixel column
 * of a plot the minimum and the maximum are kept, at their measured times. */
#ifndef MATRIG_HOST_REPORT_CHART_H
#define MATRIG_HOST_REPORT_CHART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host/base/units.h"

/* time before touchdown and after the stop that traces show */
#define CHART_TIME_BEFORE_TOUCHDOWN_S 0.3
#define CHART_TIME_AFTER_STOP_S       0.6
#define CHART_TIME_LABEL              "time since touchdown (s)"
#define CHART_LABEL_SIZE              60u

#define FIGURE_SHAPE_KINDS 15 /* the kinds of figure_add_shape, and an end */
struct figure {
    FILE *out;
    bool si;
    const struct unit *x, *y;                      /* units of the current plot */
    unsigned plots_per_row, plot_count, height_px; /* height_px: height of all plots together */
    bool has_items; /* an item was written, so the next one must be preceded by a comma */
    const char *shape_kind[FIGURE_SHAPE_KINDS]; /* kinds of the shapes written so far */
};

/* How the y ranges of plots are chosen. */
enum figure_range {
    FIGURE_RANGE_PER_PLOT,
    FIGURE_RANGE_SHARED = 1,
    FIGURE_RANGE_WITH_ZERO = 2 /* the range includes 0 */
};

/* Begins a figure. `what`: its text alternative (static). `columns`: number of plots in a row if
 * there is room. Call figure_end at its end. */
struct figure figure_begin(FILE *out, bool si, const char *what, unsigned columns, unsigned range);
/* Ends a figure. `caption` is HTML. `keys`: kind and text of shapes in turn, ending with NULL;
 * kinds that the figure does not have are left out. */
void figure_end(struct figure *figure, const char *const *keys, const char *caption, ...)
    __attribute__((format(printf, 3, 4)));

/* Axes of a plot. Values are passed in the report's units; the page shows them in the units that
 * the reader selects. If both limits are 0, the range is computed from the data. */
struct chart_axes {
    const char *title, *x, *y;
    enum unit_kind x_unit, y_unit; /* units of the axes; UNIT_NUMBER: the name contains the unit */
    double x_low, x_high, y_low, y_high;
    unsigned height_px;
    const char *(*tick_name)(void *context, size_t i); /* returns the name at y = i + 0.5 */
    void *context;
    size_t tick_count;
};
/* Begins a plot, which ends at the next figure_begin_plot or at figure_end. */
void figure_begin_plot(struct figure *figure, const struct chart_axes *axes);

struct chart_series {
    const char *name; /* name in the key; NULL: none */
    unsigned style;   /* index of colour, dash pattern and mark */
    /* "line", "marked" (a line with a few marks), "marks" (one at each point), "points", "dots",
     * "whiskers" (marks with their interval), "apart" (whiskers, shifted so that different styles
     * do not overlap), "sim", "faint". */
    const char *kind;
    const double *x, *y;      /* coordinates; x must rise or fall throughout; NaN: a gap */
    const double *half_width; /* half width of the interval or band at each point; NULL: none */
    size_t count;
};
void figure_add_series(struct figure *figure, const struct chart_series *series);
/* Adds a shape. `kind` (static): "closed", "behind", "reported", "warned", "band", "mark", "stop",
 * "lead", "sensor", "seen", "damaged", "repaired", "failed", "passed". NaN in x0 or y0: the shape
 * extends over the whole axis. */
void figure_add_shape(struct figure *figure, const char *kind, double x0, double x1, double y0,
                      double y1, const char *text);

#endif
