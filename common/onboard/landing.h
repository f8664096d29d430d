/* One landing: its states, and the motion of the gear computed from the edges.
 *
 *     idle -> armed (command) -> landing (two edges in a row at 2 ft/s or more) -> settling (gear
 *     at rest)
 *          -> done (mat at rest) -> idle (command)
 *
 * The gear counts as at rest half a second after the estimated stop, or three seconds after the
 * last gate; a gate during settling returns the state to landing. Settling lasts two seconds; a mat
 * practically stops moving when the gear has passed it (report 2.7.2). A landing lasts at most
 * LANDING_MAX_BLOCKS plus settling. A push-back of the model, at any time, is counted and reported
 * but changes no state (common/passage.h).
 *
 * Edges are reported while armed, landing or settling, at most LANDING_EDGES_MAX between two pauses
 * of 30 s, so that a chattering contact does not flood the links. In live mode they are also
 * reported while idle; a pause of one second is then enough.
 *
 * Pure: the state is a function of configuration, blocks and edges. The board runs this code, and
 * the host reruns it over a record. */
#ifndef MATRIG_COMMON_ONBOARD_LANDING_H
#define MATRIG_COMMON_ONBOARD_LANDING_H

#include <stdbool.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/config.h"
#include "common/gates.h"
#include "common/passage.h"
#include "common/switches.h"

/* An edge within the first 0.9 ms of a block belongs to that block, a later edge to the next block.
 * A block is processed 0.97 ms after its first trigger; by then, all edges of its first 0.9 ms are
 * stored even at full processor load. */
#define LANDING_BLOCK_EDGE_TICKS  75600u
#define LANDING_EDGES_MAX         96u
/* maximum number of switch events reported per block; the links can queue this many */
#define LANDING_EVENTS_MAX        80u
#define LANDING_MAX_BLOCKS        20000u
#define LANDING_SETTLE_BLOCKS     2000u
#define LANDING_LIVE_PAUSE_BLOCKS 1000u
/* number of blocks from the predicted stop until the gear counts as at rest */
#define LANDING_REST_BLOCKS       500u
/* number of blocks between two steps of the final fit; in this time the board processes waiting
 * blocks */
#define LANDING_FIT_BLOCKS        2u
/* without an edge for this time, the gear counts as at rest */
#define LANDING_NO_EDGE_BLOCKS    3000u

/* Changes caused by a block, for telemetry. */
struct landing_block_changes {
    bool has_new_state;
    bool has_new_summary;
    bool has_new_motion;
    bool has_new_pushback;
    /* reason why a finished landing has no summary; MR_OK: it has one, or no landing has
     * finished */
    enum mr_status fit_status;
    unsigned edge_count, event_count; /* number of entries in landing.edge and landing.event */
};

struct landing {
    enum mr_landing_state state;
    enum mr_landing_cause cause;
    uint16_t number;
    uint32_t changed_block; /* block of the last change of state */
    uint32_t first_block;   /* block in which the landing was recognised */
    uint32_t last_gate_block;

    struct mr_switches switches;
    struct mr_passage passage;
    unsigned edge_count;          /* number of edges since arming, up to 255 */
    unsigned edges_without_pause; /* number of edges since the last pause */
    /* live mode: until arming, edges are also reported while idle (firmware/landinglink.h) */
    bool is_live;
    uint32_t edge_block;  /* block of the last edge */
    uint32_t opened_mask; /* bit p-1: switch p was opened by a gate of the landing */

    struct mr_edge edge[MR_SWITCHES_WAITING_MAX]; /* edges to be reported with this block */
    struct mr_switch_event event[LANDING_EVENTS_MAX];
    struct landing_block_changes changes;

    bool is_braked;      /* the brake was applied in this landing */
    uint32_t brake_tick; /* tick of the edge of the brake */
    /* number of gates passed before braking: before touchdown or, once the brake's edge is known,
     * before that edge */
    unsigned gates_before_braking;
    struct mr_motion_estimate motion; /* motion at the last gate */
    bool is_motion_known;
    struct mr_final_fit fit; /* final fit of the landing that is settling or has settled */
    bool is_fitting;
    struct mr_gates_summary summary;
    bool is_summary_known;
};

void landing_start(struct landing *landing);
/* Arms a landing. `number` 0: the last number plus one. MR_NOT_NOW: a landing is armed or in
 * progress. */
enum mr_status landing_arm(struct landing *landing, uint16_t number, uint32_t block);
/* Call after the configuration has changed, in state idle or done: discards everything in progress
 * under the old configuration. */
void landing_reconfigure(struct landing *landing);
void landing_disarm(struct landing *landing, uint32_t block);

/* Processes one block: its index, first tick, mean code of the staircase, and the edges up to it.
 * `config` holds the active switches and site; it must not change from arming to the end of the
 * landing. No pointer is kept. */
struct landing_block_changes landing_on_block(struct landing *landing,
                                              const struct mr_config *config, uint32_t index,
                                              uint32_t tick, float staircase_code,
                                              const uint32_t *edge_ticks, unsigned edge_count);

/* Call with each edge of the brake. After the first such edge in a landing, the motion is estimated
 * only from gates passed later. */
void landing_set_brake(struct landing *landing, uint32_t tick);

/* True in the states whose data are recorded: armed, landing, settling. */
bool landing_is_recording(const struct landing *landing);
/* True while armed and neither a gear nor a pushed model is moving; the mat is then at rest, and
 * its zero can be measured. */
bool landing_is_quiet(const struct landing *landing, uint32_t block);
/* True if the mat's movement may be caused by a landing gear rather than by a model being pushed
 * back. */
bool landing_can_warn(const struct landing *landing, uint32_t block);

struct landing_wheel {
    float station_ft; /* NaN: unknown */
    float speed_ft_s; /* NaN: unknown; 0: at rest */
    float deceleration_ft_s2;
};
/* Position of the wheel at `tick`, extrapolated from the last estimate at constant deceleration. */
struct landing_wheel landing_wheel_at(const struct landing *landing, uint32_t tick);

#endif
