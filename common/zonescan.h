/* Search of the chain (common/matchain.h) for the predictor's results: the longest compression zone
 * (closed joints in a row) ahead of the wheel, and the largest compression there. It also finds the
 * longest zone that the wheel would push together from any position on its path. The search is
 * spread over blocks: each call of mr_zonescan_continue visits a limited number of joints and
 * continues where the last call stopped, which limits the work per block.
 *
 * A zone is a run from a closed joint to a closed joint in which at most one joint of any ten in a
 * row is open. From a position of the wheel, the push minus the friction of the mats in between
 * closes all joints whose resistance it overcomes. The zone from a later position never ends
 * earlier, so one sweep covers all positions: the search for the next position continues at the
 * joint that ended the previous zone.
 *
 * Joints and positions refer to groups, as in the chain. The chain moves during the search, so the
 * result refers to the blocks that the search took. */
#ifndef MATRIG_COMMON_ZONESCAN_H
#define MATRIG_COMMON_ZONESCAN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/matchain.h"

/* number of consecutive joints of which one may be open in a zone */
#define MR_ZONE_WINDOW_MATS   10u
/* limit of a closed joint: the true limit of 0.001 in, plus 0.001 in for the residuals of the
 * springs */
#define MR_ZONE_CLOSED_MAX_FT (0.002f / 12.0f)
#define MR_ZONE_STRIDE_GROUPS 4u /* number of groups between examined positions of the wheel */

/* Range of the search. */
struct mr_zonescan_range {
    /* first joint of the search for the present zone; above count + 1: no search */
    uint16_t from_joint;
    uint16_t position; /* group under the wheel */
    /* last position, in steps of MR_ZONE_STRIDE_GROUPS from `position`; below `position`: none */
    uint16_t last_position;
    float push_lb; /* push of the wheel */
    /* by joint: resistance that the push must overcome; must stay valid during the search */
    const float *grit_lb;
};

struct mr_zonescan_found {
    /* longest present zone: joints first_joint .. first_joint + groups; groups 0: none */
    uint16_t groups, first_joint;
    uint16_t closed_joints; /* closed joints in the zone */
    float open_ft;          /* sum of the openings in the zone */
    float compression_lb;   /* largest compression from joint `from_joint` on */
    /* longest future zone, and the wheel's position when it forms; 0: none */
    uint16_t future_groups, future_position;
};

struct mr_zonescan {
    struct mr_zonescan_range range;
    struct mr_zonescan_found found; /* results so far; the future zone is searched first */
    uint8_t phase;
    uint16_t joint, window;
    /* first closing joint for this and the previous position, or of the present zone; 0: none */
    uint16_t start_joint, previous_start_joint;
    /* joint that ends the zone; last open and closed joint before it */
    uint16_t end_joint, last_open_joint, last_closed_joint;
    uint32_t visits; /* number of joints examined */
};

/* Begins a search; `range` is copied. */
void mr_zonescan_begin(struct mr_zonescan *scan, const struct mr_chain *chain,
                       const struct mr_zonescan_range *range);
/* Examines `visits` joints, or one more. True: the search is complete. */
bool mr_zonescan_continue(struct mr_zonescan *scan, const struct mr_chain *chain, unsigned visits);

#endif
