/* What the report's pictures share: their size, labels with units, lines that can be told apart
 * without colour, traces of a channel. */
#ifndef MATRIG_HOST_REPORT_CHART_H
#define MATRIG_HOST_REPORT_CHART_H

#include "host/analyse/measured.h"
#include "host/base/svg.h"
#include "host/base/units.h"

#define CHART_WIDTH     1040.0
#define CHART_LEFT      58.0
#define CHART_RIGHT     12.0
/* traces of a small picture are thinned by such columns: 0.5 mm on paper */
#define CHART_COLUMN_PX 3.0
#define CHART_SETTLED_S 0.6 /* how long after the stop traces are shown */
#define CHART_RUNWAY_FT 120.0

/* "moved, in" */
struct chart_text {
    char text[60];
};
struct chart_text chart_label(const char *what, enum unit_kind kind, bool si);

/* Takes values into a range; NaN is left out. Begin with low INFINITY, high -INFINITY, or with what
 * must be in it. */
void chart_extend(const double *values, size_t count, double *low, double *high);

/* Look `number` is a colour, a dash and a mark of its own. A mark stands at every `every`-th point,
 * each look beginning elsewhere. */
void chart_line(const struct svg_plot *plot, unsigned number, const double *x, const double *y,
                size_t count, size_t every);
void chart_mark(const struct svg_plot *plot, unsigned number, double x, double y);
/* One whisker from low to high. */
void chart_whisker(const struct svg_plot *plot, const char *class, double x, double low,
                   double high);
/* Key of a look at (left, y) in pixels; returns where the next one begins. */
double chart_key(FILE *out, unsigned number, double left, double y, const char *text);

/* Key of a mark of one's own. */
void chart_mark_key(FILE *out, const char *class, unsigned shape, double left, double y,
                    const char *text);

/* A small picture of a row of four. */
struct svg_plot chart_small(FILE *out, size_t place, double top, double height);

/* Time and one channel between two times, in the unit shown. The caller frees t_s. */
struct chart_trace {
    double *t_s;
    double *value;
    size_t count;
};
struct chart_trace chart_trace(const struct measured *measured,
                               const struct measured_channel *channel, double from_s, double to_s,
                               double factor);
/* Replaces times by stations of the wheel. */
void chart_to_stations(const struct measured *measured, struct chart_trace *trace, double factor);

#endif
