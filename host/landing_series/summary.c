/* Summary of an ensemble: numerical errors of the largest forces, distributions, and the output of
 * matrig study. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/gates.h"
#include "host/base/cli.h"
#include "host/base/statistics.h"
#include "host/base/xmalloc.h"
#include "host/landing_series/ensemble.h"

/* ---- errors ---- */

/* Weight of the prior of a landing's error, in pairs of simulations. The prior is computed from the
 * pairs of all landings. */
#define POOLED_PAIRS       2
#define MIN_ERROR_FRACTION 1e-3 /* smallest relative error */

static const struct {
    size_t value, error; /* offsets of the value and of its error in struct series_outcome */
} peak_fields[] = {
    {offsetof(struct series_outcome, lift_ratio), offsetof(struct series_outcome, lift_error)},
    {offsetof(struct series_outcome, compression_lb),
     offsetof(struct series_outcome, compression_error_lb)},
    {offsetof(struct series_outcome, tension_lb),
     offsetof(struct series_outcome, tension_error_lb)},
};

static double *get_outcome_field(const struct series_outcome *outcome, size_t offset)
{
    return (double *)((char *)(uintptr_t)outcome + offset);
}

/* Returns the root of the sum of squares. hypot is not used, because its result differs between
 * processors. */
static double add_in_quadrature(double a, double b)
{
    return sqrt(a * a + b * b);
}

/* Sums for one peak of one landing, over the runways that one engine (chain or planar)
 * simulated. */
struct peak_tally {
    size_t count, pair_count;
    double sum, sum_of_squares;
    /* sum of the pairs' differences, and sum of their squares */
    double difference_sum, difference_squares;
};

static struct peak_tally make_peak_tally(const struct landing_series *c,
                                         const struct series_run *runs, size_t landing,
                                         bool by_planar, size_t offset)
{
    struct peak_tally t = {0};
    for (size_t i = 0; i < c->seed_count; i++) {
        const struct series_outcome *o = &runs[i].outcomes[landing], *other = NULL;
        if (runs[i].simulated_landing_count <= landing || o->is_planar != by_planar)
            continue;
        double value = *get_outcome_field(o, offset);
        t.count++;
        t.sum += value;
        t.sum_of_squares += value * value;
        if (runs[i].check_landing_count > landing)
            other = &runs[i].check_outcomes[landing];
        if (!other || other->is_planar != by_planar)
            continue;
        double apart = value - *get_outcome_field(other, offset);
        t.pair_count++;
        t.difference_sum += apart;
        t.difference_squares += apart * apart;
    }
    return t;
}

/* Returns the error of one value: sqrt(r (r + s)). r: root mean square of the pairs' differences;
 * s: the spread over the runways, which is included because few pairs contain a rare impact.
 * README.md describes how this was measured. */
static double compute_peak_error(const struct peak_tally *t, double borrowed2, size_t pairs_in_all)
{
    double mean = t->sum / (double)t->count;
    double freedom = (double)(t->pair_count + POOLED_PAIRS), spread2 = 0.0;
    double r = sqrt((t->difference_squares + POOLED_PAIRS * borrowed2 * mean * mean) / freedom);
    if (t->count > 1)
        spread2 = (t->sum_of_squares - t->sum * mean) / (double)(t->count - 1);
    r *= mr_gates_student_factor((unsigned)fmin(freedom, (double)pairs_in_all));
    return sqrt(r * (r + sqrt(fmax(spread2, 0.0))));
}

static void set_peak_errors(const struct landing_series *c, struct series_run *runs, size_t value,
                            size_t error)
{
    struct peak_tally *tallies = xcalloc(2 * c->landing_count, sizeof *tallies);
    double apart2 = 0.0;
    size_t pairs = 0;
    for (size_t k = 0; k < 2 * c->landing_count; k++) {
        struct peak_tally t = tallies[k] = make_peak_tally(c, runs, k / 2, k % 2 == 1, value);
        double mean = t.sum / (double)t.count;
        pairs += t.sum > 0.0 ? t.pair_count : 0;
        apart2 += t.sum > 0.0 ? t.difference_squares / (mean * mean) : 0.0;
    }
    for (size_t i = 0; i < c->seed_count; i++) {
        for (size_t k = 0; k < runs[i].simulated_landing_count; k++) {
            struct series_outcome *o = &runs[i].outcomes[k];
            const struct peak_tally *t = &tallies[2 * k + o->is_planar];
            *get_outcome_field(o, error) =
                pairs > 0 ? fmax(compute_peak_error(t, apart2 / (double)pairs, pairs),
                                 MIN_ERROR_FRACTION * *get_outcome_field(o, value))
                          : (double)NAN;
        }
    }
    free(tallies);
}

void series_compute_errors(const struct landing_series *series, struct series_run *runs)
{
    for (size_t peak = 0; peak < sizeof peak_fields / sizeof peak_fields[0]; peak++)
        set_peak_errors(series, runs, peak_fields[peak].value, peak_fields[peak].error);
    /* Use the largest error for all joints: a joint without a strong impact in this run may have
     * one in another. */
    for (size_t i = 0; i < series->seed_count; i++) {
        for (size_t k = 0; k < runs[i].simulated_landing_count; k++) {
            struct series_outcome *o = &runs[i].outcomes[k];
            if (o->compression_lb > 0.0)
                o->lift_error = add_in_quadrature(
                    o->lift_error, o->lift_ratio * o->compression_error_lb / o->compression_lb);
        }
    }
}

/* ---- summary ---- */

static double compute_percentile(const double *sorted, size_t count, double share)
{
    double at = share * (double)(count - 1);
    size_t left = (size_t)at;
    if (left + 1 >= count)
        return sorted[count - 1];
    return sorted[left] + (at - (double)left) * (sorted[left + 1] - sorted[left]);
}

struct series_spread series_compute_spread(double *values, size_t count)
{
    if (count == 0)
        return (struct series_spread){(double)NAN, (double)NAN, (double)NAN, 0};
    sort_numbers(values, count);
    return (struct series_spread){compute_percentile(values, count, 0.05),
                                  compute_percentile(values, count, 0.5),
                                  compute_percentile(values, count, 0.95), count};
}

struct landing_view {
    const struct landing_series *series;
    const struct series_run *runs;
    size_t landing;
    double *values;
};

static const struct series_outcome *get_outcome(const struct landing_view *g, size_t run)
{
    return &g->runs[run].outcomes[g->landing];
}

/* Computes the distribution over the runways of the value at `offset` in the outcomes of a
 * landing. */
static struct series_spread compute_spread(const struct landing_view *g, size_t offset)
{
    size_t count = 0;
    for (size_t i = 0; i < g->series->seed_count; i++) {
        if (g->runs[i].simulated_landing_count > g->landing)
            g->values[count++] = *get_outcome_field(get_outcome(g, i), offset);
    }
    return series_compute_spread(g->values, count);
}

static struct series_spread compute_zone_spread(const struct landing_view *g)
{
    size_t count = 0;
    for (size_t i = 0; i < g->series->seed_count; i++) {
        if (g->runs[i].simulated_landing_count > g->landing)
            g->values[count++] = get_outcome(g, i)->zone_mats;
    }
    return series_compute_spread(g->values, count);
}

#define SPREAD_OF(g, field) compute_spread(g, offsetof(struct series_outcome, field))

/* Computes spread and mean of a peak. The part of the error that is common to all runways does not
 * shrink with their number. It is estimated from the mean difference of the pairs, scaled to the
 * difference of their time steps, and is at most the error of one run. */
static struct series_peak compute_peak(const struct landing_view *g, size_t peak)
{
    struct series_peak p = {.spread = compute_spread(g, peak_fields[peak].value)};
    double count = (double)p.spread.count, errors2 = 0.0, known = 0.0, apart = 0.0, pairs = 0.0;
    for (int by_planar = 0; by_planar < 2; by_planar++) {
        struct peak_tally t = make_peak_tally(g->series, g->runs, g->landing, by_planar,
                                              peak_fields[peak].value);
        p.mean += t.sum / count; /* NaN without runways */
        apart += t.difference_sum;
        pairs += (double)t.pair_count;
    }
    for (size_t i = 0; i < g->series->seed_count; i++) {
        if (g->runs[i].simulated_landing_count <= g->landing)
            continue;
        double error = *get_outcome_field(get_outcome(g, i), peak_fields[peak].error);
        errors2 += isnan(error) ? 0.0 : error * error;
        known += !isnan(error);
    }
    p.run_error = sqrt(errors2 / known); /* NaN if no runway has an error */
    double alike = fabs(apart) / fmax(pairs, 1.0) / (SERIES_CHECK_STEP_RATIO - 1.0);
    p.mean_error = fmin(add_in_quadrature(p.run_error / sqrt(count), alike), p.run_error);
    return p;
}

static void summarise_landing(struct series_landing_summary *s, const struct landing_view *g)
{
    for (size_t i = 0; i < g->series->seed_count; i++) {
        if (g->runs[i].simulated_landing_count <= g->landing)
            continue;
        const struct series_outcome *out = get_outcome(g, i);
        s->runway_count++;
        s->buckled_count += g->runs[i].buckled_landing == (int)g->landing + 1;
        s->planar_count += out->has_planar_run;
        s->wave_count += out->wave_count > 0;
        s->unhinged_count += out->is_unhinged;
        s->torn_count += out->torn_joint_count > 0;
    }
    s->stop_ft = SPREAD_OF(g, stop_ft);
    s->peak_movement_in = SPREAD_OF(g, peak_movement_in);
    s->moved_length_beyond_stop_ft = SPREAD_OF(g, moved_length_beyond_stop_ft);
    s->zone_mats = compute_zone_spread(g);
    s->lift_ratio = compute_peak(g, 0);
    s->compression_lb = compute_peak(g, 1);
    s->tension_lb = compute_peak(g, 2);
    for (size_t k = 0; k < g->series->station_count; k++) {
        s->movement_in[k] =
            compute_spread(g, offsetof(struct series_outcome, movement_in) + k * sizeof(double));
        s->total_movement_in[k] = compute_spread(
            g, offsetof(struct series_outcome, total_movement_in) + k * sizeof(double));
    }
}

void series_summarise(struct series_summary *s, const struct landing_series *series,
                      const struct series_run *runs)
{
    struct landing_view g = {.series = series, .runs = runs};
    size_t buckled = 0, before = 0, seeds = series->seed_count;
    *s = (struct series_summary){0};
    s->landing = xcalloc(series->landing_count, sizeof *s->landing);
    g.values = xcalloc(4 * seeds, sizeof *g.values);
    for (size_t i = 0; i < seeds; i++) {
        s->failed_count += runs[i].error.status != MR_OK;
        s->runway_count += runs[i].error.status == MR_OK;
        s->survived_count += runs[i].error.status == MR_OK && runs[i].buckled_landing == 0;
        if (runs[i].buckled_landing > 0) {
            g.values[buckled] = runs[i].buckle_station_ft;
            g.values[seeds + buckled++] = runs[i].buckled_landing;
        }
        if (runs[i].buckled_landing > 1) {
            const struct series_outcome *last = &runs[i].outcomes[runs[i].buckled_landing - 2];
            g.values[2 * seeds + before] = last->zone_mats;
            g.values[3 * seeds + before++] = last->peak_movement_in;
        }
    }
    s->buckle_station_ft = series_compute_spread(g.values, buckled);
    s->buckle_landing = series_compute_spread(g.values + seeds, buckled);
    s->zone_mats_before_buckle = series_compute_spread(g.values + 2 * seeds, before);
    s->peak_before_buckle_in = series_compute_spread(g.values + 3 * seeds, before);
    for (g.landing = 0; g.landing < series->landing_count; g.landing++)
        summarise_landing(&s->landing[g.landing], &g);
    free(g.values);
}

void series_summary_free(struct series_summary *summary)
{
    free(summary->landing);
    summary->landing = NULL;
}

/* ---- series answer ---- */

static json_t *make_spread_json(const struct series_spread *s)
{
    return json_pack("[o,o,o]", cli_json_number(s->low, 6), cli_json_number(s->median, 6),
                     cli_json_number(s->high, 6));
}

static json_t *make_spreads_json(const struct series_spread *list, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, make_spread_json(&list[i]));
    return array;
}

/* Returns the number of decimals that show two digits of half the interval, at most `most`. More
 * digits of the median would not be significant. */
static int count_decimals(const struct series_spread *s, double factor, int most)
{
    double half = factor * (s->high - s->low) / 2.0;
    int decimals = half > 0.0 && isfinite(half) ? 1 - (int)floor(log10(half)) : most;
    return decimals < 0 ? 0 : decimals > most ? most : decimals;
}

/* Adds the median. Printed output also shows the 5th and 95th percentiles in brackets. */
static void add_spread(struct answer *answer, const char *name, const char *label,
                       enum unit_kind kind, const struct series_spread *s, int decimals)
{
    const struct unit *unit = unit_get(kind, answer_is_si(answer));
    const char *suffix = unit_get_json(kind)->suffix, *mark = unit->suffix[0] ? ",|" : "";
    char key[40], head[60];
    snprintf(key, sizeof key, "%s%s%s", name, suffix[0] ? "_" : "", suffix);
    answer_add_json(answer, key, make_spread_json(s));
    if (!label)
        return;
    snprintf(head, sizeof head, "%s%s%s", label, mark, unit->text);
    decimals = count_decimals(s, unit->factor, unit_decimals(kind, answer_is_si(answer), decimals));
    answer_add_text(answer, NULL, head, s->count > 0 ? "%.*f (%.*f-%.*f)" : "-", decimals,
                    unit->factor * s->median, decimals, unit->factor * s->low, decimals,
                    unit->factor * s->high);
}

/* Adds a peak to the JSON only; printed output has a separate table. */
static void add_peak(struct answer *answer, const char *name, const char *mean, enum unit_kind kind,
                     const struct series_peak *p)
{
    char key[24];
    add_spread(answer, name, NULL, kind, &p->spread, 0);
    answer_add_estimate(answer, mean, NULL, kind, p->mean, p->mean_error, 0);
    snprintf(key, sizeof key, "%s_error", name);
    answer_add_value(answer, key, NULL, kind, p->run_error, 0);
}

static void add_landing(struct answer *answer, const struct landing_series *c,
                        const struct series_landing_summary *s, size_t number)
{
    bool shown = s->runway_count > 0;
    answer_open_row(answer);
    answer_add_count(answer, "landing", shown ? "landing" : NULL, (int64_t)number);
    answer_add_count(answer, "runways", shown ? "runways" : NULL, (int64_t)s->runway_count);
    add_spread(answer, "stop", shown ? "stop" : NULL, UNIT_STATION, &s->stop_ft, 1);
    add_spread(answer, "peak", shown ? "largest|movement" : NULL, UNIT_DISPLACEMENT,
               &s->peak_movement_in, 2);
    add_spread(answer, "reach", shown ? "reach|ahead" : NULL, UNIT_STATION,
               &s->moved_length_beyond_stop_ft, 1);
    add_spread(answer, "zone_mats", shown ? "closed|zone,|mats" : NULL, UNIT_NUMBER, &s->zone_mats,
               0);
    answer_add_count(answer, "planar", shown ? "planar|engine" : NULL, (int64_t)s->planar_count);
    answer_add_count(answer, "with_waves", shown ? "waves" : NULL, (int64_t)s->wave_count);
    answer_add_count(answer, "buckled", shown ? "buckled" : NULL, (int64_t)s->buckled_count);
    answer_add_count(answer, "unhinged", shown ? "unhinged" : NULL, (int64_t)s->unhinged_count);
    answer_add_count(answer, "torn", shown ? "torn" : NULL, (int64_t)s->torn_count);
    if (shown && c->landings[number - 1].is_modified)
        answer_add_text(answer, NULL, "before it", "modified");
    add_peak(answer, "lift_ratio", "lift_ratio_mean", UNIT_NUMBER, &s->lift_ratio);
    add_peak(answer, "push", "push_mean", UNIT_TENSION, &s->compression_lb);
    add_peak(answer, "pull", "pull_mean", UNIT_TENSION, &s->tension_lb);
    answer_add_json(answer, "movement_in", make_spreads_json(s->movement_in, c->station_count));
    answer_add_json(answer, "total_in", make_spreads_json(s->total_movement_in, c->station_count));
}

static void add_forces(struct answer *answer, const struct landing_series *c,
                       const struct series_landing_summary *s)
{
    char label[160] =
        "largest force in a joint: mean over the runways, and its standard error caused by the "
        "time steps; \"error of\": that standard error for a single runway";
    if (isnan(s[0].compression_lb.run_error))
        snprintf(label, sizeof label,
                 "largest force in a joint: mean over the runways; for its standard error, "
                 "simulate %d runways or more (--seeds)",
                 SERIES_CHECK_EVERY);
    answer_open_table(answer, NULL, label);
    for (size_t i = 0; i < c->landing_count && s[i].runway_count > 0; i++) {
        const struct series_peak *push = &s[i].compression_lb, *pull = &s[i].tension_lb;
        answer_open_row(answer);
        answer_add_count(answer, NULL, "landing", (int64_t)i + 1);
        answer_add_estimate(answer, NULL, "push", UNIT_TENSION, push->mean, push->mean_error, 1);
        answer_add_value(answer, NULL, "error of|one push", UNIT_TENSION, push->run_error, 1);
        answer_add_estimate(answer, NULL, "pull", UNIT_TENSION, pull->mean, pull->mean_error, 1);
        answer_add_value(answer, NULL, "error of|one pull", UNIT_TENSION, pull->run_error, 1);
    }
    answer_close_group(answer);
}

static void add_stations(struct answer *answer, const struct landing_series *c,
                         const struct series_landing_summary *s)
{
    const struct unit *station = unit_get(UNIT_STATION, answer_is_si(answer)),
                      *movement = unit_get(UNIT_DISPLACEMENT, answer_is_si(answer));
    char label[80];
    snprintf(label, sizeof label, "total movement (%s), median over the runways, by station (%s)",
             movement->text, station->text);
    answer_open_table(answer, NULL, label);
    for (size_t i = 0; i < c->landing_count && s[i].runway_count > 0; i++) {
        answer_open_row(answer);
        answer_add_count(answer, NULL, "landing", (int64_t)i + 1);
        for (size_t k = 0; k < c->station_count; k++) {
            snprintf(label, sizeof label, "%.5g", station->factor * c->stations_ft[k]);
            answer_add_value(answer, NULL, label, UNIT_NUMBER,
                             movement->factor * s[i].total_movement_in[k].median,
                             unit_decimals(UNIT_DISPLACEMENT, answer_is_si(answer), 2));
        }
    }
    answer_close_group(answer);
}

static json_t *make_stations_json(const double *stations_ft, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, cli_json_number(stations_ft[i], 6));
    return array;
}

static json_t *make_outcome_json(const struct series_outcome *o, size_t number)
{
    json_t *object = json_pack(
        "{s:I,s:o,s:o,s:b,s:o,s:o,s:o,s:o,s:i,s:o,s:o,s:o,s:o,s:o,s:o,s:i,s:i,s:o,s:o,s:o,s:o,s:b,"
        "s:b,"
        "s:o,s:o}",
        "landing", (json_int_t)number, "stop_ft", cli_json_number(o->stop_ft, 6),
        "deceleration_ft_s2", cli_json_number(o->deceleration_ft_s2, 4), "planar",
        o->has_planar_run, "lift_ratio", cli_json_number(o->lift_ratio, 4), "lift_ratio_error",
        cli_json_number(o->lift_error, 2), "peak_in", cli_json_number(o->peak_movement_in, 5),
        "reach_ft", cli_json_number(o->moved_length_beyond_stop_ft, 5), "zone_mats", o->zone_mats,
        "zone_from_ft", cli_json_number(o->zone_start_ft, 6), "zone_to_ft",
        cli_json_number(o->zone_end_ft, 6), "push_lb", cli_json_number(o->compression_lb, 5),
        "push_error_lb", cli_json_number(o->compression_error_lb, 2), "pull_lb",
        cli_json_number(o->tension_lb, 5), "pull_error_lb", cli_json_number(o->tension_error_lb, 2),
        "tears", o->torn_joint_count, "waves", o->wave_count, "wave_ft",
        o->wave_count > 0 ? cli_json_number(o->wave_station_ft, 6) : json_null(), "rise_in",
        cli_json_number(o->wave_rise_in, 5), "crest_deg", cli_json_number(o->crest_angle_deg, 4),
        "sag_deg", cli_json_number(o->sag_angle_deg, 4), "unhinged", o->is_unhinged, "buckled",
        o->is_buckled, "overrun_ft",
        make_stations_json(o->wave_encounter_station_ft, (size_t)o->wave_encounter_count),
        "failure_ft", make_stations_json(o->failure_station_ft, (size_t)o->failure_count));
    if (o->first_buckle_station_ft > 0.0) {
        json_object_set_new(object, "crest_ft", cli_json_number(o->first_buckle_station_ft, 6));
        json_object_set_new(object, "crest_ahead_mats", json_integer(o->first_buckle_ahead_mats));
    }
    if (o->slack_band_segment_count > 0)
        json_object_set_new(object, "band_slack", json_integer(o->slack_band_segment_count));
    return object;
}

static json_t *make_run_json(const struct series_run *run)
{
    json_t *outcomes = json_array();
    for (size_t i = 0; i < run->simulated_landing_count; i++)
        json_array_append_new(outcomes, make_outcome_json(&run->outcomes[i], i + 1));
    json_t *object = json_pack(
        "{s:I,s:o,s:o,s:o}", "seed", (json_int_t)run->seed, "buckled_landing",
        run->buckled_landing > 0 ? json_integer(run->buckled_landing) : json_null(), "buckled_ft",
        run->buckled_landing > 0 ? cli_json_number(run->buckle_station_ft, 6) : json_null(),
        "landings", outcomes);
    if (run->error.status != MR_OK)
        json_object_set_new(object, "failed", json_string(run->error.text));
    return object;
}

/* Returns the median, over the runways that buckled, of the largest value in the landings before
 * the buckle. */
static double compute_median_of_largest(const struct landing_series *c,
                                        const struct series_run *runs,
                                        double (*value)(const struct series_outcome *))
{
    double *values = xcalloc(c->seed_count, sizeof *values);
    size_t count = 0;
    for (size_t i = 0; i < c->seed_count; i++) {
        double most = (double)NAN;
        for (size_t k = 0; k < runs[i].simulated_landing_count; k++) {
            if (!runs[i].outcomes[k].is_buckled)
                most = fmax(most, value(&runs[i].outcomes[k]));
        }
        if (runs[i].error.status == MR_OK && !isnan(most))
            values[count++] = most;
    }
    struct series_spread spread = series_compute_spread(values, count);
    free(values);
    return spread.median;
}

static double get_peak_movement_in(const struct series_outcome *outcome)
{
    return outcome->peak_movement_in;
}

static double get_zone_mats(const struct series_outcome *outcome)
{
    return outcome->zone_mats;
}

/* Adds the medians as single numbers, for tables and sweeps. */
static void add_medians(struct answer *answer, const struct landing_series *c,
                        const struct series_run *runs, const struct series_summary *s)
{
    /* NaN if there are no runways; null in the JSON */
    double share = (double)(s->runway_count - s->survived_count) / (double)s->runway_count;
    answer_add_value(answer, "buckled_share", NULL, UNIT_NUMBER, share, 2);
    answer_add_value(answer, "median_landing", NULL, UNIT_NUMBER, s->buckle_landing.median, 0);
    answer_add_value(answer, "median_station", NULL, UNIT_STATION, s->buckle_station_ft.median, 1);
    answer_add_value(answer, "median_zone_mats", NULL, UNIT_NUMBER,
                     compute_median_of_largest(c, runs, get_zone_mats), 0);
    answer_add_value(answer, "median_movement", NULL, UNIT_DISPLACEMENT,
                     compute_median_of_largest(c, runs, get_peak_movement_in), 2);
}

static void add_buckled(struct answer *answer, const struct landing_series *c,
                        const struct series_summary *s)
{
    const struct unit *station = unit_get(UNIT_STATION, answer_is_si(answer));
    char in[200] = "";
    for (size_t i = 0, length = 0; i < c->landing_count && length < sizeof in; i++) {
        if (s->landing[i].buckled_count > 0)
            length += (size_t)snprintf(in + length, sizeof in - length, ", %zu in landing %zu",
                                       s->landing[i].buckled_count, i + 1);
    }
    answer_add_text(answer, NULL, "buckled", "%zu of %zu runways%s",
                    s->runway_count - s->survived_count, s->runway_count, in);
    if (s->buckle_station_ft.count > 0)
        answer_append_remark(answer, "; at station %.1f (%.1f-%.1f) %s",
                             station->factor * s->buckle_station_ft.median,
                             station->factor * s->buckle_station_ft.low,
                             station->factor * s->buckle_station_ft.high, station->text);
    answer_add_json(answer, "buckled_landing", make_spread_json(&s->buckle_landing));
    answer_add_json(answer, "buckled_ft", make_spread_json(&s->buckle_station_ft));
}

static void add_text_if_present(struct answer *answer, const char *label, const char *text)
{
    if (text[0])
        answer_add_text(answer, NULL, label, "%s", text);
}

/* Adds the outcome of the series and its uncertainty. */
static void add_outcome(struct answer *answer, const struct landing_series *c,
                        const struct series_run *runs, const struct series_summary *s)
{
    answer_add_sentence(
        answer, NULL, "%s: %zu landings on %zu runways (seeds %llu to %llu), %d mats", c->name,
        c->landing_count, c->seed_count, (unsigned long long)c->first_seed,
        (unsigned long long)(c->first_seed + c->seed_count - 1), c->landings[0].scene.mats);
    answer_add_text(answer, "name", NULL, "%s", c->name);
    answer_add_count(answer, "seeds", NULL, (int64_t)c->seed_count);
    answer_add_count(answer, "first_seed", NULL, (int64_t)c->first_seed);
    answer_add_count(answer, "failed", NULL, (int64_t)s->failed_count);
    answer_add_count(answer, "survived", NULL, (int64_t)s->survived_count);
    answer_add_text(answer, "observed", NULL, "%s", c->observed);
    for (size_t i = 0; i < c->seed_count; i++) {
        if (runs[i].error.status != MR_OK)
            answer_add_text(answer, NULL, "FAILED", "seed %llu, landing %zu: %s",
                            (unsigned long long)runs[i].seed, runs[i].simulated_landing_count + 1,
                            runs[i].error.text);
    }
    char ground[200];
    series_describe_ground(c, ground, sizeof ground);
    answer_add_text(answer, "ground", "ground", "%s", ground);
    add_buckled(answer, c, s);
    add_text_if_present(answer, "observed", c->observed);
    add_text_if_present(answer, "parameters", c->basis);
    add_text_if_present(answer, "not predicted, but computed after the landing",
                        c->changes_after_outcome);
}

/* Adds the results of each landing. */
static void add_landing_tables(struct answer *answer, const struct landing_series *c,
                               const struct series_run *runs, const struct series_summary *s)
{
    json_t *list = json_array();
    answer_open_table(answer, "landings",
                      "values of each landing: median over the simulated runways that reached this "
                      "landing; in brackets, 5th to 95th percentile");
    for (size_t i = 0; i < c->landing_count; i++)
        add_landing(answer, c, &s->landing[i], i + 1);
    answer_close_group(answer);
    add_forces(answer, c, s->landing);
    add_stations(answer, c, s->landing);
    answer_add_json(answer, "stations_ft", make_stations_json(c->stations_ft, c->station_count));
    for (size_t i = 0; i < c->seed_count; i++)
        json_array_append_new(list, make_run_json(&runs[i]));
    answer_add_json(answer, "runways", list);
    add_medians(answer, c, runs, s);
}

struct answer *series_to_answer(const struct landing_series *c, const struct series_run *runs,
                                const struct series_summary *s, bool si)
{
    struct answer *answer = answer_new(si);
    answer_keep_units(answer);
    add_outcome(answer, c, runs, s);
    add_landing_tables(answer, c, runs, s);
    return answer;
}
