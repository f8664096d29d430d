#include "host/analyse/zones.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/store/store.h"

#define ZONES_QUIET (ZONES_HEARD_TEXT + 50)

double zones_time_s(const struct measured *measured, const struct store_zone *zone)
{
    return measured_block_s(measured, zone->block);
}

static void zones_when(const struct zone_warning *warning, bool since_touchdown, char *out,
                       size_t size)
{
    snprintf(out, size, "%.3f s %s %s, decided in block %lld", fabs(warning->t_s),
             warning->t_s < 0.0 ? "before" : "after",
             since_touchdown ? "touchdown" : "the first switch or arming",
             (long long)warning->block);
}

static struct zone_warning first_warning(const struct measured *measured,
                                         const struct store_zone *row)
{
    struct zone_warning warning = {
        .warned = true,
        .block = row->block,
        .t_s = zones_time_s(measured, row),
        .mats = row->mats,
        .start_ft = row->start_ft,
        .end_ft = row->end_ft,
        .wheel_ft = row->wheel_ft,
        .inferred_percent = row->inferred_percent,
        .lead_s = (double)NAN,
        .lead_t_s = (double)NAN,
        .lead_start_ft = (double)NAN,
        .lead_became_s = (double)NAN,
        .reason = STORE_NONE,
        .level = STORE_NONE,
        .start_error_ft = (double)NAN,
        .end_error_ft = (double)NAN,
        .coming_mats = STORE_NONE,
        .coming_wheel_ft = (double)NAN,
        .coming_after_s = (double)NAN,
    };
    warning.path_known = measured->fit_status == MR_OK;
    warning.reached_t_s = measured_reach_s(measured, row->start_ft);
    warning.reached = !isnan(warning.reached_t_s);
    if (warning.reached_t_s < warning.t_s) /* it was in the zone already */
        warning.reached_t_s = warning.t_s;
    warning.true_lead_s = warning.reached_t_s - warning.t_s;
    return warning;
}

/* What the predictor said with the first warning. */
static enum mr_status find_reason(struct store *store, const struct measured *measured,
                                  struct zones *zones, struct error *error)
{
    struct store_prediction *row = NULL;
    size_t count = 0;
    struct zone_warning *warning = &zones->warning;
    enum mr_status status = warning->warned
                              ? store_predictions(store, measured->landing.id, &row, &count, error)
                              : MR_OK;
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (row[i].block != warning->block)
            continue;
        warning->reason = row[i].reason;
        warning->level = row[i].level;
        warning->start_error_ft = row[i].start_error_ft;
        warning->end_error_ft = row[i].end_error_ft;
        warning->coming_mats = row[i].coming_mats;
        warning->coming_wheel_ft = row[i].coming_wheel_ft;
        warning->coming_after_s =
            fmax(measured_reach_s(measured, row[i].coming_wheel_ft), warning->t_s) - warning->t_s;
        if (isnan(measured_reach_s(measured, row[i].coming_wheel_ft)))
            warning->coming_after_s = (double)NAN;
    }
    free(row);
    return status;
}

static void find_warning(const struct measured *measured, struct zones *zones)
{
    struct zone_warning *warning = &zones->warning;
    for (size_t i = 0; i < zones->count; i++) {
        const struct store_zone *row = &zones->row[i];
        if (row->warning != 1)
            continue;
        if (!warning->warned)
            *warning = first_warning(measured, row);
        if (isnan(warning->lead_s) && !isnan(row->lead_s)) {
            warning->lead_s = row->lead_s;
            warning->lead_t_s = zones_time_s(measured, row);
            warning->lead_start_ft = row->start_ft;
            warning->lead_became_s = measured_reach_s(measured, row->start_ft) - warning->lead_t_s;
        }
        if (row->mats > warning->most_mats) {
            warning->most_mats = row->mats;
            warning->most_start_ft = row->start_ft;
            warning->most_end_ft = row->end_ft;
        }
    }
}

enum mr_status zones_load(struct store *store, const struct measured *measured, struct zones *zones,
                          struct error *error)
{
    memset(zones, 0, sizeof *zones);
    enum mr_status status = store_zones(store, measured->landing.id, &zones->row, &zones->count,
                                        error);
    if (status != MR_OK)
        return status;
    zones->heard = zones_heard(measured, zones->row, zones->count);
    find_warning(measured, zones);
    return find_reason(store, measured, zones, error);
}

void zones_free(struct zones *zones)
{
    free(zones->row);
}

enum mr_status zones_load_survey(struct store *store, int64_t run, struct zones_closure *closure,
                                 struct error *error)
{
    struct store_segment *rows;
    size_t count;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        closure->slack_in[s] = MR_NAN;
    closure->surveyed = 0;
    enum mr_status status = store_segments(store, run, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].segment < 0 || rows[i].segment >= (int64_t)MR_SEGMENTS ||
            isnan(rows[i].slack_in))
            continue;
        closure->slack_in[rows[i].segment] = (float)rows[i].slack_in;
        closure->surveyed++;
    }
    free(rows);
    return status;
}

void zones_closed(const struct measured *measured, const struct zones_closure *closure,
                  size_t sample, float remaining_in[MR_SEGMENTS], struct mr_closure_zone *zone)
{
    float station_ft[MR_TRANSDUCERS];
    float displacement_in[MR_TRANSDUCERS];
    double t_s = measured_time_s(measured, sample);
    double error_ft_s;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        station_ft[i] = channel->config.station_ft;
        displacement_in[i] = channel->config.kind == MR_KIND_DISPLACEMENT
                               ? (float)measured_smooth(measured, channel, sample,
                                                        MEASURED_WINDOW / 2)
                               : MR_NAN;
    }
    struct mr_closure_input input = {
        .station_ft = station_ft,
        .displacement_in = displacement_in,
        .slack_in = closure->slack_in,
        .wheel_ft = (float)measured_station_ft(measured, t_s),
        .speed_ft_s = (float)measured_speed_ft_s(measured, t_s, &error_ft_s),
        .deceleration_ft_s2 = (float)measured->summary.mean_deceleration_ft_s2.value,
    };
    mr_closure_find(&input, zone, remaining_in);
}

/* ---- answer ---- */

static const char *if_known(const char *label, double value)
{
    return isnan(value) ? NULL : label;
}

static void reason_answer(const struct zone_warning *w, struct answer *answer)
{
    if (w->reason == STORE_NONE)
        answer_none(answer, "reason", NULL, "");
    else
        answer_words(answer, "reason", "because", "%s",
                     mr_predictor_reason_text((unsigned)w->reason));
    if (w->level == STORE_NONE)
        answer_none(answer, "level", NULL, "");
    else
        answer_words(answer, "level", "model", "%s", mr_predictor_level_text((unsigned)w->level));
    answer_count(answer, "coming_mats", w->coming_mats > 0 ? "zone foreseen, mats" : NULL,
                 w->coming_mats);
    answer_value(answer, "coming_wheel", w->coming_mats > 0 ? "with the wheel at" : NULL,
                 UNIT_STATION, w->coming_wheel_ft, 1)
        ->digits = 9;
    answer_value(answer, "coming_after", if_known("wheel came there", w->coming_after_s), UNIT_TIME,
                 w->coming_after_s, 3)
        ->end = " after the warning";
}

static const char *not_reached(const struct zone_warning *w)
{
    return w->path_known ? "never: the gear stopped before"
                         : "not known: the record does not show where the gear stopped";
}

static void lead_answer(const struct zone_warning *w, struct answer *answer)
{
    const char *became = isnan(w->lead_s) ? NULL : "it really took";
    answer_value(answer, "lead", if_known("lead time", w->lead_s), UNIT_TIME, w->lead_s, 3)->end =
        " to the zone's start, the first that the board gave";
    answer_value(answer, "lead_t", if_known("given at", w->lead_s), UNIT_TIME, w->lead_t_s, 3)
        ->digits = 9;
    answer_value(answer, "lead_start", if_known("zone's start then", w->lead_s), UNIT_STATION,
                 w->lead_start_ft, 1)
        ->digits = 9;
    if (became && isnan(w->lead_became_s))
        answer_none(answer, "lead_became_s", became, not_reached(w));
    else
        answer_value(answer, "lead_became", became, UNIT_TIME, w->lead_became_s, 3);
}

/* What a warning said, and what came of it. */
static void warning_answer(const struct zone_warning *w, struct answer *answer)
{
    answer_value(answer, "t", NULL, UNIT_TIME, w->t_s, 3)->digits = 9;
    answer_count(answer, "decided_block", NULL, w->block);
    answer_count(answer, "mats", "closed mats", w->mats);
    answer_estimate(answer, "start", "from station", UNIT_STATION, w->start_ft, w->start_error_ft,
                    1)
        ->digits = 9;
    answer_estimate(answer, "end", "to station", UNIT_STATION, w->end_ft, w->end_error_ft, 1)
        ->digits = 9;
    answer_value(answer, "wheel", if_known("wheel was at", w->wheel_ft), UNIT_STATION, w->wheel_ft,
                 1)
        ->digits = 9;
    answer_count(answer, "inferred_percent", NULL, w->inferred_percent);
    if (w->inferred_percent > 0)
        answer_words(answer, NULL, "inferred", "%lld %% of it, from the survey alone",
                     (long long)w->inferred_percent);
    answer_flag(answer, "reached", NULL, w->reached);
    if (w->reached)
        answer_value(answer, "true_lead", "wheel in the zone", UNIT_TIME, w->true_lead_s, 3)->end =
            " after the warning";
    else
        answer_none(answer, "true_lead_s", "wheel in the zone", not_reached(w));
    reason_answer(w, answer);
    lead_answer(w, answer);
    answer_count(answer, "most_mats", "longest, mats", w->most_mats);
    answer_value(answer, "most_start", "its start", UNIT_STATION, w->most_start_ft, 1)->digits = 9;
    answer_value(answer, "most_end", "its end", UNIT_STATION, w->most_end_ft, 1)->digits = 9;
}

/* "no warning", or that none was received and why one may have come nevertheless. */
static void quiet_text(const struct zones *zones, char out[ZONES_QUIET])
{
    char doubt[ZONES_HEARD_TEXT];
    if (zones_heard_doubt(&zones->heard, (double)INFINITY, doubt))
        snprintf(out, ZONES_QUIET, "no warning was heard, one may have come: %s", doubt);
    else
        snprintf(out, ZONES_QUIET, "no warning");
}

bool zones_earlier_text(const struct zones *zones, char out[ZONES_HEARD_TEXT])
{
    const struct zone_warning *w = &zones->warning;
    return w->warned && zones_heard_doubt(&zones->heard, w->t_s, out);
}

/* In words whether and when; and whether the record can know that. */
static void warned_answer(const struct zones *zones, struct answer *answer)
{
    const struct zone_warning *w = &zones->warning;
    char when[80], quiet[ZONES_QUIET], doubt[ZONES_HEARD_TEXT];
    zones_when(w, zones->heard.since_touchdown, when, sizeof when);
    quiet_text(zones, quiet);
    if (w->warned)
        answer_words(answer, NULL, "zone", "warned %s", when)->warn = true;
    else
        answer_words(answer, NULL, "zone", "%s", quiet)->warn =
            zones_heard_doubt(&zones->heard, (double)INFINITY, doubt);
    if (zones_earlier_text(zones, doubt))
        answer_words(answer, NULL, "zone", "an earlier one may have come: %s", doubt)->warn = true;
}

void zones_answer(const struct zones *zones, bool watched, struct answer *answer)
{
    const struct zone_warning *w = &zones->warning;
    const struct zones_heard *heard = &zones->heard;
    char doubt[ZONES_HEARD_TEXT];
    if (watched)
        warned_answer(zones, answer);
    else
        answer_words(answer, NULL, "zone",
                     "no board watched: the readings are another instrument's");
    bool first = !zones_earlier_text(zones, doubt);
    answer_open(answer, "zone",
                !w->warned ? NULL
                : first    ? "first warning (+- is one standard error)"
                           : "first warning that was heard (+- is one standard error)");
    answer_flag(answer, "warned", NULL, w->warned);
    answer_flag(answer, "all_heard", NULL,
                watched && !zones_heard_doubt(heard, (double)INFINITY, doubt));
    answer_value(answer, "unheard_from", NULL, UNIT_TIME, heard->pause_from_s, 3)->digits = 9;
    answer_value(answer, "unheard_to", NULL, UNIT_TIME, heard->pause_to_s, 3)->digits = 9;
    if (w->warned)
        warning_answer(w, answer);
    answer_close(answer);
}

#define PAUSE_BLOCKS 100 /* two statements: a frame that is lost alone hides no warning for long */

struct zones_heard zones_heard(const struct measured *measured, const struct store_zone *row,
                               size_t count)
{
    const struct store_landing *landing = &measured->landing;
    struct zones_heard heard = {.any = count > 0,
                                .ended = landing->state == MR_LANDING_DONE ||
                                         landing->state == MR_LANDING_IDLE,
                                .pause_from_s = (double)NAN,
                                .pause_to_s = (double)NAN,
                                .since_touchdown = measured->t0_is_touchdown};
    int64_t longest = PAUSE_BLOCKS;
    if (count == 0)
        return heard;
    heard.first_s = measured_block_s(measured, row[0].block);
    heard.last_s = measured_block_s(measured, row[count - 1].block);
    heard.late = landing->armed_block == STORE_NONE ||
                 row[0].block - landing->armed_block > PAUSE_BLOCKS;
    for (size_t i = 1; i < count; i++) {
        if (row[i].block - row[i - 1].block <= longest)
            continue;
        longest = row[i].block - row[i - 1].block;
        heard.pause_from_s = measured_block_s(measured, row[i - 1].block);
        heard.pause_to_s = measured_block_s(measured, row[i].block);
    }
    return heard;
}

static void add(char out[ZONES_HEARD_TEXT], const char *text)
{
    size_t used = strlen(out);
    snprintf(out + used, ZONES_HEARD_TEXT - used, "%s%s", used ? "; " : "", text);
}

bool zones_heard_doubt(const struct zones_heard *heard, double before_s, char out[ZONES_HEARD_TEXT])
{
    const char *since = heard->since_touchdown ? "touchdown" : "the first switch or arming";
    char text[160];
    out[0] = '\0';
    if (!heard->any) {
        add(out, "the record has nothing that the board said of zones");
        return true;
    }
    if (heard->late) {
        snprintf(text, sizeof text, "nothing was heard of zones before %.3f s after %s",
                 heard->first_s, since);
        add(out, text);
    }
    if (heard->pause_from_s < before_s) {
        snprintf(text, sizeof text, "nothing was heard of zones from %.3f to %.3f s after %s",
                 heard->pause_from_s, heard->pause_to_s, since);
        add(out, text);
    }
    if (!heard->ended && isinf(before_s)) {
        snprintf(text, sizeof text,
                 "the record ends %.3f s after %s, before the board said that the landing is over",
                 heard->last_s, since);
        add(out, text);
    }
    return out[0] != '\0';
}
