/* Input and messages of the predictor, each block. The host runs this part too, to check that a
 * board's messages follow from its record (tests/again). Pure. */
#ifndef MATRIG_COMMON_ONBOARD_PREDICT_FEED_H
#define MATRIG_COMMON_ONBOARD_PREDICT_FEED_H

#include "common/catalogue.h"
#include "common/onboard/landing.h"
#include "common/predictor.h"
#include "common/risk.h"

#define PREDICT_LOOK_BLOCKS    10u /* the lamp follows so often */
#define PREDICT_SAY_BLOCKS     50u /* 20 Hz */
/* of the 16 that the board holds; the final fit of the motion keeps up to 7 waiting */
#define PREDICT_BACKLOG_BLOCKS 8u

/* Motion of the gear as of the last gate, in single precision: carried on block by block without a
 * double. */
struct predict_motion {
    unsigned gates;      /* of the passage, when this was made */
    bool rolling, known; /* a wheel is there; its speed is known */
    uint32_t tick;       /* of the gate */
    float station_ft, speed_ft_s, deceleration_ft_s2;
    float stop_s; /* from the gate until it stops; a large number: it does not */
    bool braking; /* enough gates beyond touchdown for a deceleration */
};

/* What a block brings for it. */
struct predict_block {
    uint32_t index, tick;
    const float *displacement_in; /* readings of this block, MR_TRANSDUCERS; NaN: none */
    const float *baseline_in;     /* their zero; NaN: not known yet */
    unsigned waiting;             /* blocks that wait behind this one */
};

/* Transducers, as bits, whose zero is kept although nothing seems to roll: they have moved, and no
 * switch has opened since arming. */
uint32_t predict_held(const struct mr_predictor *predictor, const struct landing *landing);

/* What the predictor is given of a block. `touchdown_ft`: station where the runway begins, of the
 * site's configuration. */
void predict_feed(struct predict_motion *motion, const struct landing *landing, float touchdown_ft,
                  const struct predict_block *block, struct mr_predictor_input *input);

/* One statement; `error` only where there is a zone. */
struct predict_said {
    struct mr_zone zone;
    struct mr_zone_lead lead;
    struct mr_zone_error error;
    struct mr_zone_coming coming;
    struct mr_zone_press press;
    struct mr_verdict verdict;
    struct mr_risk risk;
    struct mr_risk_lead risk_lead;
};

void predict_statement(const struct mr_predictor *predictor, const struct mr_predictor_zone *zone,
                       bool warning, uint32_t index, struct predict_said *said);
/* Its other part: the risk, and from where on the lamp warns (NaN: by the verdict). */
void predict_risk_statement(const struct mr_risk_said *risk, uint32_t index,
                            struct predict_said *said);

/* ---- baseline ---- */

/* The zero of a landing's movement: while it is armed and nothing rolls, the mean of each full
 * group of blocks; the newest one before the first edge stands. Where no switch works, there is
 * none: what has moved is held (predict_held). Pure. */

#define BASELINE_BLOCKS 256u

struct baseline {
    float sum_in[MR_TRANSDUCERS];
    unsigned blocks;
    float in[MR_TRANSDUCERS]; /* NaN until BASELINE_BLOCKS have passed since arming */
};

void baseline_forget(struct baseline *baseline);
/* A block's readings; NaN: missing. Not `quiet`: the group that was being summed ends with
 * something that may move the mat. Transducers of the bits `held` keep the zero they have. */
void baseline_follow(struct baseline *baseline, const float *displacement_in, bool quiet,
                     uint32_t held);

#endif
