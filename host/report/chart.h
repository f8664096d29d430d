/* Plots of a page, as data: charts.js draws them. A figure holds plots beside each other, which
 * share keys and zoom. What the page shows is here once, thinned: of a column of a plot the least
 * and the greatest value stay, where they were measured. */
#ifndef MATRIG_HOST_REPORT_CHART_H
#define MATRIG_HOST_REPORT_CHART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host/base/units.h"

#define CHART_BEFORE_S  0.3 /* how long before touchdown and after the stop traces are shown */
#define CHART_SETTLED_S 0.6
#define CHART_TIME      "time since touchdown (s)"
#define CHART_RUNWAY_FT 120.0
#define CHART_LABEL     60u

struct figure {
    FILE *out;
    bool si;
    const struct unit *x, *y;           /* of the plot */
    unsigned columns, plots, height_px; /* height: of all plots together */
    bool items;                         /* one was written: a comma comes before the next */
};

/* How plots get their range of y. */
enum figure_range { FIGURE_EACH, FIGURE_SHARED = 1, FIGURE_ZERO = 2 /* 0 is in it */ };

/* `what`: for who cannot see it; static text. `columns`: plots beside each other where there is
 * room. Ends with figure_end. */
struct figure figure_begin(FILE *out, bool si, const char *what, unsigned columns, unsigned range);
/* Caption is HTML. `keys`: kind and words of shapes, in turn, NULL at the end. */
void figure_end(struct figure *figure, const char *const *keys, const char *caption, ...)
    __attribute__((format(printf, 3, 4)));

/* What a plot is given is in the report's units, the page has it in the reader's. Ranges of 0 to 0
 * follow from the data. */
struct chart_axes {
    const char *title, *x, *y;
    enum unit_kind x_unit, y_unit; /* UNIT_NUMBER: x or y names it */
    double x_low, x_high, y_low, y_high;
    unsigned height_px;
    const char *(*tick)(void *context, size_t i); /* names at y of i + 0.5 */
    void *context;
    size_t ticks;
};
/* Until the next one, or figure_end. */
void figure_plot(struct figure *figure, const struct chart_axes *axes);

struct chart_series {
    const char *name; /* of its key; NULL: none */
    unsigned look;    /* colour, dash and mark */
    /* "line", "marked" (with a few marks), "marks" (one at each point), "points", "dots",
     * "whiskers" (marks with their interval), "apart" (likewise, beside those of other looks),
     * "sim", "faint" */
    const char *kind;
    const double *x, *y; /* x rises or falls; NaN: a hole */
    const double *half;  /* of an interval or band; NULL: none */
    size_t count;
};
void figure_series(struct figure *figure, const struct chart_series *series);
/* "closed", "behind", "reported", "warned", "band", "mark", "stop", "lead", "sensor", "seen". NaN
 * in x0 or y0: over all of that axis. */
void figure_shape(struct figure *figure, const char *kind, double x0, double x1, double y0,
                  double y1, const char *text);

#endif
