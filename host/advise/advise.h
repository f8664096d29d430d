/* The advice before a landing. An ensemble of simulated runways is updated from the campaign's
 * landings (history.h, members.h); the planned landing is then simulated on each of them. The
 * result is one word and one sentence. It concerns only the mats; host/board/ready.h checks the
 * equipment. */
#ifndef MATRIG_HOST_ADVISE_ADVISE_H
#define MATRIG_HOST_ADVISE_ADVISE_H

#include "common/risk.h"
#include "host/advise/members.h"
#include "host/advise/history.h"
#include "host/base/answer.h"
#include "host/base/progress.h"

/* Largest acceptable probability of a zone. A zone without a warning costs four times as much as an
 * unnecessarily gentle landing: the runway must be relaid, while a landing only has to be repeated.
 * The limit is therefore 1 / (1 + 4). */
#define ADVISE_RISK_LIMIT  0.2
#define ADVISE_REASON_SIZE 400
#define ADVISE_ACTION_SIZE 800
#define ADVISE_SPEEDS_MAX  12u /* largest number of touchdown speeds that are evaluated */

enum advise_verdict { ADVISE_CLEAR, ADVISE_CAUTION, ADVISE_AGAINST };
const char *advise_verdict_text(enum advise_verdict verdict);

struct advise_request {
    /* planned values. NaN: the speed and deceleration of the previous landing, the touchdown
     * station of the configuration */
    double speed_ft_s, deceleration_ft_s2, touchdown_ft;
    double thrust_share; /* share of the thrust that the mat strip carries; NaN: not measured */
    struct advise_profile profile; /* planned deceleration over time, ft/s2; count 0: uniform */
    double risk_limit;
    int64_t members, seed;
    /* the advice is computed as if this RUN were the next landing; 0: after all landings */
    int64_t before_run;
};

struct advise {
    struct advise_request request;
    struct history history;
    struct advise_members members;
    struct advise_plan plan;
    bool is_based_on_previous_landing; /* speed or deceleration is that of the previous landing */
    unsigned planned_landing_count;    /* number of landings with a stored plan */
    /* the plan lies outside the range of the previous landings, so the ensemble was widened */
    bool is_plan_outside_range;
    size_t repair_count; /* number of repairs for which new joints were drawn */
    size_t
        skipped_landing_count; /* number of landings from which the ensemble could not be updated */
    double min_braking_ft_s2;  /* deceleration that stops the gear at the end of the runway */
    struct advise_row row[ADVISE_ROW_COUNT];
    /* row_count rows in ascending order of braking; plan_row is the index of the planned braking */
    size_t row_count, plan_row;
    struct advise_limit_crossing max_braking; /* hardest braking at the planned speed, ft/s2 */
    /* least deceleration at which the gear stops before it reaches the closed mats; NaN: none */
    double stop_short_braking_ft_s2;
    /* fastest touchdown speed at the planned braking, ft/s */
    struct advise_limit_crossing max_speed;
    double min_speed_ft_s; /* lowest touchdown speed that was evaluated */
    enum advise_verdict verdict;
    char reason[ADVISE_REASON_SIZE], action[ADVISE_ACTION_SIZE];
    struct progress *progress;
};

/* Loads the previous landings and the plan, which is fast. Errors: those of history_load, or
 * MR_USAGE if the plan is incomplete or not on the runway. Call advise_free in every case. */
enum mr_status advise_begin(struct store *store, const struct advise_request *request,
                            struct advise *advise, struct error *error);
/* Computes the advice, which takes seconds on all processors. `si`: the sentence uses SI units. */
enum mr_status advise_compute(struct advise *advise, bool si, struct progress *progress,
                              struct error *error);
void advise_free(struct advise *advise);

void advise_to_answer(const struct advise *advise, struct answer *answer);
/* Converts the advice to the row that the campaign stores. */
struct store_advice advise_to_stored_row(const struct advise *advise, int64_t made_us);
/* Makes the risk chart and the plan that are loaded into a board before a landing. `landings`:
 * number of landings in the runway history of the board. The plan has at most MR_RISK_PLAN_KNOTS
 * points. MR_USAGE: the plan exceeds the limits of a board. */
enum mr_status advise_make_chart(const struct advise *advise, unsigned landings,
                                 struct mr_risk_plan *plan, struct error *error);

#endif
