#include "host/board/shunts.h"
#include "host/analyse/bands.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/bands.h"
#include "host/base/cli.h"
#include "host/base/units.h"

/* Block in which the board was armed for the next landing of the session; INT64_MAX: it was not. */
static enum mr_status next_armed(struct store *store, const struct store_landing *landing, int64_t *block,
                                 struct error *error)
{
    struct store_landing *rows = NULL;
    size_t count = 0;
    *block = INT64_MAX;
    enum mr_status status = store_landings(store, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        const struct store_landing *row = &rows[i];
        if (row->session == landing->session && row->boot == landing->boot && row->armed_block > landing->armed_block &&
            row->armed_block < *block)
            *block = row->armed_block;
    }
    free(rows);
    return status;
}

static struct bands_shunt *shunt_of(struct bands_summary *bands, int64_t gage)
{
    for (size_t i = 0; i < bands->shunts; i++) {
        if (bands->shunt[i].gage == gage)
            return &bands->shunt[i];
    }
    if (gage < 1 || gage > MR_GAGES || bands->shunts == MR_GAGES)
        return NULL;
    struct bands_shunt *made = &bands->shunt[bands->shunts++];
    *made = (struct bands_shunt){.gage = (unsigned)gage, .expected_lb = (double)NAN, .before_lb = (double)NAN,
                                 .after_lb = (double)NAN, .before_verdict = STORE_NONE, .after_verdict = STORE_NONE};
    return made;
}

static enum mr_status load_shunts(struct store *store, const struct store_landing *landing, struct bands_summary *bands,
                                  struct error *error)
{
    struct store_shunt *rows[2] = {NULL, NULL};
    size_t count[2] = {0, 0};
    int64_t next = INT64_MAX;
    if (landing->armed_block == STORE_NONE)
        return MR_OK;
    enum mr_status status = next_armed(store, landing, &next, error);
    if (status == MR_OK)
        status = store_shunts_before(store, landing->session, landing->boot, landing->armed_block, &rows[0], &count[0], error);
    if (status == MR_OK)
        status = store_shunts_after(store, landing->session, landing->boot, landing->armed_block, &rows[1], &count[1], error);
    for (int side = 0; side < 2; side++) {
        for (size_t i = 0; status == MR_OK && i < count[side]; i++) {
            const struct store_shunt *row = &rows[side][i];
            struct bands_shunt *shunt = side && row->block >= next ? NULL : shunt_of(bands, row->gage);
            if (!shunt)
                continue;
            bool measured = row->verdict == MR_SHUNT_GOOD || row->verdict == MR_SHUNT_WRONG;
            shunt->expected_lb = row->expected_lb;
            *(side ? &shunt->after_verdict : &shunt->before_verdict) = row->verdict;
            *(side ? &shunt->after_lb : &shunt->before_lb) = measured ? row->span_lb : (double)NAN;
        }
        free(rows[side]);
    }
    return status;
}

enum mr_status bands_load(struct store *store, const struct measured *measured, struct bands_summary *bands,
                          struct error *error)
{
    int64_t run = measured->landing.id;
    memset(bands, 0, sizeof *bands);
    enum mr_status status = store_bands(store, run, &bands->band, &bands->bands, error);
    if (status == MR_OK)
        status = store_band_events(store, run, &bands->event, &bands->events, error);
    if (status == MR_OK)
        status = load_shunts(store, &measured->landing, bands, error);
    return status;
}

void bands_free(struct bands_summary *bands)
{
    free(bands->band);
    free(bands->event);
    *bands = (struct bands_summary){0};
}

double bands_ahead_ft(const struct measured *measured, int64_t gage, int64_t block)
{
    int c = gage > 0 && gage <= MR_GAGES ? measured_find(measured, MR_KIND_TENSION, (unsigned)gage) : -1;
    if (c < 0 || block == STORE_NONE)
        return (double)NAN;
    double t_s = (1000.0 * (double)(block - 1) - (double)measured->t0_us) * 1e-6; /* middle of the four blocks up to it */
    return (double)measured->channel[c].config.station_ft - measured_station_ft(measured, t_s);
}

double bands_recovery(const struct store_band *band)
{
    return band->before_lb > 0.0 ? band->after_lb / band->before_lb : (double)NAN;
}

void bands_event_text(const struct store_band_event *event, bool si, char *out, size_t size)
{
    const struct unit *force = unit_of(UNIT_TENSION, si);
    char other[40] = "";
    if (event->other > 0)
        snprintf(other, sizeof other, event->reason == MR_BAND_UNEQUAL ? " to gage %lld" : ", towards gage %lld",
                 (long long)event->other);
    snprintf(out, size, "%s at gage %lld%s: %.1f %s", mr_band_reason_text((unsigned)event->reason), (long long)event->gage, other,
             event->value_lb * force->factor, force->text);
}

void bands_shunt_text(const struct bands_summary *bands, bool si, char *out, size_t size)
{
    const struct unit *force = unit_of(UNIT_TENSION, si);
    const struct bands_shunt *most = NULL;
    size_t used = 0, before = 0, after = 0;
    out[0] = '\0';
    for (size_t i = 0; i < bands->shunts; i++) {
        const struct bands_shunt *s = &bands->shunt[i];
        before += s->before_verdict != STORE_NONE;
        after += s->after_verdict != STORE_NONE;
        double drift_lb = fabs(s->after_lb - s->before_lb);
        if (!isnan(drift_lb) && (!most || drift_lb > fabs(most->after_lb - most->before_lb)))
            most = s;
    }
    if (bands->shunts == 0)
        return;
    used = (size_t)snprintf(out, size, "%zu gages before, %zu after", before, after);
    if (most && used < size)
        used += (size_t)snprintf(out + used, size - used, "; most drift %+.2f %s (%+.2f %%), gage %u",
                                 (most->after_lb - most->before_lb) * force->factor, force->text,
                                 100.0 * (most->after_lb / most->before_lb - 1.0), most->gage);
    for (size_t i = 0; i < bands->shunts && used < size; i++) {
        const struct bands_shunt *s = &bands->shunt[i];
        bool late = s->after_verdict > 0;
        if (!late && s->before_verdict <= 0)
            continue;
        double lb = late ? s->after_lb : s->before_lb;
        used += (size_t)snprintf(out + used, size - used, "; gage %u %s", s->gage,
                                 shunts_verdict_text(late ? s->after_verdict : s->before_verdict));
        if (!isnan(lb) && used < size)
            used += (size_t)snprintf(out + used, size - used, " (%.2f for %.2f %s)", lb * force->factor,
                                     s->expected_lb * force->factor, force->text);
    }
}

void bands_where_text(const struct measured *measured, int64_t gage, int64_t block, bool si, char *out, size_t size)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    double ahead_ft = bands_ahead_ft(measured, gage, block);
    int c = gage > 0 && gage <= MR_GAGES ? measured_find(measured, MR_KIND_TENSION, (unsigned)gage) : -1;
    out[0] = '\0';
    if (c < 0)
        return;
    double at = (double)measured->channel[c].config.station_ft * station->factor;
    if (isnan(ahead_ft))
        snprintf(out, size, " (at %.1f %s)", at, station->text);
    else
        snprintf(out, size, " (%.1f %s %s the wheel, at %.1f %s)", fabs(ahead_ft) * station->factor, station->text,
                 ahead_ft < 0.0 ? "behind" : "ahead of", at, station->text);
}

static void print_band(const struct store_band *band, const struct measured *measured, bool si, FILE *out)
{
    const struct unit *force = unit_of(UNIT_TENSION, si);
    char label[20], least[80], most[80];
    snprintf(label, sizeof label, "band %lld", (long long)band->band);
    if (isnan(band->before_lb))
        fprintf(out, "  %-13s not known before", label);
    else
        fprintf(out, "  %-13s %.1f %s before", label, band->before_lb * force->factor, force->text);
    bands_where_text(measured, band->least_gage, band->least_block, si, least, sizeof least);
    bands_where_text(measured, band->most_gage, band->most_block, si, most, sizeof most);
    if (!isnan(band->least_lb))
        fprintf(out, ", least %.1f%s, most %.1f%s", band->least_lb * force->factor, least, band->most_lb * force->factor, most);
    if (!isnan(band->after_lb))
        fprintf(out, ", recovered %.0f %%", 100.0 * bands_recovery(band));
    fputc('\n', out);
}

void bands_print(const struct bands_summary *bands, const struct measured *measured, bool si, FILE *out)
{
    char text[400];
    for (size_t i = 0; i < bands->bands; i++)
        print_band(&bands->band[i], measured, si, out);
    for (size_t i = 0; i < bands->events; i++) {
        char label[20];
        snprintf(label, sizeof label, "band %lld", (long long)bands->event[i].band);
        bands_event_text(&bands->event[i], si, text, sizeof text);
        fprintf(out, "  %-13s %s, block %lld\n", label, text, (long long)bands->event[i].block);
    }
    bands_shunt_text(bands, si, text, sizeof text);
    if (text[0])
        fprintf(out, "  %-13s %s\n", "shunts", text);
}

/* ---- JSON ---- */

static void set(json_t *object, const char *name, double lb, bool si)
{
    const struct unit *force = unit_of(UNIT_TENSION, si);
    char key[60];
    snprintf(key, sizeof key, "%s_%s", name, force->suffix);
    json_object_set_new(object, key, cli_json_number(lb * force->factor, 7));
}

static json_t *extreme_json(const struct measured *measured, double lb, double error_lb, int64_t gage, int64_t block, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    char key[40];
    json_t *object = json_object();
    set(object, "tension", lb, si);
    set(object, "error", error_lb, si);
    json_object_set_new(object, "gage", gage == STORE_NONE ? json_null() : json_integer((json_int_t)gage));
    json_object_set_new(object, "block", block == STORE_NONE ? json_null() : json_integer((json_int_t)block));
    snprintf(key, sizeof key, "ahead_of_wheel_%s", station->suffix);
    json_object_set_new(object, key, cli_json_number(bands_ahead_ft(measured, gage, block) * station->factor, 5));
    return object;
}

static json_t *band_json(const struct store_band *band, const struct measured *measured, bool si)
{
    json_t *object = json_pack("{sI}", "band", (json_int_t)band->band);
    set(object, "before", band->before_lb, si);
    set(object, "before_error", band->before_error_lb, si);
    set(object, "spread", band->spread_lb, si);
    json_object_set_new(object, "least",
                        extreme_json(measured, band->least_lb, band->least_error_lb, band->least_gage, band->least_block, si));
    json_object_set_new(object, "most",
                        extreme_json(measured, band->most_lb, band->most_error_lb, band->most_gage, band->most_block, si));
    set(object, "after", band->after_lb, si);
    set(object, "change", band->change_lb, si);
    set(object, "change_error", band->change_error_lb, si);
    json_object_set_new(object, "recovered", cli_json_number(bands_recovery(band), 5));
    return object;
}

void bands_json(const struct bands_summary *bands, const struct measured *measured, bool si, json_t *object)
{
    json_t *rows = json_array(), *events = json_array(), *shunts = json_array();
    for (size_t i = 0; i < bands->bands; i++)
        json_array_append_new(rows, band_json(&bands->band[i], measured, si));
    for (size_t i = 0; i < bands->events; i++) {
        const struct store_band_event *event = &bands->event[i];
        json_t *row = json_pack("{sIsIsIsIsssI}", "band", (json_int_t)event->band, "gage", (json_int_t)event->gage, "other",
                                (json_int_t)event->other, "reason", (json_int_t)event->reason, "text",
                                mr_band_reason_text((unsigned)event->reason), "block", (json_int_t)event->block);
        set(row, "value", event->value_lb, si);
        json_array_append_new(events, row);
    }
    for (size_t i = 0; i < bands->shunts; i++) {
        const struct bands_shunt *s = &bands->shunt[i];
        json_t *row = json_pack("{sissss}", "gage", (int)s->gage, "before", shunts_verdict_text(s->before_verdict), "after",
                                shunts_verdict_text(s->after_verdict));
        set(row, "expected", s->expected_lb, si);
        set(row, "span_before", s->before_lb, si);
        set(row, "span_after", s->after_lb, si);
        set(row, "drift", s->after_lb - s->before_lb, si);
        json_array_append_new(shunts, row);
    }
    json_object_set_new(object, "bands", rows);
    json_object_set_new(object, "band_events", events);
    json_object_set_new(object, "shunts", shunts);
}
