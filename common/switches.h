/* Switches: the edges of the one switch circuit become named switches, whatever the contacts do
 * (report 2.7.1).
 *
 * An edge is a capture of TIM2; the level of the staircase before and after it names the switch.
 * Several edges of one bouncing contact leave one step between the level before the first and after
 * the last: the first edge has the name, the others are bounces. Edges are answered in the order in
 * which they came, 5 ms after them, or 10 ms after the last of a bouncing contact's. Ticks are
 * compared by their difference, so that TIM2 may wrap (51.13 s) at any time.
 *
 * Pure, no heap. */
#ifndef MATRIG_COMMON_SWITCHES_H
#define MATRIG_COMMON_SWITCHES_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/staircase.h"

#define MR_SWITCHES_WAITING    32u /* edges not yet answered */
/* 10 ms: edges nearer than that can be one contact's; 5 ft take 109 ms at 46 ft/s */
#define MR_SWITCH_BOUNCE_TICKS 840000u
/* 50 ms: the same switch once more within it is still its bounce */
#define MR_SWITCH_REOPEN_TICKS 4200000u

struct mr_switch_edge {
    uint32_t tick;
    float step_codes; /* NaN: not known */
    uint8_t position; /* from 1; 0: not named */
    uint8_t reason;   /* enum mr_switch_reason: GOOD, or BOUNCE to DOUBLE */
    bool decided;     /* with an edge before it */
    bool level_known;
    float level_codes; /* before it */
};

struct mr_switches {
    struct mr_staircase staircase;
    struct mr_switch_edge waiting[MR_SWITCHES_WAITING]; /* oldest first */
    unsigned count;                                     /* of them */
    uint32_t opened;                                    /* bit p-1: switch p has opened */
    uint32_t answered_tick;                             /* of the newest edge answered */
    uint32_t named_tick;                                /* of the newest edge that had a name */
    uint8_t named;                                      /* its switch; 0: none yet */
    bool answered;
    bool left_known;
    float left_codes; /* level that it left */
};

void mr_switches_start(struct mr_switches *switches);
/* All switches are closed again, and edges that wait are forgotten. */
void mr_switches_close(struct mr_switches *switches);

/* The level of the next block, then the edges up to it. False: no room, the edge is not taken. */
void mr_switches_level(struct mr_switches *switches, uint32_t tick, float code);
bool mr_switches_add(struct mr_switches *switches, uint32_t tick);

/* The oldest edge that can be answered by now. `steps_codes`: what each of `count` (at most 32)
 * switches adds. False: none, ask again after the next block. */
bool mr_switches_next(struct mr_switches *switches, const uint16_t *steps_codes, unsigned count,
                      struct mr_switch_edge *edge);

#endif
