/* Virtual time: HCLK cycles since power on, and their physical time in picoseconds. */
#ifndef MATRIG_HIL_CLOCK_H
#define MATRIG_HIL_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#define HIL_NEVER UINT64_MAX /* of a cycle, of a physical time */

struct hil_clock {
    uint64_t now_cycle;    /* start of the basic block that runs */
    uint64_t anchor_cycle; /* where HCLK last changed */
    uint64_t anchor_ps;
    uint32_t hclk_hz;
    /* HCLK that this is of: a cycle takes ratio_ps / ratio_cycles picoseconds, in lowest terms */
    uint32_t ratio_hz;
    uint64_t ratio_ps, ratio_cycles;
    bool stopped; /* no clock at all: cycles stand still */
};

/* Physical time of a cycle, rounded down; and the first cycle that is not before a time. */
uint64_t hil_clock_ps(const struct hil_clock *clock, uint64_t cycle);
uint64_t hil_clock_cycle(const struct hil_clock *clock, uint64_t t_ps);
/* HCLK of a clock that starts. */
void hil_clock_start(struct hil_clock *clock, uint32_t hclk_hz);
/* HCLK becomes hclk_hz at the present cycle. Whoever waits for a physical time has to be told:
 * hil_hclk_change does both. */
void hil_clock_turn(struct hil_clock *clock, uint32_t hclk_hz);

#endif
