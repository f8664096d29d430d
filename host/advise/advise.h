/* The advice before a landing: what the campaign's landings teach an ensemble (past.h, members.h),
 * and what that says of a plan, in one word and one sentence. Go and no-go are
 * readiness's (host/board/ready.h); this speaks of the mats alone. */
#ifndef MATRIG_HOST_ADVISE_ADVISE_H
#define MATRIG_HOST_ADVISE_ADVISE_H

#include "common/risk.h"
#include "host/advise/members.h"
#include "host/advise/past.h"
#include "host/base/answer.h"
#include "host/base/progress.h"

/* A missed zone costs four times what a needlessly gentle landing does: runway relaid against
 * landing repeated. Acting pays from 1 / (1 + 4) on. */
#define ADVISE_LIMIT  0.2
#define ADVISE_REASON 300
#define ADVISE_ACTION 800
#define ADVISE_SPEEDS 12u /* touchdown speeds that are tried, at most */

enum advise_verdict { ADVISE_CLEAR, ADVISE_CAUTION, ADVISE_AGAINST };
const char *advise_verdict_text(enum advise_verdict verdict);

struct advise_request {
    /* NaN: as the landing before (speed, deceleration), as configured (touchdown) */
    double speed_ft_s, deceleration_ft_s2, touchdown_ft;
    double share;                  /* of the thrust that the strip bears; NaN: not measured */
    struct advise_profile profile; /* of decelerations, ft/s2; count 0: even */
    double limit;
    int64_t members, seed;
    int64_t before; /* as if RUN were still to come; 0: after all landings */
};

struct advise {
    struct advise_request request;
    struct past past;
    struct advise_members members;
    struct advise_plan plan;
    bool as_before;     /* speed or deceleration is the last landing's */
    unsigned planned;   /* landings whose plan was kept */
    bool outside;       /* of what the landings before were: widened */
    size_t unlearned;   /* landings that could not be learned from */
    double least_ft_s2; /* stops at the runway's end */
    struct advise_row row[ADVISE_ROWS];
    size_t rows, plan_row;     /* ascending; which is the plan's */
    struct advise_reach brake; /* the hardest at the planned speed, ft/s2 */
    double short_ft_s2; /* from here on it stops before the mats that are closed; NaN: nowhere */
    struct advise_reach speed; /* at the planned braking, ft/s */
    double slowest_ft_s;       /* the lowest touchdown speed that was tried */
    enum advise_verdict verdict;
    char reason[ADVISE_REASON], action[ADVISE_ACTION];
    struct progress *progress;
};

/* The landings before and the plan, which takes no time. Else as past_load has it, or MR_USAGE: the
 * plan is not complete, or does not lie on the runway. advise_free in every case. */
enum mr_status advise_begin(struct store *store, const struct advise_request *request,
                            struct advise *advise, struct error *error);
/* The advice: seconds of all processors. `si`: units of its sentence. */
enum mr_status advise_find(struct advise *advise, bool si, struct progress *progress,
                           struct error *error);
void advise_free(struct advise *advise);

void advise_answer(const struct advise *advise, struct answer *answer);
/* As the campaign keeps it. */
struct store_advice advise_row_kept(const struct advise *advise, int64_t made_us);
/* As a board takes it before a landing: chart and plan. `landings`: that the board's runway has
 * had; the plan has MR_RISK_KNOTS points at most. MR_USAGE: it is more than a board understands. */
enum mr_status advise_chart(const struct advise *advise, unsigned landings,
                            struct mr_risk_plan *plan, struct error *error);

#endif
