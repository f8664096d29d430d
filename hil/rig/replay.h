/* Replay: applies a recorded landing to the board's pins in place of a rig.
 *
 * The converters deliver codes with the sums and counts of the recorded blocks. Block n of the
 * record is used in block n of the board, counted from the start of TIM2. The codes of a transducer
 * follow the actual polarity of the excitation pins. PA15 rises so that TIM2 captures the recorded
 * ticks of edges. PB3, PB10 and PB11 rise so that it captures the recorded ticks of film frames,
 * brake and wheel (the board has subtracted the delay of its input filter from these ticks).
 * Commands are sent over serial (a third and fourth command of one block over CAN) in the middle of
 * the block in which they were processed. The command `replay` with the maintenance jumper starts
 * the board for a replay. */
#ifndef MATRIG_HIL_REPLAY_H
#define MATRIG_HIL_REPLAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/status.h"
#include "hil/rig/runfile.h"

/* Computes converter codes that have given sums and saturation counts. A block record does not
 * determine the individual codes, so this chooses them. */
#define HIL_CODES_PER_POLARITY (MR_SCANS_PER_BLOCK / 2u)

/* The codes of one block, in order of the scans. Codes of transducers are separate for each
 * polarity of the excitation (0: forward). */
struct hil_block_codes {
    uint16_t transducer[2][MR_TRANSDUCERS][HIL_CODES_PER_POLARITY];
    uint16_t adc1[MR_ADC1_CHANNELS][MR_SCANS_PER_BLOCK];
};

/* Computes codes with the sums and counts of the block; absent channels get zeroes. Returns false
 * if no codes have these sums and counts; `*channel` (0 to MR_CHANNELS - 1) is the first channel
 * without a solution. */
bool hil_codes_from_block(const struct mr_block *block, struct hil_block_codes *codes,
                          unsigned *channel);

#define HIL_REPLAY_TRAINS 3u /* number of pulse trains: film frames, brake, wheel */
#define HIL_REPLAY_FIRST_CAPTURE_CHANNEL \
    1u /* capture channel of the first pulse train (hil_capture_pins) */

struct hil_adc_device;
struct hil_can_device;
struct hil_core;
struct hil_gpio_device;
struct hil_rcc_device;
struct hil_rig_device;
struct hil_tim_device;
struct hil_usart_device;

struct hil_replay_state {
    bool is_started;          /* TIM2 is running */
    uint64_t tim2_zero_cycle; /* cycle at which TIM2 was 0 */
    uint64_t reset_count;     /* resets of the chip before TIM2 started */
    uint32_t next_edge, next_command;
    bool is_edge_pulse_high; /* PA15 is high */
    struct hil_pulse_train_state pulse_train[HIL_REPLAY_TRAINS];
    uint16_t sequence; /* sequence number of the next serial frame */
};

struct hil_replay_device {
    struct hil_core *core;
    struct hil_replay_state *state;
    struct hil_gpio_device *gpio;
    struct hil_adc_device *adc;
    struct hil_rcc_device *rcc;
    struct hil_tim_device *tim;
    struct hil_can_device *can;
    struct hil_usart_device *usart;
    const struct hil_rig_device *rig; /* provides the polarity of the excitation */
    const struct hil_replay *replay;  /* record being replayed; NULL: none */
    /* The following members are derived from the others when needed. */
    const struct mr_block *codes_block; /* block whose codes are stored; NULL: none */
    struct hil_block_codes codes;
};

void hil_replay_create(struct hil_replay_device *dev);
/* Connects a record, which is not copied; NULL: none. The state is unchanged. */
void hil_replay_connect(struct hil_replay_device *dev, const struct hil_replay *replay);
/* Time from power on, s, after which the record has ended and all output about it has been sent. */
double hil_replay_duration_s(const struct hil_replay *replay);

/* ---- the replay file ---- */

/* The replay file contains the board's input during a recorded landing as text. hil/README.md,
 * "Replay file", describes its lines. Blocks are counted from the start of the board's scans, as in
 * the records. Before the first and after the last record, the codes of that record are used. */

struct hil_replay_command {
    uint32_t block;
    struct mr_command message;
};

struct hil_replay {
    bool has_uid;
    uint32_t uid[3];
    bool has_crystal;
    struct mr_block *blocks;
    size_t block_count; /* at least 1 */
    uint64_t *edge_ticks;
    size_t edge_count;
    struct hil_pulse_train
        pulse_train[HIL_REPLAY_TRAINS]; /* pulses of each train; times in ticks */
    struct hil_replay_command *commands;
    size_t command_count;
    uint32_t block0_tick; /* value of TIM2 at the first trigger of block 0 */
};

/* Reads a file. On failure no memory remains allocated, and `error` (size bytes) describes the
 * fault with file and line. MR_OK; MR_IO: cannot be read; MR_MALFORMED, MR_TRUNCATED, MR_CRC,
 * MR_VERSION: not a complete replay file of version 1, or a record with impossible sums. */
enum mr_status hil_replay_read(const char *path, struct hil_replay *replay, char *error,
                               size_t size);
void hil_replay_free(struct hil_replay *replay);

#endif
