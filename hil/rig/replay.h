/* Replay: a recorded landing on the board's pins instead of a rig.
 *
 * The converters deliver codes that have the sums and counts of the recorded blocks, block n of the record in block n of the
 * board (both count on TIM2, from the moment it starts); a transducer's codes follow the polarity that the excitation pins
 * really have. PA15 rises so that TIM2 captures the recorded ticks, PB3 at
 * those of film frames, from which the board has taken off the delay of its filter. Commands come over the serial line (a third and fourth
 * of one block over CAN) in the middle of the block that took them. */
#ifndef MATRIG_HIL_REPLAY_H
#define MATRIG_HIL_REPLAY_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/rig/replayfile.h"

struct hil_board;

struct hil_replay_state {
    bool started;        /* TIM2 runs */
    uint64_t zero_cycle; /* it was 0 here */
    uint64_t resets;     /* of the chip when it started */
    uint32_t next_edge, next_command, next_frame;
    bool pulse;          /* PA15 is high */
    bool frame_pulse;    /* PB3 is high */
    uint16_t sequence;   /* of serial frames */
};

/* Connect a replay in place of a rig; it is not copied and must outlive the board. Before the first run. */
void hil_board_attach_replay(struct hil_board *board, const struct hil_replay *replay);
/* Seconds from power on by which the record is over and everything about it has been sent. */
double hil_replay_duration_s(const struct hil_replay *replay);

/* Code of a pin sampled at cycle `at`. */
uint16_t hil_replay_code(struct hil_board *board, unsigned port, unsigned pin, uint64_t at);
void hil_replay_event(struct hil_board *board, uint64_t at);

#endif
