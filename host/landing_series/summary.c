#include "host/landing_series/summary.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/statistics.h"
#include "host/landing_series/facts.h"

static double percentile(const double *sorted, size_t count, double share)
{
    double at = share * (double)(count - 1);
    size_t left = (size_t)at;
    if (left + 1 >= count)
        return sorted[count - 1];
    return sorted[left] + (at - (double)left) * (sorted[left + 1] - sorted[left]);
}

struct series_spread series_spread_of(double *values, size_t count)
{
    if (count == 0)
        return (struct series_spread){(double)NAN, (double)NAN, (double)NAN, 0};
    sort_numbers(values, count);
    return (struct series_spread){percentile(values, count, 0.05), percentile(values, count, 0.5),
                                  percentile(values, count, 0.95), count};
}

struct gather {
    const struct landing_series *series;
    const struct series_run *runs;
    size_t landing;
    double *values;
};

static const struct series_outcome *outcome_at(const struct gather *g, size_t run)
{
    return &g->runs[run].outcomes[g->landing];
}

/* Spread of one number at `offset` in the outcomes of a landing. */
static struct series_spread spread_at(const struct gather *g, size_t offset)
{
    size_t count = 0;
    for (size_t i = 0; i < g->series->seeds; i++) {
        if (g->runs[i].played > g->landing)
            g->values[count++] = *(const double *)((const char *)outcome_at(g, i) + offset);
    }
    return series_spread_of(g->values, count);
}

static struct series_spread zones(const struct gather *g)
{
    size_t count = 0;
    for (size_t i = 0; i < g->series->seeds; i++) {
        if (g->runs[i].played > g->landing)
            g->values[count++] = outcome_at(g, i)->zone_mats;
    }
    return series_spread_of(g->values, count);
}

#define SPREAD(g, field) spread_at(g, offsetof(struct series_outcome, field))

static void summarise_landing(struct series_landing_summary *s, const struct gather *g)
{
    for (size_t i = 0; i < g->series->seeds; i++) {
        if (g->runs[i].played <= g->landing)
            continue;
        const struct series_outcome *out = outcome_at(g, i);
        s->played++;
        s->buckled += g->runs[i].buckled == (int)g->landing + 1;
        s->planar += out->asked_planar;
        s->waved += out->waves > 0;
        s->unhinged += out->unhinged;
        s->torn += out->tears > 0;
    }
    s->stop_ft = SPREAD(g, stop_ft);
    s->deceleration_ft_s2 = SPREAD(g, deceleration_ft_s2);
    s->peak_in = SPREAD(g, peak_in);
    s->reach_ft = SPREAD(g, reach_ft);
    s->push_lb = SPREAD(g, push_lb);
    s->pull_lb = SPREAD(g, pull_lb);
    s->zone_mats = zones(g);
    for (size_t k = 0; k < g->series->station_count; k++) {
        s->movement_in[k] =
            spread_at(g, offsetof(struct series_outcome, movement_in) + k * sizeof(double));
        s->total_in[k] = spread_at(g,
                                   offsetof(struct series_outcome, total_in) + k * sizeof(double));
    }
}

enum mr_status series_summarise(struct series_summary *s, const struct landing_series *series,
                                const struct series_run *runs, struct error *error)
{
    struct gather g = {.series = series, .runs = runs};
    size_t buckled = 0, before = 0, seeds = series->seeds;
    *s = (struct series_summary){0};
    s->landing = calloc(series->landing_count, sizeof *s->landing);
    g.values = calloc(4 * seeds, sizeof *g.values);
    if (!s->landing || !g.values) {
        free(g.values);
        series_summary_free(s);
        return error_set(error, MR_FULL, "out of memory: %zu seeds; give fewer", series->seeds);
    }
    for (size_t i = 0; i < seeds; i++) {
        s->failed += runs[i].error.status != MR_OK;
        s->runways += runs[i].error.status == MR_OK;
        s->survived += runs[i].error.status == MR_OK && runs[i].buckled == 0;
        for (size_t k = 0; k < runs[i].played; k++) {
            s->landings++;
            s->planar += runs[i].outcomes[k].asked_planar;
            s->ms_chain += runs[i].outcomes[k].ms_chain;
            s->ms_planar += runs[i].outcomes[k].ms_planar;
        }
        if (runs[i].buckled > 0) {
            g.values[buckled] = runs[i].buckle_ft;
            g.values[seeds + buckled++] = runs[i].buckled;
        }
        if (runs[i].buckled > 1) {
            const struct series_outcome *last = &runs[i].outcomes[runs[i].buckled - 2];
            g.values[2 * seeds + before] = last->zone_mats;
            g.values[3 * seeds + before++] = last->peak_in;
        }
    }
    s->station_ft = series_spread_of(g.values, buckled);
    s->buckle_landing = series_spread_of(g.values + seeds, buckled);
    s->zone_before = series_spread_of(g.values + 2 * seeds, before);
    s->peak_before_in = series_spread_of(g.values + 3 * seeds, before);
    for (g.landing = 0; g.landing < series->landing_count; g.landing++)
        summarise_landing(&s->landing[g.landing], &g);
    for (size_t i = 0; i < series->fact_count; i++)
        s->fact[i] = facts_summarise(series, &series->facts[i], runs, g.values);
    free(g.values);
    return MR_OK;
}

void series_summary_free(struct series_summary *summary)
{
    free(summary->landing);
    summary->landing = NULL;
}

size_t series_agree(const struct landing_series *c, const struct series_run *runs)
{
    size_t agree = 0;
    for (size_t i = 0; i < c->seeds; i++) {
        int n = runs[i].buckled;
        if (runs[i].error.status == MR_OK)
            agree += c->observed_landing < 0 ? n == 0
                                             : n > 0 && abs(n - c->observed_landing) <= c->within;
    }
    return agree;
}

struct series_difference series_compare(const struct landing_series *series,
                                        const struct series_run *a, const struct series_run *b)
{
    struct series_difference most = {0};
    double a_ms = 0.0, b_ms = 0.0;
    for (size_t i = 0; i < series->seeds; i++) {
        bool waved = false;
        a_ms += a[i].ms;
        b_ms += b[i].ms;
        most.outcomes += a[i].buckled != b[i].buckled;
        for (size_t k = 0; k < a[i].played && k < b[i].played; k++) {
            if (a[i].buckled == (int)k + 1 || b[i].buckled == (int)k + 1)
                break;
            waved = waved || a[i].outcomes[k].waves > 0 || b[i].outcomes[k].waves > 0;
            double *apart_in = waved ? &most.waved_in : &most.movement_in;
            for (size_t s = 0; s < series->station_count; s++)
                *apart_in = fmax(*apart_in, fabs(a[i].outcomes[k].movement_in[s] -
                                                 b[i].outcomes[k].movement_in[s]));
        }
    }
    most.times = b_ms / a_ms;
    return most;
}

double series_log_score_bits(const struct landing_series *c, const struct series_run *runs)
{
    size_t runways = 0, same = 0;
    int seen = c->observed_landing < 0 ? 0 : c->observed_landing;
    if (c->observed_landing == 0)
        return (double)NAN;
    for (size_t i = 0; i < c->seeds; i++) {
        runways += runs[i].error.status == MR_OK;
        same += runs[i].error.status == MR_OK && runs[i].buckled == seen;
    }
    double outcomes = (double)c->landing_count + 1.0;
    return -log2(((double)same + 1.0 / outcomes) / ((double)runways + 1.0));
}
