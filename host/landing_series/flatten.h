/* Flatten: a wave that a landing left, pressed flat when the aircraft is pushed back over it. */
#ifndef MATRIG_HOST_LANDING_SERIES_FLATTEN_H
#define MATRIG_HOST_LANDING_SERIES_FLATTEN_H

#include <stddef.h>

struct flat_runway {
    size_t joints;  /* mats + 1; the first and the last are the runway's ends, which hold */
    double *gap_ft; /* per joint; negative: its mats are that much too long to lie flat */
    double *u_ft;   /* per mat 1..joints - 1, [0] unused: movement, added to */
    const double *closing_lb; /* per joint: what it resists closing with */
    double rub_lb;            /* what holds a mat: friction times its weight */
    double kl_lb_ft;          /* of a joint, pressed */
};

/* Joints that are too short push what lies against them away, step by step to the side that resists
 * less: mats that touch each other go together, until the next opening has closed. Each joint stops
 * at the compression that both sides hold by friction. Openings only pass along: their sum
 * stays. */
void flatten(const struct flat_runway *runway);

#endif
