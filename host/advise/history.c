#include "host/advise/history.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/runway.h"
#include "host/analyse/measured_load.h"
#include "host/analyse/zones.h"
#include "host/store/store_journal.h"
#include "host/store/store.h"
#include "host/survey/survey.h"
#include "host/base/xmalloc.h"

/* Below this speed, the deceleration due to braking cannot be separated from the final movement at
 * the stop. */
#define MIN_SPEED_FT_S 1.0

static void fill_nan(double sum_in[MR_SEGMENTS])
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = (double)NAN;
}

/* ---- surveys ---- */

/* Loads the newest gage survey with readings that began between the two times. */
static enum mr_status load_gage_survey(struct store *store, int64_t from_us, int64_t to_us,
                                       double sum_in[MR_SEGMENTS], double *error_in,
                                       struct error *error)
{
    static struct survey_results found;
    bool there;
    enum mr_status status = survey_evaluate_between(store, from_us, to_us, &found, &there, error);
    for (unsigned s = 0; status == MR_OK && there && s < MR_SEGMENTS; s++) {
        const struct survey_estimate *segment = &found.slack.segment[s];
        sum_in[s] = segment->value_in;
        if (segment->error_in > *error_in)
            *error_in = segment->error_in;
    }
    return status;
}

/* Loads the joint openings that the board had stored before the landing. An opening exactly equal
 * to that before the previous landing was not measured again, and is ignored. */
static enum mr_status load_survey(struct store *store, int64_t run, float last_in[MR_SEGMENTS],
                                  double sum_in[MR_SEGMENTS], struct error *error)
{
    struct zones_slack closure;
    enum mr_status status = zones_load_survey(store, run, &closure, error);
    for (unsigned s = 0; status == MR_OK && s < MR_SEGMENTS; s++) {
        float now_in = closure.slack_in[s];
        if (isfinite(now_in) && (now_in < last_in[s] || now_in > last_in[s] || isnan(last_in[s])))
            sum_in[s] = (double)now_in;
        last_in[s] = now_in;
    }
    return status;
}

/* ---- a landing ---- */

/* Sets the braking over time, relative to its mean, from the fit that the board makes after the
 * landing. */
static void set_profile(const struct measured_landing *measured, struct history_landing *landing)
{
    struct advise_profile *profile = &landing->profile;
    double width_s = measured->summary.stop_t_s.value / ADVISE_PROFILE_MAX, error;
    for (size_t i = 0; i < ADVISE_PROFILE_MAX; i++) {
        double from = measured_speed_ft_s(measured, width_s * (double)i, &error),
               to = measured_speed_ft_s(measured, width_s * (double)(i + 1), &error);
        if (!isfinite(from) || !isfinite(to) || from < MIN_SPEED_FT_S)
            break;
        profile->t_s[i] = width_s * ((double)i + 0.5);
        profile->factor[i] = fmax((from - to) / width_s, 0.0) /
                             landing->observation.braking.mean_braking_ft_s2;
        profile->point_count++;
    }
}

static void set_readings(const struct measured_landing *measured, struct history *history,
                         struct history_landing *landing)
{
    landing->observation.movement_error_in = 0.0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        bool own = channel->config.kind == MR_KIND_DISPLACEMENT &&
                   fabsf(channel->config.station_ft - history->runway.transducer_station_ft[i]) <
                       0.01f;
        landing->observation.movement_in[i] = own ? channel->end : (double)NAN;
        if (own && channel->end_error > landing->observation.movement_error_in)
            landing->observation.movement_error_in = channel->end_error;
    }
}

static enum mr_status load_landing(struct store *store, struct history *history,
                                   struct history_landing *landing, bool last, struct error *error)
{
    struct measured_landing measured;
    enum mr_status status = measured_load(store, landing->run, &measured, error);
    const struct mr_gates_summary *summary = &measured.summary;
    if (status == MR_OK) {
        double speed_ft_s = summary->touchdown_speed_ft_s.value,
               stopping_distance_ft = summary->stop_station_ft.value -
                                      measured.landing.touchdown_ft;
        landing->is_measured = measured.fit_status == MR_OK && speed_ft_s > MIN_SPEED_FT_S &&
                               stopping_distance_ft > 1.0 && summary->stop_t_s.value > 0.0;
        history->touchdown_ft = measured.landing.touchdown_ft;
        if (landing->is_measured) {
            landing->observation.braking = (struct advise_braking){
                .speed_ft_s = speed_ft_s,
                .touchdown_ft = measured.landing.touchdown_ft,
                .mean_braking_ft_s2 = speed_ft_s * speed_ft_s / (2.0 * stopping_distance_ft),
            };
            set_profile(&measured, landing);
            set_readings(&measured, history, landing);
        }
    }
    if (status == MR_OK && last)
        status = braking_load(store, &measured, &history->braking, error);
    measured_free(&measured);
    return status;
}

/* Loads the last advice that was stored after RUN `after` and before the landing. */
static enum mr_status load_plan(struct store *store, int64_t after, struct history_landing *landing,
                                struct error *error)
{
    struct store_advice *advice = NULL;
    size_t count = 0;
    enum mr_status status = store_advices_get(store, &advice, &count, error);
    landing->planned_deceleration_ft_s2 = (double)NAN;
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (advice[i].after_run >= after && advice[i].after_run < landing->run)
            landing->planned_deceleration_ft_s2 = advice[i].deceleration_ft_s2;
    }
    free(advice);
    return status;
}

/* ---- campaign ---- */

/* Reads the properties of the runway from the newest landing that has all parameters. */
static enum mr_status load_runway(struct store *store, const struct store_landing *row,
                                  size_t count, struct history *history, struct error *error)
{
    for (size_t i = count; i-- > 0;) {
        struct mr_predictor_config config;
        size_t items = 0;
        enum mr_status status = store_predict_config_get(store, row[i].id, &config, &items, error);
        if (status != MR_OK)
            return status;
        if (items != (size_t)MR_PREDICT_ITEM_COUNT)
            continue;
        history->runway = (struct advise_runway){.chain = config.chain,
                                                 .grit_lb = (double)config.grit_lb,
                                                 .thrust_lb_per_g = (double)config.thrust_lb_per_g,
                                                 .ground_irregularity_ft = (double)config.bump_ft};
        memcpy(history->runway.transducer_station_ft, config.station_ft,
               sizeof history->runway.transducer_station_ft);
        history->segment_count = config.chain.mats / MR_MATS_PER_SEGMENT;
        return MR_OK;
    }
    return error_set(
        error, MR_TOO_FEW,
        "runway unknown: %s has no landing with the parameters of the board's predictor; log a "
        "landing with a board that runs the predictor (matrig board config)",
        store_path(store));
}

/* Selects the landings from which the ensemble is updated: those before RUN `before`, of the board
 * that recorded the latest landing. */
static enum mr_status select_landings(struct store *store, int64_t before,
                                      struct store_landing **rows, size_t *count,
                                      struct history *history, int64_t *end_us, struct error *error)
{
    size_t all = 0, kept = 0;
    char reason[STORE_JOURNAL_TEXT_SIZE];
    bool found = before == 0;
    enum mr_status status = store_landings_get(store, rows, &all, error);
    for (size_t i = 0; status == MR_OK && i < all; i++) {
        if (before && (*rows)[i].id == before) {
            found = true;
            *end_us = (*rows)[i].armed_us;
            all = i;
        }
    }
    if (status == MR_OK && !found)
        return error_set(error, MR_UNKNOWN, "no RUN %lld: %s", (long long)before,
                         store_path(store));
    for (size_t i = 0; status == MR_OK && i < all; i++) {
        bool is_void = false;
        history->newest_run = (*rows)[i].id > history->newest_run ? (*rows)[i].id
                                                                  : history->newest_run;
        if (strcmp((*rows)[i].board_uid, (*rows)[all - 1].board_uid) != 0)
            continue;
        status = store_is_void(store, (*rows)[i].id, &is_void, reason, error);
        history->voided_landing_count += is_void;
        if (status == MR_OK && !is_void)
            (*rows)[kept++] = (*rows)[i];
    }
    *count = kept;
    return status;
}

static enum mr_status load_series(struct store *store, const struct store_landing *row,
                                  size_t count, struct history *history, int64_t end_us,
                                  struct error *error)
{
    struct store_series series = {0}, *all = NULL;
    size_t series_count = 0;
    int64_t last = 0, newest = 0;
    enum mr_status status = store_all_series_get(store, &all, &series_count, error);
    for (size_t i = 0; status == MR_OK && i < series_count; i++) {
        if (all[i].made_us <= end_us)
            newest = all[i].id;
    }
    free(all);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        series.id = 0;
        status = store_landing_series_get(store, &row[i], &series, error);
        history->landing[i].is_relaid = i > 0 && series.id != last;
        last = series.id;
    }
    history->is_relaid_since_landing = count > 0 && newest > last;
    return status;
}

enum mr_status history_load(struct store *store, int64_t before, struct history *history,
                            struct error *error)
{
    struct store_landing *row = NULL;
    size_t count = 0;
    int64_t end_us = INT64_MAX;
    float last_in[MR_SEGMENTS];
    *history = (struct history){.touchdown_ft = (double)NAN,
                                .survey_error_in = SURVEY_READING_ERROR_IN};
    fill_nan(history->segment_sum_in);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        last_in[s] = NAN;
    enum mr_status status = select_landings(store, before, &row, &count, history, &end_us, error);
    if (status == MR_OK && before && !count)
        status = error_set(error, MR_TOO_FEW,
                           "the campaign has no landing before RUN %lld: %s; give a later RUN",
                           (long long)before, store_path(store));
    if (status == MR_OK)
        status = load_runway(store, row, count, history, error);
    history->landing = status == MR_OK ? xcalloc(count, sizeof *history->landing) : NULL;
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        struct history_landing *landing = &history->landing[i];
        struct advise_observation *observation = &landing->observation;
        landing->run = row[i].id;
        observation->survey_error_in = history->survey_error_in;
        fill_nan(observation->survey_before_in);
        fill_nan(observation->survey_after_in);
        status = load_landing(store, history, landing, i + 1 == count, error) ?:
                 load_survey(store, row[i].id, last_in, observation->survey_before_in, error) ?:
                 load_gage_survey(store, i ? row[i - 1].armed_us : INT64_MIN, row[i].armed_us,
                             observation->survey_before_in, &observation->survey_error_in, error) ?:
                 load_plan(store, i ? row[i - 1].id : 0, landing, error);
        history->landing_count++;
    }
    if (status == MR_OK)
        status = load_series(store, row, count, history, end_us, error);
    if (status == MR_OK && before)
        status = load_survey(store, before, last_in, history->segment_sum_in, error);
    if (status == MR_OK)
        status = load_gage_survey(store, row[count - 1].armed_us, end_us, history->segment_sum_in,
                                  &history->survey_error_in, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        bool last = i + 1 == count,
             anew = last ? history->is_relaid_since_landing : history->landing[i + 1].is_relaid;
        if (!anew)
            memcpy(history->landing[i].observation.survey_after_in,
                   last ? history->segment_sum_in
                        : history->landing[i + 1].observation.survey_before_in,
                   sizeof history->segment_sum_in);
        history->landing[i].observation.braking.profile = &history->landing[i].profile;
    }
    if (status == MR_OK)
        status = inspection_load(store, &history->inspections, error);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        history->surveyed_segment_count += isfinite(history->segment_sum_in[s]) ? 1u : 0u;
    free(row);
    return status;
}

void history_free(struct history *history)
{
    free(history->landing);
    inspection_free(&history->inspections);
    history->landing = NULL;
}
