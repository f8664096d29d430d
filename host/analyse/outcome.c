#include "host/analyse/outcome.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/closure.h"
#include "common/wire.h"
#include "host/store/store_journal.h"
#include "host/survey/survey.h"

#define STEP_SAMPLES  20  /* of 1 ms: the wheel rolls 0.7 ft at most */
#define STEADY_STEPS  5   /* 0.1 s: a run that joins two for less is the segments' coarseness */
#define SLOW_FT_S     2.0 /* slower, the wheel is at the end of its way */
#define LEAST_WATCHED 0.5

const char *outcome_basis_text(enum outcome_basis basis)
{
    static const char *const text[OUTCOME_BASES] = {
        [OUTCOME_NOTHING] = "nothing",
        [OUTCOME_SEEN] = "what was seen",
        [OUTCOME_TRANSDUCERS] = "survey before and transducers",
        [OUTCOME_SURVEY_AFTER] = "survey after",
    };
    return text[basis];
}

/* ---- surveys ---- */

/* A board tells its survey with each landing, also one that is old. A survey was read anew where
 * at least half of its sums are others than before; of fewer, those alone are new: two readings of
 * a closed segment may be the same to the last digit. */
static enum mr_status told_survey(struct store *store, int64_t run, int64_t run_before,
                                  struct zones_closure *told, struct error *error)
{
    struct zones_closure last;
    size_t changed = 0;
    enum mr_status status = zones_load_survey(store, run, told, error);
    if (status != MR_OK || run_before == 0)
        return status;
    status = zones_load_survey(store, run_before, &last, error);
    bool other[MR_SEGMENTS];
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float now_in = told->slack_in[s], then_in = last.slack_in[s];
        other[s] = isfinite(now_in) && (isnan(then_in) || now_in < then_in || now_in > then_in);
        changed += other[s];
    }
    for (unsigned s = 0; s < MR_SEGMENTS && 2 * changed < told->surveyed; s++) {
        if (!other[s])
            told->slack_in[s] = MR_NAN;
    }
    told->surveyed = 2 * changed < told->surveyed ? changed : told->surveyed;
    return status;
}

/* The newest gage survey with readings that was begun between two moments, in place of what was
 * told. */
static enum mr_status gage_survey(struct store *store, int64_t from_us, int64_t to_us,
                                  struct zones_closure *slack, struct error *error)
{
    static struct survey_found found;
    bool there;
    enum mr_status status = survey_find_between(store, from_us, to_us, &found, &there, error);
    if (status != MR_OK || !there)
        return status;
    slack->surveyed = found.slack.surveyed;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack->slack_in[s] = (float)found.slack.segment[s].value_in;
    return MR_OK;
}

/* ---- transducers ---- */

/* The longest zone that the wheel came to, and from when on it was at one of 50 mats. */
struct came {
    unsigned mats;
    double start_ft, t_s; /* NaN: never for STEADY_STEPS */
};

static struct came play(const struct measured *measured, const struct zones_closure *slack)
{
    struct came came = {.start_ft = (double)NAN, .t_s = (double)NAN};
    unsigned steady = 0;
    double since_s = (double)NAN;
    for (size_t i = 0; i < measured->samples; i += STEP_SAMPLES) {
        float left_in[MR_SEGMENTS];
        struct mr_closure_zone zone;
        double t_s = measured_time_s(measured, i), error_ft_s,
               wheel_ft = measured_station_ft(measured, t_s);
        if (t_s > measured->summary.stop_t_s.value)
            break;
        if (isnan(wheel_ft) || !(measured_speed_ft_s(measured, t_s, &error_ft_s) > SLOW_FT_S))
            continue;
        zones_closed(measured, slack, i, left_in, &zone);
        bool at_it = zone.mats > 0 && (double)zone.start_ft - wheel_ft < OUTCOME_NEAR_FT;
        steady = at_it && zone.mats >= OUTCOME_MATS ? steady + 1 : 0;
        since_s = steady == 1 ? t_s : since_s;
        if (isnan(came.t_s) && steady == STEADY_STEPS)
            came.t_s = since_s;
        if (!at_it)
            continue;
        if (zone.mats > came.mats) {
            came.mats = zone.mats;
            came.start_ft = (double)zone.start_ft;
        }
    }
    return came;
}

/* Share of the way, from touchdown to 50 mats beyond the stop, between the first and the last
 * transducer that spoke to the end. */
static double watched_share(const struct measured *measured)
{
    double from_ft = measured->landing.touchdown_ft,
           to_ft = measured->summary.stop_station_ft.value +
                   OUTCOME_MATS * (double)MR_MAT_LENGTH_FT,
           first_ft = (double)NAN, last_ft = (double)NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        const struct measured_channel *channel = &measured->channel[i];
        if (channel->config.kind != MR_KIND_DISPLACEMENT || !isfinite(channel->end))
            continue;
        double at_ft = (double)channel->config.station_ft;
        first_ft = isnan(first_ft) ? at_ft : first_ft;
        last_ft = at_ft;
    }
    double watched_ft = fmin(last_ft, to_ft) - fmax(first_ft, from_ft);
    return isnan(first_ft) || !(to_ft > from_ft) ? 0.0 : fmax(0.0, watched_ft) / (to_ft - from_ft);
}

static void by_transducers(const struct measured *measured, const struct zones_closure *slack,
                           struct outcome *outcome)
{
    struct zones_closure closed = *slack; /* what was not surveyed taken as closed */
    if (measured->fit_status != MR_OK) {
        outcome->why = "its gear's way to a stop is not known";
        return;
    }
    if (slack->surveyed == 0) {
        outcome->why = "no survey was read between the landing before and it";
        return;
    }
    outcome->watched = watched_share(measured);
    if (!(outcome->watched > 0.0)) {
        outcome->why = "no two transducers spoke";
        return;
    }
    struct came came = play(measured, slack);
    outcome->mats = (int64_t)came.mats;
    outcome->start_ft = came.start_ft;
    outcome->t_s = came.t_s;
    if (isfinite(came.t_s)) {
        outcome->came = OUTCOME_CAME;
        outcome->basis = OUTCOME_TRANSDUCERS;
        return;
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        closed.slack_in[s] = isnan(closed.slack_in[s]) ? 0.0f : closed.slack_in[s];
    if (outcome->watched < LEAST_WATCHED)
        outcome->why = "transducers bound less than half of its way";
    else if (slack->surveyed < MR_SEGMENTS && isfinite(play(measured, &closed).t_s))
        outcome->why = "the survey before it leaves out where a zone may have been";
    else {
        outcome->came = OUTCOME_DID_NOT;
        outcome->basis = OUTCOME_TRANSDUCERS;
    }
}

/* ---- the survey after, and what was seen ---- */

static void by_survey_after(const struct measured *measured, const struct zones_closure *slack,
                            struct outcome *outcome)
{
    float nothing_in[MR_TRANSDUCERS], station_ft[MR_TRANSDUCERS];
    struct mr_closure_zone zone;
    double stop_ft = measured->summary.stop_station_ft.value;
    if (measured->fit_status != MR_OK || slack->surveyed == 0)
        return;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        nothing_in[i] = station_ft[i] = MR_NAN;
    struct mr_closure_input input = {.station_ft = station_ft,
                                     .displacement_in = nothing_in,
                                     .slack_in = slack->slack_in,
                                     .wheel_ft = (float)stop_ft,
                                     .speed_ft_s = 0.0f,
                                     .deceleration_ft_s2 = MR_NAN};
    mr_closure_find(&input, &zone, NULL);
    bool at_it = zone.mats > 0 && (double)zone.start_ft - stop_ft < OUTCOME_NEAR_FT;
    outcome->left_mats = at_it ? (int64_t)zone.mats : 0;
    if (outcome->left_mats < OUTCOME_MATS || outcome->came == OUTCOME_CAME)
        return;
    if (outcome->came == OUTCOME_DID_NOT) {
        outcome->came = OUTCOME_UNKNOWN;
        outcome->basis = OUTCOME_NOTHING;
        outcome->why = "transducers and the survey after it disagree";
    } else {
        outcome->came = OUTCOME_CAME;
        outcome->basis = OUTCOME_SURVEY_AFTER;
    }
}

static enum mr_status by_what_was_seen(struct store *store, int64_t run, struct outcome *outcome,
                                       struct error *error)
{
    struct store_observation *row = NULL;
    size_t count = 0;
    enum mr_status status = store_observations(store, run, &row, &count, error);
    for (size_t i = 0; i < count; i++) {
        bool wave = strcmp(row[i].kind, "wave") == 0 && strcmp(row[i].form, "two-panel") != 0;
        if (row[i].withdrawn || row[i].withdraws != STORE_NONE)
            continue;
        outcome->waves += wave;
        outcome->breaks += strcmp(row[i].kind, "break") == 0;
        if (outcome->waves + outcome->breaks == 0)
            continue;
        if (outcome->basis != OUTCOME_SEEN && isnan(outcome->t_s))
            outcome->t_s = row[i].time_s;
        outcome->came = OUTCOME_CAME;
        outcome->basis = OUTCOME_SEEN;
        outcome->why = NULL;
    }
    free(row);
    return status;
}

enum mr_status outcome_load(struct store *store, const struct measured *measured,
                            const struct outcome_between *between, struct outcome *outcome,
                            struct error *error)
{
    struct zones_closure before, after = {.surveyed = 0};
    const struct store_landing *landing = &measured->landing;
    *outcome = (struct outcome){
        .mats = STORE_NONE, .left_mats = STORE_NONE, .start_ft = (double)NAN, .t_s = (double)NAN};
    enum mr_status status = told_survey(store, landing->id,
                                        between->before ? between->before->id : 0, &before, error);
    if (status == MR_OK)
        status = gage_survey(store, between->before ? between->before->armed_us : INT64_MIN,
                             landing->armed_us, &before, error);
    if (status == MR_OK && between->after)
        status = told_survey(store, between->after->id, landing->id, &after, error);
    if (status == MR_OK)
        status = gage_survey(store, landing->armed_us,
                             between->after ? between->after->armed_us : INT64_MAX, &after, error);
    if (status != MR_OK)
        return status;
    by_transducers(measured, &before, outcome);
    by_survey_after(measured, &after, outcome);
    status = by_what_was_seen(store, landing->id, outcome, error);
    if (outcome->came != OUTCOME_UNKNOWN)
        outcome->why = NULL;
    return status;
}
