/* Input and messages of the predictor for each block. The host also runs this code, to check that a
 * board's messages follow from its record (tests/again). The functions have no side effects. */
#ifndef MATRIG_COMMON_ONBOARD_PREDICT_FEED_H
#define MATRIG_COMMON_ONBOARD_PREDICT_FEED_H

#include "common/catalogue.h"
#include "common/onboard/landing.h"
#include "common/predictor.h"
#include "common/risk.h"

#define PREDICT_LAMP_BLOCKS    10u /* interval between updates of the lamp */
#define PREDICT_REPORT_BLOCKS  50u /* interval between reports, 20 Hz */
/* maximum number of waiting blocks: the board's queue holds 16, and the final fit delays up to 7 */
#define PREDICT_BACKLOG_BLOCKS 8u

/* Motion of the gear at the last gate, in single precision; it is extrapolated from block to block
 * without double arithmetic. */
struct predict_motion {
    /* number of gates of the passage when the motion was last computed */
    unsigned gate_count;
    bool is_rolling, is_known; /* is_rolling: a wheel is present; is_known: its speed is known */
    uint32_t tick;             /* tick of the gate */
    float station_ft, speed_ft_s, deceleration_ft_s2;
    float stop_s;    /* time from the gate to the stop; very large if there is no stop */
    bool is_braking; /* enough gates were passed while braking to determine the deceleration */
};

/* Input from one block. */
struct predict_block {
    uint32_t index, tick;
    /* displacement of each transducer in this block, MR_TRANSDUCERS values; NaN: none */
    const float *displacement_in;
    const float *baseline_in; /* zero of each transducer; NaN: not known yet */
    unsigned blocks_waiting;  /* number of blocks that are waiting after this one */
};

/* Bit mask of transducers that moved after arming and before any switch opened. They keep their
 * zero although no gear was detected. */
uint32_t predict_find_frozen_zeros(const struct mr_predictor *predictor,
                                   const struct landing *landing);

/* Computes the predictor's input from a block. `touchdown_ft`: station where the runway begins,
 * from the configuration of the site. */
void predict_compute_input(struct predict_motion *motion, const struct landing *landing,
                           float touchdown_ft, const struct predict_block *block,
                           struct mr_predictor_input *input);

/* The messages of one report. `zone_error` is valid only if there is a zone. */
struct predict_report {
    struct mr_zone zone;
    struct mr_zone_lead zone_lead;
    struct mr_zone_error zone_error;
    struct mr_zone_coming zone_coming;
    struct mr_zone_press zone_press;
    struct mr_verdict verdict;
    struct mr_risk risk;
    struct mr_risk_lead risk_lead;
};

/* Fills in the messages of the report for block `index`, except those of the risk. `warning`: state
 * of the lamp. */
void predict_fill_report(const struct mr_predictor *predictor, const struct mr_predictor_zone *zone,
                         bool warning, uint32_t index, struct predict_report *report);
/* Fills in the risk messages of the report. */
void predict_fill_risk_report(const struct mr_risk_report *risk, uint32_t index,
                              struct predict_report *report);

/* ---- baseline ---- */

/* The zero of a landing's movements is the mean of BASELINE_BLOCKS consecutive blocks while the
 * board is armed and nothing rolls: the last complete group before the first edge. If no switch
 * works, there is no first edge; transducers that have moved then keep their zero
 * (predict_find_frozen_zeros). Pure. */

#define BASELINE_BLOCKS 256u

struct baseline {
    float sum_in[MR_TRANSDUCERS];
    unsigned blocks;
    /* zero of each transducer; NaN until BASELINE_BLOCKS blocks have passed since arming */
    float zero_in[MR_TRANSDUCERS];
};

void baseline_discard(struct baseline *baseline);
/* Adds the readings of a block; NaN: missing. If `quiet` is false, the mat may be moving, and the
 * current group is discarded. Transducers in the bit mask `frozen` keep their zero. */
void baseline_update(struct baseline *baseline, const float *displacement_in, bool quiet,
                     uint32_t frozen);

#endif
