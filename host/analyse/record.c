#include "host/analyse/record.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/closure.h"
#include "common/wire.h"
#include "host/base/xmalloc.h"
#include "host/base/statistics.h"
#include "host/store/store_journal.h"
#include "host/store/store_predict.h"
#include "host/store/store_survey.h"
#include "host/survey/survey.h"

/* ---- what was said ---- */

static enum mr_status take_risk(struct store *store, const struct measured *measured,
                                struct record_row *row, struct error *error)
{
    struct store_risk *risk = NULL;
    size_t risks = 0;
    row->risk_most = row->risk_most_t_s = row->risk_early = (double)NAN;
    enum mr_status status = store_risks(store, row->run, &risk, &risks, error);
    for (size_t i = 0; status == MR_OK && i < risks; i++) {
        double t_s = measured_block_s(measured, risk[i].block);
        if (isnan(risk[i].risk))
            continue;
        if (measured->t0_is_touchdown && t_s >= 0.0 && t_s <= RECORD_RISK_AT_S)
            row->risk_early = risk[i].risk;
        if (isnan(row->risk_most) || risk[i].risk > row->risk_most) {
            row->risk_most = risk[i].risk;
            row->risk_most_t_s = t_s;
        }
    }
    free(risk);
    return status;
}

static void take_warning(const struct measured *measured, const struct zones *zones,
                         struct record_row *row)
{
    const struct zone_warning *warning = &zones->warning;
    char doubt[ZONES_HEARD_TEXT];
    row->warned_t_s = row->warned_ft = row->wheel_ft = row->lead_s = (double)NAN;
    if (warning->warned) {
        row->warned = RECORD_WARNED;
        row->warned_t_s = warning->t_s;
        row->warned_ft = warning->start_ft;
        row->wheel_ft = warning->wheel_ft;
    } else if (measured->source == MEASURED_IMPORT)
        row->warned = RECORD_UNWATCHED;
    else
        row->warned = zones_heard_doubt(&zones->heard, (double)INFINITY, doubt) ? RECORD_UNHEARD
                                                                                : RECORD_QUIET;
}

/* Whether it was the landing that the advice was of. */
static void take_plan(const struct measured *measured, struct record_row *row)
{
    const struct mr_gates_summary *fit = &measured->summary;
    row->met = (double)NAN;
    if (!row->advised || measured->fit_status != MR_OK)
        return;
    double speed_ft_s = fit->touchdown_speed_ft_s.value,
           way_ft = fit->stop_station_ft.value - measured->landing.touchdown_ft;
    row->met = way_ft > 0.0
                 ? speed_ft_s * speed_ft_s / (2.0 * way_ft) / row->advice.deceleration_ft_s2
                 : (double)NAN;
    row->off_plan = fabs(row->met - 1.0) > RECORD_OFF_BRAKING ||
                    fabs(speed_ft_s / row->advice.speed_ft_s - 1.0) > RECORD_OFF_SPEED;
}

/* ---- what came of it ---- */

static void judge_warned(struct record_row *row)
{
    const struct outcome *outcome = &row->outcome;
    if (outcome->came == OUTCOME_DID_NOT)
        row->verdict = RECORD_FALSE;
    else if (outcome->t_s < row->warned_t_s)
        row->verdict = RECORD_LATE;
    else {
        row->verdict = RECORD_HIT;
        row->lead_s = outcome->t_s - row->warned_t_s;
    }
}

static void judge(struct record_row *row)
{
    row->verdict = RECORD_NOT_KNOWN;
    if (row->is_void)
        row->why = "the landing is void";
    else if (row->outcome.came == OUTCOME_UNKNOWN)
        row->why = row->outcome.why;
    else if (row->warned == RECORD_UNWATCHED)
        row->why = "no board watched";
    else if (row->warned == RECORD_UNHEARD)
        row->why = "no warning was heard, and one may have come";
    else if (row->warned == RECORD_WARNED)
        judge_warned(row);
    else
        row->verdict = row->outcome.came == OUTCOME_CAME ? RECORD_MISS : RECORD_SILENCE;
}

/* ---- a landing ---- */

/* The newest advice between the landing before it in the campaign and it. */
static void take_advice(const struct store_advice *advice, size_t count, int64_t before,
                        struct record_row *row)
{
    for (size_t i = 0; i < count; i++) {
        if (advice[i].after_run < before || advice[i].after_run >= row->run)
            continue;
        row->replaced += row->advised;
        row->advised = true;
        row->advice = advice[i];
    }
}

static const struct store_landing *neighbour(const struct store_landing *all, size_t count,
                                             size_t at, int step)
{
    for (size_t i = at + (size_t)step; i < count; i += (size_t)step) {
        if (strcmp(all[i].board_uid, all[at].board_uid) == 0)
            return &all[i];
    }
    return NULL;
}

/* Its series take long to read and are of use with a survey alone. */
static enum mr_status has_survey(struct store *store, int64_t run, bool *has, struct error *error)
{
    struct zones_closure told;
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    enum mr_status status = zones_load_survey(store, run, &told, error);
    if (status == MR_OK)
        status = store_gage_surveys(store, &rows, &count, error);
    *has = status == MR_OK && (told.surveyed > 0 || count > 0);
    free(rows);
    return status;
}

static enum mr_status judge_landing(struct store *store, const struct outcome_between *between,
                                    const struct record_given *given, struct record_row *row,
                                    struct error *error)
{
    take_warning(given->measured, given->zones, row);
    take_plan(given->measured, row);
    enum mr_status status = take_risk(store, given->measured, row, error);
    if (status == MR_OK && !row->is_void)
        status = outcome_load(store, given->measured, between, &row->outcome, error);
    if (status == MR_OK)
        judge(row);
    row->judged = status == MR_OK;
    return status;
}

static enum mr_status load_landing(struct store *store, const struct outcome_between *between,
                                   struct record_row *row, struct error *error)
{
    static struct measured measured; /* some ten kilobytes */
    struct zones zones = {0};
    bool surveyed = false;
    enum mr_status status = has_survey(store, row->run, &surveyed, error);
    memset(&measured, 0, sizeof measured);
    if (status == MR_OK)
        status = surveyed && !row->is_void ? measured_load(store, row->run, &measured, error)
                                           : measured_load_gear(store, row->run, &measured, error);
    if (status == MR_OK)
        status = zones_load(store, &measured, &zones, error);
    if (status == MR_OK)
        status = judge_landing(store, between,
                               &(struct record_given){.measured = &measured, .zones = &zones}, row,
                               error);
    zones_free(&zones);
    measured_free(&measured);
    return status;
}

/* ---- sums ---- */

static int ascending(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void add_row(struct record *record, const struct record_row *row, double *lead_s)
{
    record->replaced += row->replaced;
    if (row->is_void) {
        record->voided++;
        record->advice_voided += row->advised;
        return;
    }
    record->landings++;
    record->verdict[row->verdict]++;
    record->basis[row->outcome.basis]++;
    record->unwatched += row->warned == RECORD_UNWATCHED;
    record->unknown_warned += row->verdict == RECORD_NOT_KNOWN && row->warned == RECORD_WARNED;
    if (row->verdict == RECORD_HIT && isfinite(row->lead_s))
        lead_s[record->leads++] = row->lead_s;
    if (!row->advised)
        return;
    record->advices++;
    record->off_plan += row->off_plan;
    if (!row->off_plan)
        record->advice[strcmp(row->advice.verdict, "against") == 0 ? RECORD_AGAINST
                       : strcmp(row->advice.verdict, "caution") == 0
                           ? RECORD_CAUTION
                           : RECORD_CLEAR][row->outcome.came]++;
}

/* The probability of a landing that is scored; NaN: none, or nobody knows what came. A landing
 * that was another than planned says nothing of it. */
static double stated(const struct record_row *row, bool said)
{
    bool known = !row->is_void && row->outcome.came != OUTCOME_UNKNOWN;
    if (!known)
        return (double)NAN;
    if (said)
        return row->advised && !row->off_plan ? row->advice.zone : (double)NAN;
    return row->outcome.t_s <= RECORD_RISK_AT_S ? (double)NAN : row->risk_early;
}

static void score(const struct record *record, bool said, struct record_score *score)
{
    double square = 0.0, came = 0.0;
    *score = (struct record_score){.brier = (double)NAN, .climatology = (double)NAN};
    for (size_t i = 0; i < record->rows; i++) {
        double p = stated(&record->row[i], said),
               y = record->row[i].outcome.came == OUTCOME_CAME ? 1.0 : 0.0;
        if (isnan(p))
            continue;
        score->count++;
        square += (p - y) * (p - y);
        came += y;
    }
    if (score->count < RECORD_SCORED)
        return;
    double n = (double)score->count;
    score->brier = square / n;
    score->climatology = came / n * (1.0 - came / n);
}

static void add_up(struct record *record)
{
    double *lead_s = xcalloc(record->rows, sizeof *lead_s);
    for (size_t i = 0; i < record->rows; i++)
        add_row(record, &record->row[i], lead_s);
    qsort(lead_s, record->leads, sizeof *lead_s, ascending);
    record->lead_least_s = record->leads ? lead_s[0] : (double)NAN;
    record->lead_median_s = record->leads
                              ? 0.5 * (lead_s[(record->leads - 1) / 2] + lead_s[record->leads / 2])
                              : (double)NAN;
    score(record, true, &record->said);
    score(record, false, &record->risk);
    free(lead_s);
}

/* ---- the campaign ---- */

struct record_row *record_find(struct record *record, int64_t run)
{
    size_t low = 0, high = record->rows;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (record->row[middle].run < run)
            low = middle + 1;
        else
            high = middle;
    }
    return low < record->rows && record->row[low].run == run ? &record->row[low] : NULL;
}

static struct outcome_between between_of(const struct record *record, const struct record_row *row)
{
    size_t at = (size_t)(row - record->row);
    return (struct outcome_between){neighbour(record->landing, record->rows, at, -1),
                                    neighbour(record->landing, record->rows, at, 1)};
}

enum mr_status record_begin(struct store *store, struct record *record, struct error *error)
{
    struct store_advice *advice = NULL;
    size_t count = 0, advices = 0;
    *record = (struct record){0};
    enum mr_status status = store_landings(store, &record->landing, &count, error);
    if (status == MR_OK)
        status = store_advices(store, &advice, &advices, error);
    if (status == MR_OK)
        record->row = xcalloc(count, sizeof *record->row);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        struct record_row *row = &record->row[record->rows++];
        row->run = record->landing[i].id;
        take_advice(advice, advices, i ? record->landing[i - 1].id : 0, row);
        status = store_is_void(store, row->run, &row->is_void, NULL, error);
    }
    for (size_t i = 0; status == MR_OK && i < advices; i++)
        record->to_come_advices += advice[i].after_run >=
                                   (count ? record->landing[count - 1].id : 0);
    free(advice);
    return status;
}

enum mr_status record_judge(struct store *store, struct record *record,
                            const struct record_given *given, struct error *error)
{
    struct record_row *row = record_find(record, given->measured->landing.id);
    if (!row)
        return MR_OK;
    const struct outcome_between between = between_of(record, row);
    return judge_landing(store, &between, given, row, error);
}

enum mr_status record_end(struct store *store, struct record *record, struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; status == MR_OK && i < record->rows; i++) {
        struct record_row *row = &record->row[i];
        const struct outcome_between between = between_of(record, row);
        if (!row->judged)
            status = load_landing(store, &between, row, error);
    }
    if (record->to_come_advices) {
        record->to_come = 1;
        record->replaced += record->to_come_advices - 1;
    }
    if (status == MR_OK)
        add_up(record);
    return status;
}

enum mr_status record_load(struct store *store, struct record *record, struct error *error)
{
    enum mr_status status = record_begin(store, record, error);
    return status == MR_OK ? record_end(store, record, error) : status;
}

void record_free(struct record *record)
{
    free(record->row);
    free(record->landing);
    record->row = NULL;
    record->landing = NULL;
}

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

/* The sums of a campaign's record in words and numbers. */
const char *record_verdict_text(enum record_verdict verdict)
{
    static const char *const text[RECORD_VERDICTS] = {
        [RECORD_NOT_KNOWN] = "not known",
        [RECORD_HIT] = "hit",
        [RECORD_LATE] = "warned, but too late",
        [RECORD_MISS] = "missed",
        [RECORD_FALSE] = "false",
        [RECORD_SILENCE] = "rightly quiet",
    };
    return text[verdict];
}

static const char *const advised[RECORD_ADVICES] = {"clear", "caution", "against"};

/* "3 of 4", with Wilson's interval. For programs NAME, NAME_of, NAME_low, NAME_high. */
static void share_answer(struct answer *answer, const char *name, const char *label, size_t count,
                         size_t of, const char *what)
{
    char key[60];
    struct wilson share = wilson_of(count, of);
    answer_count(answer, name, NULL, (int64_t)count);
    snprintf(key, sizeof key, "%s_of", name);
    answer_count(answer, key, NULL, (int64_t)of);
    snprintf(key, sizeof key, "%s_low", name);
    answer_value(answer, key, NULL, UNIT_NUMBER, of ? share.low : (double)NAN, 3);
    snprintf(key, sizeof key, "%s_high", name);
    answer_value(answer, key, NULL, UNIT_NUMBER, of ? share.high : (double)NAN, 3);
    if (of)
        answer_words(answer, NULL, label, "%zu of %zu %s: with 95 %% between %.0f and %.0f %%",
                     count, of, what, 100.0 * share.low, 100.0 * share.high);
    else
        answer_words(answer, NULL, label, "no %s", what);
}

static size_t came(const struct record *record)
{
    return record->verdict[RECORD_HIT] + record->verdict[RECORD_LATE] +
           record->verdict[RECORD_MISS];
}

static void unknown_answer(const struct record *record, struct answer *answer)
{
    size_t unknown = record->verdict[RECORD_NOT_KNOWN];
    answer_count(answer, "unknown", NULL, (int64_t)unknown);
    answer_count(answer, "unknown_warned", NULL, (int64_t)record->unknown_warned);
    answer_count(answer, "unwatched", NULL, (int64_t)record->unwatched);
    answer_words(answer, NULL, "not known",
                 "%zu landing%s, %zu of them warned of: counted as neither right nor wrong",
                 unknown, unknown == 1 ? "" : "s", record->unknown_warned);
}

static void lead_answer(const struct record *record, struct answer *answer)
{
    answer_value(answer, "lead_median", NULL, UNIT_TIME, record->lead_median_s, 3);
    answer_value(answer, "lead_least", NULL, UNIT_TIME, record->lead_least_s, 3);
    answer_count(answer, "leads", NULL, (int64_t)record->leads);
    if (record->leads)
        answer_words(answer, NULL, "lead time",
                     "median %.2f s, least %.2f s, to when the wheel came to 50 closed mats; of "
                     "%zu",
                     record->lead_median_s, record->lead_least_s, record->leads);
}

static void warnings_answer(const struct record *record, struct answer *answer)
{
    size_t hit = record->verdict[RECORD_HIT], wrong = record->verdict[RECORD_FALSE],
           late = record->verdict[RECORD_LATE];
    answer_open(answer, "warnings", "warnings");
    share_answer(answer, "warned", "warned of", hit + late, came(record),
                 "landings in which the wheel came to a zone");
    share_answer(answer, "hits", "in time", hit, came(record), "of them, before it came there");
    answer_count(answer, "late", "too late", (int64_t)late);
    answer_count(answer, "misses", "missed", (int64_t)record->verdict[RECORD_MISS]);
    share_answer(answer, "false", "false", wrong, wrong + hit + late,
                 "warnings of which that is known");
    answer_count(answer, "silences", "rightly quiet", (int64_t)record->verdict[RECORD_SILENCE]);
    lead_answer(record, answer);
    unknown_answer(record, answer);
    answer_close(answer);
}

static void score_answer(const struct record_score *score, const char *name, const char *label,
                         struct answer *answer)
{
    answer_open(answer, name, "");
    answer_count(answer, "known", NULL, (int64_t)score->count);
    answer_value(answer, "brier", NULL, UNIT_NUMBER, score->brier, 4);
    answer_value(answer, "climatology", NULL, UNIT_NUMBER, score->climatology, 4);
    if (score->count >= RECORD_SCORED)
        answer_words(answer, NULL, label,
                     "Brier score %.3f of %zu; always saying the share that came would have %.3f",
                     score->brier, score->count, score->climatology);
    else
        answer_words(answer, NULL, label,
                     "no score: %zu known landings, and fewer than %d tell nothing", score->count,
                     RECORD_SCORED);
    answer_close(answer);
}

static void one_advice_answer(const struct record *record, enum record_advised verdict,
                              struct answer *answer)
{
    static const char *const label[RECORD_ADVICES] = {"said clear", "said caution", "said against"};
    const size_t *by = record->advice[verdict];
    char what[80];
    answer_open(answer, advised[verdict], "");
    snprintf(what, sizeof what, "known landings came to a zone, %zu not known",
             by[OUTCOME_UNKNOWN]);
    share_answer(answer, "came", label[verdict], by[OUTCOME_CAME],
                 by[OUTCOME_CAME] + by[OUTCOME_DID_NOT],
                 by[OUTCOME_CAME] + by[OUTCOME_DID_NOT] ? what : "landing of which it is known");
    answer_count(answer, "unknown", NULL, (int64_t)by[OUTCOME_UNKNOWN]);
    answer_close(answer);
}

static void advice_answer(const struct record *record, struct answer *answer)
{
    answer_open(answer, "advice", "advice before landings");
    answer_count(answer, "given", "kept before a landing", (int64_t)record->advices);
    for (int i = RECORD_ADVICES - 1; i >= 0; i--)
        one_advice_answer(record, (enum record_advised)i, answer);
    answer_count(answer, "off_plan", "landed otherwise than planned", (int64_t)record->off_plan);
    answer_count(answer, "to_come", NULL, (int64_t)record->to_come);
    answer_count(answer, "replaced", "replaced by a later one", (int64_t)record->replaced);
    answer_count(answer, "voided", "before a landing that is void", (int64_t)record->advice_voided);
    score_answer(&record->said, "probability", "its probabilities", answer);
    answer_close(answer);
}

static void basis_answer(const struct record *record, struct answer *answer)
{
    char text[200] = "";
    for (int i = 1; i < OUTCOME_BASES; i++) {
        size_t used = strlen(text);
        if (record->basis[i])
            snprintf(text + used, sizeof text - used, "%s%s in %zu", used ? ", " : "",
                     outcome_basis_text((enum outcome_basis)i), record->basis[i]);
    }
    answer_count(answer, "by_seen", NULL, (int64_t)record->basis[OUTCOME_SEEN]);
    answer_count(answer, "by_transducers", NULL, (int64_t)record->basis[OUTCOME_TRANSDUCERS]);
    answer_count(answer, "by_survey_after", NULL, (int64_t)record->basis[OUTCOME_SURVEY_AFTER]);
    answer_words(answer, NULL, "what came rests on", "%s",
                 text[0] ? text : "nothing: none is known");
}

static void line_answer(const struct record *record, struct answer *answer)
{
    size_t hit = record->verdict[RECORD_HIT], late = record->verdict[RECORD_LATE],
           wrong = record->verdict[RECORD_FALSE];
    char before[60] = "";
    if (record->advices)
        snprintf(before, sizeof before, "; advice before %zu", record->advices);
    answer_sentence(answer, NULL,
                    "warned of %zu of %zu landings that came to a zone (%zu in time), %zu of %zu "
                    "warnings false, %zu rightly quiet, %zu not known%s (matrig report has each)",
                    hit + late, came(record), hit, wrong, wrong + hit + late,
                    record->verdict[RECORD_SILENCE], record->verdict[RECORD_NOT_KNOWN], before);
}

void record_answer(const struct record *record, bool brief, struct answer *answer)
{
    answer_open(answer, "record", brief ? NULL : "");
    answer_count(answer, "counted", brief ? NULL : "landings", (int64_t)record->landings);
    answer_count(answer, "voided", brief ? NULL : "void, not counted", (int64_t)record->voided);
    basis_answer(record, answer);
    warnings_answer(record, answer);
    score_answer(&record->risk, "risk", "risk told 1 s after touchdown", answer);
    advice_answer(record, answer);
    answer_close(answer);
    if (brief)
        line_answer(record, answer);
}
