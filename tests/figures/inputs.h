/* What the text leaves open about figures 3.6 to 3.12: the unknown inputs, as one vector.
 *
 * A reading is one value for each. R* is the reading that the scenes of host/scenes have; applied
 * to them it changes nothing. Ranges are what the text allows (`open` says where it leaves the
 * input open); they were fixed before any search. Choices are 0, 1, ... of `options`. */
#ifndef MATRIG_TESTS_FIGURES_INPUTS_H
#define MATRIG_TESTS_FIGURES_INPUTS_H

#include <stdbool.h>
#include <stdint.h>

enum input_id {
    IN_W,
    IN_V0,
    IN_VAC,
    IN_S0,
    IN_TO_EDGE,
    IN_CROSS38,
    IN_N,
    IN_LEFT,
    IN_RIGHT,
    IN_RIGHT312,
    IN_F312,
    IN_CL,
    IN_THRUST,
    IN_FRICTION,
    IN_SHEAR,
    IN_SHEAR_LAW,
    IN_KV,
    IN_TAD_MODE,
    IN_BUMP_FIRST,
    IN_THIRD36,
    IN_RATIO,
    IN_HEIGHT,
    IN_NODES39,
    IN_NODES311,
    IN_NODES312,
    IN_MAT36,
    IN_MAT312,
    INPUTS
};

enum input_kind { INPUT_EVEN, INPUT_LOG, INPUT_WHOLE, INPUT_CHOICE };

struct input {
    const char *name, *open; /* what it is; where the text leaves it open */
    enum input_kind kind;
    double low, high, rstar;
    const char *options[4]; /* of a choice */
};
extern const struct input inputs[INPUTS];

struct reading {
    double value[INPUTS];
};

struct reading reading_rstar(void);

#endif
