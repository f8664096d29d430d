#include "tests/scoreboard/facts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

static const char *const quantities[] = {"moved_in",  "each_in",  "most_in", "mean_in",
                                         "zone_mats", "waves",    "slack",   "torn",
                                         "failures",  "apart_ft", NULL};

static enum mr_status wrong(const char *path, size_t number, const char *what, struct error *error)
{
    return error_set(error, MR_MALFORMED, "%s: _facts[%zu]: %s", path, number, what);
}

static bool read_fact(const json_t *entry, const struct landing_series *c, struct series_fact *fact,
                      char what[JSON_ERROR_TEXT_LENGTH])
{
    const char *says, *quantity, *when = NULL;
    json_t *landings, *against = NULL;
    json_error_t unpacked = {0};
    size_t most = c->landing_count, choice = 0;
    int first = 1, last = 1, against_first = 0, against_last = 0;
    bool good = json_unpack_ex((json_t *)(uintptr_t)entry, &unpacked, JSON_STRICT,
                               "{s:s,s:s,s:o,s?o,s?F,s?F,s?F,s?F}", "says", &says, "quantity",
                               &quantity, "landings", &landings, "against", &against, "station_ft",
                               &fact->station_ft, "at_least", &fact->low, "at_most", &fact->high,
                               "needed", &fact->needed) == 0 &&
                (json_unpack_ex(landings, &unpacked, 0, "s", &when) == 0 ||
                 json_unpack_ex(landings, &unpacked, 0, "[ii!]", &first, &last) == 0) &&
                (!against || json_unpack_ex(against, &unpacked, 0, "[ii!]", &against_first,
                                            &against_last) == 0);
    snprintf(what, JSON_ERROR_TEXT_LENGTH, "%s", unpacked.text);
    if (!good)
        return false;
    snprintf(fact->says, sizeof fact->says, "%s", says);
    while (quantities[choice] && strcmp(quantities[choice], quantity) != 0)
        choice++;
    fact->quantity = (enum series_quantity)choice;
    if (when)
        fact->when = strcmp(when, "at buckling") == 0 ? SERIES_AT_BUCKLING : SERIES_BEFORE_BUCKLING;
    fact->first = (size_t)first;
    fact->last = (size_t)last;
    fact->against_first = (size_t)against_first;
    fact->against_last = (size_t)against_last;
    snprintf(what, JSON_ERROR_TEXT_LENGTH,
             "a quantity, landings of the study in order, and a range that is one");
    return quantities[choice] && first >= 1 && last >= first && fact->last <= most &&
           fact->against_last <= most && against_first <= against_last && fact->low <= fact->high &&
           !(isinf(fact->low) && isinf(fact->high)) &&
           (!when || strcmp(when, "at buckling") == 0 || strcmp(when, "before buckling") == 0) &&
           (isnan(fact->station_ft) ||
            (fact->quantity <= SERIES_MOST_IN && fact->station_ft >= 0.0 &&
             fact->station_ft <= c->landings[0].scene.mats * c->landings[0].scene.length_ft));
}

enum mr_status facts_read(const char *path, const json_t *root, const struct landing_series *c,
                          struct facts *facts, struct error *error)
{
    char what[JSON_ERROR_TEXT_LENGTH];
    json_t *list = NULL;
    *facts = (struct facts){.needed = 0.625};
    json_unpack((json_t *)(uintptr_t)root, "{s?i,s?i,s?F,s?o}", "_observed_landing",
                &facts->observed_landing, "_within", &facts->within, "_needed", &facts->needed,
                "_facts", &list);
    for (size_t i = 0; i < json_array_size(list); i++) {
        struct series_fact *fact = &facts->fact[facts->count];
        if (facts->count++ == SERIES_FACTS_MAX)
            return wrong(path, i, "at most 12", error);
        *fact = (struct series_fact){.station_ft = (double)NAN,
                                     .low = -(double)INFINITY,
                                     .high = (double)INFINITY,
                                     .needed = facts->needed};
        if (!read_fact(json_array_get(list, i), c, fact, what))
            return wrong(path, i, what, error);
    }
    return MR_OK;
}

static size_t station_of(const struct landing_series *c, double station_ft)
{
    size_t best = 0;
    for (size_t k = 1; k < c->station_count; k++) {
        if (fabs(c->stations_ft[k] - station_ft) < fabs(c->stations_ft[best] - station_ft))
            best = k;
    }
    return best;
}

static double moved_in(const struct landing_series *c, const struct series_fact *fact,
                       const struct series_outcome *o)
{
    return isnan(fact->station_ft) ? o->peak_movement_in
                                   : fabs(o->movement_in[station_of(c, fact->station_ft)]);
}

static double mean_in(const struct landing_series *c, const struct series_outcome *o)
{
    double sum = 0.0;
    for (size_t k = 0; k < c->station_count; k++)
        sum += fabs(o->movement_in[k]) / (double)c->station_count;
    return sum;
}

/* Sum of the movements from landing `first` to `last`, at the fact's station or the one that it is
 * largest at. */
static double sum_in(const struct landing_series *c, const struct series_fact *fact,
                     const struct series_outcome *outcomes, size_t first, size_t last)
{
    double most_in = 0.0;
    for (size_t k = 0; k < c->station_count; k++) {
        double sum = 0.0;
        if (!isnan(fact->station_ft) && k != station_of(c, fact->station_ft))
            continue;
        for (size_t i = first - 1; i < last; i++)
            sum += outcomes[i].movement_in[k];
        most_in = fmax(most_in, fabs(sum));
    }
    return most_in;
}

/* What one landing adds to a count, or is the largest of. */
static double of_landing(const struct landing_series *c, const struct series_fact *fact,
                         const struct series_outcome *o)
{
    switch (fact->quantity) {
    case SERIES_MEAN_IN: return mean_in(c, o);
    case SERIES_ZONE_MATS: return o->zone_mats;
    case SERIES_WAVES: return o->wave_count > 0;
    case SERIES_SLACK: return o->slack_band_segment_count > 0;
    case SERIES_TORN: return o->torn_joint_count > 0;
    case SERIES_FAILURES: return o->failure_count;
    case SERIES_APART_FT:
        return o->failure_count > 1 ? o->failure_station_ft[1] - o->failure_station_ft[0]
                                    : (double)NAN;
    default: return moved_in(c, fact, o);
    }
}

/* The quantity over landings of a run. */
static double over(const struct landing_series *c, const struct series_fact *fact,
                   const struct series_run *run, size_t first, size_t last)
{
    const struct series_outcome *outcomes = run->outcomes;
    bool buckling = fact->when == SERIES_AT_BUCKLING;
    double sum = 0.0, most = (double)NAN; /* of what there is */
    size_t count = 0;
    for (size_t i = first - 1; i < last && i < run->simulated_landing_count; i++) {
        if ((int)i + 1 == run->buckled_landing && !buckling)
            break;
        double value = of_landing(c, fact, &outcomes[i]);
        sum += value;
        most = fmax(most, value);
        count++;
    }
    if (count == 0 || (fact->quantity == SERIES_MOVED_IN && count < last - first + 1))
        return (double)NAN;
    switch (fact->quantity) {
    case SERIES_MOVED_IN: return sum_in(c, fact, outcomes, first, last);
    case SERIES_EACH_IN:
    case SERIES_MEAN_IN: return sum / (double)count;
    case SERIES_MOST_IN:
    case SERIES_ZONE_MATS:
    case SERIES_FAILURES:
    case SERIES_APART_FT: return most;
    default: return sum;
    }
}

double facts_value(const struct landing_series *c, const struct series_fact *fact,
                   const struct series_run *run)
{
    size_t first = fact->first, last = fact->last;
    if (run->error.status != MR_OK)
        return (double)NAN;
    if (fact->when != SERIES_IN_LANDINGS) {
        if (run->buckled_landing == 0 ||
            (fact->when == SERIES_BEFORE_BUCKLING && run->buckled_landing == 1))
            return (double)NAN;
        first = last = (size_t)run->buckled_landing - (fact->when == SERIES_BEFORE_BUCKLING);
    }
    double value = over(c, fact, run, first, last);
    if (fact->against_first == 0)
        return value;
    double other = over(c, fact, run, fact->against_first, fact->against_last);
    return other > 0.0 ? value / other : (double)NAN;
}

struct series_fact_summary facts_summarise(const struct landing_series *c,
                                           const struct series_fact *fact,
                                           const struct series_run *runs)
{
    double *values = xcalloc(c->seed_count, sizeof *values);
    struct series_fact_summary s = {0};
    size_t count = 0, runways = 0;
    for (size_t i = 0; i < c->seed_count; i++) {
        double value = facts_value(c, fact, &runs[i]);
        runways += runs[i].error.status == MR_OK;
        s.agree += value >= fact->low && value <= fact->high;
        if (!isnan(value))
            values[count++] = value;
    }
    s.enough = runways > 0 && (double)s.agree >= fact->needed * (double)runways;
    s.value = series_compute_spread(values, count);
    free(values);
    return s;
}

static const char *facts_unit(const struct series_fact *fact)
{
    static const char *const units[] = {"in",       "in",       "in",       "in",       "mats",
                                        "landings", "landings", "landings", "stations", "ft"};
    bool ratio = fact->against_first > 0;
    return ratio ? "times" : units[fact->quantity];
}

void facts_range_text(const struct series_fact *fact, char *text, size_t size)
{
    const char *unit = facts_unit(fact);
    if (isinf(fact->low))
        snprintf(text, size, "at most %.3g %s", fact->high, unit);
    else if (isinf(fact->high))
        snprintf(text, size, "at least %.3g %s", fact->low, unit);
    else
        snprintf(text, size, "%.3g to %.3g %s", fact->low, fact->high, unit);
}

size_t series_agree(const struct landing_series *c, const struct facts *facts,
                    const struct series_run *runs)
{
    size_t agree = 0;
    for (size_t i = 0; i < c->seed_count; i++) {
        int n = runs[i].buckled_landing;
        if (runs[i].error.status == MR_OK)
            agree += facts->observed_landing < 0
                       ? n == 0
                       : n > 0 && abs(n - facts->observed_landing) <= facts->within;
    }
    return agree;
}

double series_log_score_bits(const struct landing_series *c, const struct facts *facts,
                             const struct series_run *runs)
{
    size_t runways = 0, same = 0;
    int seen = facts->observed_landing < 0 ? 0 : facts->observed_landing;
    if (facts->observed_landing == 0)
        return (double)NAN;
    for (size_t i = 0; i < c->seed_count; i++) {
        runways += runs[i].error.status == MR_OK;
        same += runs[i].error.status == MR_OK && runs[i].buckled_landing == seen;
    }
    double outcomes = (double)c->landing_count + 1.0;
    return -log2(((double)same + 1.0 / outcomes) / ((double)runways + 1.0));
}
