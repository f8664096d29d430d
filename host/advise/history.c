#include "host/advise/history.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/runway.h"
#include "host/analyse/braking.h"
#include "host/analyse/measured_load.h"
#include "host/analyse/zones.h"
#include "host/store/store_journal.h"
#include "host/store/store.h"
#include "host/survey/survey.h"
#include "host/base/xmalloc.h"

#define LEAST_FT_S 1.0 /* at lower speeds braking and the end of the movement look alike */

static void blank(double sum_in[MR_SEGMENTS])
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = (double)NAN;
}

/* ---- surveys ---- */

/* The newest gage survey with readings that was begun between the two times. */
static enum mr_status gage_survey(struct store *store, int64_t from_us, int64_t to_us,
                                  double sum_in[MR_SEGMENTS], double *error_in, struct error *error)
{
    static struct survey_found found;
    bool there;
    enum mr_status status = survey_find_between(store, from_us, to_us, &found, &there, error);
    for (unsigned s = 0; status == MR_OK && there && s < MR_SEGMENTS; s++) {
        const struct survey_estimate *segment = &found.slack.segment[s];
        sum_in[s] = segment->value_in;
        if (segment->error_in > *error_in)
            *error_in = segment->error_in;
    }
    return status;
}

/* Openings that the board had before the landing. An opening equal to the previous landing's to
 * the last digit was not measured again. */
static enum mr_status surveyed_segments(struct store *store, int64_t run,
                                        float last_in[MR_SEGMENTS], double sum_in[MR_SEGMENTS],
                                        struct error *error)
{
    struct zones_closure closure;
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

/* Braking over time, relative to its mean, from the final fit. */
static void take_profile(const struct measured *measured, struct history_landing *landing)
{
    struct advise_profile *profile = &landing->profile;
    double width_s = measured->summary.stop_t_s.value / ADVISE_PROFILE, error;
    for (size_t i = 0; i < ADVISE_PROFILE; i++) {
        double from = measured_speed_ft_s(measured, width_s * (double)i, &error),
               to = measured_speed_ft_s(measured, width_s * (double)(i + 1), &error);
        if (!isfinite(from) || !isfinite(to) || from < LEAST_FT_S)
            break;
        profile->t_s[i] = width_s * ((double)i + 0.5);
        profile->factor[i] = fmax((from - to) / width_s, 0.0) / landing->seen.braking.mean_ft_s2;
        profile->count++;
    }
}

static void take_readings(const struct measured *measured, struct history *past,
                          struct history_landing *landing)
{
    landing->seen.moved_error_in = 0.0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        bool own = channel->config.kind == MR_KIND_DISPLACEMENT &&
                   fabsf(channel->config.station_ft - past->runway.station_ft[i]) < 0.01f;
        landing->seen.moved_in[i] = own ? channel->end : (double)NAN;
        if (own && channel->end_error > landing->seen.moved_error_in)
            landing->seen.moved_error_in = channel->end_error;
    }
}

static enum mr_status take_landing(struct store *store, struct history *past,
                                   struct history_landing *landing, struct error *error)
{
    struct measured measured;
    struct braking braking;
    enum mr_status status = measured_load(store, landing->run, &measured, error)
                              ?: braking_load(store, &measured, &braking, error);
    const struct mr_gates_summary *summary = &measured.summary;
    if (status == MR_OK) {
        double speed_ft_s = summary->touchdown_speed_ft_s.value,
               stopping_distance_ft = summary->stop_station_ft.value -
                                      measured.landing.touchdown_ft;
        landing->measured = measured.fit_status == MR_OK && speed_ft_s > LEAST_FT_S &&
                            stopping_distance_ft > 1.0 && summary->stop_t_s.value > 0.0;
        past->touchdown_ft = measured.landing.touchdown_ft;
        past->braked_ft_s2 = braking.deceleration_ft_s2;
        if (landing->measured) {
            landing->seen.braking = (struct advise_braking){
                .speed_ft_s = speed_ft_s,
                .touchdown_ft = measured.landing.touchdown_ft,
                .mean_ft_s2 = speed_ft_s * speed_ft_s / (2.0 * stopping_distance_ft),
            };
            take_profile(&measured, landing);
            take_readings(&measured, past, landing);
        }
    }
    measured_free(&measured);
    return status;
}

/* The last advice stored after RUN `after` and before the landing. */
static enum mr_status take_plan(struct store *store, int64_t after, struct history_landing *landing,
                                struct error *error)
{
    struct store_advice *advice = NULL;
    size_t count = 0;
    enum mr_status status = store_advices(store, &advice, &count, error);
    landing->planned_ft_s2 = (double)NAN;
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (advice[i].after_run >= after && advice[i].after_run < landing->run)
            landing->planned_ft_s2 = advice[i].deceleration_ft_s2;
    }
    free(advice);
    return status;
}

/* ---- campaign ---- */

/* Reads the runway from the newest landing with all parameters. */
static enum mr_status take_runway(struct store *store, const struct store_landing *row,
                                  size_t count, struct history *past, struct error *error)
{
    for (size_t i = count; i-- > 0;) {
        struct mr_predictor_config config;
        size_t items = 0;
        enum mr_status status = store_predict_config(store, row[i].id, &config, &items, error);
        if (status != MR_OK)
            return status;
        if (items != (size_t)MR_PREDICT_ITEMS)
            continue;
        past->runway = (struct advise_runway){.chain = config.chain,
                                              .grit_lb = (double)config.grit_lb,
                                              .thrust_lb_per_g = (double)config.thrust_lb_per_g,
                                              .bump_ft = (double)config.bump_ft};
        memcpy(past->runway.station_ft, config.station_ft, sizeof past->runway.station_ft);
        past->segments = config.chain.mats / MR_MATS_PER_SEGMENT;
        return MR_OK;
    }
    return error_set(error, MR_TOO_FEW,
                     "no runway: %s has no landing with the parameters of a predictor; log a "
                     "landing with a board that runs the predictor (matrig board config)",
                     store_path(store));
}

/* Landings to learn from: of the board that landed last, before RUN `before`. */
static enum mr_status choose(struct store *store, int64_t before, struct store_landing **rows,
                             size_t *count, struct history *past, int64_t *end_us,
                             struct error *error)
{
    size_t all = 0, kept = 0;
    char reason[STORE_JOURNAL_TEXT];
    bool found = before == 0;
    enum mr_status status = store_landings(store, rows, &all, error);
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
        past->newest_run = (*rows)[i].id > past->newest_run ? (*rows)[i].id : past->newest_run;
        if (strcmp((*rows)[i].board_uid, (*rows)[all - 1].board_uid) != 0)
            continue;
        status = store_is_void(store, (*rows)[i].id, &is_void, reason, error);
        past->voided += is_void;
        if (status == MR_OK && !is_void)
            (*rows)[kept++] = (*rows)[i];
    }
    *count = kept;
    return status;
}

static enum mr_status take_series(struct store *store, const struct store_landing *row,
                                  size_t count, struct history *past, int64_t end_us,
                                  struct error *error)
{
    struct store_series series = {0}, *all = NULL;
    size_t series_count = 0;
    int64_t last = 0, newest = 0;
    enum mr_status status = store_series_all(store, &all, &series_count, error);
    for (size_t i = 0; status == MR_OK && i < series_count; i++) {
        if (all[i].made_us <= end_us)
            newest = all[i].id;
    }
    free(all);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        series.id = 0;
        status = store_series_of(store, &row[i], &series, error);
        past->landing[i].relaid = i > 0 && series.id != last;
        last = series.id;
    }
    past->relaid = count > 0 && newest > last;
    return status;
}

enum mr_status history_load(struct store *store, int64_t before, struct history *past,
                            struct error *error)
{
    struct store_landing *row = NULL;
    size_t count = 0;
    int64_t end_us = INT64_MAX;
    float last_in[MR_SEGMENTS];
    *past = (struct history){.touchdown_ft = (double)NAN, .survey_error_in = SURVEY_ERROR_IN};
    blank(past->sum_in);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        last_in[s] = NAN;
    enum mr_status status = choose(store, before, &row, &count, past, &end_us, error);
    if (status == MR_OK && before && !count) /* RUN `before` is the first landing */
        status = error_set(error, MR_TOO_FEW, "no landing before RUN %lld: %s; give a later RUN",
                           (long long)before, store_path(store));
    if (status == MR_OK)
        status = take_runway(store, row, count, past, error);
    past->landing = status == MR_OK ? xcalloc(count, sizeof *past->landing) : NULL;
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        struct history_landing *landing = &past->landing[i];
        landing->run = row[i].id;
        landing->seen.survey_error_in = past->survey_error_in;
        blank(landing->seen.before_in);
        blank(landing->seen.after_in);
        status = take_landing(store, past, landing, error) ?:
                 surveyed_segments(store, row[i].id, last_in, landing->seen.before_in, error) ?:
                 gage_survey(store, i ? row[i - 1].armed_us : INT64_MIN, row[i].armed_us,
                             landing->seen.before_in, &landing->seen.survey_error_in, error) ?:
                 take_plan(store, i ? row[i - 1].id : 0, landing, error);
        past->landings++;
    }
    if (status == MR_OK)
        status = take_series(store, row, count, past, end_us, error);
    if (status == MR_OK && before)
        status = surveyed_segments(store, before, last_in, past->sum_in, error);
    if (status == MR_OK)
        status = gage_survey(store, row[count - 1].armed_us, end_us, past->sum_in,
                             &past->survey_error_in, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        bool last = i + 1 == count, anew = last ? past->relaid : past->landing[i + 1].relaid;
        if (!anew)
            memcpy(past->landing[i].seen.after_in,
                   last ? past->sum_in : past->landing[i + 1].seen.before_in, sizeof past->sum_in);
        past->landing[i].seen.braking.profile = &past->landing[i].profile;
    }
    if (status == MR_OK)
        status = inspection_load(store, &past->records, error);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        past->surveyed += isfinite(past->sum_in[s]) ? 1u : 0u;
    free(row);
    return status;
}

void history_free(struct history *past)
{
    free(past->landing);
    inspection_free(&past->records);
    past->landing = NULL;
}
