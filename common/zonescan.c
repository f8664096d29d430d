#include "common/zonescan.h"

#include <string.h>

enum { PHASE_FUTURE_START, PHASE_FUTURE_END, PHASE_PRESENT_ZONE, PHASE_SUMS, PHASE_COMPLETE };

static float get_closed_limit_ft(const struct mr_chain *chain)
{
    return MR_ZONE_CLOSED_MAX_FT * (float)chain->mats_per_group;
}

/* True if joint j is closed, or would close when the wheel reaches the position. */
static inline bool is_closing(const struct mr_zonescan *scan, const struct mr_chain *chain,
                              unsigned j)
{
    float press_lb = scan->range.push_lb - (float)(j - scan->range.position) * chain->friction_lb;
    return press_lb > scan->range.grit_lb[j] ||
           !(mr_chain_opening_ft(chain, j) > get_closed_limit_ft(chain));
}

static void begin_position(struct mr_zonescan *scan)
{
    bool any = scan->range.position <= scan->range.last_position;
    scan->phase = any ? PHASE_FUTURE_START : PHASE_PRESENT_ZONE;
    scan->joint = any ? (uint16_t)(scan->range.position + 1u) : scan->range.search_start_joint;
    scan->previous_start_joint = scan->start_joint;
    scan->start_joint = 0;
    if (!any)
        scan->last_open_joint = 0;
}

void mr_zonescan_begin(struct mr_zonescan *scan, const struct mr_chain *chain,
                       const struct mr_zonescan_range *range)
{
    memset(scan, 0, sizeof *scan);
    scan->range = *range;
    if (scan->range.last_position >= chain->group_count)
        scan->range.last_position = (uint16_t)(chain->group_count - 1u);
    scan->window_joints =
        (uint16_t)((MR_ZONE_WINDOW_MATS + chain->mats_per_group - 1u) / chain->mats_per_group);
    begin_position(scan);
}

static void end_position(struct mr_zonescan *scan)
{
    unsigned groups = scan->start_joint ? (unsigned)scan->last_closed_joint - scan->start_joint : 0;
    if (groups > scan->result.future_groups) {
        scan->result.future_groups = (uint16_t)groups;
        scan->result.future_position = scan->range.position;
    }
    scan->range.position = (uint16_t)(scan->range.position + MR_ZONE_STRIDE_GROUPS);
    begin_position(scan);
}

/* Finds the first joint that closes ahead of a position. A wheel at a later position closes at
 * least the joints up to the end of the zone of an earlier position. The search for the end
 * therefore continues at the joint where the previous search stopped, unless the first joint is
 * beyond it. */
static void find_start(struct mr_zonescan *scan, const struct mr_chain *chain)
{
    unsigned j = scan->joint;
    scan->examined_joints++;
    if (j > chain->group_count + 1u || j > scan->range.position + scan->window_joints + 1u) {
        scan->end_joint = 0;
        end_position(scan);
        return;
    }
    if (!is_closing(scan, chain, j)) {
        scan->joint++;
        return;
    }
    scan->start_joint = (uint16_t)j;
    scan->phase = PHASE_FUTURE_END;
    if (scan->end_joint <= j || j < scan->previous_start_joint) {
        scan->last_closed_joint = (uint16_t)j;
        scan->last_open_joint = (uint16_t)(j > scan->range.position + 1u ? j - 1u : 0);
        scan->joint = (uint16_t)(j + 1u);
        return;
    }
    if (scan->last_open_joint <= scan->range.position ||
        is_closing(scan, chain, scan->last_open_joint)) {
        scan->last_closed_joint = scan->last_open_joint > scan->last_closed_joint
                                    ? scan->last_open_joint
                                    : scan->last_closed_joint;
        scan->last_open_joint = 0;
        scan->examined_joints++;
    }
    scan->joint = scan->end_joint;
}

/* Finds the end of the zone that the wheel closes from a position, within the visits allowed. */
static void find_end(struct mr_zonescan *scan, const struct mr_chain *chain, uint32_t until)
{
    unsigned j = scan->joint, last_open = scan->last_open_joint,
             last_closed = scan->last_closed_joint, beyond = chain->group_count + 2u;
    uint32_t visits = scan->examined_joints;
    bool ended = false;
    for (; visits < until && !ended; visits++) {
        if (j >= beyond) {
            ended = true;
        } else if (is_closing(scan, chain, j)) {
            last_closed = j++;
        } else if (last_open && j - last_open < scan->window_joints) {
            ended = true;
        } else {
            last_open = j++;
        }
    }
    scan->examined_joints = visits;
    scan->joint = scan->end_joint = (uint16_t)j;
    scan->last_open_joint = (uint16_t)last_open;
    scan->last_closed_joint = (uint16_t)last_closed;
    if (ended)
        end_position(scan);
}

/* Finds the longest zone and the largest compression of the present chain, within the visits
 * allowed. */
static void scan_present(struct mr_zonescan *scan, const struct mr_chain *chain, uint32_t until)
{
    unsigned j = scan->joint, beyond = chain->group_count + 2u, first = scan->start_joint,
             last_open = scan->last_open_joint, best = scan->result.groups;
    unsigned stop = beyond < j + (until - scan->examined_joints)
                      ? beyond
                      : j + (until - scan->examined_joints);
    float most_lb = scan->result.compression_lb, limit_ft = get_closed_limit_ft(chain);
    scan->examined_joints += stop > j ? stop - j : 1u;
    for (; j < stop; j++) {
        float press_lb = mr_chain_compression_lb(chain, j);
        most_lb = press_lb > most_lb ? press_lb : most_lb;
        if (mr_chain_opening_ft(chain, j) > limit_ft) {
            /* two open joints are too close, so the zone must begin after the first of them */
            if (last_open && j - last_open < scan->window_joints)
                first = j - last_open > 1u ? last_open + 1u : 0;
            last_open = j;
            continue;
        }
        first = first ? first : j;
        if (j - first > best) {
            best = j - first;
            scan->result.first_joint = (uint16_t)first;
        }
    }
    scan->joint = (uint16_t)j;
    scan->start_joint = (uint16_t)first;
    scan->last_open_joint = (uint16_t)last_open;
    scan->result.groups = (uint16_t)best;
    scan->result.compression_lb = most_lb;
    if (j < beyond)
        return;
    scan->phase = best ? PHASE_SUMS : PHASE_COMPLETE;
    scan->joint = scan->result.first_joint;
}

/* Sums the openings and counts the closed joints of the zone that was found. */
static void sum_openings(struct mr_zonescan *scan, const struct mr_chain *chain, uint32_t until)
{
    struct mr_zonescan_result *found = &scan->result;
    unsigned j = scan->joint, beyond = found->first_joint + found->groups + 1u;
    for (; j < beyond && scan->examined_joints < until; j++, scan->examined_joints++) {
        float opening_ft = mr_chain_opening_ft(chain, j);
        found->opening_sum_ft += opening_ft > 0.0f ? opening_ft : 0.0f;
        found->closed_joints =
            (uint16_t)(found->closed_joints + !(opening_ft > get_closed_limit_ft(chain)));
    }
    scan->joint = (uint16_t)j;
    if (j == beyond)
        scan->phase = PHASE_COMPLETE;
}

bool mr_zonescan_continue(struct mr_zonescan *scan, const struct mr_chain *chain, unsigned visits)
{
    uint32_t until = scan->examined_joints + visits;
    while (scan->phase != PHASE_COMPLETE && scan->examined_joints < until) {
        if (scan->phase == PHASE_FUTURE_START)
            find_start(scan, chain);
        else if (scan->phase == PHASE_FUTURE_END)
            find_end(scan, chain, until);
        else if (scan->phase == PHASE_PRESENT_ZONE)
            scan_present(scan, chain, until);
        else
            sum_openings(scan, chain, until);
    }
    return scan->phase == PHASE_COMPLETE;
}
