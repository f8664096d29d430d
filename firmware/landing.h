/* One landing: its states, the edges, and the motion of the gear that follows from them.
 *
 *     idle -> armed (command) -> landing (first edge) -> settling (gear at rest) -> done (mat at rest) -> idle (command)
 *
 * The gear counts as at rest half a second after the time at which the last estimate says it stops, or three seconds after
 * the last edge; an edge while settling returns to landing. Settling lasts two seconds: the mat practically ceases to move
 * as the gear passes (report 2.7.2). No landing lasts longer than LANDING_LIMIT_BLOCKS and settling: edges beyond it, or
 * beyond LANDING_EDGES, are ignored.
 *
 * Pure but for the configuration: blocks and edges in, state out. */
#ifndef MATRIG_FIRMWARE_LANDING_H
#define MATRIG_FIRMWARE_LANDING_H

#include <stdbool.h>
#include <stdint.h>

#include "common/gates.h"
#include "common/staircase.h"
#include "firmware/config.h"

#define LANDING_EDGES 32u
#define LANDING_LIMIT_BLOCKS 20000u
#define LANDING_SETTLE_BLOCKS 2000u
#define LANDING_REST_BLOCKS 500u      /* after the predicted stop */
#define LANDING_NO_EDGE_BLOCKS 3000u  /* without one the gear is at rest, whatever was predicted */

_Static_assert(LANDING_EDGES == MR_GATES_MAX, "every edge can become a gate");

enum landing_state { LANDING_IDLE, LANDING_ARMED, LANDING_LANDING, LANDING_SETTLING, LANDING_DONE };
enum landing_cause {
    LANDING_BY_NOTHING, LANDING_BY_COMMAND, LANDING_BY_EDGE, LANDING_BY_STOP, LANDING_BY_SETTLED, LANDING_BY_LIMIT,
};

struct landing_edge {
    uint32_t tick;
    float step_codes; /* NaN until known */
    uint8_t position; /* 0: not named */
    bool resolved;    /* the staircase has been asked to the end */
};

struct landing {
    enum landing_state state;
    enum landing_cause cause;
    uint16_t number;
    uint32_t changed_block; /* of the last change of state */
    uint32_t first_block;   /* of the first edge */
    uint32_t last_edge_block;

    struct mr_staircase staircase;
    struct landing_edge edge[LANDING_EDGES];
    unsigned edges;    /* captured */
    unsigned resolved; /* of them, from the oldest on */
    uint32_t opened;   /* bit p-1: switch p has opened */

    struct mr_gate gate[LANDING_EDGES]; /* named edges in order, seconds since the first edge */
    unsigned gates;
    unsigned gates_on_track; /* of them, before the touchdown station */
    struct mr_motion_estimate motion; /* at the last gate */
    bool motion_known;
    struct mr_gates_summary summary;
    bool summary_known;
};

/* What a block changed, for telemetry. */
struct landing_news {
    bool state;
    bool summary;
    enum mr_status no_fit; /* why a landing that ended has no summary; MR_OK: it has, or none ended */
    unsigned edges;  /* edges resolved now; they end at landing.resolved */
    bool motion;
};

void landing_start(struct landing *landing);
/* MR_OK, or MR_NOT_NOW. `number` 0: one more than the last. */
enum mr_status landing_arm(struct landing *landing, uint16_t number, uint32_t block);
void landing_disarm(struct landing *landing, uint32_t block);

/* One block: its index, first tick, the mean code of the staircase, and the edges up to it. */
struct landing_news landing_block(struct landing *landing, uint32_t index, uint32_t tick, float staircase_code,
                                  const uint32_t *edge_ticks, unsigned edge_count);

/* Data of this state are kept: armed, landing, settling. */
bool landing_recording(const struct landing *landing);

struct landing_wheel {
    float station_ft; /* NaN: not known */
    float speed_ft_s; /* NaN: not known; 0: at rest */
    float deceleration_ft_s2;
};
/* Where the wheel is at `tick`, carried on from the last estimate at constant deceleration. */
struct landing_wheel landing_wheel_at(const struct landing *landing, uint32_t tick);

#endif
