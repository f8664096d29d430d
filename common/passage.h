/* Passage: distinguishes a landing from a push-back of the model over the switches, and selects the
 * named edges that are gates of the landing.
 *
 * A landing is recognised when two edges follow each other along the runway at 2 ft/s or more. A
 * model that is pushed back by hand moves backward or slower than 2 ft/s (report 2.7.1 pushes it
 * back over the same switches). Its edges are counted as one push-back until
 * MR_PASSAGE_QUIET_BLOCKS pass without an edge, and never become gates. During a landing an edge is
 * refused if it is impossible: the gear would be faster than at its entry, or move backward. If it
 * would be possible without the edge before it, that earlier edge was late and is withdrawn
 * instead.
 *
 * Times are tick differences between edges at most 30 s apart, so TIM2 may wrap (51.13 s). Pure, no
 * heap. */
#ifndef MATRIG_COMMON_PASSAGE_H
#define MATRIG_COMMON_PASSAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/gates.h"
#include "common/switches.h"

#define MR_PASSAGE_MIN_FT_S     2.0 /* slower motion is a push-back */
/* limit for a gear, whose maximum is 46 ft/s (report 2.4) */
#define MR_PASSAGE_MAX_FT_S     80.0
#define MR_PASSAGE_HELD_MAX     4u
#define MR_PASSAGE_QUIET_BLOCKS 30000u
/* maximum number of events of one edge: its own, one of each held edge, and one of each switch in
 * the table */
#define MR_PASSAGE_EVENTS_MAX   40u
#define MR_S_PER_TICK           (1.0 / 84.0e6)

enum mr_passage_state {
    MR_PASSAGE_NONE,
    MR_PASSAGE_UNDECIDED,
    MR_PASSAGE_PUSHED,
    MR_PASSAGE_ROLLING
};

struct mr_passage_edge {
    uint32_t tick;
    uint32_t block;
    double station_ft;
    uint8_t position;
    uint8_t number; /* number of the edge, as in its message */
};

/* An event of a switch, to be reported. */
struct mr_passage_event {
    uint8_t number; /* number of the edge; 0: none */
    uint8_t position;
    uint8_t reason; /* enum mr_switch_reason */
};

struct mr_passage {
    enum mr_passage_state state;
    /* edges that are not yet assigned to a landing or a push-back; newest last */
    struct mr_passage_edge pending_edge[MR_PASSAGE_HELD_MAX];
    unsigned pending_count;
    uint32_t quiet_since_block;

    /* gates of the landing, with times in seconds since the first gate */
    struct mr_gate gate[MR_GATES_MAX];
    struct mr_passage_edge gate_edge[MR_GATES_MAX];
    unsigned gate_count;
    double
        entry_speed_ft_s; /* speed computed from the first two gates, later from the first three */

    bool is_pushback_in_progress; /* a push-back is in progress */
    uint16_t pushback_count;      /* number of push-backs since the start */
    double pushback_speed_ft_s;   /* speed at the newest edge of a push-back; negative: backward */
    uint8_t pushback_position;

    /* switch events reported by the last call */
    struct mr_passage_event event[MR_PASSAGE_EVENTS_MAX];
    unsigned event_count;
};

/* Result of the last edge. */
struct mr_passage_changes {
    bool has_started_landing; /* a landing has started: there are two gates */
    bool has_new_gate;        /* the landing has one more gate, or its last gate has changed */
    bool has_new_pushback;    /* a new push-back has begun */
};

void mr_passage_start(struct mr_passage *passage);
/* Resets gates and held edges for the next landing; the count of push-backs is kept. */
void mr_passage_clear(struct mr_passage *passage);

/* Processes the next named edge. `speed_ft_s`: speed that the last estimate predicts for the gear;
 * NaN: unknown. `switches`: number of switches in the table; `stations_ft`: their stations. */
struct mr_passage_changes mr_passage_on_edge(struct mr_passage *passage,
                                             const struct mr_passage_edge *edge, double speed_ft_s,
                                             const float *stations_ft, unsigned switches);

/* Call in each block: discards the held edges if no edge has followed for too long. Returns true if
 * edges were discarded; `event` then reports them. */
bool mr_passage_on_block(struct mr_passage *passage, uint32_t block);

/* True while held edges may be the beginning of a landing or of a push-back, or while a push-back
 * is in progress. The caller must not start warnings or measure zeros then. */
bool mr_passage_is_ambiguous(const struct mr_passage *passage, uint32_t block);

#endif
