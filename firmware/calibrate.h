/* Zero and shunt calibration by command, in state idle or done. Results are means of blocks and are
 * checked before use.
 *
 * zero: averages CALIBRATE_BLOCKS blocks of the requested channels. The zeros are accepted only if
 * all channels are valid, no channel moves, and no gage is more than 30 lb from its configured zero
 * (the zero cannot be measured with a band under tension). A channel counts as moving if its
 * standard deviation, or the difference between the first and second half, exceeds 0.004 in or 0.75
 * lb. Each channel is reported (zero_result); if the zeros are accepted, the configuration is sent
 * again.
 *
 * shunt: measures CALIBRATE_BLOCKS blocks three times: at rest, with the relay on, and at rest
 * again. After each switching of the relay, it waits CALIBRATE_SETTLE_BLOCKS blocks, in which relay
 * and amplifiers settle. The calibration takes 0.9 s. The span of each gage that has a shunt is
 * reported with its nominal value and its change since the previous calibration (shunt,
 * shunt_result, shunt_check). The relay is off at the end in every case.
 *
 * The command is answered at the end of the calibration: MR_OK; MR_LIMIT: a channel failed its
 * check, as reported; MR_TIMEOUT: the scans stopped. It is answered at once with MR_NOT_NOW (from
 * arming to the end of a landing, or during a calibration) or MR_USAGE. */
#ifndef MATRIG_FIRMWARE_CALIBRATE_H
#define MATRIG_FIRMWARE_CALIBRATE_H

#include "common/block.h"
#include "common/onboard/landing.h"
#include "firmware/telemetry.h"

#define CALIBRATE_BLOCKS        256u
#define CALIBRATE_SETTLE_BLOCKS 64u

/* Sums of one channel over the blocks of a phase: codes for a zero, pounds for a shunt. */
struct calibrate_mean {
    float origin, sum, square_sum, first_half_sum;
};

struct calibrate {
    uint8_t command;       /* 0: no calibration in progress */
    uint8_t zero_argument; /* argument of the command `zero` */
    uint8_t phase;
    uint16_t tag;
    uint32_t start_block, next_block; /* next_block: first block that is used after settling */
    unsigned block_count;             /* number of blocks processed in this phase */
    uint32_t invalid_channels;        /* one bit per channel: not valid in at least one block */
    struct calibrate_mean mean[MR_CHANNELS];
    float rest_lb[MR_GAGES], shunt_reading_lb[MR_GAGES],
        noise_lb[MR_GAGES]; /* results of completed phases */
    uint32_t moved_gages;   /* bit mask of gages that moved */
    uint16_t number;        /* number of shunt calibrations since reset */
    /* results of the previous calibration; NaN: none */
    float previous_span_lb[MR_GAGES], previous_rest_lb[MR_GAGES];
    unsigned gages_to_report; /* number of gages still to be reported */
    bool has_failed;
};

void calibrate_start(struct calibrate *calibrate);
/* Starts the command zero or shunt. MR_OK: the calibration is in progress, or is complete (a zero
 * given as a value). */
enum mr_status calibrate_begin(struct calibrate *calibrate, struct telemetry *telemetry,
                               const struct landing *landing, const struct mr_command *command,
                               uint32_t block);
bool calibrate_is_busy(const struct calibrate *calibrate);
void calibrate_on_block(struct calibrate *calibrate, struct telemetry *telemetry,
                        const struct landing *landing, const struct mr_block *block);
/* Call when the scans have stopped: ends a calibration. */
void calibrate_abort(struct calibrate *calibrate, struct telemetry *telemetry, uint32_t block);

#endif
