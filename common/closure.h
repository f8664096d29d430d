/* Closure: how far the joints between stations have closed, compared with the available slack, and
 * the compression zone: the longest run of mats with closed joints ahead of the wheel.
 *
 * Slack is the sum of the joint openings of a survey segment (10 mats), measured between gage
 * points before the landing (report 2.7.2). Movement is measured by the transducers: between
 * neighbouring stations a (upfield) and b (downfield), the joints have closed by u_a - u_b. A
 * braking gear closes first the joints next to the wheel. The closure of an interval is therefore
 * assigned to its segments in order, beginning at the upfield end, or at the wheel if it is inside
 * the interval. Each segment closes by at most its slack. Upfield and downfield of all transducers,
 * only the survey is known.
 *
 * Buckling starts inside a zone of 50 to 60 compressed mats (report 6.1.4); a run of
 * MR_PREDICTOR_WARNING_MATS causes a warning. Single precision and no library calls except a square
 * root: host and board agree bit for bit. */
#ifndef MATRIG_COMMON_CLOSURE_H
#define MATRIG_COMMON_CLOSURE_H

#include <stdint.h>

#include "common/block.h"

#define MR_SEGMENTS              42u
#define MR_MATS_PER_SEGMENT      10u
#define MR_MAT_LENGTH_FT         (2.0f / 7.0f)
#define MR_SEGMENT_LENGTH_FT     (10.0f * MR_MAT_LENGTH_FT)
/* A segment counts as closed when its remaining slack is below this limit. The limit allows one
 * open joint (0.036 in by design, report 2.7.2), nine joints closed to 0.001 in each, and three
 * times the survey error of 0.005 in. */
#define MR_CLOSED_SEGMENT_MAX_IN (0.036f + 9.0f * 0.001f + 3.0f * 0.005f)

struct mr_closure_input {
    const float *station_ft;      /* MR_TRANSDUCERS stations in ascending order */
    const float *displacement_in; /* movement of each transducer since arming; NaN: not valid */
    /* slack of each segment, MR_SEGMENTS values; NaN: not surveyed, never counts as closed */
    const float *slack_in;
    /* station of the wheel; NaN: unknown, every station then counts as ahead */
    float wheel_ft;
};

struct mr_closure_zone {
    unsigned mats; /* length of the zone; 0: there is no closed segment ahead */
    float start_ft;
    float end_ft;
};

/* Finds the longest run of closed segments that ends ahead of the wheel; of equally long runs, the
 * nearest. A run that contains the wheel starts at the wheel. Sets `remaining_in` (MR_SEGMENTS
 * values) to the remaining slack of each segment. */
void mr_closure_find_zone(const struct mr_closure_input *input, struct mr_closure_zone *zone,
                          float *remaining_in);

/* Returns the time for `distance_ft` at constant deceleration (NaN: no deceleration); 0 s if the
 * distance is 0 or negative. NaN if the gear stops before or has no speed. */
float mr_closure_compute_lead_s(float distance_ft, float speed_ft_s, float deceleration_ft_s2);

#endif
