#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_journal.h"
#include "host/store/table.h"

/* Finds the value before a change: the value that a user entered last, or else the board's
 * value. */
static enum mr_status find_old_value(struct store *store, const struct store_change *change,
                                     char was[STORE_JOURNAL_TEXT_SIZE], struct error *error)
{
    struct store_landing landing;
    enum mr_status status = store_landing_get(store, change->run, &landing, error);
    was[0] = '\0';
    if (status == MR_OK && strcmp(change->field, "note") != 0)
        status = store_change_get(store, change->run, change->field, was, NULL, error);
    if (status == MR_OK && !was[0] && strcmp(change->field, "touchdown_ft") == 0 &&
        !isnan(landing.touchdown_ft))
        snprintf(was, STORE_JOURNAL_TEXT_SIZE, "%.10g", landing.touchdown_ft);
    return status;
}

enum mr_status store_change_add(struct store *store, const struct store_change *change,
                                struct error *error)
{
    struct store_change row = *change;
    enum mr_status status = find_old_value(store, change, row.was, error);
    return status == MR_OK ? STORE_PUT(store, error, change, &row) : status;
}

enum mr_status store_change_get(struct store *store, int64_t run, const char *field,
                                char value[STORE_JOURNAL_TEXT_SIZE],
                                char reason[STORE_JOURNAL_TEXT_SIZE], struct error *error)
{
    struct store_change row;
    value[0] = '\0';
    if (reason)
        reason[0] = '\0';
    enum mr_status status = STORE_READ_ONE(store, error, CHANGE_NEWEST, &row, STORE_BIND(run),
                                           STORE_BIND(field));
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    memcpy(value, row.value, sizeof row.value);
    if (reason)
        memcpy(reason, row.reason, sizeof row.reason);
    return MR_OK;
}

enum mr_status store_is_void(struct store *store, int64_t run, bool *is_void,
                             char reason[STORE_JOURNAL_TEXT_SIZE], struct error *error)
{
    char value[STORE_JOURNAL_TEXT_SIZE];
    enum mr_status status = store_change_get(store, run, "void", value, reason, error);
    *is_void = strcmp(value, "yes") == 0;
    return status;
}

enum mr_status store_check_not_void(struct store *store, int64_t run, bool allowed,
                                    struct error *error)
{
    char reason[STORE_JOURNAL_TEXT_SIZE];
    bool is_void;
    enum mr_status status = store_is_void(store, run, &is_void, reason, error);
    if (status != MR_OK || !is_void || allowed)
        return status;
    return error_set(error, MR_NOT_NOW,
                     "RUN %lld is void (%s): %s; to use this landing anyway, give --void",
                     (long long)run, reason, store->path);
}

enum mr_status store_observation_add(struct store *store,
                                     const struct store_observation *observation,
                                     struct error *error)
{
    struct store_observation row = *observation;
    row.withdraws = STORE_NONE;
    return STORE_PUT(store, error, observation, &row);
}

enum mr_status store_observation_withdraw(struct store *store, int64_t run, int64_t id,
                                          int64_t made_us, const char *who, const char *reason,
                                          struct error *error)
{
    struct store_observation *rows;
    size_t count;
    bool exists = false, withdrawn = false;
    enum mr_status status = store_observations_get(store, run, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        exists |= rows[i].id == id;
        withdrawn |= rows[i].id == id && rows[i].withdrawn;
    }
    free(rows);
    if (status == MR_OK && (!exists || withdrawn))
        status = error_set(error, MR_UNKNOWN,
                           "no observation %lld to withdraw: RUN %lld of %s; matrig landing DB RUN "
                           "lists the observations",
                           (long long)id, (long long)run, store->path);
    if (status == MR_OK && strlen(reason) >= STORE_JOURNAL_TEXT_SIZE)
        status = error_set(error, MR_TOO_LONG,
                           "the reason is too long: withdrawal of observation %lld of RUN %lld; "
                           "give at most %d characters",
                           (long long)id, (long long)run, STORE_JOURNAL_TEXT_SIZE - 1);
    if (status != MR_OK)
        return status;
    struct store_observation row = {.run = run,
                                    .made_us = made_us,
                                    .kind = "withdrawal",
                                    .withdraws = id,
                                    .panels = STORE_NONE,
                                    .station_ft = (double)NAN,
                                    .height_in = (double)NAN,
                                    .time_s = (double)NAN};
    snprintf(row.who, sizeof row.who, "%s", who);
    snprintf(row.note, sizeof row.note, "%s", reason);
    return STORE_PUT(store, error, observation, &row);
}

enum mr_status store_count_landings_since(struct store *store, int64_t since_us, int64_t *count,
                                          struct error *error)
{
    return STORE_READ_NUMBER(store, error, LANDINGS_COUNT_SINCE, count, STORE_BIND(since_us));
}

/* Replaces a field of the series by the value entered for the landing itself, if there is one. */
static enum mr_status apply_landing_change(struct store *store, int64_t run, const char *field,
                                           char *into, size_t size, struct error *error)
{
    char value[STORE_JOURNAL_TEXT_SIZE];
    enum mr_status status = store_change_get(store, run, field, value, NULL, error);
    if (status == MR_OK && value[0])
        snprintf(into, size, "%.*s", (int)size - 1, value);
    return status;
}

enum mr_status store_landing_series_get(struct store *store, const struct store_landing *landing,
                                        struct store_series *series, struct error *error)
{
    struct store_series *rows;
    size_t count;
    char name[STORE_JOURNAL_TEXT_SIZE];
    *series = (struct store_series){0};
    enum mr_status status = store_all_series_get(store, &rows, &count, error);
    if (status == MR_OK)
        status = store_change_get(store, landing->id, "series", name, NULL, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (name[0] ? strcmp(rows[i].name, name) == 0 : rows[i].made_us <= landing->armed_us)
            *series = rows[i];
    }
    free(rows);
    if (status == MR_OK)
        status = apply_landing_change(store, landing->id, "runway", series->runway,
                                      sizeof series->runway, error);
    if (status == MR_OK)
        status = apply_landing_change(store, landing->id, "pattern", series->pattern,
                                      sizeof series->pattern, error);
    if (status == MR_OK)
        status = apply_landing_change(store, landing->id, "modification", series->modification,
                                      sizeof series->modification, error);
    return status;
}

/* ---- one landing twice in a campaign ---- */

/* Reads the earlier landings with the same landing number. */
static enum mr_status read_same_number(struct store *store, const struct store_landing *landing,
                                       struct store_landing **rows, size_t *count,
                                       struct error *error)
{
    STORE_RETURN_ROWS(LANDINGS_SAME_NUMBER, STORE_BIND(landing->id),
                      STORE_BIND(landing->board_landing));
}

static bool is_same_landing(const struct store_landing *a, const struct store_edge *a_edge,
                            size_t a_edges, const struct store_landing *b,
                            const struct store_edge *b_edge, size_t b_edges)
{
    size_t same = 0, i = 0, k = 0;
    bool same_board = !a->board_uid[0] || !b->board_uid[0] ||
                      strcmp(a->board_uid, b->board_uid) == 0;
    if (!same_board || a->board_landing != b->board_landing)
        return false;
    while (i < a_edges && k < b_edges) { /* both arrays are in the order of `count` */
        int64_t ahead = a_edge[i].count - b_edge[k].count;
        if (ahead == 0 && a_edge[i].tick != b_edge[k].tick)
            return false;
        same += ahead == 0;
        i += ahead <= 0;
        k += ahead >= 0;
    }
    return same >= 2;
}

static enum mr_status check_duplicate(struct store *store, const struct store_landing *landing,
                                      const struct store_edge *edge, size_t edges,
                                      const struct store_landing *other, bool *duplicate,
                                      struct error *error)
{
    struct store_edge *other_edges = NULL;
    size_t count = 0;
    bool is_void = false;
    enum mr_status status = store_edges_get(store, other->id, &other_edges, &count, error);
    *duplicate = status == MR_OK &&
                 is_same_landing(landing, edge, edges, other, other_edges, count);
    free(other_edges);
    if (*duplicate)
        status = store_is_void(store, other->id, &is_void, NULL, error);
    *duplicate &= !is_void;
    return status;
}

enum mr_status store_find_duplicate(struct store *store, int64_t run, int64_t *duplicate,
                                    struct error *error)
{
    struct store_landing landing, *rows = NULL;
    struct store_edge *edge = NULL;
    size_t count = 0, edges = 0;
    *duplicate = 0;
    enum mr_status status = store_landing_get(store, run, &landing, error);
    if (status == MR_OK)
        status = store_edges_get(store, run, &edge, &edges, error);
    if (status == MR_OK)
        status = read_same_number(store, &landing, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK && *duplicate == 0; i++) {
        bool same = false;
        status = check_duplicate(store, &landing, edge, edges, &rows[i], &same, error);
        if (same)
            *duplicate = rows[i].id;
    }
    free(edge);
    free(rows);
    return status;
}

/* ---- recalibration ---- */

static bool has_same_bits(float a, float b)
{
    return a == b || (isnan(a) && isnan(b));
}

static enum mr_status put_recalibration(struct store *store, int64_t run, unsigned index,
                                        int64_t item, float was, float value,
                                        const struct store_recalibration *how, unsigned *changed,
                                        struct error *error)
{
    if (has_same_bits(was, value))
        return MR_OK;
    ++*changed;
    const struct store_recalibrated row = {.index = index,
                                           .item = item,
                                           .was = (double)was,
                                           .value = (double)value,
                                           .made_us = how->made_us,
                                           .who = how->who,
                                           .reason = how->reason};
    return STORE_PUT(store, error, recalibrated, &row, run);
}

enum mr_status store_recalibrate(struct store *store, int64_t run, unsigned index,
                                 const struct mr_channel_config *old,
                                 const struct mr_channel_config *new,
                                 const struct store_recalibration *how, unsigned *changed,
                                 struct error *error)
{
    struct mr_channel_config becomes = *old;
    becomes.unit_per_code = new->unit_per_code;
    if (old->kind != MR_KIND_TENSION || how->changes_gage_zeros)
        becomes.zero_code = new->zero_code;
    *changed = 0;
    enum mr_status status = put_recalibration(store, run, index, STORE_ITEM_UNIT_PER_CODE,
                                              old->unit_per_code, becomes.unit_per_code, how,
                                              changed, error);
    if (status == MR_OK)
        status = put_recalibration(store, run, index, STORE_ITEM_ZERO_CODE, old->zero_code,
                                   becomes.zero_code, how, changed, error);
    for (unsigned item = 0; item < MR_CALIBRATION_ITEM_COUNT && status == MR_OK; item++) {
        float was = mr_channel_get_item(old, item), value = mr_channel_get_item(new, item);
        status = put_recalibration(store, run, index, item, was, value, how, changed, error);
        if (status == MR_OK && !has_same_bits(was, value))
            status = store_calibration_put(
                store, run, &(struct store_calibration){index, item, (double)value}, error);
    }
    return status == MR_OK && *changed ? store_channel_put(store, run, index, &becomes, error)
                                       : status;
}

enum mr_status store_recalibrated_channels_get(struct store *store, int64_t run, int64_t *channels,
                                               struct error *error)
{
    *channels = 0;
    return STORE_READ_NUMBER(store, error, RECALIBRATED, channels, STORE_BIND(run));
}

/* ---- surveys ---- */

enum mr_status store_set_durable(struct store *store, struct error *error)
{
    return sqlite3_exec(store->database, "PRAGMA synchronous=FULL", NULL, NULL, NULL) == SQLITE_OK
             ? MR_OK
             : store_set_error(store, "set up", error);
}

enum mr_status store_gage_survey_add(struct store *store, struct store_gage_survey *survey,
                                     struct error *error)
{
    struct store_gage_survey row = *survey;
    row.ended_us = STORE_NONE; /* not ended */
    enum mr_status status = STORE_PUT(store, error, gage_survey, &row);
    survey->id = sqlite3_last_insert_rowid(store->database);
    return status;
}

enum mr_status store_gage_survey_end(struct store *store, int64_t survey, int64_t ended_us,
                                     struct error *error)
{
    return STORE_RUN_STATEMENT(store, error, GAGE_SURVEY_END, STORE_BIND(ended_us),
                               STORE_BIND(survey));
}

enum mr_status store_gage_reading_add(struct store *store, int64_t survey,
                                      const struct store_gage_reading *reading, struct error *error)
{
    return STORE_PUT(store, error, gage_reading, reading, survey);
}

enum mr_status store_gage_load_add(struct store *store, int64_t survey, int64_t made_us,
                                   const char *link, int64_t segments, struct error *error)
{
    const struct store_gage_load_row row = {.made_us = made_us, .link = link, .segments = segments};
    return STORE_PUT(store, error, gage_load_row, &row, survey);
}
