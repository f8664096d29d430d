/* Replay: a recorded landing on the board's pins instead of a rig.
 *
 * The converters deliver codes that have the sums and counts of the recorded blocks, block n of the
 * record in block n of the board (both count on TIM2, from the moment it starts); a transducer's
 * codes follow the polarity that the excitation pins really have. PA15 rises so that TIM2 captures
 * the recorded ticks, PB3 at those of film frames, from which the board has taken off the delay of
 * its filter. Commands come over the serial line (a third and fourth of one block over CAN) in the
 * middle of the block that took them; the board is started for a replay by the command `replay` and
 * the maintenance jumper. */
#ifndef MATRIG_HIL_REPLAY_H
#define MATRIG_HIL_REPLAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/status.h"

/* Converter codes that have given sums and counts of saturation: what a block record leaves open is
 * chosen here. */
#define HIL_CODES_PER_POLARITY (MR_SCANS_PER_BLOCK / 2u)

/* The codes of one block: of the transducers by polarity of the excitation (0 forward), each in
 * order of the scans. */
struct hil_codes {
    uint16_t transducer[2][MR_TRANSDUCERS][HIL_CODES_PER_POLARITY];
    uint16_t adc1[MR_ADC1_CHANNELS][MR_SCANS_PER_BLOCK];
};

/* Codes whose sums and counts are the block's, zeroes of channels that are absent. False: there are
 * none; `*channel` (0 to MR_CHANNELS - 1) is the first for which it is so. */
bool hil_codes_of(const struct mr_block *block, struct hil_codes *codes, unsigned *channel);

struct hil_adc_device;
struct hil_can_device;
struct hil_core;
struct hil_gpio_device;
struct hil_rcc_device;
struct hil_rig_device;
struct hil_tim_device;
struct hil_usart_device;

struct hil_replay_state {
    bool started;        /* TIM2 runs */
    uint64_t zero_cycle; /* it was 0 here */
    uint64_t resets;     /* of the chip when it started */
    uint32_t next_edge, next_command, next_frame;
    bool pulse;        /* PA15 is high */
    bool frame_pulse;  /* PB3 is high */
    uint16_t sequence; /* of serial frames */
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
    const struct hil_rig_device *rig; /* for the polarity of the excitation */
    const struct hil_replay *replay;  /* NULL: none */
    /* Derived; worked out again when needed. */
    const struct mr_block *codes_block; /* whose codes these are; NULL: of none */
    struct hil_codes codes;
};

void hil_replay_create(struct hil_replay_device *dev);
/* Begin a record; it is not copied. NULL: none. The state stays as it is. */
void hil_replay_connect(struct hil_replay_device *dev, const struct hil_replay *replay);
/* Seconds from power on by which the record is over and everything about it has been sent. */
double hil_replay_duration_s(const struct hil_replay *replay);

/* ---- replayfile ---- */

/* The replay file: a recorded landing as the board saw it, as text, read once. Its lines:
 * hil/README.md, "Replay file". Blocks count from the start of the board's scans, as in the
 * records; before the first record its codes hold, after the last one the last one's. */

struct hil_replay_command {
    uint32_t block;
    struct mr_command message;
};

struct hil_replay {
    bool has_uid;
    uint32_t uid[3];
    bool crystal;
    struct mr_block *blocks;
    size_t block_count; /* at least 1 */
    uint64_t *edge_tick;
    size_t edge_count;
    uint64_t *frame_tick;
    size_t frame_count;
    struct hil_replay_command *commands;
    size_t command_count;
    uint32_t origin_tick; /* TIM2 at the first trigger of block 0 */
};

/* Read a file. On failure nothing is kept and `error` (size bytes) describes the fault, with file
 * and line. MR_IO: cannot be read; MR_MALFORMED, MR_TRUNCATED, MR_CRC, MR_VERSION: not a whole
 * replay file of version 1, or a record whose sums no codes can have. */
enum mr_status hil_replay_read(const char *path, struct hil_replay *replay, char *error,
                               size_t size);
void hil_replay_free(struct hil_replay *replay);

#endif
