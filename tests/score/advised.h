/* What `matrig advise` says before the landings of a series of the score, by its own code: known are
 * a survey, friction told, the speed, and a plan of the mean deceleration; each landing teaches. */
#ifndef MATRIG_TESTS_SCORE_ADVISED_H
#define MATRIG_TESTS_SCORE_ADVISED_H

#include "host/advise/forecast.h"
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
/* What the ensemble is told of the runway: as the board is, but for the share of the thrust. */
bool advised_begin(struct advise_members *members, const struct score_series *series);
/* `log_ratio`: of the landings before, how their plans were met. */
void advised_plan(struct advise_plan *plan, const struct score_landing *landing,
                  const struct advised_known *known, const double *log_ratio, size_t landings);
/* What is said of a mean deceleration before a landing. */
bool advised_say(struct advise_members *members, const struct advise_plan *plan,
                 const struct advised_known *known, double mean_ft_s2, struct advise_row *row);
/* What a landing teaches; `next`: the one whose survey comes after it. */
bool advised_teach(struct advise_members *members, const struct score_landing *landing,
                   const struct advised_known *known, const struct advised_known *next);

#endif
