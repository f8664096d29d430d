#include "host/store/store_survey.h"

#include "host/store/store_sql.h"

enum mr_status store_durable(struct store *store, struct error *error)
{
    return sqlite3_exec(store->database, "PRAGMA synchronous=FULL", NULL, NULL, NULL) == SQLITE_OK
             ? MR_OK
             : store_failed(store, "set up", error);
}

enum mr_status store_gage_survey_add(struct store *store, struct store_gage_survey *survey,
                                     struct error *error)
{
    struct store_gage_survey row = *survey;
    row.ended_us = STORE_NONE; /* it begins */
    enum mr_status status = STORE_PUT(store, error, gage_survey, &row);
    survey->id = sqlite3_last_insert_rowid(store->database);
    return status;
}

enum mr_status store_gage_survey_end(struct store *store, int64_t survey, int64_t ended_us,
                                     struct error *error)
{
    return STORE_RUN(store, error, GAGE_SURVEY_END, BIND(ended_us), BIND(survey));
}

enum mr_status store_gage_surveys(struct store *store, struct store_gage_survey **rows,
                                  size_t *count, struct error *error)
{
    STORE_ROWS(GAGE_SURVEYS);
}

enum mr_status store_gage_reading_add(struct store *store, int64_t survey,
                                      const struct store_gage_reading *reading, struct error *error)
{
    return STORE_PUT(store, error, gage_reading, reading, survey);
}

enum mr_status store_gage_readings(struct store *store, int64_t survey,
                                   struct store_gage_reading **rows, size_t *count,
                                   struct error *error)
{
    STORE_ROWS(GAGE_READINGS, BIND(survey));
}

enum mr_status store_gage_load_add(struct store *store, int64_t survey, int64_t made_us,
                                   const char *link, int64_t segments, struct error *error)
{
    const struct store_gage_load_row row = {.made_us = made_us, .link = link, .segments = segments};
    return STORE_PUT(store, error, gage_load_row, &row, survey);
}

enum mr_status store_gage_loaded(struct store *store, int64_t survey, int64_t *made_us,
                                 struct error *error)
{
    return STORE_NUMBER(store, error, GAGE_LOADED, made_us, BIND(survey));
}
