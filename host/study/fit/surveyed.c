#include "host/study/fit/surveyed.h"

#include <math.h>
#include <stdlib.h>

#include "host/survey/survey.h"

static enum mr_status take_boards(struct store *store, int64_t run, struct fit_surveyed *surveyed,
                                  struct error *error)
{
    struct store_segment *rows;
    size_t count;
    enum mr_status status = store_segments(store, run, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].segment < 0 || rows[i].segment >= (int64_t)MR_SEGMENTS ||
            isnan(rows[i].slack_in))
            continue;
        surveyed->sum_in[rows[i].segment] = rows[i].slack_in;
        surveyed->segments++;
    }
    free(rows);
    return status;
}

/* The slack of one survey over what is there; its error is the mean square of those of the
 * segments. */
static enum mr_status take_gages(struct store *store, int64_t id, struct fit_surveyed *surveyed,
                                 struct error *error)
{
    struct survey *survey = malloc(sizeof *survey);
    struct survey_slack slack;
    double squares = 0.0;
    if (!survey)
        return error_set(error, MR_FULL, "no memory: survey %lld; close other programs",
                         (long long)id);
    enum mr_status status = survey_get(store, id, survey, error);
    if (status == MR_OK)
        survey_slack(&survey->readings, survey->row.closed_in, &slack);
    free(survey);
    for (size_t s = 0; s < MR_SEGMENTS && status == MR_OK; s++) {
        if (isnan(slack.segment[s].value_in))
            continue;
        surveyed->segments += isnan(surveyed->sum_in[s]) ? 1 : 0;
        surveyed->sum_in[s] = slack.segment[s].value_in;
        squares += slack.segment[s].error_in * slack.segment[s].error_in;
        surveyed->gages++;
    }
    if (surveyed->gages > 0)
        surveyed->error_in = sqrt(squares / (double)surveyed->gages);
    return status;
}

/* The newest survey between landing `after` (STORE_NONE: the first) and the next one. */
static enum mr_status take_gages_after(struct store *store, int64_t after,
                                       struct fit_surveyed *surveyed, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    int64_t found = 0;
    enum mr_status status = store_gage_surveys(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        found = rows[i].after_run == after ? rows[i].id : found;
    free(rows);
    return status == MR_OK && found ? take_gages(store, found, surveyed, error) : status;
}

static void nothing(struct fit_surveyed *surveyed)
{
    *surveyed = (struct fit_surveyed){0};
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        surveyed->sum_in[s] = (double)NAN;
}

static enum mr_status landing_before(struct store *store, int64_t run, int64_t *before,
                                     struct error *error)
{
    struct store_landing *rows = NULL;
    size_t count = 0;
    *before = STORE_NONE;
    enum mr_status status = store_landings(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (rows[i].id < run && (*before == STORE_NONE || rows[i].id > *before))
            *before = rows[i].id;
    }
    free(rows);
    return status;
}

enum mr_status fit_surveyed_before(struct store *store, int64_t run, struct fit_surveyed *surveyed,
                                   struct error *error)
{
    int64_t before;
    nothing(surveyed);
    if (landing_before(store, run, &before, error) != MR_OK ||
        take_boards(store, run, surveyed, error) != MR_OK)
        return error->status;
    return take_gages_after(store, before, surveyed, error);
}

enum mr_status fit_surveyed_after(struct store *store, int64_t run, int64_t next,
                                  struct fit_surveyed *surveyed, struct error *error)
{
    nothing(surveyed);
    if (next != STORE_NONE && take_boards(store, next, surveyed, error) != MR_OK)
        return error->status;
    return take_gages_after(store, run, surveyed, error);
}
