#include "common/onboard/predict_feed.h"

#include "common/wire.h"

#define S_PER_TICK    (1.0f / 84e6f)
#define NEVER_S       1e9f
/* after this many gates passed while braking, the estimated deceleration no longer includes the
 * time before braking */
#define BRAKING_GATES 3u

/* Copies the landing's motion estimate in single precision, at each new gate. */
static void update_motion(struct predict_motion *motion, const struct landing *landing)
{
    const struct mr_passage *passage = &landing->passage;
    bool rolling = passage->gate_count && passage->state == MR_PASSAGE_ROLLING;
    if (rolling == motion->is_rolling && passage->gate_count == motion->gate_count &&
        !landing->changes.has_new_motion)
        return;
    *motion = (struct predict_motion){.gate_count = passage->gate_count, .is_rolling = rolling};
    if (!rolling)
        return;
    motion->tick = passage->gate_edge[passage->gate_count - 1u].tick;
    motion->station_ft = (float)passage->gate[passage->gate_count - 1u].station_ft;
    motion->is_known = landing->is_motion_known;
    if (!motion->is_known)
        return;
    double a = landing->motion.deceleration_ft_s2.value;
    motion->station_ft = (float)landing->motion.position_ft.value;
    motion->speed_ft_s = (float)landing->motion.speed_ft_s.value;
    motion->is_braking = !__builtin_isnan(a) &&
                         passage->gate_count - landing->gates_before_braking >= BRAKING_GATES;
    motion->deceleration_ft_s2 = __builtin_isnan(a) ? 0.0f : (float)a;
    motion->stop_s = motion->deceleration_ft_s2 > 0.0f
                       ? motion->speed_ft_s / motion->deceleration_ft_s2
                       : NEVER_S;
}

static void set_motion(const struct predict_motion *motion, float touchdown_ft, uint32_t tick,
                       struct mr_predictor_input *input)
{
    input->wheel_ft = input->speed_ft_s = input->deceleration_ft_s2 = MR_NAN;
    if (!motion->is_rolling)
        return;
    input->wheel_ft = motion->station_ft;
    if (motion->is_known) {
        float a = motion->deceleration_ft_s2,
              s = (float)(int32_t)(tick - motion->tick) * S_PER_TICK;
        bool stopped = s > motion->stop_s;
        s = stopped ? motion->stop_s : s;
        input->wheel_ft = motion->station_ft + (motion->speed_ft_s - 0.5f * a * s) * s;
        input->speed_ft_s = stopped ? 0.0f : motion->speed_ft_s - a * s;
        input->deceleration_ft_s2 = a;
        input->is_braking_known = motion->is_braking;
    }
    input->is_on_runway = input->wheel_ft >= touchdown_ft;
}

uint32_t predict_find_frozen_zeros(const struct mr_predictor *predictor,
                                   const struct landing *landing)
{
    return landing->edge_count ? 0u : predictor->moved_mask;
}

void predict_compute_input(struct predict_motion *motion, const struct landing *landing,
                           float touchdown_ft, const struct predict_block *block,
                           struct mr_predictor_input *input)
{
    *input = (struct mr_predictor_input){0};
    update_motion(motion, landing);
    set_motion(motion, touchdown_ft, block->tick, input);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        input->displacement_in[i] = block->displacement_in[i] - block->baseline_in[i];
}

/* --- messages --- */

static uint16_t clamp_u16(uint32_t value)
{
    return (uint16_t)(value < UINT16_MAX ? value : UINT16_MAX);
}

/* Percentage of the zone that is not between the first and the last trusted transducer. */
static uint8_t compute_inferred_percent(const struct mr_predictor *predictor,
                                        const struct mr_predictor_zone *zone)
{
    float low_ft = MR_NAN, high_ft = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        float station_ft = predictor->config.station_ft[i];
        if (__builtin_isnan(station_ft) || __builtin_isnan(predictor->last_reading_in[i]))
            continue;
        low_ft = station_ft < low_ft || __builtin_isnan(low_ft) ? station_ft : low_ft;
        high_ft = station_ft > high_ft || __builtin_isnan(high_ft) ? station_ft : high_ft;
    }
    float from_ft = zone->start_ft > low_ft ? zone->start_ft : low_ft,
          to_ft = zone->end_ft < high_ft ? zone->end_ft : high_ft;
    float length_ft = zone->end_ft - zone->start_ft;
    if (!zone->mats)
        return 0;
    float between = to_ft > from_ft && length_ft > 0.0f ? (to_ft - from_ft) / length_ft : 0.0f;
    return (uint8_t)(100.0f * (1.0f - between) + 0.5f);
}

void predict_fill_report(const struct mr_predictor *predictor, const struct mr_predictor_zone *zone,
                         bool warning, uint32_t index, struct predict_report *report)
{
    uint16_t block16 = (uint16_t)index;
    report->zone = (struct mr_zone){.mats = (uint16_t)zone->mats,
                                    .start_ft = zone->start_ft,
                                    .end_ft = zone->end_ft,
                                    .block16 = block16};
    report->zone_lead =
        (struct mr_zone_lead){.lead_s = zone->lead_s,
                              .wheel_ft = predictor->wheel_ft,
                              .warning = warning,
                              .inferred_percent = compute_inferred_percent(predictor, zone),
                              .block16 = block16};
    report->zone_error = (struct mr_zone_error){.start_ft = zone->start_error_ft,
                                                .end_ft = zone->end_error_ft,
                                                .mean_gap_in = zone->mean_gap_in,
                                                .block16 = block16};
    report->zone_coming = (struct mr_zone_coming){.mats = (uint16_t)zone->future_mats,
                                                  .wheel_ft = zone->future_wheel_ft,
                                                  .closed_joints = (uint16_t)zone->closed_joints,
                                                  .block16 = block16};
    report->zone_press = (struct mr_zone_press){.compression_lb = zone->compression_lb,
                                                .critical_lb = zone->critical_lb,
                                                .distance_ft = zone->distance_ft,
                                                .block16 = block16};
    report->verdict = (struct mr_verdict){.verdict = (uint8_t)zone->verdict,
                                          .reason = (uint8_t)zone->reason,
                                          .level = (uint8_t)zone->level,
                                          .basis = (uint8_t)zone->basis,
                                          .age = clamp_u16(zone->age_blocks),
                                          .block16 = block16};
}

void predict_fill_risk_report(const struct mr_risk_report *risk, uint32_t index,
                              struct predict_report *report)
{
    report->risk = (struct mr_risk){.risk = risk->risk,
                                    .basis = (uint8_t)risk->basis,
                                    .reason = (uint8_t)risk->reason,
                                    .block16 = (uint16_t)index};
    report->risk_lead = (struct mr_risk_lead){.start_s = risk->start_s,
                                              .failure_s = risk->failure_s,
                                              .failure_ft = risk->failure_ft,
                                              .block16 = (uint16_t)index};
}

/* ---- baseline ---- */

static void begin_baseline_group(struct baseline *baseline)
{
    baseline->blocks = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->sum_in[i] = 0.0f;
}

void baseline_discard(struct baseline *baseline)
{
    begin_baseline_group(baseline);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->zero_in[i] = MR_NAN;
}

void baseline_update(struct baseline *baseline, const float *displacement_in, bool quiet,
                     uint32_t frozen)
{
    if (!quiet) {
        begin_baseline_group(baseline);
        return;
    }
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->sum_in[i] += displacement_in[i];
    if (++baseline->blocks < BASELINE_BLOCKS)
        return;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        baseline->zero_in[i] = frozen >> i & 1u ? baseline->zero_in[i]
                                                : baseline->sum_in[i] / (float)BASELINE_BLOCKS;
    begin_baseline_group(baseline);
}
