#include "host/analyse/record.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "host/store/store_predict.h"
#include "host/store/store_survey.h"

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

static enum mr_status add_up(struct record *record, struct error *error)
{
    double *lead_s = calloc(record->rows ? record->rows : 1, sizeof *lead_s);
    if (!lead_s)
        return error_set(error, MR_FULL, "no memory: %zu landings; close other programs",
                         record->rows);
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
    return MR_OK;
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
    if (status == MR_OK && !(record->row = calloc(count ? count : 1, sizeof *record->row)))
        status = error_set(error, MR_FULL, "no memory: %zu landings; close other programs", count);
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
    return status == MR_OK ? add_up(record, error) : status;
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
