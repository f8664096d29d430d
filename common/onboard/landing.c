#include "common/onboard/landing.h"

#include <string.h>

#include "common/wire.h"

static void change_state(struct landing *landing, enum mr_landing_state state,
                         enum mr_landing_cause cause, uint32_t block)
{
    landing->state = state;
    landing->cause = cause;
    landing->changed_block = block;
}

void landing_start(struct landing *landing)
{
    memset(landing, 0, sizeof *landing);
    mr_switches_start(&landing->switches);
    mr_passage_start(&landing->passage);
}

static void reset_passage(struct landing *landing)
{
    mr_switches_reset(&landing->switches);
    mr_passage_clear(&landing->passage);
    landing->edges_without_pause = 0;
}

enum mr_status landing_arm(struct landing *landing, uint16_t number, uint32_t block)
{
    if (landing->state != MR_LANDING_IDLE && landing->state != MR_LANDING_DONE)
        return MR_NOT_NOW;
    landing->is_live = false;
    landing->number = number ? number : (uint16_t)(landing->number + 1);
    reset_passage(landing);
    landing->edge_count = 0;
    landing->opened_mask = 0;
    landing->gates_before_braking = 0;
    landing->is_braked = false;
    landing->is_motion_known = false;
    landing->is_fitting = false;
    landing->is_summary_known = false;
    change_state(landing, MR_LANDING_ARMED, MR_LANDING_BY_COMMAND, block);
    return MR_OK;
}

void landing_reconfigure(struct landing *landing)
{
    reset_passage(landing);
}

void landing_disarm(struct landing *landing, uint32_t block)
{
    reset_passage(landing);
    change_state(landing, MR_LANDING_IDLE, MR_LANDING_BY_COMMAND, block);
}

bool landing_is_recording(const struct landing *landing)
{
    return landing->state == MR_LANDING_ARMED || landing->state == MR_LANDING_LANDING ||
           landing->state == MR_LANDING_SETTLING;
}

bool landing_is_quiet(const struct landing *landing, uint32_t block)
{
    return landing->state == MR_LANDING_ARMED && !mr_passage_is_ambiguous(&landing->passage, block);
}

bool landing_can_warn(const struct landing *landing, uint32_t block)
{
    return landing_is_recording(landing) && !mr_passage_is_ambiguous(&landing->passage, block);
}

static bool is_reporting_edges(const struct landing *landing)
{
    return landing->is_live || landing_is_recording(landing);
}

static void add_switch_event(struct landing *landing, uint8_t count, uint8_t position,
                             enum mr_switch_reason reason, float late_ms, uint32_t block)
{
    if (is_reporting_edges(landing) && landing->changes.event_count < LANDING_EVENTS_MAX)
        landing->event[landing->changes.event_count++] =
            (struct mr_switch_event){.count = count,
                                     .position = position,
                                     .reason = (uint8_t)reason,
                                     .late_ms = late_ms,
                                     .block16 = (uint16_t)block};
}

static void add_passage_events(struct landing *landing, uint32_t block)
{
    const struct mr_passage *passage = &landing->passage;
    for (unsigned i = 0; i < passage->event_count; i++) {
        const struct mr_passage_event *note = &passage->event[i];
        add_switch_event(landing, note->number, note->position, (enum mr_switch_reason)note->reason,
                         MR_NAN, block);
    }
}

void landing_set_brake(struct landing *landing, uint32_t tick)
{
    if (landing->state != MR_LANDING_LANDING || landing->is_braked)
        return;
    landing->is_braked = true;
    landing->brake_tick = tick;
}

/* True if the gear passed the gate before the brake acted, which is MR_BRAKE_DELAY_S after the edge
 * of the brake signal. */
static bool is_gate_before_brake(const struct landing *landing, const struct mr_gate *gate)
{
    const struct mr_passage *passage = &landing->passage;
    double brake_s = (double)(int32_t)(landing->brake_tick - passage->gate_edge[0].tick) *
                     MR_S_PER_TICK;
    return landing->is_braked && gate->t_s < brake_s + MR_BRAKE_DELAY_S;
}

/* Standard error of the braking that the first gates under braking do not show yet; landings brake
 * at 4 to 12 ft/s2. */
#define UNKNOWN_BRAKING_FT_S2 6.0
#define BRAKED_GATES_MIN      3u /* gates that determine a constant deceleration */

/* Two gates under braking give the mean speed between them, and one gate with those before braking
 * only a part of the deceleration. */
static void add_unknown_braking(const struct mr_passage *passage, unsigned braked_gates,
                                struct mr_motion_estimate *motion)
{
    if (braked_gates == 0 || braked_gates >= BRAKED_GATES_MIN)
        return;
    const struct mr_gate *last = &passage->gate[passage->gate_count - 1u];
    motion->speed_ft_s.error += 0.5 * UNKNOWN_BRAKING_FT_S2 * (last->t_s - last[-1].t_s);
    motion->deceleration_ft_s2.error += UNKNOWN_BRAKING_FT_S2;
}

static void estimate_motion(struct landing *landing, const struct mr_config *config)
{
    const struct mr_passage *passage = &landing->passage;
    /* Gates that were passed before braking (at touchdown or at the edge of the brake) do not fit
     * the parabola. Use them only until two later gates have opened. */
    landing->gates_before_braking = 0;
    while (landing->gates_before_braking < passage->gate_count) {
        const struct mr_gate *gate = &passage->gate[landing->gates_before_braking];
        if (gate->station_ft >= (double)config->site[0].touchdown_ft &&
            !is_gate_before_brake(landing, gate))
            break;
        landing->gates_before_braking++;
    }
    unsigned skip = passage->gate_count >= landing->gates_before_braking + 2
                      ? landing->gates_before_braking
                      : 0;
    landing->is_motion_known =
        mr_gates_latest_motion(passage->gate + skip, passage->gate_count - skip,
                               (double)config->site[0].switch_error_ft, &landing->motion) == MR_OK;
    if (landing->is_motion_known)
        add_unknown_braking(passage, passage->gate_count - landing->gates_before_braking,
                            &landing->motion);
}

/* Assigns an edge of an identified switch to a landing, to a push-back, or to neither. */
static void handle_identified_edge(struct landing *landing, const struct mr_config *config,
                                   const struct mr_switch_edge *edge, uint8_t number,
                                   uint32_t index)
{
    float station_ft[MR_CONFIG_SWITCHES];
    struct landing_wheel wheel = landing_wheel_at(landing, edge->tick);
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++)
        /* a switch that is not fitted does not count as missing */
        station_ft[i] = config->gate[i].step_codes ? mr_config_gate_ft(config, i) : MR_NAN;
    struct mr_passage_edge passed = {.tick = edge->tick,
                                     .block = index,
                                     .position = edge->position,
                                     .number = number,
                                     .station_ft = (double)station_ft[edge->position - 1]};
    struct mr_passage_changes changes = mr_passage_on_edge(
        &landing->passage, &passed, (double)wheel.speed_ft_s, station_ft, MR_CONFIG_SWITCHES);
    add_passage_events(landing, index);
    landing->changes.has_new_pushback |= changes.has_new_pushback;
    if (!landing_is_recording(landing) || !changes.has_new_gate)
        return;
    estimate_motion(landing, config);
    landing->changes.has_new_motion = landing->is_motion_known;
    landing->last_gate_block = index;
    if (changes.has_started_landing)
        landing->first_block = index;
    if (landing->state != MR_LANDING_LANDING)
        change_state(landing, MR_LANDING_LANDING, MR_LANDING_BY_EDGE, index);
}

static void handle_edge(struct landing *landing, const struct mr_config *config,
                        const struct mr_switch_edge *edge, uint32_t index)
{
    /* In a landing a switch opens once; during a push-back it may open several times. */
    bool rolling = landing->passage.state == MR_PASSAGE_ROLLING &&
                   !((double)landing_wheel_at(landing, edge->tick).speed_ft_s <
                     MR_PASSAGE_MIN_FT_S);
    bool counts = edge->position && (edge->reason == MR_SWITCH_GOOD ||
                                     (edge->reason == MR_SWITCH_DOUBLE && !rolling));
    if (landing->passage.state == MR_PASSAGE_ROLLING && landing_is_recording(landing) &&
        index - landing->first_block >= LANDING_MAX_BLOCKS)
        counts = false;
    if (landing->edge_count < UINT8_MAX)
        landing->edge_count++;
    uint8_t number = (uint8_t)landing->edge_count;
    if (is_reporting_edges(landing) && landing->changes.edge_count < MR_SWITCHES_WAITING_MAX)
        landing->edge[landing->changes.edge_count++] =
            (struct mr_edge){.tick = edge->tick,
                             .position = counts ? edge->position : 0,
                             .count = number,
                             .step_codes = edge->step_codes < 0.0f ? 0.0f : edge->step_codes};
    if (edge->reason != MR_SWITCH_GOOD)
        add_switch_event(landing, number, edge->position, (enum mr_switch_reason)edge->reason,
                         MR_NAN, index);
    if (counts)
        handle_identified_edge(landing, config, edge, number, index);
}

static void handle_edges(struct landing *landing, const struct mr_config *config, uint32_t index,
                         const uint32_t *edge_ticks, unsigned edge_count)
{
    struct mr_switch_edge edge;
    uint16_t steps_codes[MR_CONFIG_SWITCHES];
    if (edge_count == 0 &&
        index - landing->edge_block >=
            (landing->is_live ? LANDING_LIVE_PAUSE_BLOCKS : MR_PASSAGE_QUIET_BLOCKS))
        landing->edges_without_pause = 0;
    for (unsigned i = 0; i < edge_count; i++) {
        if (landing->edges_without_pause < LANDING_EDGES_MAX &&
            mr_switches_add_edge(&landing->switches, edge_ticks[i]))
            landing->edges_without_pause++;
        landing->edge_block = index;
    }
    if (!landing->switches.waiting_count)
        return;
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++)
        steps_codes[i] = config->gate[i].step_codes;
    while (mr_switches_next_edge(&landing->switches, steps_codes, MR_CONFIG_SWITCHES, &edge))
        handle_edge(landing, config, &edge, index);
}

/* Returns the number of blocks after the last gate until the gear counts as at rest. */
static uint32_t compute_blocks_to_rest(const struct landing *landing)
{
    double deceleration_ft_s2 = landing->motion.deceleration_ft_s2.value;
    if (landing->is_motion_known && deceleration_ft_s2 > 0.5) {
        double stop_s = landing->motion.speed_ft_s.value / deceleration_ft_s2;
        if (stop_s >= 0.0 && stop_s < 2.5)
            return (uint32_t)(stop_s * 1000.0) + LANDING_REST_BLOCKS;
    }
    return LANDING_NO_EDGE_BLOCKS;
}

static void start_final_fit(struct landing *landing, const struct mr_config *config)
{
    mr_final_fit_start(&landing->fit, landing->passage.gate, landing->passage.gate_count,
                       (double)config->site[0].touchdown_ft,
                       (double)config->site[0].switch_error_ft);
    landing->is_fitting = true;
    landing->is_summary_known = false;
}

/* Computes one step of the final fit, and stores the result after the last step. */
static void continue_final_fit(struct landing *landing, uint32_t index)
{
    const struct mr_passage *passage = &landing->passage;
    if (mr_final_fit_step(&landing->fit))
        return;
    landing->is_fitting = false;
    landing->summary = landing->fit.summary;
    landing->changes.fit_status = landing->fit.status;
    landing->is_summary_known = landing->fit.status == MR_OK;
    landing->changes.has_new_summary = landing->is_summary_known;
    for (unsigned g = 0; landing->is_summary_known && g < passage->gate_count; g++) {
        double late_s = landing->summary.lateness_s[g];
        if (landing->summary.outlier_mask & 1u << g)
            add_switch_event(landing, passage->gate_edge[g].number, passage->gate_edge[g].position,
                             late_s > 0.0 ? MR_SWITCH_LATE : MR_SWITCH_EARLY,
                             (float)(1000.0 * late_s), index);
    }
}

struct landing_block_changes landing_on_block(struct landing *landing,
                                              const struct mr_config *config, uint32_t index,
                                              uint32_t tick, float staircase_code,
                                              const uint32_t *edge_ticks, unsigned edge_count)
{
    enum mr_landing_state before = landing->state;
    landing->changes = (struct landing_block_changes){0};

    mr_switches_add_level(&landing->switches, tick, staircase_code);
    handle_edges(landing, config, index, edge_ticks, edge_count);
    if (mr_passage_on_block(&landing->passage, index)) {
        add_passage_events(landing, index);
        mr_switches_reset(&landing->switches);
    }
    if (landing->state == MR_LANDING_LANDING) {
        if (index - landing->last_gate_block >= compute_blocks_to_rest(landing))
            change_state(landing, MR_LANDING_SETTLING, MR_LANDING_BY_STOP, index);
        else if (index - landing->first_block >= LANDING_MAX_BLOCKS)
            change_state(landing, MR_LANDING_SETTLING, MR_LANDING_BY_LIMIT, index);
        if (landing->state == MR_LANDING_SETTLING)
            start_final_fit(landing, config);
    } else if (landing->state == MR_LANDING_SETTLING &&
               index - landing->changed_block >= LANDING_SETTLE_BLOCKS) {
        change_state(landing, MR_LANDING_DONE, MR_LANDING_BY_SETTLED, index);
    } else if (!landing_is_recording(landing) && landing->passage.state == MR_PASSAGE_ROLLING &&
               index - landing->passage.quiet_since_block >= LANDING_NO_EDGE_BLOCKS) {
        /* a model passed while the board was not armed, or was pushed back after a landing */
        reset_passage(landing);
    }
    if (landing->is_fitting && landing->state == MR_LANDING_SETTLING &&
        index % LANDING_FIT_BLOCKS == 0)
        continue_final_fit(landing, index);
    landing->changes.has_new_state = landing->state != before;
    return landing->changes;
}

struct landing_wheel landing_wheel_at(const struct landing *landing, uint32_t tick)
{
    struct landing_wheel wheel = {MR_NAN, MR_NAN, MR_NAN};
    const struct mr_passage *passage = &landing->passage;
    if (!passage->gate_count || passage->state != MR_PASSAGE_ROLLING)
        return wheel;
    const struct mr_gate *last = &passage->gate[passage->gate_count - 1];
    wheel.station_ft = (float)last->station_ft;
    if (!landing->is_motion_known)
        return wheel;

    double since_s = (double)(uint32_t)(tick - passage->gate_edge[0].tick) * MR_S_PER_TICK -
                     last->t_s;
    double speed_ft_s = landing->motion.speed_ft_s.value;
    double deceleration_ft_s2 = landing->motion.deceleration_ft_s2.value;
    if (__builtin_isnan(deceleration_ft_s2))
        deceleration_ft_s2 = 0.0;
    if (deceleration_ft_s2 > 0.0 && since_s > speed_ft_s / deceleration_ft_s2)
        since_s = speed_ft_s / deceleration_ft_s2;
    wheel.station_ft = (float)(landing->motion.position_ft.value +
                               (speed_ft_s - 0.5 * deceleration_ft_s2 * since_s) * since_s);
    wheel.speed_ft_s = (float)(speed_ft_s - deceleration_ft_s2 * since_s);
    wheel.deceleration_ft_s2 = (float)deceleration_ft_s2;
    return wheel;
}
