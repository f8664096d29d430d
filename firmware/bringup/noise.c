/* Level and noise of each input, with the flash's prefetch and without: prefetch is said to disturb
 * the converters (AN4073). The core runs from flash meanwhile, as it does while it predicts.
 *
 * Noise of one conversion from the sums of 8, or 4, in block records: differences of one block to
 * the next have twice the variance of a sum, a drift drops out. White noise is assumed; hum counts
 * more than it should. */
#include <string.h>

#include "common/crc32.h"
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

#define BLOCKS         400u
#define SKIPPED        20u /* what the queue held */
#define BLOCK_WAIT_US  5000u
#define BUSY_BYTES     512u
#define REFERENCE_MV   2500u
#define SUPPLY_MOST_MV 4000u /* what the chip does not stand: no reference is there */

extern const uint8_t program_start[]; /* linker script */

static struct {
    struct mr_block last;
    uint32_t count; /* of differences */
    uint64_t squares[MR_BLOCK_SUMS];
    uint32_t sums[MR_BLOCK_SUMS];
} seen;

/* The next block; the core is busy until it comes. */
static bool next_block(struct mr_block *block)
{
    uint32_t begun = pace_begin(), at = 0;
    volatile uint32_t crc = 0;
    while (!board_block_take(block)) {
        crc = mr_crc32(crc, program_start + at, BUSY_BYTES);
        at = (at + BUSY_BYTES) % 32768u;
        if (pace_passed(begun, BLOCK_WAIT_US))
            return false;
    }
    return true;
}

static void add(const struct mr_block *block)
{
    bool follows = seen.last.index + 1u == block->index;
    for (unsigned i = 0; follows && i < MR_BLOCK_SUMS; i++) {
        int32_t difference = block->sums[i] - seen.last.sums[i];
        seen.squares[i] += (uint64_t)((int64_t)difference * difference);
        seen.sums[i] += block->sums[i];
    }
    seen.count += follows;
    seen.last = *block;
}

static bool measure(void)
{
    struct mr_block block;
    memset(&seen, 0, sizeof seen);
    for (unsigned n = 0; n < SKIPPED; n++) {
        if (!next_block(&block))
            return false;
    }
    seen.last.index = block.index - 2u; /* none follows it */
    for (unsigned n = 0; n < BLOCKS; n++) {
        if (!next_block(&block))
            return false;
        add(&block);
    }
    return seen.count > BLOCKS / 2u;
}

static uint32_t root(uint64_t of)
{
    uint64_t r = 0;
    for (uint64_t bit = 1ull << 31; bit; bit >>= 1) {
        if ((r | bit) * (r | bit) <= of)
            r |= bit;
    }
    return (uint32_t)r;
}

/* Thousandths of a code, of one conversion; `codes` are summed. */
static int32_t noise_milli(unsigned sum, unsigned codes)
{
    return (int32_t)root(seen.squares[sum] * 1000000u / (2u * codes * seen.count));
}

static int32_t level_milli(unsigned sum, unsigned codes)
{
    return (int32_t)((uint64_t)seen.sums[sum] * 1000u / (codes * seen.count));
}

static void say_channel(const char *what, unsigned channel, const char *signal, bool level)
{
    bool transducer = channel < MR_TRANSDUCERS;
    /* of a transducer the sums with forward excitation */
    unsigned sum = transducer ? channel : channel + MR_TRANSDUCERS;
    unsigned codes = transducer ? MR_SCANS_PER_BLOCK / 2u : MR_SCANS_PER_BLOCK;
    if (level)
        say_milli_of(what, signal, level_milli(sum, codes), "codes");
    else
        say_milli_of(what, signal, noise_milli(sum, codes), "codes");
}

static void say_channels(const char *what, bool level)
{
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) \
    say_channel(what, BOARD_##SIGNAL, #SIGNAL, level);
#include "firmware/boards/pins.def"
}

/* The converters' supply by the reference of 2.500 V, and how far it is from what the board's
 * should be: the staircase is read relative to the one, its wires to the other. */
static void say_supply(void)
{
    uint32_t sum = seen.sums[2u * MR_TRANSDUCERS + MR_ADC1_REFERENCE];
    uint32_t codes = MR_SCANS_PER_BLOCK * seen.count;
    uint32_t mv = sum ? (uint32_t)((uint64_t)REFERENCE_MV * 4096u * codes / sum) : 0;
    if (mv == 0 || mv > SUPPLY_MOST_MV) {
        say_none("supply", "V");
        say_none("supply_error", "ratio");
        return;
    }
    say_milli("supply", (int32_t)mv, "V");
    say_milli("supply_error", ((int32_t)mv - BOARD_SUPPLY_MV) * 1000 / BOARD_SUPPLY_MV, "ratio");
}

void bringup_noise(void)
{
    if (!measure()) {
        say_none("noise", "codes");
        return;
    }
    say_supply();
    say_channels("level_", true);
    say_channels("noise_", false);
    bringup_prefetch(false);
    bool came = measure();
    bringup_prefetch(true);
    if (came)
        say_channels("noise_without_prefetch_", false);
    else
        say_none("noise_without_prefetch", "codes");
}
