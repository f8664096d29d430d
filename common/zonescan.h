/* Search of the chain (common/matchain.h) for the predictor's results: the longest compression zone
 * (closed joints in a row) ahead of the wheel, and the largest compression there. It also finds the
 * longest zone that the wheel would push together from any position on its path. To limit the work
 * per block, each call of mr_zonescan_continue examines a limited number of joints and continues
 * where the last call stopped.
 *
 * A zone is a run from a closed joint to a closed joint in which at most one joint of any ten in a
 * row is open. From a position of the wheel, the push minus the friction of the mats in between
 * closes all joints whose resistance it overcomes. The zone from a later position never ends
 * earlier, so one sweep covers all positions: the search for the next position continues at the
 * joint that ended the previous zone.
 *
 * Joints and positions are numbered by groups, as in the chain. The chain moves during a search, so
 * the result does not belong to a single block. */
#ifndef MATRIG_COMMON_ZONESCAN_H
#define MATRIG_COMMON_ZONESCAN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/matchain.h"

/* a zone has at most one open joint among this many consecutive joints */
#define MR_ZONE_WINDOW_MATS   10u
/* largest opening of a joint that counts as closed: 0.001 in, plus 0.001 in because the corrected
 * model does not follow the readings exactly */
#define MR_ZONE_CLOSED_MAX_FT (0.002f / 12.0f)
#define MR_ZONE_STRIDE_GROUPS 4u /* number of groups between examined positions of the wheel */

/* Range of the search. */
struct mr_zonescan_range {
    /* joint from which the present zone is searched; above count + 1: no search */
    uint16_t search_start_joint;
    uint16_t position; /* group under the wheel */
    /* last position, in steps of MR_ZONE_STRIDE_GROUPS from `position`; below `position`: none */
    uint16_t last_position;
    float push_lb; /* push of the wheel */
    /* resistance of each joint, which the push must overcome; must stay valid during the search */
    const float *grit_lb;
};

struct mr_zonescan_result {
    /* longest present zone, from joint first_joint to joint first_joint + groups; groups 0: none */
    uint16_t groups, first_joint;
    uint16_t closed_joints; /* closed joints in the zone */
    float opening_sum_ft;   /* sum of the openings in the zone */
    float compression_lb;   /* largest compression of any joint from `search_start_joint` on */
    /* longest future zone, and the wheel's position when it forms; 0: none */
    uint16_t future_groups, future_position;
};

struct mr_zonescan {
    struct mr_zonescan_range range;
    struct mr_zonescan_result result; /* results so far; the future zone is searched for first */
    uint8_t phase;
    uint16_t joint, window_joints;
    /* first joint of the zone for this and for the previous position, or of the present zone; 0:
     * none */
    uint16_t start_joint, previous_start_joint;
    /* joint that ends the zone; last open and closed joint before it */
    uint16_t end_joint, last_open_joint, last_closed_joint;
    uint32_t examined_joints; /* number of joints examined */
};

/* Begins a search; `range` is copied. */
void mr_zonescan_begin(struct mr_zonescan *scan, const struct mr_chain *chain,
                       const struct mr_zonescan_range *range);
/* Examines `visits` joints, or one more. True: the search is complete. */
bool mr_zonescan_continue(struct mr_zonescan *scan, const struct mr_chain *chain, unsigned visits);

#endif
