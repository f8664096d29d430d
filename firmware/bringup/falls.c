/* What ends in a reset: a stack that overflows, and a watchdog that nobody feeds. What it was like
 * is known afterwards from the note of the fault (fault.c), and from a count that RAM keeps. */
#include "common/crash.h"
#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"

#define CAUSE_SOFTWARE 4u
#define CAUSE_WATCHDOG 8u
#define STARVED_S      4u
#define COUNTS         (WATCHDOG_USUAL + 1u) /* RM0090 table 107: the last one is of 0 */
#define LSI_DIVIDER    32u
#define CFSR_BFARVALID (1u << 15)
#define CFSR_STKERR    (1u << 12)
#define CFSR_IMPRECISE (1u << 10)

extern uint32_t stack_bottom[]; /* linker script */

static uint32_t starved_cycles __attribute__((section(".noinit")));
static uint32_t starved_mhz __attribute__((section(".noinit")));

static uint8_t reset_cause(void)
{
    struct board_identity identity;
    board_identify(&identity);
    return identity.reset_cause;
}

/* As a chain of calls that is too deep does: the stack is at its bottom, then comes one more. */
void bringup_overflow_stack(void)
{
    __asm volatile("mov sp, %0\n\tpush {r0-r7}\n\tdsb" : : "r"(stack_bottom) : "memory");
    for (;;) { /* nothing stopped it; the watchdog does, and the note is missing then */
    }
}

static const char *caught_word(const struct board_restart *restart)
{
    if (!(reset_cause() & CAUSE_SOFTWARE) || !restart->crash || restart->crash_age != 0)
        return "no_fault";
    return mr_crash_kind_text(restart->crash[MR_CRASH_KIND])[0] == 'b' ? "bus_fault"
                                                                       : "other_fault";
}

void bringup_say_overflow(void)
{
    struct board_restart restart;
    board_restarted(&restart);
    const uint32_t *crash = restart.crash;
    say_word("stack_overflow", caught_word(&restart), "caught_by");
    if (!crash || restart.crash_age != 0) {
        say_none("stack_status", "cfsr");
        say_none("stack_address", "address");
        return;
    }
    uint32_t cfsr = crash[MR_CRASH_CFSR];
    say_hex("stack_status", cfsr, "cfsr");
    if (cfsr & CFSR_BFARVALID)
        say_hex("stack_address", crash[MR_CRASH_BFAR], "address");
    else
        say_word("stack_address", cfsr & (CFSR_STKERR | CFSR_IMPRECISE) ? "imprecise" : "none",
                 "address");
}

void bringup_starve_watchdog(void)
{
    (void)irq_mask();
    starved_mhz = pace_hclk_mhz();
    starved_cycles = 0;
    watchdog_patience(WATCHDOG_USUAL); /* and feeds it, for the last time */
    uint32_t begun = pace_begin();
    while (pace_cycles(begun) < STARVED_S * 1000000u * starved_mhz)
        starved_cycles = pace_cycles(begun);
}

void bringup_say_watchdog(void)
{
    uint32_t us = starved_mhz ? starved_cycles / starved_mhz : 0;
    if (!(reset_cause() & CAUSE_WATCHDOG) || us == 0) {
        say_none("watchdog", "ms");
        say_none("low_speed", "kHz");
        return;
    }
    say_milli("watchdog", (int32_t)us, "ms");
    say_milli("low_speed", (int32_t)((uint64_t)COUNTS * LSI_DIVIDER * 1000000u / us), "kHz");
}
