/* Surveys of the mat by gage points, as they were read. Conventions as in store.h. A reading is a
 * row of its own, written and on disk when store_gage_reading_add returns (outside a transaction);
 * readings are never changed, the newest of a place holds. */
#ifndef MATRIG_HOST_STORE_STORE_SURVEY_H
#define MATRIG_HOST_STORE_STORE_SURVEY_H

#include "host/store/store.h"

enum mr_status store_gage_survey_add(struct store *store, struct store_gage_survey *survey,
                                     struct error *error);
enum mr_status store_gage_survey_end(struct store *store, int64_t survey, int64_t ended_us,
                                     struct error *error);
enum mr_status store_gage_surveys(struct store *store, struct store_gage_survey **rows,
                                  size_t *count, struct error *error);
enum mr_status store_gage_reading_add(struct store *store, int64_t survey,
                                      const struct store_gage_reading *reading,
                                      struct error *error);
/* In the order in which they were written. */
enum mr_status store_gage_readings(struct store *store, int64_t survey,
                                   struct store_gage_reading **rows, size_t *count,
                                   struct error *error);
/* That a board was given the survey. */
enum mr_status store_gage_load_add(struct store *store, int64_t survey, int64_t made_us,
                                   const char *link, int64_t segments, struct error *error);
/* When one was given it last; 0: never. */
enum mr_status store_gage_loaded(struct store *store, int64_t survey, int64_t *made_us,
                                 struct error *error);
/* From now on a commit is on disk when it returns, also for a campaign that was not opened to be
 * created. */
enum mr_status store_durable(struct store *store, struct error *error);

#endif
