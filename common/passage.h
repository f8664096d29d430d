/* Passage: what rolls over the switches - a landing, or the model pushed back - and which of the
 * named edges are its gates.
 *
 * A landing is under way once two edges have followed each other along the runway at 2 ft/s or
 * more. The model pushed back by hand passes backward or slower than 2 ft/s (report 2.7.1 pushes it
 * back over the same switches): that is counted as one push-back until MR_PASSAGE_QUIET_BLOCKS go
 * by without an edge, and never becomes a gate. In a landing an edge that no gear could have made -
 * faster than it came in, or behind - is refused, or the edge before it is taken back when without
 * it the new one fits: then that one was late.
 *
 * Times are differences of ticks of edges at most 30 s apart, so that TIM2 may wrap (51.13 s).
 * Pure, no heap. */
#ifndef MATRIG_COMMON_PASSAGE_H
#define MATRIG_COMMON_PASSAGE_H

#include <stdbool.h>
#include <stdint.h>

#include "common/gates.h"
#include "common/switches.h"

#define MR_PASSAGE_LEAST_FT_S   2.0 /* slower is pushed */
/* faster was no gear: 46 ft/s at most is reached (report 2.4) */
#define MR_PASSAGE_MOST_FT_S    80.0
#define MR_PASSAGE_HELD         4u
#define MR_PASSAGE_QUIET_BLOCKS 30000u
#define MR_PASSAGE_NOTES        40u /* of one edge: it, those held, and each switch of the table */
#define MR_S_PER_TICK           (1.0 / 84.0e6)

enum mr_passage_state {
    MR_PASSAGE_NONE,
    MR_PASSAGE_HELD_UP,
    MR_PASSAGE_PUSHED,
    MR_PASSAGE_ROLLING
};

struct mr_passage_edge {
    uint32_t tick;
    uint32_t block;
    double station_ft;
    uint8_t position;
    uint8_t number; /* of the edge, as in its message */
};

/* An event of a switch, to be reported. */
struct mr_passage_note {
    uint8_t number; /* of the edge; 0: none */
    uint8_t position;
    uint8_t reason; /* enum mr_switch_reason */
};

struct mr_passage {
    enum mr_passage_state state;
    struct mr_passage_edge held[MR_PASSAGE_HELD]; /* newest last; not yet known of what */
    unsigned held_count;
    uint32_t quiet_since_block;

    struct mr_gate gate[MR_GATES_MAX]; /* seconds since the first of them */
    struct mr_passage_edge source[MR_GATES_MAX];
    unsigned gates;
    double entry_ft_s; /* over the first two, then the first three */

    bool pushing;       /* the newest push-back is not over */
    uint16_t pushbacks; /* since the start */
    double pushed_ft_s; /* speed of the newest edge of one; negative: backward */
    uint8_t pushed_position;

    struct mr_passage_note note[MR_PASSAGE_NOTES]; /* of the last call */
    unsigned notes;
};

/* What the last edge did. */
struct mr_passage_news {
    bool started; /* a landing: there are two gates */
    bool gate;    /* one more gate, or another one */
    bool pushed;  /* one more push-back */
};

void mr_passage_start(struct mr_passage *passage);
/* Forget gates and held edges, for the next landing; the count of push-backs stays. */
void mr_passage_clear(struct mr_passage *passage);

/* The next named edge. `speed_ft_s`: what the gear should have by the last estimate, NaN when not
 * known. `switches`: how many the table has, `stations_ft` where they are. */
struct mr_passage_news mr_passage_edge(struct mr_passage *passage,
                                       const struct mr_passage_edge *edge, double speed_ft_s,
                                       const float *stations_ft, unsigned switches);

/* Each block: gives up the edges held when nothing has followed for long. True: this happened; the
 * notes report it. */
bool mr_passage_block(struct mr_passage *passage, uint32_t block);

/* Something may be coming that is not known yet, or is being pushed: no time for warnings or
 * zeros. */
bool mr_passage_unclear(const struct mr_passage *passage, uint32_t block);

#endif
