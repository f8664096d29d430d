/* Ensemble smoother: what readings say of the unknowns of an ensemble, from how both go together
 * among its members (Evensen 1994; several passes with larger errors: ES-MDA, Emerick and Reynolds
 * 2013; gain taken down by distance: Chen and Oliver 2017; spread given back: Whitaker and Hamill
 * 2012). Of a linear model with Gaussian unknowns and many members it comes to the Kalman filter
 * (tests/host/test_advise.c). Pure but for its memory and the draws. */
#ifndef MATRIG_HOST_ADVISE_SMOOTHER_H
#define MATRIG_HOST_ADVISE_SMOOTHER_H

#include <stdbool.h>
#include <stddef.h>

#include "host/advise/chance.h"

/* Unknowns and readings are in any units; each reading's error is in the reading's. */
struct smoother {
    size_t members, states, data;
    double *state;           /* [members][states]; smoother_take changes it */
    const double *predicted; /* [members][data]: what each member says of the readings */
    const double *read;      /* [data]; NaN: not read */
    const double *error;     /* [data]: standard errors, of the model too; above 0 */
    /* the errors' variance counts so many times; n passes with n each come to one with 1 */
    double passes;
    /* 0..1: how much datum may say of state; NULL: all. Keeps chance from being taken for cause */
    double (*nearness)(const void *context, size_t state, size_t datum);
    const void *context;
};

/* One pass. Readings are perturbed member by member, their mean is not. False: too
 * few members (below 2). Without a reading nothing changes. */
bool smoother_take(const struct smoother *smoother, struct chance *chance);

/* Mean and standard deviation of column `column` of [members][states]. */
void smoother_spread(const double *state, size_t members, size_t states, size_t column,
                     double *mean, double *deviation);
/* Gives back to the column the share `kept` of the deviation that it has lost since it was `was`,
 * and all of it up to `least`. */
void smoother_widen(double *state, size_t members, size_t states, size_t column, double was,
                    double kept, double least);

/* 1 at 0, 0 from twice `half` on, smooth between (Gaspari and Cohn 1999, equation 4.10). */
double smoother_taper(double distance, double half);

#endif
