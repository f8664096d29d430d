/* Closure: how far the joints between stations have closed against the slack that was available,
 * and the compression zone: the longest run of mats ahead of the wheel whose joints are closed.
 *
 * Slack: sum of joint openings per survey segment (10 mats), measured between gage points before
 * the landing (report 2.7.2). Movement: the transducers, so that between neighbouring stations a
 * and b (upfield, downfield) the joints have closed by u_a - u_b. A braking gear closes joints like
 * a plough, starting at the wheel: the closure of an interval is therefore given to its segments
 * from the upfield end on (from the wheel, when the wheel is inside), each up to its slack. Outside
 * the transducers only the survey is known.
 *
 * Buckling starts inside a zone of 50 to 60 compressed mats (report 6.1.4): a run of
 * MR_CLOSURE_WARNING_MATS is warned of. Single precision, no library calls but a square root: host
 * and board agree bit for bit. */
#ifndef MATRIG_COMMON_CLOSURE_H
#define MATRIG_COMMON_CLOSURE_H

#include <stdint.h>

#include "common/block.h"

#define MR_SEGMENTS          42u
#define MR_MATS_PER_SEGMENT  10u
#define MR_MAT_LENGTH_FT     (2.0f / 7.0f)
#define MR_SEGMENT_LENGTH_FT (10.0f * MR_MAT_LENGTH_FT)
/* A segment counts as closed when less than this is left of its slack: one joint in ten may still
 * be open (0.036 in designed, report 2.6), the nine others closed to 0.001 in, and a survey reading
 * is good to 0.005 in (three of them). */
#define MR_CLOSURE_OPEN_IN   (0.036f + 9.0f * 0.001f + 3.0f * 0.005f)

struct mr_closure_input {
    const float *station_ft;      /* MR_TRANSDUCERS, rising */
    const float *displacement_in; /* MR_TRANSDUCERS, since arming; NaN: not valid */
    const float *slack_in;        /* MR_SEGMENTS; NaN: not surveyed (never closed) */
    float wheel_ft;               /* NaN: not known, every station is ahead */
};

struct mr_closure_zone {
    unsigned mats; /* 0: no closed segment ahead */
    float start_ft;
    float end_ft;
};

/* Longest run of closed segments whose end is ahead of the wheel; a run the wheel is inside starts
 * at the wheel. On equal lengths the nearest. `remaining_in` (MR_SEGMENTS) receives what is left of
 * each segment's slack. */
void mr_closure_find(const struct mr_closure_input *input, struct mr_closure_zone *zone,
                     float *remaining_in);

/* Time to travel `distance_ft` (up to 0: 0 s) at constant deceleration (NaN: none). NaN when the
 * gear stops before, or has no speed. */
float mr_closure_lead_s(float distance_ft, float speed_ft_s, float deceleration_ft_s2);

#endif
