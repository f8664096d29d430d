#include "common/zonescan.h"

#include <string.h>

enum { COMING_START, COMING_END, LYING, COMPLETE };

static bool is_open(const struct mr_chain *chain, unsigned joint)
{
    return mr_chain_opening_ft(chain, joint) > MR_ZONE_CLOSED_FT * (float)chain->group;
}

/* Whether joint j is closed, or closed by a wheel at the place. */
static bool closes(const struct mr_zonescan *scan, const struct mr_chain *chain, unsigned j)
{
    float press_lb = scan->order.push_lb - (float)(j - scan->order.place) * chain->friction_lb;
    return press_lb > chain->grit_lb[j] || !is_open(chain, j);
}

static void begin_place(struct mr_zonescan *scan)
{
    bool any = scan->order.place <= scan->order.last_place;
    scan->phase = any ? COMING_START : LYING;
    scan->joint = any ? (uint16_t)(scan->order.place + 1u) : scan->order.from;
    scan->start_before = scan->start;
    scan->start = 0;
    if (!any)
        scan->last_open = 0;
}

void mr_zonescan_begin(struct mr_zonescan *scan, const struct mr_chain *chain, const struct mr_zonescan_order *order)
{
    memset(scan, 0, sizeof *scan);
    scan->order = *order;
    if (scan->order.last_place >= chain->count)
        scan->order.last_place = (uint16_t)(chain->count - 1u);
    scan->tally = (uint16_t)((MR_ZONE_TALLY_MATS + chain->group - 1u) / chain->group);
    begin_place(scan);
}

static void leave_place(struct mr_zonescan *scan)
{
    unsigned groups = scan->start ? (unsigned)scan->last_closed - scan->start : 0;
    if (groups > scan->found.coming) {
        scan->found.coming = (uint16_t)groups;
        scan->found.coming_place = scan->order.place;
    }
    scan->order.place = (uint16_t)(scan->order.place + MR_ZONE_STRIDE);
    begin_place(scan);
}

/* The first joint that closes ahead of a place. When the search for the last place's end began no further and has gone beyond it,
 * it goes on from there: of two places the further one closes all that the nearer does. Else it begins anew. */
static void find_start(struct mr_zonescan *scan, const struct mr_chain *chain)
{
    unsigned j = scan->joint;
    if (j > chain->count + 1u || j > scan->order.place + scan->tally + 1u) {
        scan->end = 0;
        leave_place(scan);
        return;
    }
    if (!closes(scan, chain, j)) {
        scan->joint++;
        return;
    }
    scan->start = (uint16_t)j;
    scan->phase = COMING_END;
    if (scan->end <= j || j < scan->start_before) {
        scan->last_closed = (uint16_t)j;
        scan->last_open = (uint16_t)(j > scan->order.place + 1u ? j - 1u : 0);
        scan->joint = (uint16_t)(j + 1u);
        return;
    }
    if (scan->last_open <= scan->order.place || closes(scan, chain, scan->last_open)) {
        scan->last_closed = scan->last_open > scan->last_closed ? scan->last_open : scan->last_closed;
        scan->last_open = 0;
        scan->visits++;
    }
    scan->joint = scan->end;
}

static void find_end(struct mr_zonescan *scan, const struct mr_chain *chain)
{
    unsigned j = scan->joint;
    bool beyond = j > chain->count + 1u;
    scan->end = (uint16_t)j;
    if (!beyond && closes(scan, chain, j)) {
        scan->last_closed = (uint16_t)j;
    } else if (beyond || (scan->last_open && j - scan->last_open < scan->tally)) {
        leave_place(scan);
        return;
    } else {
        scan->last_open = (uint16_t)j;
    }
    scan->joint++;
}

/* The chain as it is, one joint. */
static void lie(struct mr_zonescan *scan, const struct mr_chain *chain)
{
    unsigned j = scan->joint++;
    float opening_ft = mr_chain_opening_ft(chain, j), press_lb = mr_chain_compression_lb(chain, j);
    float open_ft = opening_ft > 0.0f ? opening_ft : 0.0f;
    bool closed = !is_open(chain, j);
    if (press_lb > scan->found.compression_lb)
        scan->found.compression_lb = press_lb;
    if (closed) {
        if (!scan->run.first)
            scan->run.first = (uint16_t)j;
        if (!scan->rest.first)
            scan->rest.first = (uint16_t)j;
        scan->run.closed++;
        scan->rest.closed++;
        scan->rest.open_ft += open_ft;
    } else {
        if (scan->last_open && j - scan->last_open < scan->tally)
            scan->run = scan->rest; /* only what follows the last open joint may go on */
        scan->rest = (struct mr_zonescan_run){0};
        scan->last_open = (uint16_t)j;
    }
    if (scan->run.first)
        scan->run.open_ft += open_ft;
    if (!closed || j - scan->run.first <= scan->found.groups)
        return;
    scan->found.groups = (uint16_t)(j - scan->run.first);
    scan->found.first = scan->run.first;
    scan->found.closed = scan->run.closed;
    scan->found.open_ft = scan->run.open_ft;
}

bool mr_zonescan_go(struct mr_zonescan *scan, const struct mr_chain *chain, unsigned visits)
{
    for (uint32_t until = scan->visits + visits; scan->phase != COMPLETE && scan->visits < until; scan->visits++) {
        if (scan->phase == COMING_START)
            find_start(scan, chain);
        else if (scan->phase == COMING_END)
            find_end(scan, chain);
        else if (scan->joint <= chain->count + 1u)
            lie(scan, chain);
        else
            scan->phase = COMPLETE;
    }
    return scan->phase == COMPLETE;
}
