/* Switches: assigns the edges of the common switch circuit to switches, also when contacts bounce
 * (report 2.7.1).
 *
 * An edge is a capture of TIM2; the levels of the staircase before and after the edge identify the
 * switch. The edges of a bouncing contact produce a single step between the level before the first
 * edge and the level after the last. The first edge is assigned to the switch; the others are
 * marked as bounces. Edges are decided in order of time, 5 ms after each edge, or 10 ms after the
 * last edge of a bouncing contact. Ticks are compared by their difference, so TIM2 may wrap (51.13
 * s) at any time.
 *
 * Pure, no heap. */
#ifndef MATRIG_COMMON_SWITCHES_H
#define MATRIG_COMMON_SWITCHES_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/staircase.h"

#define MR_SWITCHES_WAITING_MAX 32u /* largest number of edges that are not decided yet */
/* 10 ms: edges closer than this may come from one contact; the switches are 5 ft apart, 109 ms at
 * 46 ft/s */
#define MR_SWITCH_BOUNCE_TICKS  840000u
/* 50 ms: another edge of the same switch within this time is a bounce */
#define MR_SWITCH_REOPEN_TICKS  4200000u

struct mr_switch_edge {
    uint32_t tick;
    float step_codes; /* step of the level at the edge; NaN: unknown */
    uint8_t position; /* number of the switch from 1; 0: not identified */
    uint8_t reason;   /* enum mr_switch_reason: GOOD, or BOUNCE to DOUBLE */
    bool is_decided;  /* the edge was decided together with an earlier one */
    bool is_level_known;
    float level_codes; /* level before the edge */
};

struct mr_switches {
    struct mr_staircase staircase;
    /* edges that are not decided yet, oldest first */
    struct mr_switch_edge waiting_edge[MR_SWITCHES_WAITING_MAX];
    unsigned waiting_count;      /* number of waiting edges */
    uint32_t opened_mask;        /* bit p-1: switch p has opened */
    uint32_t decided_tick;       /* tick of the newest decided edge */
    uint32_t identified_tick;    /* tick of the newest identified edge */
    uint8_t identified_position; /* switch of that edge; 0: none yet */
    bool has_decided_edge;
    bool is_level_after_known;
    float level_after_codes; /* level after the newest decided edge */
};

void mr_switches_start(struct mr_switches *switches);
/* Marks all switches as closed and discards the waiting edges. */
void mr_switches_reset(struct mr_switches *switches);

/* Adds the level of the next block. Add the edges up to that block afterwards; mr_switches_add_edge
 * returns false if there is no room, and ignores the edge. */
void mr_switches_add_level(struct mr_switches *switches, uint32_t tick, float code);
bool mr_switches_add_edge(struct mr_switches *switches, uint32_t tick);

/* Removes the oldest edge that can be decided, and returns it in `edge`. `steps_codes`: the step of
 * each of `count` (at most 32) switches. Returns false if no edge can be decided yet; call again
 * after the next block. */
bool mr_switches_next_edge(struct mr_switches *switches, const uint16_t *steps_codes,
                           unsigned count, struct mr_switch_edge *edge);

#endif
