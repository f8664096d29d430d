#include "host/study/fit/misfit.h"

#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/study/fit/misfit_parts.h"

#define TAIL        0.9 /* quantile that a figure's unit comes from */
#define TAIL_NORMAL 1.2815515655446004
#define FAR         0.975 /* and another, when that is wider */
#define FAR_NORMAL  1.959963984540054

/* Half of the rows' tail on one side in standard deviations of a normal distribution: what is
 * skewed or has long tails among right rows too is not odd by that. */
static double tail(const double *sorted, size_t n, double middle, double part)
{
    double far = part > 0.5 ? FAR : 1.0 - FAR;
    return fmax(fabs(gsl_stats_quantile_from_sorted_data(sorted, 1, n, part) - middle) /
                    TAIL_NORMAL,
                fabs(gsl_stats_quantile_from_sorted_data(sorted, 1, n, far) - middle) / FAR_NORMAL);
}

/* How far each row is from the median, in the direction that is odd. */
static void set_away(struct checking *c, enum misfit_figure figure, double *sorted, double *away,
                     struct misfit_found *found)
{
    size_t n = c->rows;
    double *value = c->figure + figure * n;
    /* of these too little is as odd as too much */
    bool both = figure == MISFIT_SCATTER || figure == MISFIT_CLOSED || figure == MISFIT_SUMS ||
                figure == MISFIT_NEIGHBOURS || figure == MISFIT_SUMS_ALONG ||
                figure == MISFIT_ODD_THRUST;
    memcpy(sorted, value + 1, (n - 1) * sizeof *sorted);
    gsl_sort(sorted, 1, n - 1);
    found->measured = value[0];
    found->middle = gsl_stats_median_from_sorted_data(sorted, 1, n - 1);
    found->low = gsl_stats_quantile_from_sorted_data(sorted, 1, n - 1, 0.025);
    found->high = gsl_stats_quantile_from_sorted_data(sorted, 1, n - 1, 0.975);
    memcpy(sorted, value, n * sizeof *sorted);
    gsl_sort(sorted, 1, n);
    /* whole numbers may all be the same but for a few */
    double middle = gsl_stats_median_from_sorted_data(sorted, 1, n),
           least = figure == MISFIT_CLOSED ? 1.0 : 1e-9,
           above = fmax(tail(sorted, n, middle, TAIL), least),
           below = fmax(tail(sorted, n, middle, 1.0 - TAIL), least);
    for (size_t i = 0; i < n; i++) {
        double far = value[i] > middle ? (value[i] - middle) / above : (value[i] - middle) / below;
        away[i] = both ? fabs(far) : far;
        if (i == 0)
            found->away = far;
    }
}

/* A row's distance: its farthest figure, or all that are odd together, if that is odder. */
static void set_most(struct checking *c, const double *together, double *sorted, double *most)
{
    size_t n = c->rows;
    memcpy(sorted, together, n * sizeof *sorted);
    gsl_sort(sorted, 1, n);
    double middle = gsl_stats_median_from_sorted_data(sorted, 1, n),
           unit = fmax(tail(sorted, n, middle, TAIL), 1e-9);
    for (size_t i = 0; i < n; i++)
        most[i] = fmax(most[i], (together[i] - middle) / unit);
}

static bool judge(struct checking *c, struct misfit *misfit)
{
    size_t n = c->rows, out = 0;
    double *sorted = calloc(4 * n, sizeof *sorted);
    if (!sorted)
        return false;
    double *away = sorted + n, *most = away + n, *together = most + n, worst = -(double)INFINITY;
    for (size_t i = 0; i < n; i++)
        most[i] = -(double)INFINITY;
    for (enum misfit_figure f = 0; f < MISFITS; f++) {
        if (!misfit->found[f].known)
            continue;
        set_away(c, f, sorted, away, &misfit->found[f]);
        for (size_t i = 0; i < n; i++) {
            most[i] = fmax(most[i], away[i]);
            together[i] += fmax(away[i], 0.0) * fmax(away[i], 0.0);
        }
        if (away[0] > worst) {
            worst = away[0];
            misfit->worst = f;
        }
    }
    for (size_t i = 0; i < n; i++)
        together[i] = sqrt(together[i]);
    set_most(c, together, sorted, most);
    for (size_t i = 0; i < n; i++)
        out += most[i] >= most[0];
    misfit->share = (double)out / (double)n;
    misfit->cannot = misfit->share <= MISFIT_FALSE;
    free(sorted);
    return true;
}

static void standardise(struct checking *c)
{
    for (size_t s = 0; s < c->statistics; s++) {
        const double *column = c->answer->residual + s;
        double mean = gsl_stats_mean(column, c->statistics, c->rows),
               sd = gsl_stats_sd(column, c->statistics, c->rows);
        c->spread[s] = sd;
        for (size_t i = 0; i < c->rows; i++)
            c->z[i * c->statistics + s] =
                sd > 0.0 ? (c->answer->residual[i * c->statistics + s] - mean) / sd : 0.0;
    }
}

static bool begin(struct checking *c)
{
    size_t s = 0;
    c->landing = calloc(c->statistics, sizeof(*c->landing));
    c->window = calloc(c->statistics, sizeof(*c->window));
    c->z = calloc(c->rows * c->statistics, sizeof *c->z);
    c->figure = calloc(MISFITS * c->rows, sizeof *c->figure);
    c->group = calloc(GROUP_MAX * c->rows, sizeof *c->group);
    c->weight = calloc(c->statistics, sizeof *c->weight);
    c->spread = calloc(c->statistics, sizeof *c->spread);
    c->member_at = calloc(GROUP_MAX, sizeof *c->member_at);
    if (!c->landing || !c->window || !c->z || !c->figure || !c->group || !c->weight || !c->spread ||
        !c->member_at)
        return false;
    for (size_t l = 0; l < c->list->count; l++) {
        for (size_t w = 0; w < c->list->landing[l].windows; w++, s++) {
            c->landing[s] = &c->list->landing[l];
            c->window[s] = &c->list->landing[l].window[w];
        }
    }
    standardise(c);
    return true;
}

enum mr_status misfit_check(const struct fit_landings *list, const struct fit_answer *answer,
                            uint64_t seed, struct misfit *misfit, struct error *error)
{
    struct checking c = {.list = list,
                         .answer = answer,
                         .rows = 1 + answer->replicas,
                         .statistics = answer->statistics};
    *misfit = (struct misfit){.replicas = answer->replicas};
    for (enum misfit_figure f = 0; f < MISFITS; f++)
        misfit->found[f].where = SIZE_MAX;
    if (answer->replicas < MISFIT_LEAST)
        return MR_OK;
    bool good = begin(&c);
    if (good) {
        misfit_singles(&c, seed, misfit);
        good = misfit_groups(&c, misfit) && misfit_odds(&c, misfit) && judge(&c, misfit);
    }
    if (!good)
        error_set(error, MR_FULL, "no memory: check of %zu statistics; use fewer landings",
                  c.statistics);
    misfit->checked = good;
    free(c.landing);
    free(c.window);
    free(c.z);
    free(c.figure);
    free(c.group);
    free(c.weight);
    free(c.spread);
    free(c.member_at);
    return error->status;
}
