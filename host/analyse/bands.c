#include "host/board/gage_client.h"
#include "host/analyse/bands.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/units.h"

/* Finds the block in which the board was armed for the next landing of the session; INT64_MAX: it
 * was not armed again. */
static enum mr_status find_next_arming(struct store *store, const struct store_landing *landing,
                                       int64_t *block, struct error *error)
{
    struct store_landing *rows = NULL;
    size_t count = 0;
    *block = INT64_MAX;
    enum mr_status status = store_landings_get(store, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        const struct store_landing *row = &rows[i];
        if (row->session == landing->session && row->boot == landing->boot &&
            row->armed_block > landing->armed_block && row->armed_block < *block)
            *block = row->armed_block;
    }
    free(rows);
    return status;
}

static struct bands_shunt *find_or_add_shunt(struct bands_summary *bands, int64_t gage)
{
    for (size_t i = 0; i < bands->shunt_count; i++) {
        if (bands->shunt[i].gage == gage)
            return &bands->shunt[i];
    }
    if (gage < 1 || gage > MR_GAGES || bands->shunt_count == MR_GAGES)
        return NULL;
    struct bands_shunt *made = &bands->shunt[bands->shunt_count++];
    *made = (struct bands_shunt){.gage = (unsigned)gage,
                                 .expected_lb = (double)NAN,
                                 .before_lb = (double)NAN,
                                 .after_lb = (double)NAN,
                                 .verdict_before = STORE_NONE,
                                 .verdict_after = STORE_NONE};
    return made;
}

static enum mr_status load_shunts(struct store *store, const struct store_landing *landing,
                                  struct bands_summary *bands, struct error *error)
{
    struct store_shunt *rows[2] = {NULL, NULL};
    size_t count[2] = {0, 0};
    int64_t next = INT64_MAX;
    if (landing->armed_block == STORE_NONE)
        return MR_OK;
    enum mr_status status = find_next_arming(store, landing, &next, error) ?:
                            store_shunts_before_get(store, landing->session, landing->boot,
                                                landing->armed_block, &rows[0], &count[0], error) ?:
                            store_shunts_after_get(store, landing->session, landing->boot,
                                               landing->armed_block, &rows[1], &count[1], error);
    for (int side = 0; side < 2; side++) {
        for (size_t i = 0; status == MR_OK && i < count[side]; i++) {
            const struct store_shunt *row = &rows[side][i];
            struct bands_shunt *shunt = side && row->block >= next
                                          ? NULL
                                          : find_or_add_shunt(bands, row->gage);
            if (!shunt)
                continue;
            bool measured = row->verdict == MR_SHUNT_GOOD || row->verdict == MR_SHUNT_WRONG;
            shunt->expected_lb = row->expected_lb;
            *(side ? &shunt->verdict_after : &shunt->verdict_before) = row->verdict;
            *(side ? &shunt->after_lb : &shunt->before_lb) = measured ? row->span_lb : (double)NAN;
        }
        free(rows[side]);
    }
    return status;
}

enum mr_status bands_load(struct store *store, const struct measured_landing *measured,
                          struct bands_summary *bands, struct error *error)
{
    int64_t run = measured->landing.id;
    memset(bands, 0, sizeof *bands);
    return store_bands_get(store, run, &bands->band, &bands->band_count, error) ?:
           store_band_events_get(store, run, &bands->event, &bands->event_count, error) ?:
           load_shunts(store, &measured->landing, bands, error);
}

void bands_free(struct bands_summary *bands)
{
    free(bands->band);
    free(bands->event);
    *bands = (struct bands_summary){0};
}

/* Distance in ft of a gage ahead of the lead wheel in a block; NaN: unknown. */
static double compute_wheel_distance_ft(const struct measured_landing *measured, int64_t gage,
                                        int64_t block)
{
    int c = gage > 0 && gage <= MR_GAGES
              ? measured_channel_index(measured, MR_KIND_TENSION, (unsigned)gage)
              : -1;
    if (c < 0 || block == STORE_NONE)
        return (double)NAN;
    /* middle of the four blocks that end with `block` */
    double t_s = (1000.0 * (double)(block - 1) - (double)measured->t0_us) * 1e-6;
    return (double)measured->channel[c].config.station_ft - measured_station_ft(measured, t_s);
}

/* Summarizes the shunt calibrations in one line; "": there are none. */
static void format_shunts(const struct bands_summary *bands, bool si, char *out, size_t size)
{
    const struct unit *force = unit_get(UNIT_TENSION, si);
    const struct bands_shunt *most = NULL;
    size_t used = 0, before = 0, after = 0;
    out[0] = '\0';
    for (size_t i = 0; i < bands->shunt_count; i++) {
        const struct bands_shunt *s = &bands->shunt[i];
        before += s->verdict_before != STORE_NONE;
        after += s->verdict_after != STORE_NONE;
        double drift_lb = fabs(s->after_lb - s->before_lb);
        if (!isnan(drift_lb) && (!most || drift_lb > fabs(most->after_lb - most->before_lb)))
            most = s;
    }
    if (bands->shunt_count == 0)
        return;
    used = (size_t)snprintf(out, size, "%zu gages before, %zu after", before, after);
    if (most && used < size)
        used += (size_t)snprintf(out + used, size - used,
                                 "; largest drift %+.2f %s (%+.2f %%), gage %u",
                                 (most->after_lb - most->before_lb) * force->factor, force->text,
                                 100.0 * (most->after_lb / most->before_lb - 1.0), most->gage);
    for (size_t i = 0; i < bands->shunt_count && used < size; i++) {
        const struct bands_shunt *s = &bands->shunt[i];
        bool late = s->verdict_after > 0;
        if (!late && s->verdict_before <= 0)
            continue;
        double lb = late ? s->after_lb : s->before_lb;
        used += (size_t)snprintf(out + used, size - used, "; gage %u %s", s->gage,
                                 shunts_verdict_text(late ? s->verdict_after : s->verdict_before));
        if (!isnan(lb) && used < size)
            used += (size_t)snprintf(out + used, size - used, " (%.2f for %.2f %s)",
                                     lb * force->factor, s->expected_lb * force->factor,
                                     force->text);
    }
}

/* ---- answers ---- */

/* The smallest or the largest tension, with its gage and its time (the middle of a block). */
struct extreme {
    /* headings of the columns: time of the gage, station of the gage, distance ahead of the
     * wheel */
    const char *key_name, *station_heading, *wheel_distance_heading;
    double tension_lb, error_lb;
    int64_t gage, block;
};

static void add_extreme(const struct extreme *e, const struct measured_landing *measured,
                        struct answer *answer)
{
    int c = e->gage > 0 && e->gage <= MR_GAGES
              ? measured_channel_index(measured, MR_KIND_TENSION, (unsigned)e->gage)
              : -1;
    answer_add_estimate(answer, NULL, e->key_name, UNIT_TENSION, e->tension_lb, e->error_lb, 1);
    answer_add_value(answer, NULL, e->station_heading, UNIT_STATION,
                     c < 0 ? (double)NAN : (double)measured->channel[c].config.station_ft, 1);
    answer_open_group(answer, e->key_name, "");
    answer_add_value(answer, "tension", NULL, UNIT_TENSION, e->tension_lb, 1)->digits = 7;
    answer_add_value(answer, "error", NULL, UNIT_TENSION, e->error_lb, 1)->digits = 7;
    answer_add_count(answer, "gage", NULL, e->gage);
    answer_add_count(answer, "block", NULL, e->block);
    answer_add_value(answer, "ahead_of_wheel", e->wheel_distance_heading, UNIT_STATION,
                     compute_wheel_distance_ft(measured, e->gage, e->block), 1)
        ->digits = 5;
    answer_close_group(answer);
}

static void add_band(const struct store_band *band, const struct measured_landing *measured,
                     struct answer *answer)
{
    const struct extreme least = {"least",          "least|at",           "ahead of|the wheel",
                                  band->least_lb,   band->least_error_lb, band->least_gage,
                                  band->least_block};
    const struct extreme most = {"most",          "most|at",           "ahead|of wheel",
                                 band->most_lb,   band->most_error_lb, band->most_gage,
                                 band->most_block};
    double recovered = band->before_lb > 0.0 ? band->after_lb / band->before_lb : (double)NAN;
    answer_open_row(answer);
    answer_add_count(answer, "band", "band", band->band);
    answer_add_estimate(answer, "before", "before", UNIT_TENSION, band->before_lb,
                        band->before_error_lb, 1)
        ->digits = 7;
    answer_add_value(answer, "spread", "spread", UNIT_TENSION, band->spread_lb, 1)->digits = 7;
    add_extreme(&least, measured, answer);
    add_extreme(&most, measured, answer);
    answer_add_value(answer, "after", "after", UNIT_TENSION, band->after_lb, 1)->digits = 7;
    answer_add_estimate(answer, "change", "change", UNIT_TENSION, band->change_lb,
                        band->change_error_lb, 3)
        ->digits = 7;
    answer_add_value(answer, "recovered", NULL, UNIT_NUMBER, recovered, 2)->digits = 5;
    answer_add_value(answer, NULL, "recovered|%", UNIT_NUMBER, 100.0 * recovered, 0);
}

static void add_event(const struct store_band_event *event, struct answer *answer)
{
    answer_open_row(answer);
    answer_add_count(answer, "band", "band", event->band);
    answer_add_text(answer, "text", "finding", "%s", mr_band_reason_text((unsigned)event->reason));
    answer_add_count(answer, "gage", "at gage", event->gage);
    answer_add_count(answer, "other", event->other > 0 ? "to gage" : NULL, event->other);
    answer_add_value(answer, "value", "value", UNIT_TENSION, event->value_lb, 1)->digits = 7;
    answer_add_count(answer, "reason", NULL, event->reason);
    answer_add_count(answer, "block", "block", event->block);
}

static void add_shunt(const struct bands_shunt *s, struct answer *answer)
{
    answer_open_row(answer);
    answer_add_count(answer, "gage", "gage", s->gage);
    answer_add_value(answer, "expected", "shunt", UNIT_TENSION, s->expected_lb, 2)->digits = 7;
    answer_add_value(answer, "span_before", "span before", UNIT_TENSION, s->before_lb, 2)->digits =
        7;
    answer_add_value(answer, "span_after", "span after", UNIT_TENSION, s->after_lb, 2)->digits = 7;
    answer_add_value(answer, "drift", "drift", UNIT_TENSION, s->after_lb - s->before_lb, 2)
        ->digits = 7;
    answer_add_text(answer, "before", "before", "%s", shunts_verdict_text(s->verdict_before));
    answer_add_text(answer, "after", "after", "%s", shunts_verdict_text(s->verdict_after));
}

void bands_to_answer(const struct bands_summary *bands, const struct measured_landing *measured,
                     struct answer *answer)
{
    answer_open_table(answer, "bands",
                      bands->band_count ? "band tension (+- is one standard error)" : NULL);
    for (size_t i = 0; i < bands->band_count; i++)
        add_band(&bands->band[i], measured, answer);
    answer_close_group(answer);
    answer_open_table(answer, "band_events",
                      bands->event_count ? "band events reported by the board" : NULL);
    for (size_t i = 0; i < bands->event_count; i++)
        add_event(&bands->event[i], answer);
    answer_close_group(answer);
}

void bands_add_shunts(const struct bands_summary *bands, bool each, struct answer *answer)
{
    char text[400];
    format_shunts(bands, answer_is_si(answer), text, sizeof text);
    if (text[0])
        answer_add_text(answer, NULL, "shunts", "%s", text);
    answer_open_table(answer, "shunts", each && bands->shunt_count ? "" : NULL);
    for (size_t i = 0; i < bands->shunt_count; i++)
        add_shunt(&bands->shunt[i], answer);
    answer_close_group(answer);
}
