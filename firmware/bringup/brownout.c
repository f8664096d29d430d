/* The brown-out level, which chips leave the factory without. At 168 MHz the core wants 2.7 V (data
 * sheet, table 14 with RM0090 5.1.3), so what is wanted is the highest level that the board's own
 * supply is above for sure: a board whose supply is below the level that is set never starts
 * again.
 *
 *     level  starts at, most   (data sheet, VBOR1 to VBOR3, rising)
 *     3      2.97 V            from 3.15 V on
 *     2      2.63 V            from 2.80 V on
 *
 * The supply is measured by the reference of 2.500 V, and must be what the board's own should be: a
 * pin without a reference reads anything. RM0090 3.6.2 (option bytes), 3.9.10. */
#include "common/channels.h"
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

#define KEY1            0x08192a3bu
#define KEY2            0x4c5d6e7fu
#define OPTCR_OPTLOCK   (1u << 0)
#define OPTCR_OPTSTRT   (1u << 1)
#define OPTCR_BOR_SHIFT 2u
#define OPTCR_BOR       (3u << OPTCR_BOR_SHIFT)
#define OPTCR_RDP       (0xffu << 8)
#define RDP_LEVEL_0     (0xaau << 8)
#define POLLS           48000000u /* some seconds; the loop stands still with the flash */
#define REFERENCE_MV    2500u
#define LEVEL_3_MV      3150u
#define LEVEL_2_MV      2800u
#define OFF_PERCENT     5u /* from what the board's supply should be */
#define BLOCK_WAIT_US   100000u
#define BLOCKS          64u

/* 0: no scans, or the reference is not one. */
static uint32_t measure_supply_mv(void)
{
    uint32_t sum = 0;
    struct mr_block block;
    for (unsigned n = 0; n < BLOCKS; n++) {
        uint32_t begun = pace_begin();
        while (!board_block_take(&block)) {
            if (pace_passed(begun, BLOCK_WAIT_US))
                return 0;
        }
        sum += block.sum[MR_ADC1_REFERENCE];
    }
    if (sum == 0)
        return 0;
    uint32_t mv = (uint32_t)((uint64_t)REFERENCE_MV * 4096u * MR_SCANS_PER_BLOCK * BLOCKS / sum);
    return mv <= 3700u ? mv : 0; /* beyond what the chip stands: no reference is there */
}

static bool is_the_boards(uint32_t mv)
{
    uint32_t off = mv > BOARD_SUPPLY_MV ? mv - BOARD_SUPPLY_MV : BOARD_SUPPLY_MV - mv;
    return off * 100u <= BOARD_SUPPLY_MV * OFF_PERCENT;
}

static bool write_options(uint32_t options)
{
    uint32_t mask = irq_mask(); /* their handlers are in the flash that stands still */
    watchdog_patience(WATCHDOG_FLASH);
    if (FLASH_OPTCR & OPTCR_OPTLOCK) {
        FLASH_OPTKEYR = KEY1;
        FLASH_OPTKEYR = KEY2;
    }
    FLASH_OPTCR = options;
    FLASH_OPTCR = options | OPTCR_OPTSTRT;
    uint32_t polls = POLLS;
    while ((FLASH_SR & FLASH_SR_BSY) && --polls) {
    }
    FLASH_OPTCR |= OPTCR_OPTLOCK;
    watchdog_patience(WATCHDOG_USUAL);
    irq_restore(mask);
    return polls > 0 && (FLASH_OPTCR & ~OPTCR_OPTLOCK) == options;
}

static void set_level(uint32_t level)
{
    uint32_t before = FLASH_OPTCR & ~(OPTCR_OPTLOCK | OPTCR_OPTSTRT);
    uint32_t wanted = (before & ~OPTCR_BOR) | (3u - level) << OPTCR_BOR_SHIFT;
    /* Anything else than level 0 of the read protection: an error here could lock the chip. */
    if ((before & OPTCR_RDP) != RDP_LEVEL_0)
        say_word("brown_out_set", "protected", "result");
    else if (before == wanted)
        say_word("brown_out_set", "was_so", "result");
    else
        say_word("brown_out_set", write_options(wanted) ? "written" : "failed", "result");
}

void bringup_set_brown_out(void)
{
    uint32_t mv = measure_supply_mv();
    if (mv)
        say_milli("supply", (int32_t)mv, "V");
    else
        say_none("supply", "V");
    uint32_t level = mv >= LEVEL_3_MV ? 3u : mv >= LEVEL_2_MV ? 2u : 0u;
    if (mv && !is_the_boards(mv))
        say_word("brown_out_set", "supply_not_the_boards", "result");
    else if (level)
        set_level(level);
    else
        say_word("brown_out_set", mv ? "supply_too_low" : "supply_not_known", "result");
    say_number("brown_out", (int32_t)(3u - (FLASH_OPTCR >> OPTCR_BOR_SHIFT & 3u)), "level");
}
