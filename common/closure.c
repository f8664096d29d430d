#include "common/closure.h"

#include "common/wire.h"

static float get_segment_start_ft(unsigned segment)
{
    return MR_SEGMENT_LENGTH_FT * (float)segment;
}

/* Returns the share of a segment that is inside [from_ft, to_ft], 0 to 1. */
static float compute_overlap_share(unsigned segment, float from_ft, float to_ft)
{
    float low = get_segment_start_ft(segment);
    float high = low + MR_SEGMENT_LENGTH_FT;
    if (low < from_ft)
        low = from_ft;
    if (high > to_ft)
        high = to_ft;
    return high > low ? (high - low) / MR_SEGMENT_LENGTH_FT : 0.0f;
}

/* Closes joints by `closure_in` in the segments inside [from_ft, to_ft], beginning at the upfield
 * end, each segment up to its slack. A segment that contains one of the stations is divided
 * there. */
static void push_joints_closed(const float *slack_in, float *remaining_in, float from_ft,
                               float to_ft, float closure_in)
{
    for (unsigned s = 0; s < MR_SEGMENTS && closure_in > 0.0f; s++) {
        float available_in = slack_in[s] * compute_overlap_share(s, from_ft, to_ft);
        if (available_in > remaining_in[s])
            available_in = remaining_in[s];
        if (!(available_in > 0.0f))
            continue;
        float taken_in = closure_in < available_in ? closure_in : available_in;
        remaining_in[s] -= taken_in;
        closure_in -= taken_in;
    }
}

/* Closes joints according to the readings, in each interval between transducers. The displacement
 * at the wheel itself is not measured; that of the last transducer that the wheel has passed is
 * used, because mats behind the wheel keep their displacement. */
static void close_joints_by_movement(const struct mr_closure_input *input, float *remaining_in)
{
    unsigned from = MR_TRANSDUCERS;
    for (unsigned to = 0; to < MR_TRANSDUCERS; to++) {
        if (__builtin_isnan(input->displacement_in[to]))
            continue;
        if (from < MR_TRANSDUCERS && !(input->station_ft[to] <= input->wheel_ft)) {
            float from_ft = input->station_ft[from];
            if (from_ft < input->wheel_ft)
                from_ft = input->wheel_ft;
            push_joints_closed(input->slack_in, remaining_in, from_ft, input->station_ft[to],
                               input->displacement_in[from] - input->displacement_in[to]);
        }
        from = to;
    }
}

/* Returns the smaller root t of d = v t - a t^2 / 2, computed without cancellation. */
float mr_closure_compute_lead_s(float distance_ft, float speed_ft_s, float deceleration_ft_s2)
{
    if (!(speed_ft_s > 0.0f))
        return MR_NAN;
    if (distance_ft <= 0.0f)
        return 0.0f;
    float a = __builtin_isnan(deceleration_ft_s2) ? 0.0f : deceleration_ft_s2;
    float discriminant = speed_ft_s * speed_ft_s - 2.0f * a * distance_ft;
    if (discriminant < 0.0f)
        return MR_NAN;
    return 2.0f * distance_ft / (speed_ft_s + __builtin_sqrtf(discriminant));
}

void mr_closure_find_zone(const struct mr_closure_input *input, struct mr_closure_zone *zone,
                          float *remaining_in)
{
    float wheel_ft = __builtin_isnan(input->wheel_ft) ? 0.0f : input->wheel_ft;

    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        remaining_in[s] = input->slack_in[s];
    close_joints_by_movement(input, remaining_in);

    *zone = (struct mr_closure_zone){0};
    for (unsigned s = 0; s < MR_SEGMENTS;) {
        unsigned first = s;
        while (s < MR_SEGMENTS && remaining_in[s] < MR_CLOSED_SEGMENT_MAX_IN)
            s++;
        float start_ft = get_segment_start_ft(first);
        float end_ft = get_segment_start_ft(s);
        if (start_ft < wheel_ft)
            start_ft = wheel_ft;
        if (s == first)
            s++;
        if (end_ft <= start_ft)
            continue;
        unsigned mats = (unsigned)((end_ft - start_ft) / MR_MAT_LENGTH_FT + 0.5f);
        if (mats > zone->mats) {
            zone->mats = mats;
            zone->start_ft = start_ft;
            zone->end_ft = end_ft;
        }
    }
}
