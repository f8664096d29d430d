/* Zero and shunt calibration by command, while idle or done: means of blocks, checked before they
 * are used.
 *
 * zero: CALIBRATE_BLOCKS blocks of the channels asked for. Taken only if all of them are valid,
 * none moves (standard deviation, and first half against second half: 0.004 in, 0.75 lb) and no
 * gage is more than 30 lb from its configured zero - a band under tension is not at zero. Each is
 * reported (zero_result), and when taken the configuration is sent again.
 *
 * shunt: CALIBRATE_BLOCKS at rest, relay on, CALIBRATE_SETTLE_BLOCKS for relay and amplifiers,
 * CALIBRATE_BLOCKS, relay off, settling, CALIBRATE_BLOCKS at rest: 0.9 s. The span of each gage
 * that has a shunt is reported with its nominal value and its change since the calibration before
 * (shunt, shunt_result, shunt_check). Whatever happens meanwhile, the relay is off at the end.
 *
 * The answer to the command comes when it is over: MR_OK; MR_LIMIT: a channel was not good, as
 * reported; MR_TIMEOUT: the scans stopped. At once: MR_NOT_NOW: from arming to the end of a
 * landing, or another one is going on; MR_USAGE. */
#ifndef MATRIG_FIRMWARE_CALIBRATE_H
#define MATRIG_FIRMWARE_CALIBRATE_H

#include "common/block.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

#define CALIBRATE_BLOCKS        256u
#define CALIBRATE_SETTLE_BLOCKS 64u

/* Of one channel over the blocks of a phase: codes for a zero, pounds for a shunt. */
struct calibrate_mean {
    float origin, sum, square, first_half;
};

struct calibrate {
    uint8_t command; /* 0: nothing goes on */
    uint8_t what;    /* argument of zero */
    uint8_t phase;
    uint16_t tag;
    uint32_t began_block, next_block; /* next: the first that counts after settling */
    unsigned count;                   /* blocks of the phase so far */
    uint32_t bad;                     /* bit per channel: not valid in some block */
    struct calibrate_mean mean[MR_CHANNELS];
    float rest_lb[MR_GAGES], on_lb[MR_GAGES], noise_lb[MR_GAGES]; /* of the phases that are over */
    uint32_t moved;                                               /* bit per gage */
    uint16_t number;                                      /* of shunt calibrations since reset */
    float last_span_lb[MR_GAGES], last_rest_lb[MR_GAGES]; /* NaN: none */
    unsigned telling;                                     /* gages still to be reported */
    bool failed;
};

void calibrate_start(struct calibrate *calibrate);
/* Codes of enum mr_command_code: zero, shunt. MR_OK: it goes on, or (a zero that was given) is
 * done. */
enum mr_status calibrate_begin(struct calibrate *calibrate, struct telemetry *telemetry,
                               const struct landing *landing, const struct mr_command *command,
                               uint32_t block);
bool calibrate_busy(const struct calibrate *calibrate);
void calibrate_block(struct calibrate *calibrate, struct telemetry *telemetry,
                     const struct landing *landing, const struct mr_block *block);
/* Scans have stopped. */
void calibrate_abort(struct calibrate *calibrate, struct telemetry *telemetry, uint32_t block);

#endif
