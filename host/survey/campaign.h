/* Surveys of a campaign: which one goes on, its readings at their places, what it is compared
 * with. */
#ifndef MATRIG_HOST_SURVEY_CAMPAIGN_H
#define MATRIG_HOST_SURVEY_CAMPAIGN_H

#include "host/store/store_survey.h"
#include "host/survey/desk.h"
#include "host/survey/result.h"

struct survey {
    struct store_gage_survey row;
    struct survey_desk desk; /* values, skipped ones, those of the survey before */
    size_t confirmed;        /* readings that were doubted and typed again */
    struct survey_readings readings;
};

/* What a survey comes to. `previous` and `first` are ids, 0: there is none before it. */
struct survey_found {
    int64_t previous, first;
    struct survey_change since_previous, since_first;
    struct survey_slack slack;
    double worst_bow_in, worst_bow_error_in; /* since the first; NaN: not known */
    double worst_bow_ft;
};

/* Survey `id`, 0: the newest. MR_UNKNOWN: no such survey. */
enum mr_status survey_get(struct store *store, int64_t id, struct survey *survey,
                          struct error *error);
/* The newest one that goes on, of that pattern; *found false: none. */
enum mr_status survey_get_open(struct store *store, enum survey_pattern pattern,
                               struct survey *survey, bool *found, struct error *error);
enum mr_status survey_find(struct store *store, const struct survey *survey,
                           struct survey_found *found, struct error *error);
/* What the newest one comes to that was begun between two moments and tells of segments; *there
 * false: none. */
enum mr_status survey_find_between(struct store *store, int64_t from_us, int64_t to_us,
                                   struct survey_found *found, bool *there, struct error *error);

#endif
