#include <math.h>

#include "host/base/cli.h"
#include "host/compare/agree.h"
#include "host/compare/show.h"
#include "host/base/units.h"

#define DIGITS 6

/* "rms_in": 0.05, the unit in the name. */
static void put(json_t *object, const char *name, enum unit_kind kind, bool si, double value)
{
    char key[80];
    snprintf(key, sizeof key, "%s_%s", name, unit_of(kind, si)->suffix);
    json_object_set_new(object, key, cli_json_number(value * unit_of(kind, si)->factor, DIGITS));
}
static void put_in(json_t *object, const char *name, bool si, double value_in)
{
    put(object, name, UNIT_DISPLACEMENT, si, value_in);
}
static void put_ft(json_t *object, const char *name, bool si, double value_ft)
{
    put(object, name, UNIT_STATION, si, value_ft);
}
static void put_number(json_t *object, const char *name, double value)
{
    json_object_set_new(object, name, cli_json_number(value, DIGITS));
}

/* NAME, NAME_error; with `at` NAME_at and how long it lasts. */
static void put_moment(json_t *object, const char *name, const struct signal_moment *m, bool at, bool si)
{
    char key[80];
    put_in(object, name, si, m->value);
    snprintf(key, sizeof key, "%s_error", name);
    put_in(object, key, si, m->error);
    snprintf(key, sizeof key, "%s_at_s", name);
    if (at)
        put_number(object, key, m->t_s);
    snprintf(key, sizeof key, "%s_lasts_s", name);
    if (at)
        put_number(object, key, m->lasts_s);
}

static json_t *channel_json(const struct compare_channel *c, bool si)
{
    const struct signal_figures *f = &c->f;
    json_t *o = json_pack("{sIsb}", "number", (json_int_t)c->number, "compared", (int)c->compared);
    put_ft(o, "station", si, c->station_ft);
    put_number(o, "valid", c->valid);
    if (c->why[0])
        json_object_set_new(o, "why", json_string(c->why));
    if (!c->compared)
        return o;
    put_in(o, "bias", si, f->bias);
    put_in(o, "bias_error", si, f->bias_error);
    put_number(o, "bias_en", c->bias_en);
    put_in(o, "rms", si, f->rms);
    put_number(o, "chi", f->chi);
    put_number(o, "inside", f->inside);
    put_moment(o, "peak_measured", &f->peak_measured, true, si);
    put_moment(o, "peak_simulated", &f->peak_simulated, true, si);
    put_number(o, "peak_en", c->peak_en);
    put_moment(o, "end_measured", &c->end_measured, false, si);
    put_moment(o, "end_simulated", &c->end_simulated, false, si);
    put_in(o, "end_difference", si, c->end_measured.value - c->end_simulated.value);
    put_number(o, "end_en", c->end_en);
    put_number(o, "arrival_measured_s", f->arrival_measured.t_s);
    put_number(o, "arrival_measured_error_s", f->arrival_measured.t_error_s);
    put_number(o, "arrival_simulated_s", f->arrival_simulated.t_s);
    put_number(o, "arrival_simulated_error_s", f->arrival_simulated.t_error_s);
    put_number(o, "arrival_en", c->arrival_en);
    put_ft(o, "ahead_measured", si, c->ahead_measured_ft);
    put_ft(o, "ahead_simulated", si, c->ahead_simulated_ft);
    put_number(o, "correlation", f->correlation);
    put_number(o, "lag_s", f->lag_s);
    put_number(o, "lag_correlation", f->lag_correlation);
    put_in(o, "alignment", si, c->alignment_in);
    return o;
}

static json_t *zone_json(const struct compare_zone *zone, bool si)
{
    if (!zone->known)
        return json_null();
    json_t *o = json_object();
    put_number(o, "mats", zone->mats);
    bool any = zone->mats > 0.0;
    put_ft(o, "start", si, any ? zone->start_ft : (double)NAN);
    put_ft(o, "end", si, any ? zone->end_ft : (double)NAN);
    put_ft(o, "start_error", si, any ? zone->start_error_ft : (double)NAN);
    put_ft(o, "end_error", si, any ? zone->end_error_ft : (double)NAN);
    return o;
}

static json_t *overlap_json(const struct compare_overlap *overlap, bool si)
{
    if (!overlap->known)
        return json_null();
    json_t *o = json_object();
    put_number(o, "common_mats", overlap->common_mats);
    put_number(o, "all_mats", overlap->all_mats);
    put_number(o, "share", overlap->share);
    put_ft(o, "start_difference", si, overlap->start_ft);
    put_ft(o, "end_difference", si, overlap->end_ft);
    return o;
}

static json_t *zones_json(const struct compare_zones *zones, bool si)
{
    json_t *list = json_array();
    for (size_t i = 0; i < zones->count; i++) {
        const struct compare_zone_moment *m = &zones->moment[i];
        json_t *o = json_pack("{ss}", "when", m->what);
        put_number(o, "at_s", m->t_s);
        put_ft(o, "wheel", si, m->wheel_ft);
        json_object_set_new(o, "measured", zone_json(&m->zone[COMPARE_MEASURED], si));
        json_object_set_new(o, "board", zone_json(&m->zone[COMPARE_BOARD], si));
        json_object_set_new(o, "simulated", zone_json(&m->zone[COMPARE_SIMULATED], si));
        json_object_set_new(o, "overlap_board", overlap_json(&m->board, si));
        json_object_set_new(o, "overlap_simulated", overlap_json(&m->simulated, si));
        json_array_append_new(list, o);
    }
    return list;
}

/* The value that differs most, as the sentence tells. */
static json_t *worst_json(const struct compare_agreement *a, bool si)
{
    bool time = a->value == COMPARE_ARRIVAL;
    const char *const names[] = {"measured", "measured_error", "simulated", "simulated_error", "difference", "error"};
    const double values[] = {a->measured, a->measured_error, a->simulated, a->simulated_error, a->difference, a->error};
    json_t *o = json_pack("{sssI}", "value", compare_value_text(a->value), "number", (json_int_t)a->channel->number);
    put_ft(o, "station", si, a->channel->station_ft);
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char key[40];
        snprintf(key, sizeof key, "%s_s", names[i]);
        if (time)
            put_number(o, key, values[i]);
        else
            put_in(o, names[i], si, values[i]);
    }
    put_number(o, "measured_at_s", a->measured_t_s);
    put_number(o, "simulated_at_s", a->simulated_t_s);
    put_number(o, "en", a->en);
    return o;
}

static json_t *agreement_json(const struct compare_figures *figures, bool si)
{
    struct compare_agreement a;
    char sentence[COMPARE_SENTENCE];
    compare_agreement(figures, &a);
    compare_sentence(&a, si, sentence);
    return json_pack("{sosIsIsIsIsoss}", "agree", a.channel ? json_boolean(a.differ == 0) : json_null(), "judged", (json_int_t)a.judged, "differ",
                     (json_int_t)a.differ, "unknown", (json_int_t)a.unknown, "not_compared", (json_int_t)a.left_out, "worst",
                     a.channel ? worst_json(&a, si) : json_null(), "sentence", sentence);
}

static json_t *verdict_json(const struct compare_verdict *verdict)
{
    if (verdict->checked == 0)
        return json_null();
    json_t *o = json_pack("{sIsIsb}", "checked", (json_int_t)verdict->checked, "failed", (json_int_t)verdict->failed, "pass",
                          (int)(verdict->failed == 0));
    if (verdict->failed)
        json_object_set_new(o, "worst", json_string(verdict->text));
    return o;
}

json_t *compare_json(const struct compare_figures *figures, const struct compare_verdict *verdict, bool si)
{
    json_t *channels = json_array();
    for (size_t i = 0; i < figures->channels; i++)
        json_array_append_new(channels, channel_json(&figures->channel[i], si));
    json_t *o = json_pack("{sIsssIsIsI}", "run", (json_int_t)figures->run, "scene", figures->against, "surveyed",
                          (json_int_t)figures->surveyed, "seeds", (json_int_t)figures->seeds, "edges", (json_int_t)figures->edges);
    json_object_set_new(o, "doubtful", figures->doubt[0] ? json_string(figures->doubt) : json_null());
    put_number(o, "run_ms", figures->run_ms);
    put_in(o, "error", si, figures->error_in);
    put_number(o, "offset_s", figures->offset_s);
    put_number(o, "scatter_s", figures->scatter_s);
    json_object_set_new(o, "channels", channels);
    json_object_set_new(o, "zones", zones_json(&figures->zones, si));
    json_object_set_new(o, "agreement", agreement_json(figures, si));
    json_object_set_new(o, "limits", verdict_json(verdict));
    return o;
}

static json_t *moved_json(const struct compare_moved *moved, bool si)
{
    json_t *points = json_array();
    json_t *o = json_pack("{sIsIsIsb}", "from_survey", (json_int_t)moved->from_survey, "to_survey", (json_int_t)moved->to_survey, "landings",
                          (json_int_t)moved->landings, "compared", (int)moved->simulated);
    for (size_t p = 0; p < SURVEY_POINTS && moved->simulated; p++) {
        json_t *point = json_object();
        put_ft(point, "station", si, (double)p * SURVEY_SPAN_FT);
        put_in(point, "measured", si, moved->point[p].measured_in);
        put_in(point, "measured_error", si, moved->point[p].error_in);
        put_in(point, "simulated", si, moved->point[p].simulated_in);
        put_in(point, "simulated_spread", si, moved->point[p].spread_in);
        json_array_append_new(points, point);
    }
    if (moved->simulated) {
        put_in(o, "bias", si, moved->bias_in);
        put_in(o, "rms", si, moved->rms_in);
        put_number(o, "chi", moved->chi);
    }
    json_object_set_new(o, "points", points);
    return o;
}

json_t *compare_series_json(const struct compare_series *set, bool si)
{
    json_t *landings = json_array(), *channels = json_array(), *moved = json_array();
    for (size_t i = 0; i < set->count; i++) {
        const struct compare_series_landing *l = &set->landing[i];
        json_array_append_new(landings, l->compared ? compare_json(&l->figures, &l->verdict, si)
                                                    : json_pack("{sIss}", "run", (json_int_t)l->run, "not_compared", l->why));
    }
    for (size_t c = 0; c < MR_TRANSDUCERS; c++) {
        if (set->channel[c].landings == 0)
            continue;
        json_t *o = json_pack("{sIsI}", "number", (json_int_t)set->channel[c].number, "landings", (json_int_t)set->channel[c].landings);
        put_ft(o, "station", si, set->channel[c].station_ft);
        put_in(o, "bias", si, set->channel[c].bias_in);
        put_in(o, "rms", si, set->channel[c].rms_in);
        json_array_append_new(channels, o);
    }
    for (size_t i = 0; i < set->moves; i++)
        json_array_append_new(moved, moved_json(&set->moved[i], si));
    json_t *o = json_pack("{sssssI}", "scene", set->against, "series", set->name, "compared", (json_int_t)set->compared);
    put_number(o, "run_ms", set->run_ms);
    put_in(o, "error", si, set->error_in);
    put_in(o, "bias", si, set->pooled.bias_in);
    put_in(o, "rms", si, set->pooled.rms_in);
    if (set->verdict.checked)
        put_number(o, "within", set->pooled.within);
    json_object_set_new(o, "landings", landings);
    json_object_set_new(o, "channels", channels);
    json_object_set_new(o, "moved", moved);
    char sentence[COMPARE_SENTENCE];
    compare_series_sentence(set, si, sentence);
    json_object_set_new(o, "agreement", json_string(sentence));
    json_object_set_new(o, "limits", verdict_json(&set->verdict));
    return o;
}
