/* Figures 4.1, 4.5, 4.6, 5.2, 5.3, 5.5, 5.9 and 5.12 of the 1973 report, drawn from the series'
 * series. Its drawings are lost: what its captions and text state is marked in them and compared in
 * a table. */
#ifndef MATRIG_TESTS_SERIES_FIGURES_FIGURES_H
#define MATRIG_TESTS_SERIES_FIGURES_FIGURES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host/landing_series/play.h"
#include "host/base/error.h"

#define FIGURE_CURVES 8
#define FIGURE_FACTS  8
#define FIGURE_LAST   (-1) /* the landing that buckles */

/* Movement of landings from + 1 to `to` together; (0, n) is the total after landing n. A `to` of
 * FIGURE_LAST is the landing that buckles, with the one before it as `from`. */
struct figure_curve {
    int from, to;
    const char *text; /* NULL: no more curves */
};

/* Something the text states, and what is computed for it: more than half of the runways must be in
 * [low, high]. a, b, c: see each. In the picture it is marked at stations [at, to] (to 0: a point),
 * or where the displacement is `mark_in` (at `at`, or anywhere). */
enum fact_kind {
    FACT_NONE,
    FACT_LANDING,      /* landing that buckles; never is infinite */
    FACT_STATION,      /* station where it buckles, ft */
    FACT_PEAK_STATION, /* of the movement of curve a, ft */
    FACT_PEAK,         /* largest movement of curve a, in */
    FACT_RISE,         /* movement at station c less that at station b, curve a, in */
    FACT_AT,           /* movement at station b, curve a, in */
    FACT_RATIO,        /* largest movement of curve a over that of curve b */
    FACT_FAR_SHARE,    /* movement at station b over the largest, curve a */
    /* mats in the closed zone after landing a; 0: after the one before the buckle, or the last */
    FACT_ZONE,
    FACT_ZONE_REACH, /* downfield end of it, ft */
    FACT_SLACK,      /* landings of the first a in which a band goes slack */
    FACT_AHEAD,      /* mean change of tension ahead of the aircraft over landings, lb */
    FACT_BEHIND,     /* and behind */
};

struct figure_fact {
    enum fact_kind kind;
    double a, b, c;
    double low, high;
    double at_ft, to_ft; /* stations of the mark; at 0: none */
    double mark_in;      /* 0: none */
    const char *text;    /* as the report states it, and where */
    const char *note;    /* why it is judged so; "" */
};

struct figure {
    const char *number, *title;
    /* file in the folder of series, or in the output folder when it begins with '+' */
    const char *series;
    enum series_engine engine;
    bool tension;    /* fig 5.3: change of band tension against deceleration */
    double zero_ft;  /* station of the runway's edge */
    size_t landings; /* played at most; 0: all */
    struct figure_curve curves[FIGURE_CURVES];
    struct figure_fact facts[FIGURE_FACTS];
};

extern const struct figure series_figures[];
extern const size_t series_figure_count;

/* A figure's series, played; the caller frees. */
struct figure_run {
    struct landing_series series;
    struct series_run *runs;
};
enum mr_status figure_play(struct figure_run *run, const struct figure *figure, const char *folder,
                           size_t seeds, struct error *error);
void figure_run_free(struct figure_run *run);

/* Movement of a runway along a curve, by station; false when it did not take those landings. */
bool figure_curve_of(const struct landing_series *series, const struct series_run *run,
                     const struct figure_curve *curve, double *movement_in);
/* What a fact comes to on the runways: least, middle (the lower of two) and most; NaN when no
 * runway has it. `agree`: runways within [low, high], of the `of` that have it. */
struct fact_value {
    double low, middle, high;
    size_t agree, of;
};
struct fact_value figure_fact_of(const struct figure *figure, const struct figure_fact *fact,
                                 const struct figure_run *run);

enum mr_status figure_draw(const char *path, const struct figure *figure,
                           const struct figure_run *run, struct error *error);
/* Markdown. */
void figure_table(FILE *out, const struct figure *figure, const struct figure_run *run);

#endif
