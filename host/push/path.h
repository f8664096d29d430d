/* The way of a push test through its forces: where it turns, and what each reading's displacement
 * is made of. Inner part of fit.c. */
#ifndef MATRIG_HOST_PUSH_PATH_H
#define MATRIG_HOST_PUSH_PATH_H

#include <stdbool.h>

#include "host/push/fit.h"

/* u_i = u0 + sum over m of (a grows[i][m] + b falls[i][m]) F_m. */
struct push_path {
    size_t count;
    size_t top;     /* at which the force first turns back, or the last one */
    size_t plateau; /* the last one from there on whose force is that one as far as can be told */
    size_t falling; /* readings at which |F| has fallen */
    double grows[PUSH_READINGS_MAX][PUSH_READINGS_MAX];
    double falls[PUSH_READINGS_MAX][PUSH_READINGS_MAX];
};

/* A force turns where it comes back by more than its gage's error explains; steps within that go on
 * as before. False: no force of the series stands out of the gage's error. */
bool push_path_make(struct push_path *path, const struct push_series *series,
                    double force_error_lb);

#endif
