/* Drawn calibrations and landings of one transducer and one gage, from volts: a board of the
 * reference circuits, a sensor with a curve, a laboratory whose standard is off, a calibration
 * through points, another temperature, and then a landing. What is wrong in the end is known,
 * because the truth is.
 *
 * Nothing here knows the uncertainty budget (host/calibrate/budget.h), which is held against it. */
#ifndef MATRIG_TESTS_UNCERTAINTY_DRAW_H
#define MATRIG_TESTS_UNCERTAINTY_DRAW_H

#include <stdint.h>

#include "common/config.h"
#include "common/channels.h"

/* What is drawn beside the board, which hil/rig/electronics.c draws. */
struct draw_setting {
    double laboratory_rel; /* standard: the scale of its standard, common to all points */
    double setting;        /* standard: of one known value, in or lb, by chance each time */
    double kelvin;         /* the landing is so much warmer or colder at most, evenly */
    double least, most;    /* of the landing's true value, in or lb, evenly */
    double known_most;     /* points from 0 to this, up and down */
    unsigned steps;
};

struct drawn {
    struct mr_channel_config channel; /* as matrig calibrate made it */
    struct mr_error_case reading;     /* how the landing was read */
    double value, truth;              /* in or lb: movement, or tension */
};

/* The transducer d3, or the gage t2. The configuration's reference and curve are the built-in
 * ones. */
enum draw_kind { DRAW_TRANSDUCER, DRAW_GAGE };
void draw(enum draw_kind kind, const struct draw_setting *setting, uint64_t seed,
          struct drawn *drawn);

#endif
