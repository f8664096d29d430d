/* What a check for a misfit works on; host/study/fit/misfit.h. */
#ifndef MATRIG_HOST_STUDY_FIT_MISFIT_PARTS_H
#define MATRIG_HOST_STUDY_FIT_MISFIT_PARTS_H

#include "host/study/fit/misfit.h"

#define GROUP_MAX 160 /* means in a group */

struct checking {
    const struct fit_landings *list;
    const struct fit_answer *answer;
    size_t rows, statistics;
    const struct fit_landing **landing; /* of each statistic */
    const struct fit_window **window;
    double *z;      /* rows of statistics, each of mean 0 and variance 1 over the rows */
    double *figure; /* MISFITS rows of `rows` values */
    double *group;  /* GROUP_MAX columns of `rows` values */
    size_t members;
    double *weight;    /* of statistics, for one member */
    double *spread;    /* of each statistic's residuals */
    size_t *member_at; /* most odd statistic of each member in the measured row */
};

static inline bool is_sum(const struct checking *c, size_t s)
{
    return c->window[s]->channel == SIZE_MAX;
}

static inline double z_of(const struct checking *c, size_t row, size_t s)
{
    return c->z[row * c->statistics + s];
}

/* Statistics of transducers that are of one landing and place of the wheel. */
bool misfit_alike(const struct checking *c, size_t s, size_t other);

/* Fill figures and what is known of them. False: no memory. */
void misfit_singles(struct checking *c, uint64_t seed, struct misfit *misfit);
bool misfit_groups(struct checking *c, struct misfit *misfit);
bool misfit_odds(struct checking *c, struct misfit *misfit);

#endif
