#include "common/switches.h"

#include <string.h>

#include "common/wire.h"

void mr_switches_start(struct mr_switches *switches)
{
    memset(switches, 0, sizeof *switches);
    mr_staircase_init(&switches->staircase);
}

void mr_switches_reset(struct mr_switches *switches)
{
    switches->waiting_count = 0;
    switches->opened_mask = 0;
    switches->identified_position = 0;
    switches->has_decided_edge = false;
    switches->is_level_after_known = false;
}

void mr_switches_add_level(struct mr_switches *switches, uint32_t tick, float code)
{
    mr_staircase_add(&switches->staircase, tick, code);
}

bool mr_switches_add_edge(struct mr_switches *switches, uint32_t tick)
{
    if (switches->waiting_count == MR_SWITCHES_WAITING_MAX)
        return false;
    struct mr_switch_edge *edge = &switches->waiting_edge[switches->waiting_count++];
    *edge = (struct mr_switch_edge){.tick = tick, .step_codes = MR_NAN};
    edge->is_level_known = mr_staircase_level_before(&switches->staircase, tick,
                                                     &edge->level_codes);
    return true;
}

static bool is_below_smallest_step(float step_codes)
{
    return step_codes < MR_STAIRCASE_TOLERANCE_CODES && step_codes > -MR_STAIRCASE_TOLERANCE_CODES;
}

static bool follows_last_edge(const struct mr_switches *switches, uint32_t tick,
                              uint32_t within_ticks)
{
    return switches->has_decided_edge && tick - switches->decided_tick < within_ticks;
}

static void identify_switch(struct mr_switches *switches, const uint16_t *steps_codes,
                            unsigned count, float step_codes, struct mr_switch_edge *edge)
{
    edge->step_codes = step_codes;
    if (is_below_smallest_step(step_codes)) {
        edge->reason = follows_last_edge(switches, edge->tick, MR_SWITCH_BOUNCE_TICKS)
                         ? MR_SWITCH_BOUNCE
                         : MR_SWITCH_NO_STEP;
        return;
    }
    edge->position = (uint8_t)mr_staircase_identify(step_codes, steps_codes, count, 0);
    if (!edge->position) {
        edge->reason = MR_SWITCH_UNKNOWN_STEP;
    } else if (switches->opened_mask & 1u << (edge->position - 1)) {
        bool bounced = edge->position == switches->identified_position &&
                       edge->tick - switches->identified_tick < MR_SWITCH_REOPEN_TICKS;
        edge->reason = bounced ? MR_SWITCH_BOUNCE : MR_SWITCH_DOUBLE;
    }
}

/* Returns the number of edges, from the oldest one on, each of which is followed by the next within
 * the bounce time. */
static unsigned count_cluster_edges(const struct mr_switches *switches)
{
    unsigned n = 1;
    while (n < switches->waiting_count &&
           switches->waiting_edge[n].tick - switches->waiting_edge[n - 1].tick <
               MR_SWITCH_BOUNCE_TICKS)
        n++;
    return n;
}

/* Identifies the switch of several close edges, or of an edge with an unsteady level, from the
 * total step up to the level after the last edge. Steps inside the group are not reliable: a
 * contact that bounces every 2 ms is open for half of each block, and its level looks steady. If
 * the total step matches no switch, tries the oldest edge alone. Returns false if it cannot be
 * decided yet. */
static bool decide_cluster(struct mr_switches *switches, const uint16_t *steps_codes,
                           unsigned count, float own_step)
{
    unsigned n = count_cluster_edges(switches);
    struct mr_switch_edge *first = &switches->waiting_edge[0],
                          *last = &switches->waiting_edge[n - 1];
    const struct mr_staircase *staircase = &switches->staircase;
    uint32_t now = staircase->tick[(staircase->block_count - 1) % MR_STAIRCASE_HISTORY_BLOCKS];
    float after;
    if (n < MR_SWITCHES_WAITING_MAX &&
        (int32_t)(now - last->tick) < (int32_t)MR_SWITCH_BOUNCE_TICKS)
        return false;
    enum mr_status status = mr_staircase_level_after(staircase, last->tick, &after);
    if (!first->is_level_known && switches->is_level_after_known &&
        follows_last_edge(switches, first->tick, MR_SWITCH_BOUNCE_TICKS)) {
        first->is_level_known = true;
        first->level_codes = switches->level_after_codes;
    }
    if (status == MR_OK && first->is_level_known)
        identify_switch(switches, steps_codes, count, after - first->level_codes, first);
    bool one = first->position && first->reason == MR_SWITCH_GOOD;
    if (!one && own_step == own_step && n > 1) {
        struct mr_switch_edge alone = *first;
        alone.position = 0;
        alone.reason = MR_SWITCH_GOOD;
        identify_switch(switches, steps_codes, count, own_step, &alone);
        if (alone.position && alone.reason == MR_SWITCH_GOOD) {
            *first = alone;
            return true;
        }
    }
    bool none = first->reason == MR_SWITCH_BOUNCE || first->reason == MR_SWITCH_NO_STEP;
    if (!one && !none) {
        first->position = 0;
        first->reason = MR_SWITCH_TOO_SOON;
    }
    for (unsigned i = 1; i < n; i++) {
        switches->waiting_edge[i].is_decided = true;
        switches->waiting_edge[i].reason = one || none ? MR_SWITCH_BOUNCE : MR_SWITCH_TOO_SOON;
        switches->waiting_edge[i].position = one ? first->position : 0;
    }
    return true;
}

static void remove_edge(struct mr_switches *switches, struct mr_switch_edge *edge)
{
    *edge = switches->waiting_edge[0];
    switches->waiting_count--;
    memmove(switches->waiting_edge, switches->waiting_edge + 1,
            switches->waiting_count * sizeof switches->waiting_edge[0]);
    /* A bounce does not change the level after the previous edge. */
    if (edge->reason != MR_SWITCH_BOUNCE) {
        switches->is_level_after_known = edge->is_level_known &&
                                         edge->step_codes == edge->step_codes;
        switches->level_after_codes = edge->level_codes + edge->step_codes;
    }
    switches->has_decided_edge = true;
    switches->decided_tick = edge->tick;
    if (edge->position && edge->reason != MR_SWITCH_BOUNCE) {
        switches->opened_mask |= 1u << (edge->position - 1);
        switches->identified_position = edge->position;
        switches->identified_tick = edge->tick;
    }
}

bool mr_switches_next_edge(struct mr_switches *switches, const uint16_t *steps_codes,
                           unsigned count, struct mr_switch_edge *edge)
{
    if (!switches->waiting_count)
        return false;
    struct mr_switch_edge *oldest = &switches->waiting_edge[0];
    if (!oldest->is_decided) {
        float step_codes = MR_NAN;
        enum mr_status status = mr_staircase_find_step(&switches->staircase, oldest->tick,
                                                       &step_codes);
        if (status == MR_TOO_FEW)
            return false;
        if (status == MR_OK && count_cluster_edges(switches) == 1)
            identify_switch(switches, steps_codes, count, step_codes, oldest);
        else if (!decide_cluster(switches, steps_codes, count,
                                 status == MR_OK ? step_codes : MR_NAN))
            return false;
    }
    remove_edge(switches, edge);
    return true;
}
