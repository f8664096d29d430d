#include "host/survey/campaign.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Those of a survey by place in the plan; NaN: not read, undone or skipped. `survey` NULL: only the
 * values are wanted. */
static enum mr_status take_readings(struct store *store, int64_t id, const struct survey_plan *plan,
                                    double value_in[SURVEY_ITEMS_MAX], struct survey *survey,
                                    struct error *error)
{
    struct store_gage_reading *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_gage_readings(store, id, &rows, &count, error);
    for (size_t i = 0; i < SURVEY_ITEMS_MAX; i++)
        value_in[i] = (double)NAN;
    for (size_t i = 0; i < count; i++) {
        struct survey_item item = {SURVEY_KINDS, (unsigned)rows[i].line, (unsigned)rows[i].place};
        int at = survey_kind_parse(rows[i].kind, &item.kind) ? survey_plan_find(plan, &item) : -1;
        if (at < 0)
            continue; /* a place that this plan lacks */
        value_in[at] = rows[i].value_in;
        if (!survey)
            continue;
        survey_desk_restore(&survey->desk, (size_t)at, rows[i].value_in, rows[i].skipped != 0);
        *survey_reading_at(&survey->readings, &item) = rows[i].value_in;
        survey->confirmed += rows[i].confirmed != 0;
    }
    free(rows);
    return status;
}

/* Row `i`, and of each place what was read there last before. */
static enum mr_status fill(struct store *store, const struct store_gage_survey *rows, size_t i,
                           struct survey *survey, struct error *error)
{
    const struct store_gage_survey *row = &rows[i];
    double value_in[SURVEY_ITEMS_MAX];
    enum survey_pattern pattern;
    enum survey_edges edges;
    enum mr_status status = MR_OK;
    if (!survey_pattern_parse(row->pattern, &pattern) || !survey_edges_parse(row->edges, &edges))
        return error_set(
            error, MR_MALFORMED,
            "survey %lld has a pattern that is not known, '%s': %s; the database is damaged",
            (long long)row->id, row->pattern, store_path(store));
    memset(survey, 0, sizeof *survey);
    survey->row = *row;
    survey_desk_init(&survey->desk, pattern, edges);
    survey_readings_init(&survey->readings);
    survey->readings.error_in = row->error_in;
    for (size_t k = 0; k < i && status == MR_OK; k++) {
        if (strcmp(rows[k].pattern, row->pattern) != 0)
            continue;
        status = take_readings(store, rows[k].id, &survey->desk.plan, value_in, NULL, error);
        for (size_t at = 0; at < survey->desk.plan.count; at++)
            survey->desk.previous_in[at] = isnan(value_in[at]) ? survey->desk.previous_in[at]
                                                               : value_in[at];
    }
    if (status == MR_OK)
        status = take_readings(store, row->id, &survey->desk.plan, value_in, survey, error);
    size_t lasts = survey->desk.lasts; /* it goes on behind the last one read */
    survey_desk_next(&survey->desk, lasts ? survey->desk.last[lasts - 1] : 0);
    return status;
}

/* The newest of the same pattern before row `i`; 0: none. */
static int64_t before(const struct store_gage_survey *rows, size_t i)
{
    for (size_t k = i; k-- > 0;) {
        if (strcmp(rows[k].pattern, rows[i].pattern) == 0)
            return rows[k].id;
    }
    return 0;
}

enum mr_status survey_get(struct store *store, int64_t id, struct survey *survey,
                          struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0, i = 0;
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    if (status == MR_OK && id == 0 && count)
        id = rows[count - 1].id;
    while (i < count && rows[i].id != id)
        i++;
    if (status == MR_OK && count == 0)
        status = error_set(error, MR_UNKNOWN, "no survey yet: %s; take one with matrig survey %s",
                           store_path(store), store_path(store));
    else if (status == MR_OK && i == count)
        status = error_set(error, MR_UNKNOWN, "no survey %lld: %s; it has %lld to %lld",
                           (long long)id, store_path(store), (long long)rows[0].id,
                           (long long)rows[count - 1].id);
    if (status == MR_OK)
        status = fill(store, rows, i, survey, error);
    free(rows);
    return status;
}

enum mr_status survey_get_open(struct store *store, enum survey_pattern pattern,
                               struct survey *survey, bool *found, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    *found = false;
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    for (size_t i = count; i-- > 0 && status == MR_OK && !*found;) {
        if (rows[i].ended_us != STORE_NONE ||
            strcmp(rows[i].pattern, survey_pattern_text(pattern)) != 0)
            continue;
        status = fill(store, rows, i, survey, error);
        *found = status == MR_OK;
    }
    free(rows);
    return status;
}

static void worst_bow(struct survey_found *found)
{
    found->worst_bow_in = found->worst_bow_error_in = found->worst_bow_ft = (double)NAN;
    for (unsigned k = 0; found->first && k < SURVEY_POINTS; k++) {
        const struct survey_estimate *bow = &found->since_first.bow[k];
        if (isnan(bow->value_in) || fabs(bow->value_in) <= fabs(found->worst_bow_in))
            continue;
        found->worst_bow_in = bow->value_in;
        found->worst_bow_error_in = bow->error_in;
        found->worst_bow_ft = SURVEY_SPAN_FT * k;
    }
}

enum mr_status survey_find(struct store *store, const struct survey *survey,
                           struct survey_found *found, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0, i = 0;
    memset(found, 0, sizeof *found);
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    while (i < count && rows[i].id != survey->row.id)
        i++;
    if (status == MR_OK && i < count) {
        found->previous = before(rows, i);
        for (size_t k = i; k-- > 0;) {
            if (strcmp(rows[k].pattern, rows[i].pattern) == 0)
                found->first = rows[k].id;
        }
    }
    free(rows);
    struct survey *other = malloc(sizeof *other);
    if (!other)
        abort();
    const int64_t against[2] = {found->previous, found->first};
    struct survey_change *const change[2] = {&found->since_previous, &found->since_first};
    for (int k = 0; k < 2 && status == MR_OK; k++) {
        if (against[k])
            status = survey_get(store, against[k], other, error);
        if (status == MR_OK && against[k])
            survey_change(&survey->readings, &other->readings, change[k]);
    }
    free(other);
    survey_slack(&survey->readings, survey->row.closed_in, &found->slack);
    worst_bow(found);
    return status;
}

enum mr_status survey_find_between(struct store *store, int64_t from_us, int64_t to_us,
                                   struct survey_found *found, bool *there, struct error *error)
{
    static struct survey survey; /* tens of kilobytes */
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    *there = false;
    for (size_t i = count; status == MR_OK && !*there && i-- > 0;) {
        if (rows[i].made_us <= from_us || rows[i].made_us > to_us)
            continue;
        status = survey_get(store, rows[i].id, &survey, error);
        if (status == MR_OK)
            status = survey_find(store, &survey, found, error);
        *there = status == MR_OK && found->slack.surveyed > 0;
    }
    free(rows);
    return status;
}
