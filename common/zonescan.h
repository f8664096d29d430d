/* Search of the chain (common/matchain.h) for the predictor's results: the longest compression zone
 * (closed joints in a row) ahead of the wheel, the largest compression there, and the longest zone
 * that the wheel would push together from any place on its way. A search is spread over blocks:
 * mr_zonescan_go visits so many joints and goes on from there at the next call, so that no block
 * bears more than its share.
 *
 * A zone is a run from a closed joint to a closed joint in which no ten in a row have more than one
 * open. From a place on the way, the push less the friction of the mats between closes joints whose
 * resistance it overcomes; the further the place, the more of them, so that one sweep serves all
 * places: the joint that ends the zone of one place is where the next one's search goes on.
 *
 * Joints and places are of groups, as in the chain. The chain moves during the search: the result
 * belongs to the blocks that it took. */
#ifndef MATRIG_COMMON_ZONESCAN_H
#define MATRIG_COMMON_ZONESCAN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/matchain.h"

#define MR_ZONE_TALLY_MATS 10u /* of so many joints in a row of a zone one may be open */
/* the truth's 0.001 in, and as much again for what the springs leave */
#define MR_ZONE_CLOSED_FT  (0.002f / 12.0f)
#define MR_ZONE_STRIDE     4u /* groups between places on the way */

/* Where to look. */
struct mr_zonescan_order {
    /* first joint looked at for the zone that is there; beyond count + 1: none */
    uint16_t from;
    uint16_t place;      /* group under the wheel */
    uint16_t last_place; /* places up to this, every MR_ZONE_STRIDE; below `place`: none */
    float push_lb;       /* of the wheel on its way */
    /* by joint: what the push must overcome; kept by the caller while the search goes on */
    const float *grit_lb;
};

struct mr_zonescan_found {
    /* the longest zone: joints first .. first + groups; groups 0: none */
    uint16_t groups, first;
    uint16_t closed;      /* joints in it that are */
    float open_ft;        /* sum of the openings in it */
    float compression_lb; /* largest from `from` on */
    /* the longest zone to come, and the wheel's place then; 0: none */
    uint16_t coming, coming_place;
};

struct mr_zonescan {
    struct mr_zonescan_order order;
    struct mr_zonescan_found found; /* so far; of places on the way first */
    uint8_t phase;
    uint16_t joint, tally;
    /* first joint that closes, of this place and the last, or of the zone; 0: none */
    uint16_t start, start_before;
    uint16_t end, last_open, last_closed; /* joint that ends the zone; last ones before it */
    uint32_t visits;                      /* joints looked at */
};

void mr_zonescan_begin(struct mr_zonescan *scan, const struct mr_chain *chain,
                       const struct mr_zonescan_order *order);
/* Looks at `visits` joints, or one more. True: the search is complete. */
bool mr_zonescan_go(struct mr_zonescan *scan, const struct mr_chain *chain, unsigned visits);

#endif
