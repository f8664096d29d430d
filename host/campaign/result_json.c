#include "host/campaign/result_json.h"

#include <math.h>
#include <stdlib.h>

#include "host/campaign/facts.h"
#include "host/base/cli.h"

static json_t *spread_json(const struct campaign_spread *s)
{
    return json_pack("[o,o,o]", cli_json_number(s->low, 6), cli_json_number(s->middle, 6), cli_json_number(s->high, 6));
}

static json_t *spreads_json(const struct campaign_spread *list, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, spread_json(&list[i]));
    return array;
}

static json_t *landing_json(const struct campaign *c, const struct campaign_landing_summary *s, size_t number)
{
    json_t *o = json_pack("{s:I,s:I,s:I,s:I,s:I,s:I,s:I}", "landing", (json_int_t)number, "runways", (json_int_t)s->played,
                          "buckled", (json_int_t)s->buckled, "planar", (json_int_t)s->planar, "with_waves",
                          (json_int_t)s->waved, "unhinged", (json_int_t)s->unhinged, "torn", (json_int_t)s->torn);
    const struct {
        const char *name;
        const struct campaign_spread *spread;
    } spreads[] = {{"stop_ft", &s->stop_ft},   {"deceleration_ft_s2", &s->deceleration_ft_s2},
                   {"peak_in", &s->peak_in},   {"reach_ft", &s->reach_ft},
                   {"zone_mats", &s->zone_mats}, {"push_lb", &s->push_lb},
                   {"pull_lb", &s->pull_lb}};
    for (size_t i = 0; i < sizeof spreads / sizeof spreads[0]; i++)
        json_object_set_new(o, spreads[i].name, spread_json(spreads[i].spread));
    json_object_set_new(o, "movement_in", spreads_json(s->movement_in, c->station_count));
    json_object_set_new(o, "total_in", spreads_json(s->total_in, c->station_count));
    return o;
}

static json_t *stations_json(const double *stations_ft, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, cli_json_number(stations_ft[i], 6));
    return array;
}

static json_t *outcome_json(const struct campaign_outcome *o, size_t number)
{
    size_t waves = (size_t)(o->waves < CAMPAIGN_WAVES_MAX ? o->waves : CAMPAIGN_WAVES_MAX);
    json_t *object = json_pack("{s:I,s:o,s:o,s:o,s:o,s:b,s:o,s:o,s:o,s:i,s:o,s:o,s:o,s:o,s:i,s:i,s:o,s:o,s:o,s:o,s:b,s:b,s:o,s:o}", "landing",
                     (json_int_t)number, "stop_ft", cli_json_number(o->stop_ft, 6), "deceleration_ft_s2",
                     cli_json_number(o->deceleration_ft_s2, 4), "mats_chain", cli_json_number(o->mats_chain, 4), "mats_planar",
                     cli_json_number(o->mats_planar, 4), "planar", o->asked_planar, "lift_ratio",
                     cli_json_number(o->skip_ratio, 4), "peak_in", cli_json_number(o->peak_in, 5), "reach_ft",
                     cli_json_number(o->reach_ft, 5), "zone_mats", o->zone_mats, "zone_from_ft",
                     cli_json_number(o->zone_from_ft, 6), "zone_to_ft", cli_json_number(o->zone_to_ft, 6), "push_lb",
                     cli_json_number(o->push_lb, 5), "pull_lb", cli_json_number(o->pull_lb, 5), "tears", o->tears, "waves",
                     o->waves, "wave_ft", stations_json(o->wave_ft, waves), "rise_in", cli_json_number(o->rise_in, 5),
                     "crest_deg", cli_json_number(o->crest_deg, 4), "sag_deg", cli_json_number(o->sag_deg, 4), "unhinged",
                     o->unhinged, "buckled", o->buckled, "overrun_ft", stations_json(o->overrun_ft, (size_t)o->overruns),
                     "failure_ft", stations_json(o->failure_ft, (size_t)o->failures));
    if (o->crest_ft > 0.0) {
        json_object_set_new(object, "crest_ft", cli_json_number(o->crest_ft, 6));
        json_object_set_new(object, "crest_ahead_mats", json_integer(o->crest_ahead_mats));
    }
    if (o->band_ahead_lb != 0.0 || o->band_behind_lb != 0.0) {
        json_object_set_new(object, "band_ahead_lb", cli_json_number(o->band_ahead_lb, 5));
        json_object_set_new(object, "band_behind_lb", cli_json_number(o->band_behind_lb, 5));
        json_object_set_new(object, "band_slack", json_integer(o->band_slack));
    }
    return object;
}

static json_t *run_json(const struct campaign_run *run)
{
    json_t *outcomes = json_array();
    for (size_t i = 0; i < run->played; i++)
        json_array_append_new(outcomes, outcome_json(&run->outcomes[i], i + 1));
    json_t *object = json_pack("{s:I,s:o,s:o,s:o}", "seed", (json_int_t)run->seed, "buckled_landing",
                               run->buckled > 0 ? json_integer(run->buckled) : json_null(), "buckled_ft",
                               run->buckled > 0 ? cli_json_number(run->buckle_ft, 6) : json_null(), "landings", outcomes);
    if (run->error.status != MR_OK)
        json_object_set_new(object, "failed", json_string(run->error.text));
    return object;
}

/* Medians over runways: of the largest value that a runway had in the landings before the one that it buckled in. */
static json_t *largest_json(const struct campaign *c, const struct campaign_run *runs, double (*value)(const struct campaign_outcome *))
{
    double *values = calloc(c->seeds, sizeof *values);
    size_t count = 0;
    if (!values)
        return json_null();
    for (size_t i = 0; i < c->seeds; i++) {
        double most = (double)NAN;
        for (size_t k = 0; k < runs[i].played; k++) {
            if (!runs[i].outcomes[k].buckled)
                most = fmax(most, value(&runs[i].outcomes[k]));
        }
        if (runs[i].error.status == MR_OK && !isnan(most))
            values[count++] = most;
    }
    struct campaign_spread spread = campaign_spread_of(values, count);
    free(values);
    return cli_json_number(spread.middle, 6);
}

static double movement_in(const struct campaign_outcome *outcome)
{
    return outcome->peak_in;
}

static double zone_mats(const struct campaign_outcome *outcome)
{
    return outcome->zone_mats;
}

/* One number each, for tables and sweeps. */
static void add_medians(json_t *object, const struct campaign *c, const struct campaign_run *runs, const struct campaign_summary *s)
{
    double share = (double)(s->runways - s->survived) / (double)s->runways; /* NaN without a runway: null */
    json_object_set_new(object, "buckled_share", cli_json_number(share, 6));
    json_object_set_new(object, "median_landing", cli_json_number(s->buckle_landing.middle, 6));
    json_object_set_new(object, "median_station_ft", cli_json_number(s->station_ft.middle, 6));
    json_object_set_new(object, "median_zone_mats", largest_json(c, runs, zone_mats));
    json_object_set_new(object, "median_movement_in", largest_json(c, runs, movement_in));
}

static json_t *facts_json(const struct campaign *c, const struct campaign_summary *s)
{
    json_t *list = json_array();
    for (size_t i = 0; i < c->fact_count; i++) {
        const struct campaign_fact *fact = &c->facts[i];
        json_array_append_new(list, json_pack("{s:s,s:s,s:o,s:o,s:I,s:o,s:b}", "says", fact->says, "unit", facts_unit(fact), "at_least",
                                              cli_json_number(fact->low, 6), "at_most", cli_json_number(fact->high, 6), "agree",
                                              (json_int_t)s->fact[i].agree, "value", spread_json(&s->fact[i].value), "enough",
                                              s->fact[i].enough));
    }
    return list;
}

json_t *campaign_json(const struct campaign *c, const struct campaign_run *runs, const struct campaign_summary *s,
                      const struct campaign_difference *apart)
{
    json_t *landings = json_array(), *list = json_array();
    for (size_t i = 0; i < c->landing_count; i++)
        json_array_append_new(landings, landing_json(c, &s->landing[i], i + 1));
    for (size_t i = 0; i < c->seeds; i++)
        json_array_append_new(list, run_json(&runs[i]));
    json_t *object = json_pack("{s:s,s:I,s:I,s:I,s:I,s:o,s:o,s:o,s:o,s:o,s:s}", "name", c->name, "seeds",
                               (json_int_t)c->seeds, "first_seed", (json_int_t)c->first_seed, "failed",
                               (json_int_t)s->failed, "survived", (json_int_t)s->survived, "buckled_landing",
                               spread_json(&s->buckle_landing), "buckled_ft", spread_json(&s->station_ft), "stations_ft",
                               stations_json(c->stations_ft, c->station_count), "landings", landings, "runways", list,
                               "observed", c->observed);
    add_medians(object, c, runs, s);
    if (c->fact_count > 0)
        json_object_set_new(object, "facts", facts_json(c, s));
    if (apart)
        json_object_set_new(object, "check", json_pack("{s:o,s:o,s:I}", "movement_in", cli_json_number(apart->movement_in, 4),
                                                       "with_waves_in", cli_json_number(apart->waved_in, 4),
                                                       "other_outcomes", (json_int_t)apart->outcomes));
    return object;
}
