#include "tests/scoreboard/facts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

static const char *const quantities[] = {"moved_in",  "each_in",  "most_in", "mean_in",
                                         "zone_mats", "waves",    "slack",   "torn",
                                         "failures",  "apart_ft", NULL};

/* [first, last], both from 1. */
static void read_landings(const struct keys *keys, const char *where, const char *key,
                          const json_t *entry, size_t most, size_t *first, size_t *last)
{
    const json_t *from = json_array_get(entry, 0), *to = json_array_get(entry, 1);
    *first = (size_t)json_integer_value(from);
    *last = (size_t)json_integer_value(to);
    if (json_array_size(entry) != 2 || !json_is_integer(from) || !json_is_integer(to) ||
        json_integer_value(from) < 1 || *last < *first || *last > most)
        keys_wrong(keys, where, key, "the first and the last of the study's landings, [1, 4]");
}

static void read_fact(const struct keys *keys, const char *where, const json_t *entry,
                      const struct landing_series *c, double needed, struct series_fact *fact)
{
    static const char *const known[] = {"says",     "quantity", "landings", "against", "station_ft",
                                        "at_least", "at_most",  "needed",   NULL};
    static const char *const whens[] = {"before buckling", "at buckling", NULL};
    const json_t *landings = json_object_get(entry, "landings"),
                 *against = json_object_get(entry, "against");
    const struct sim_scene *scene = &c->landings[0].scene;
    *fact = (struct series_fact){.station_ft = (double)NAN,
                                 .low = -(double)INFINITY,
                                 .high = (double)INFINITY,
                                 .needed = needed};
    keys_check(keys, where, entry, known);
    if (keys_failed(keys))
        return;
    keys_text(keys, where, entry, "says", fact->says, sizeof fact->says);
    if (!json_object_get(entry, "quantity"))
        keys_wrong(
            keys, where, "quantity",
            "what was seen: moved_in, each_in, most_in, mean_in, zone_mats, waves, slack, torn, "
            "failures or apart_ft");
    fact->quantity = keys_choice(keys, where, entry, "quantity", quantities, 0);
    if (json_is_string(landings))
        fact->when = SERIES_BEFORE_BUCKLING + keys_choice(keys, where, entry, "landings", whens, 0);
    else if (!keys_failed(keys))
        read_landings(keys, where, "landings", landings, c->landing_count, &fact->first,
                      &fact->last);
    if (against && !keys_failed(keys))
        read_landings(keys, where, "against", against, c->landing_count, &fact->against_first,
                      &fact->against_last);
    keys_number(keys, where, entry, "station_ft", 0.0, scene->mats * scene->length_ft,
                &fact->station_ft);
    keys_number(keys, where, entry, "at_least", 0.0, 1e9, &fact->low);
    keys_number(keys, where, entry, "at_most", 0.0, 1e9, &fact->high);
    keys_number(keys, where, entry, "needed", 0.0, 1.0, &fact->needed);
    if (!isnan(fact->station_ft) && fact->quantity > SERIES_MOST_IN)
        keys_wrong(keys, where, "station_ft",
                   "it with moved_in, each_in or most_in: a station's movement");
    if (!keys_failed(keys) && !fact->says[0])
        keys_wrong(keys, where, "says", "what was seen, in words");
    if (!keys_failed(keys) &&
        (!(fact->low <= fact->high) || (isinf(fact->low) && isinf(fact->high))))
        keys_wrong(keys, where, "at_least", "a range: at_least, at_most or both in order");
}

static void read_list(const struct keys *keys, const json_t *root, const struct landing_series *c,
                      struct facts *facts)
{
    const json_t *list = json_object_get(root, "facts");
    if (list && (!json_is_array(list) || json_array_size(list) > SERIES_FACTS_MAX)) {
        keys_wrong(keys, "", "facts", "a list of at most 12 objects");
        return;
    }
    for (size_t i = 0; i < json_array_size(list) && !keys_failed(keys); i++) {
        char where[32];
        snprintf(where, sizeof where, "facts[%zu]", i);
        read_fact(keys, where, json_array_get(list, i), c, facts->needed,
                  &facts->fact[facts->count++]);
    }
}

enum mr_status facts_read(const char *path, const json_t *root, const struct landing_series *c,
                          struct facts *facts, struct error *error)
{
    const struct keys keys = {path, error};
    double landing = 0.0, within = 0.0;
    *facts = (struct facts){.needed = 0.625};
    keys_number(&keys, "", root, "observed_landing", -1.0, SERIES_LANDINGS_MAX, &landing);
    facts->observed_landing = (int)landing;
    keys_number(&keys, "", root, "within", 0.0, SERIES_LANDINGS_MAX, &within);
    facts->within = (int)within;
    keys_number(&keys, "", root, "needed", 0.0, 1.0, &facts->needed);
    if (!keys_failed(&keys))
        read_list(&keys, root, c, facts);
    return error->status;
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
    return isnan(fact->station_ft) ? o->peak_in
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
    case SERIES_WAVES: return o->waves > 0;
    case SERIES_SLACK: return o->band_slack > 0;
    case SERIES_TORN: return o->tears > 0;
    case SERIES_FAILURES: return o->failures;
    case SERIES_APART_FT:
        return o->failures > 1 ? o->failure_ft[1] - o->failure_ft[0] : (double)NAN;
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
    for (size_t i = first - 1; i < last && i < run->played; i++) {
        if ((int)i + 1 == run->buckled && !buckling)
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
        if (run->buckled == 0 || (fact->when == SERIES_BEFORE_BUCKLING && run->buckled == 1))
            return (double)NAN;
        first = last = (size_t)run->buckled - (fact->when == SERIES_BEFORE_BUCKLING);
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
    double *values = xcalloc(c->seeds, sizeof *values);
    struct series_fact_summary s = {0};
    size_t count = 0, runways = 0;
    for (size_t i = 0; i < c->seeds; i++) {
        double value = facts_value(c, fact, &runs[i]);
        runways += runs[i].error.status == MR_OK;
        s.agree += value >= fact->low && value <= fact->high;
        if (!isnan(value))
            values[count++] = value;
    }
    s.enough = runways > 0 && (double)s.agree >= fact->needed * (double)runways;
    s.value = series_spread_of(values, count);
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
    for (size_t i = 0; i < c->seeds; i++) {
        int n = runs[i].buckled;
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
    for (size_t i = 0; i < c->seeds; i++) {
        runways += runs[i].error.status == MR_OK;
        same += runs[i].error.status == MR_OK && runs[i].buckled == seen;
    }
    double outcomes = (double)c->landing_count + 1.0;
    return -log2(((double)same + 1.0 / outcomes) / ((double)runways + 1.0));
}
