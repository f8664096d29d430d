/* What `matrig advise` says before the landings of a series of the score, by its own code: known
 * are a survey, friction told, the speed, and a plan of the braking; each landing teaches. */
#ifndef MATRIG_TESTS_SCORE_ADVISED_H
#define MATRIG_TESTS_SCORE_ADVISED_H

#include "common/risk.h"
#include "host/advise/members.h"
#include "tests/score/score.h"

#define ADVISED_STATIONS 7 /* 40 to 100 ft */
#define ADVISED_MEMBERS  64

/* What is known of a landing: before it the plan and the survey, after it how it was braked and
 * where the transducers came to rest. */
struct advised_known {
    double plan_ft_s2, true_ft_s2, sum_in[MR_SEGMENTS], read_in[ADVISED_STATIONS];
    struct advise_profile profile; /* count 0: even */
};

double advised_mean_ft_s2(const struct score_landing *landing, double touchdown_ft);
/* Survey before the landing and readings after it, with their errors. */
void advised_read(const struct score_landing *landing, uint64_t *facts,
                  struct advised_known *known);
/* What the ensemble is told of the runway: as the board is, but for the share of the thrust;
 * `share`: that was measured. */
bool advised_begin(struct advise_members *members, const struct score_series *series, bool share);
/* `log_ratio`: of the landings before, how their plans were met. */
void advised_plan(struct advise_plan *plan, const struct score_landing *landing,
                  const struct advised_known *known, const double *log_ratio, size_t landings);
/* What is said of a mean deceleration before a landing. */
bool advised_say(struct advise_members *members, const struct advise_plan *plan,
                 const struct advised_known *known, double mean_ft_s2, struct advise_row *row);
/* What a landing teaches; `next`: the one whose survey comes after it. */
bool advised_teach(struct advise_members *members, const struct score_landing *landing,
                   const struct advised_known *known, const struct advised_known *next);

/* How a series is told: what is not 0 or 1 of it is off. */
struct advised_told {
    unsigned view;         /* of score.h: survey and transducers */
    double friction_times; /* what is told of it, over what is told otherwise */
    double plan_error;     /* rms, of the deceleration and of the time when it changes */
    double harder;         /* each landing is braked so many times harder than planned */
    bool share;            /* of the thrust that the strip bears: measured within 3 % */
};

/* The plan as it is told to the board; no chart yet. */
void advised_draw_plan(const struct score_landing *landing, uint32_t series,
                       const struct advised_told *told, struct mr_risk_plan *plan);
/* Its mean deceleration over the way, and its hardest. */
double advised_plan_mean_ft_s2(const struct mr_risk_plan *plan);
double advised_plan_hardest_ft_s2(const struct mr_risk_plan *plan);

/* A chart for each landing of a series: what is said at `factors` times the planned mean. */
#define ADVISED_ROWS 3
struct advised_chart {
    double mean_ft_s2[ADVISED_ROWS], p[ADVISED_ROWS], share[ADVISED_ROWS], half_ft[ADVISED_ROWS];
};
bool advised_charts(const struct score_truth *truth, const struct advised_told *told,
                    const double *factors, size_t rows, struct advised_chart *chart);
/* Into the plan. */
void advised_chart_put(const struct advised_chart *chart, size_t rows, struct mr_risk_plan *plan);

#endif
