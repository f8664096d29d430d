/* One landing: its states, and the motion of the gear that follows from the edges.
 *
 *     idle -> armed (command) -> landing (two edges in a row at 2 ft/s or more) -> settling (gear
 *     at rest)
 *          -> done (mat at rest) -> idle (command)
 *
 * The gear counts as at rest half a second after the estimated stop, or three seconds after the
 * last gate; a gate while settling returns to landing. Settling lasts two seconds: the mat
 * practically ceases to move as the gear passes (report 2.7.2). No landing lasts longer than
 * LANDING_LIMIT_BLOCKS and settling. A model pushed back, at any time, is counted and reported, and
 * changes no state (common/passage.h).
 *
 * Edges are reported while armed, landing or settling, LANDING_EDGES between two pauses of 30 s at
 * most: a contact that chatters does not fill the links. While live they are reported too, with
 * pauses of a second.
 *
 * Pure: configuration, blocks and edges in, state out. The board runs it, and the host runs it
 * again over a record. */
#ifndef MATRIG_COMMON_ONBOARD_LANDING_H
#define MATRIG_COMMON_ONBOARD_LANDING_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/config.h"
#include "common/gates.h"
#include "common/passage.h"
#include "common/switches.h"

/* An edge belongs to the block in whose first 0.9 ms it falls, or to the next: when a block is
 * taken, 0.97 ms after its first trigger, every edge up to there has been stored, however busy the
 * processor was. */
#define LANDING_EDGE_TICKS        75600u
#define LANDING_EDGES             96u
#define LANDING_EVENTS            80u /* reported for a block; the links hold them */
#define LANDING_LIMIT_BLOCKS      20000u
#define LANDING_SETTLE_BLOCKS     2000u
#define LANDING_LIVE_PAUSE_BLOCKS 1000u
#define LANDING_REST_BLOCKS       500u /* after the predicted stop */
/* between two steps of the final fit: blocks that waited meanwhile are taken */
#define LANDING_FIT_BLOCKS        2u
/* without one the gear is at rest, whatever was predicted */
#define LANDING_NO_EDGE_BLOCKS    3000u

/* What a block changed, for telemetry. */
struct landing_news {
    bool state;
    bool summary;
    bool motion;
    bool pushed;
    /* why a landing that ended has no summary; MR_OK: it has, or none ended */
    enum mr_status no_fit;
    unsigned edges, events; /* of landing.edge and landing.event */
};

struct landing {
    enum mr_landing_state state;
    enum mr_landing_cause cause;
    uint16_t number;
    uint32_t changed_block; /* of the last change of state */
    uint32_t first_block;   /* in which the landing was known to be one */
    uint32_t last_gate_block;

    struct mr_switches switches;
    struct mr_passage passage;
    unsigned edges;        /* since arming; counts to 255 */
    unsigned edges_in_row; /* without a pause */
    bool live; /* edges are also reported while idle (firmware/landinglink.h); arming ends this */
    uint32_t edge_block; /* of the last one */
    uint32_t opened;     /* by gates: bit p-1 */

    struct mr_edge edge[MR_SWITCHES_WAITING]; /* to be reported with this block */
    struct mr_switch_event event[LANDING_EVENTS];
    struct landing_news news;

    unsigned gates_on_track;          /* of the passage's, before the touchdown station */
    struct mr_motion_estimate motion; /* at the last gate */
    bool motion_known;
    struct mr_final_fit fit; /* of the landing that settles, or did */
    bool fitting;
    struct mr_gates_summary summary;
    bool summary_known;
};

void landing_start(struct landing *landing);
/* MR_OK, or MR_NOT_NOW. `number` 0: one more than the last. */
enum mr_status landing_arm(struct landing *landing, uint16_t number, uint32_t block);
/* Idle or done, and the configuration has changed: what is under way by the old one is
 * forgotten. */
void landing_reconfigure(struct landing *landing);
void landing_disarm(struct landing *landing, uint32_t block);

/* One block: its index, first tick, the mean code of the staircase, and the edges up to it.
 * `config`: the switches and the site that are in force; the same from arming to the end of the
 * landing. Not kept. */
struct landing_news landing_block(struct landing *landing, const struct mr_config *config,
                                  uint32_t index, uint32_t tick, float staircase_code,
                                  const uint32_t *edge_ticks, unsigned edge_count);

/* Data of this state are kept: armed, landing, settling. */
bool landing_recording(const struct landing *landing);
/* Armed, and nothing rolls or is pushed: the mat at rest is the zero. */
bool landing_quiet(const struct landing *landing, uint32_t block);
/* What the mat does now is the gear's doing, or may be: not that of a model pushed back. */
bool landing_may_warn(const struct landing *landing, uint32_t block);

struct landing_wheel {
    float station_ft; /* NaN: not known */
    float speed_ft_s; /* NaN: not known; 0: at rest */
    float deceleration_ft_s2;
};
/* Where the wheel is at `tick`, carried on from the last estimate at constant deceleration. */
struct landing_wheel landing_wheel_at(const struct landing *landing, uint32_t tick);

#endif
