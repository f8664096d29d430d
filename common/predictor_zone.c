#include "common/predictor_parts.h"

#define AT_WHEEL_FT 1.0f
#define NEAR_FT     9.5f /* an end so far beyond a transducer is better known */
#define LAST_FT     6.0f /* and an end so near to the runway's */

/* Where the wheel is when its place is under it, not behind where it is now. */
static float place_ft(const struct mr_predictor *p, unsigned place, float group_ft)
{
    float at_ft = (float)(place - 1u) * group_ft;
    return at_ft > p->wheel_ft ? at_ft : p->wheel_ft;
}

/* As it was found by the last search; what is to come also as far as the search going on has it,
 * when that is worse. */
static void describe(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    const struct mr_zonescan_found *found = &p->found;
    unsigned group = p->found_group, coming = found->coming, place = found->coming_place;
    float group_ft = p->config.chain.mat_length_ft * (float)group;
    zone->compression_lb = p->level == MR_PREDICTOR_PLOUGH && p->speed_ft_s > 0.0f
                             ? thrust_lb(p)
                             : found->compression_lb;
    if (p->speed_ft_s > 0.0f) {
        float ahead_ft = p->config.chain.mat_length_ft * (float)p->chain.group;
        zone->coming_mats = coming * group;
        zone->coming_ft = coming ? place_ft(p, place, group_ft) : MR_NAN;
        if (p->scan.found.coming * p->chain.group > zone->coming_mats) {
            zone->coming_mats = p->scan.found.coming * p->chain.group;
            zone->coming_ft = place_ft(p, p->scan.found.coming_place, ahead_ft);
        }
    }
    unsigned first = found->first, end = found->first + found->groups;
    unsigned wheel = p->wheel_ft > 0.0f && p->wheel_ft < 1e6f
                       ? (unsigned)(p->wheel_ft / group_ft) + 2u
                       : 0;
    first = first < wheel ? wheel : first; /* it has rolled on since */
    if (!found->groups || first >= end)
        return;
    zone->mats = (end - first) * group;
    zone->start_ft = (float)(first - 1u) * group_ft;
    zone->end_ft = (float)(end - 1u) * group_ft;
    unsigned passed = (first - found->first) * group, closed = found->closed * group;
    zone->closed_joints = closed > passed + 2u ? closed - passed : 2u;
    zone->mean_gap_in = IN_PER_FT * found->open_ft / (float)((found->groups + 1u) * group);
}

static void describe_kinematic(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    struct mr_closure_zone found;
    float left_in[MR_SEGMENTS];
    mr_predictor_find_kinematic(p, &found, left_in);
    zone->mats = zone->coming_mats = found.mats;
    zone->start_ft = found.start_ft;
    zone->end_ft = found.end_ft;
    zone->closed_joints = found.mats ? found.mats + 1u : 0;
    zone->coming_ft = found.start_ft;
    zone->mean_gap_in = found.mats ? 0.5f * MR_CLOSURE_OPEN_IN / (float)MR_MATS_PER_SEGMENT : 0.0f;
}

static void state_basis(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    float low_ft = MR_NAN, high_ft = MR_NAN;
    unsigned surveyed = 0, segments = 0;
    bool any = false;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        bool fitted = !__builtin_isnan(p->config.station_ft[i]);
        if (!fitted || p->doubt[i] != MR_PREDICTOR_TRUSTED ||
            (p->block && __builtin_isnan(p->last_in[i])))
            continue;
        if (!any)
            low_ft = p->config.station_ft[i];
        high_ft = p->config.station_ft[i];
        any = true;
    }
    float segment_ft = (float)MR_MATS_PER_SEGMENT * p->config.chain.mat_length_ft;
    for (unsigned s = (unsigned)(zone->start_ft / segment_ft);
         s < MR_SEGMENTS && (float)s * segment_ft < zone->end_ft; s++) {
        segments++;
        surveyed += __builtin_isnan(p->surveyed_in[s]) ? 0u : 1u;
    }
    zone->basis |= !any ? MR_PREDICTOR_BLIND : 0u;
    zone->basis |= any && zone->mats && zone->start_ft >= low_ft && zone->end_ft <= high_ft
                     ? MR_PREDICTOR_BRACKETED
                     : 0u;
    zone->basis |= segments && 2u * surveyed > segments ? MR_PREDICTOR_SURVEY : 0u;
    zone->basis |= p->degraded ? MR_PREDICTOR_DEGRADED : 0u;
    zone->basis |= p->fell_back ? MR_PREDICTOR_FELL_BACK : 0u;
}

/* Standard errors of the ends, mats: 95 % points of `make score`, series 0 to 309, over 1.96
 * (tests/score/README.md). They hold where there is a zone of 30 mats or more at all. First four:
 * not surveyed; then surveyed. Start: beyond the transducers, at the wheel and ahead of it; between
 * them, the same. End: at most NEAR_FT beyond a valid transducer; further, another one beyond;
 * further, none beyond; LAST_FT before the runway's end. */
static const float start_error_mats[MR_PREDICTOR_START_CLASSES] = {3.83f, 21.17f, 0.77f, 19.13f,
                                                                   1.28f, 10.97f, 0.77f, 6.89f};
static const float end_error_mats[MR_PREDICTOR_END_CLASSES] = {16.07f, 17.60f, 23.21f, 10.97f,
                                                               9.95f,  15.05f, 12.50f, 8.42f};

/* By level, over those: two and four mats in one need no other, the plough and kinematic zones do
 * (tests/score/README.md). */
#define LEVELS (MR_PREDICTOR_KINEMATIC + 1)
static const float coarser_start[LEVELS] = {1.0f, 1.0f, 1.0f, 1.2f, 1.7f},
                   coarser_end[LEVELS] = {1.0f, 1.0f, 1.0f, 1.2f, 2.0f};

static uint8_t class_of_end(const struct mr_predictor *p, const struct mr_predictor_zone *zone)
{
    float runway_ft = p->config.chain.mat_length_ft * (float)p->config.chain.mats;
    bool near = false, beyond = false;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        float past_ft = zone->end_ft - p->config.station_ft[i];
        if (__builtin_isnan(p->last_in[i])) /* nor has one that is not fitted */
            continue;
        near = near || (past_ft >= 0.0f && past_ft < NEAR_FT);
        beyond = beyond || past_ft < 0.0f;
    }
    return zone->end_ft > runway_ft - LAST_FT ? 3u : near ? 0u : beyond ? 1u : 2u;
}

static void state_errors(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    unsigned surveyed = zone->basis & MR_PREDICTOR_SURVEY ? 4u : 0u,
             between = zone->basis & MR_PREDICTOR_BRACKETED ? 2u : 0u;
    /* there, beginning and wheel are further apart */
    bool ahead = zone->distance_ft > AT_WHEEL_FT || zone->level != MR_PREDICTOR_FULL;
    float mat_ft = p->config.chain.mat_length_ft;
    zone->start_class = (uint8_t)(surveyed + between + ahead);
    zone->end_class = (uint8_t)(surveyed + class_of_end(p, zone));
    zone->start_error_ft = mat_ft * coarser_start[zone->level] *
                           start_error_mats[zone->start_class];
    zone->end_error_ft = mat_ft * coarser_end[zone->level] * end_error_mats[zone->end_class];
}

static void judge(struct mr_predictor_zone *zone)
{
    if (zone->coming_mats >= MR_PREDICTOR_WARNING_MATS) {
        zone->verdict = MR_PREDICTOR_WARNING;
        zone->reason = zone->mats >= MR_PREDICTOR_WARNING_MATS ? MR_PREDICTOR_LONG_ZONE
                                                               : MR_PREDICTOR_GROWING_ZONE;
    } else if (zone->coming_mats >= MR_PREDICTOR_ADVISORY_MATS) {
        zone->verdict = MR_PREDICTOR_ADVISORY;
        zone->reason = zone->mats >= MR_PREDICTOR_ADVISORY_MATS ? MR_PREDICTOR_LONG_ZONE
                                                                : MR_PREDICTOR_GROWING_ZONE;
    }
}

void mr_predictor_zone(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    bool unmoved = __builtin_isnan(p->wheel_ft) || __builtin_isnan(p->speed_ft_s);
    *zone = (struct mr_predictor_zone){.level = p->level,
                                       .grit_scale = p->scale,
                                       .coming_ft = MR_NAN,
                                       .distance_ft = MR_NAN,
                                       .lead_s = MR_NAN,
                                       .start_error_ft = MR_NAN,
                                       .end_error_ft = MR_NAN};
    zone->critical_lb = p->config.mat_weight_lb * p->config.chain.mat_length_ft /
                        (2.0f * p->config.bump_ft);
    zone->age_blocks = p->block - p->corrected_block;
    if (p->level == MR_PREDICTOR_KINEMATIC || (unmoved && p->moved)) {
        zone->level = MR_PREDICTOR_KINEMATIC;
        describe_kinematic(p, zone);
    } else {
        describe(p, zone);
    }
    zone->basis = unmoved ? MR_PREDICTOR_NO_MOTION : 0u;
    state_basis(p, zone);
    if (zone->mats) {
        float distance_ft = zone->start_ft - p->wheel_ft;
        zone->distance_ft = distance_ft < 0.0f ? 0.0f : distance_ft;
        /* for which the score found none that would hold */
        if (zone->level != MR_PREDICTOR_KINEMATIC)
            state_errors(p, zone);
        if (!unmoved)
            zone->lead_s = mr_closure_lead_s(zone->distance_ft, p->speed_ft_s,
                                             p->deceleration_ft_s2);
    }
    judge(zone);
}
