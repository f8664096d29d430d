#include "common/passage.h"

#include <string.h>

/* time without a decision after which edges are discarded; longer than the 2.5 s between switches 5
 * ft apart at 2 ft/s */
#define UNCLEAR_MAX_BLOCKS  3000u
/* speed above which a backward motion is impossible, so a switch must have opened late */
#define REVERSE_MAX_FT_S    20.0
/* A plausible speed of a landing gear is at most SPEED_RATIO_MAX times its entry speed plus
 * SPEED_RISE_MAX_FT_S. */
#define SPEED_RATIO_MAX     1.25
#define SPEED_RISE_MAX_FT_S 3.0

void mr_passage_start(struct mr_passage *passage)
{
    memset(passage, 0, sizeof *passage);
}

void mr_passage_clear(struct mr_passage *passage)
{
    passage->state = MR_PASSAGE_NONE;
    passage->pending_count = 0;
    passage->gate_count = 0;
    passage->event_count = 0;
    passage->is_pushback_in_progress = false;
}

static void add_event(struct mr_passage *passage, const struct mr_passage_edge *edge,
                      enum mr_switch_reason reason)
{
    if (passage->event_count < MR_PASSAGE_EVENTS_MAX)
        passage->event[passage->event_count++] = (struct mr_passage_event){
            .number = edge->number, .position = edge->position, .reason = (uint8_t)reason};
}

/* Mean speed from one edge to a later one. The tick counter may wrap between them. */
static double compute_speed(const struct mr_passage_edge *from, const struct mr_passage_edge *to)
{
    double since_s = (double)(uint32_t)(to->tick - from->tick) * MR_S_PER_TICK;
    return (to->station_ft - from->station_ft) / (since_s > 1e-6 ? since_s : 1e-6);
}

static bool is_rolling_speed(double speed_ft_s)
{
    return speed_ft_s >= MR_PASSAGE_MIN_FT_S && speed_ft_s <= MR_PASSAGE_MAX_FT_S;
}

static void add_missing_events(struct mr_passage *passage, double from_ft, double to_ft,
                               const float *stations_ft, unsigned switches)
{
    for (unsigned i = 0; i < switches; i++) {
        double station_ft = (double)stations_ft[i];
        struct mr_passage_edge missing = {.position = (uint8_t)(i + 1)};
        if (station_ft > from_ft && station_ft < to_ft)
            add_event(passage, &missing, MR_SWITCH_MISSING);
    }
}

static void add_gate(struct mr_passage *passage, const struct mr_passage_edge *edge)
{
    uint32_t first_tick = passage->gate_count ? passage->gate_edge[0].tick : edge->tick;
    passage->gate_edge[passage->gate_count] = *edge;
    passage->gate[passage->gate_count++] =
        (struct mr_gate){.t_s = (double)(uint32_t)(edge->tick - first_tick) * MR_S_PER_TICK,
                         .station_ft = edge->station_ft};
}

static void reject_pending_edges(struct mr_passage *passage, enum mr_switch_reason reason)
{
    for (unsigned i = 0; i < passage->pending_count; i++)
        add_event(passage, &passage->pending_edge[i], reason);
    passage->pending_count = 0;
}

static void add_pending_edge(struct mr_passage *passage, const struct mr_passage_edge *edge)
{
    if (passage->pending_count == MR_PASSAGE_HELD_MAX) {
        add_event(passage, &passage->pending_edge[0], MR_SWITCH_OUT_OF_ORDER);
        passage->pending_count--;
        memmove(passage->pending_edge, passage->pending_edge + 1,
                passage->pending_count * sizeof passage->pending_edge[0]);
    }
    passage->pending_edge[passage->pending_count++] = *edge;
}

static void start_rolling(struct mr_passage *passage, unsigned first,
                          const struct mr_passage_edge *edge, const float *stations_ft,
                          unsigned switches)
{
    struct mr_passage_edge from = passage->pending_edge[first];
    for (unsigned i = 0; i < passage->pending_count; i++) {
        if (i != first)
            add_event(passage, &passage->pending_edge[i], MR_SWITCH_OUT_OF_ORDER);
    }
    passage->pending_count = 0;
    passage->state = MR_PASSAGE_ROLLING;
    passage->entry_speed_ft_s = compute_speed(&from, edge);
    add_gate(passage, &from);
    add_gate(passage, edge);
    add_missing_events(passage, -1e9, from.station_ft, stations_ft, switches);
    add_missing_events(passage, from.station_ft, edge->station_ft, stations_ft, switches);
}

static bool add_pushback_edge(struct mr_passage *passage, const struct mr_passage_edge *edge,
                              double speed_ft_s)
{
    bool first = !passage->is_pushback_in_progress;
    passage->is_pushback_in_progress = true;
    enum mr_switch_reason reason = speed_ft_s < 0.0 ? MR_SWITCH_REVERSE : MR_SWITCH_SLOW;
    passage->pushback_speed_ft_s = speed_ft_s;
    passage->pushback_position = edge->position;
    if (first && passage->pushback_count < UINT16_MAX)
        passage->pushback_count++;
    reject_pending_edges(passage, reason);
    if (passage->state != MR_PASSAGE_ROLLING)
        passage->state = MR_PASSAGE_PUSHED;
    return first;
}

/* Handles an edge while it is not known whether a gear or a pushed model is passing. */
static struct mr_passage_changes handle_first_edges(struct mr_passage *passage,
                                                    const struct mr_passage_edge *edge,
                                                    const float *stations_ft, unsigned switches)
{
    struct mr_passage_changes changes = {0};
    for (unsigned i = passage->pending_count; i-- > 0;) {
        if (is_rolling_speed(compute_speed(&passage->pending_edge[i], edge))) {
            start_rolling(passage, i, edge, stations_ft, switches);
            changes.has_started_landing = changes.has_new_gate = true;
            return changes;
        }
    }
    if (passage->pending_count) {
        double speed_ft_s = compute_speed(&passage->pending_edge[passage->pending_count - 1], edge);
        if (speed_ft_s > -REVERSE_MAX_FT_S && speed_ft_s < MR_PASSAGE_MIN_FT_S)
            changes.has_new_pushback = add_pushback_edge(passage, edge, speed_ft_s);
    } else if (passage->state == MR_PASSAGE_NONE) {
        passage->state = MR_PASSAGE_UNDECIDED;
    }
    add_pending_edge(passage, edge);
    return changes;
}

/* Uses the entry speed only from the third gate on, because the first two switches may have opened
 * late. */
static bool is_plausible_speed(const struct mr_passage *passage, double speed_ft_s)
{
    return passage->gate_count < 3
             ? is_rolling_speed(speed_ft_s)
             : speed_ft_s >= MR_PASSAGE_MIN_FT_S &&
                   speed_ft_s <= SPEED_RATIO_MAX * passage->entry_speed_ft_s + SPEED_RISE_MAX_FT_S;
}

static struct mr_passage_changes handle_rolling_edge(struct mr_passage *passage,
                                                     const struct mr_passage_edge *edge,
                                                     double speed_ft_s, const float *stations_ft,
                                                     unsigned switches)
{
    struct mr_passage_changes changes = {0};
    const struct mr_passage_edge *last = &passage->gate_edge[passage->gate_count - 1];
    double since_ft_s = compute_speed(last, edge);
    bool at_rest = speed_ft_s < MR_PASSAGE_MIN_FT_S;
    if ((since_ft_s >= 0.0 && since_ft_s < MR_PASSAGE_MIN_FT_S) || (since_ft_s < 0.0 && at_rest)) {
        changes.has_new_pushback = add_pushback_edge(passage, edge, since_ft_s);
        add_event(passage, edge, since_ft_s < 0.0 ? MR_SWITCH_REVERSE : MR_SWITCH_SLOW);
    } else if (is_plausible_speed(passage, since_ft_s)) {
        if (passage->gate_count == MR_GATES_MAX)
            return changes;
        add_missing_events(passage, last->station_ft, edge->station_ft, stations_ft, switches);
        add_gate(passage, edge);
        if (passage->gate_count == 3)
            passage->entry_speed_ft_s = compute_speed(&passage->gate_edge[0], edge);
        changes.has_new_gate = true;
    } else if (passage->gate_count > 2 && since_ft_s > 0.0 &&
               is_plausible_speed(
                   passage, compute_speed(&passage->gate_edge[passage->gate_count - 2], edge))) {
        add_event(passage, last, MR_SWITCH_LATE);
        passage->gate_count--;
        add_gate(passage, edge);
        changes.has_new_gate = true;
    } else {
        add_event(passage, edge, MR_SWITCH_OUT_OF_ORDER);
    }
    return changes;
}

struct mr_passage_changes mr_passage_on_edge(struct mr_passage *passage,
                                             const struct mr_passage_edge *edge, double speed_ft_s,
                                             const float *stations_ft, unsigned switches)
{
    passage->event_count = 0;
    passage->quiet_since_block = edge->block;
    return passage->state == MR_PASSAGE_ROLLING
             ? handle_rolling_edge(passage, edge, speed_ft_s, stations_ft, switches)
             : handle_first_edges(passage, edge, stations_ft, switches);
}

bool mr_passage_on_block(struct mr_passage *passage, uint32_t block)
{
    passage->event_count = 0;
    if (block - passage->quiet_since_block < MR_PASSAGE_QUIET_BLOCKS)
        return false;
    passage->is_pushback_in_progress = false;
    if (passage->state == MR_PASSAGE_NONE || passage->state == MR_PASSAGE_ROLLING)
        return false;
    reject_pending_edges(passage, passage->state != MR_PASSAGE_PUSHED  ? MR_SWITCH_SINGLE
                                  : passage->pushback_speed_ft_s < 0.0 ? MR_SWITCH_REVERSE
                                                                       : MR_SWITCH_SLOW);
    passage->state = MR_PASSAGE_NONE;
    return true;
}

bool mr_passage_is_ambiguous(const struct mr_passage *passage, uint32_t block)
{
    return passage->state == MR_PASSAGE_PUSHED ||
           (passage->state == MR_PASSAGE_UNDECIDED &&
            block - passage->quiet_since_block < UNCLEAR_MAX_BLOCKS);
}
