#include "common/predictor.h"

#include <string.h>

#include "common/wire.h"

#define IN_PER_FT   12.0f
#define G_FT_S2     32.174f
#define BLOCK_S     1e-3f
#define HMIL_PER_FT 1.2e6f

/* Constants of the springs that correct the model by transducer readings. Tuned with seeds of `make
 * score` that are not in its tables. */
#define SPRING_LB_FT           3000.0f
#define SPRING_MAX_LB          16.0f
/* The springs correct stations from SPRING_AHEAD_FT ahead of the wheel to SPRING_BEHIND_FT behind
 * it: a mat practically stops moving when the gear has passed it (report 2.7.2). */
#define SPRING_AHEAD_FT        60.0f
#define SPRING_BEHIND_FT       5.0f
/* readings up to this far ahead of the wheel are used to adapt the resistance */
#define EVIDENCE_AHEAD_FT      40.0f
#define SCALE_CHANGE_PER_LB_IN 0.02f
#define SCALE_MIN              0.3f
#define SCALE_MAX              2.5f
/* weight of a new reading in the running mean, which averages over about 50 blocks */
#define SMOOTHING_SHARE        0.02f

/* A transducer whose reading drifts from the model by more than this is no longer trusted. */
#define DRIFT_MAX_IN            0.02f
#define READING_MAX_IN          (IN_PER_FT * MR_CHAIN_RUNAWAY_FT) /* a larger reading is invalid */
#define DISAGREEMENT_MAX_IN     0.25f
#define DISAGREEMENT_MAX_BLOCKS 300u

#define STATION_MAX_FT         10000.0f /* limit of a plausible station */
#define SPEED_MAX_FT_S         300.0f
#define DECELERATION_MAX_FT_S2 64.0f /* twice the deceleration with locked wheels */
/* a larger movement proves that a wheel is rolling, even if no switch has opened */
#define MOVED_MIN_IN           0.05f
/* a smaller relative change of the deceleration does not restart the search */
#define BRAKING_TOLERANCE      0.01f
#define INTERVALS_TO_UPGRADE   10u
#define GUARD_TRIPS_MAX        3u

/* Joints at rest. */
/* gaps as laid: uniform between 0 and this, none beyond the slack (report 2.6) */
#define LAID_GAP_MAX_IN    0.036f
#define SURVEY_ERROR_IN    0.005f
/* blocks between two updates of the resistance: a wheel rolls about half a mat in 4 blocks; with 8
 * blocks the error doubles */
#define GRIT_UPDATE_BLOCKS 4u
#define GRIT_UPDATE_VISITS 3u /* cost of one updated group, in joints visited */

/* --- result --- */
#define AT_WHEEL_MAX_FT    1.0f
/* a zone end at most this far beyond a transducer has a smaller standard error */
#define NEAR_TRANSDUCER_FT 9.5f
/* a zone end at most this far from the end of the runway has a smaller standard error */
#define NEAR_RUNWAY_END_FT 6.0f

static bool is_between(float x, float least, float most)
{
    return x >= least && x <= most;
}

static unsigned get_joint_count(const struct mr_predictor *p)
{
    return p->config.chain.mats + 1u;
}

static float compute_thrust_lb(const struct mr_predictor *p)
{
    return p->config.thrust_lb_per_g * p->deceleration_ft_s2 / G_FT_S2;
}

/* --- joints at rest and their resistance --- */

/* Returns a number that is uniform over 0..1 for consecutive i: the fractional part of i times an
 * irrational number (`multiplier` / 2^32), to 24 bits. */
static float draw_uniform_share(uint32_t i, uint32_t multiplier)
{
    return (float)(i * multiplier >> 8) * (1.0f / 16777216.0f);
}

/* Closing resistance of a joint, relative to the mean of all joints. */
static float get_grit_share(unsigned joint)
{
    /* the multiplier is 2^32 (sqrt 5 - 1) / 2 */
    return 2.0f * draw_uniform_share(joint, 2654435769u);
}

/* --- openings --- */

static void reset_gaps(struct mr_predictor *p)
{
    float slack_ft = p->config.chain.slack_ft;
    for (unsigned j = 0; j <= MR_CHAIN_MATS; j++) {
        /* the multiplier is 2^32 (sqrt 2 - 1) */
        float gap_ft = LAID_GAP_MAX_IN / IN_PER_FT * draw_uniform_share(j + 1u, 1779033704u);
        p->gap_ft[j] = gap_ft < slack_ft ? gap_ft : slack_ft;
    }
}

/* Scales the gaps of ten joints so that their sum changes from `have_ft` to `sum_ft`. For a smaller
 * sum, multiplies all gaps by one factor; for a larger sum, does so with the differences between
 * slack and gaps. */
static void rescale_gaps(float *gap_ft, unsigned count, float have_ft, float sum_ft, float slack_ft)
{
    float room_ft = slack_ft * (float)count - have_ft;
    if (sum_ft < have_ft) {
        for (unsigned j = 0; j < count; j++)
            gap_ft[j] *= sum_ft / have_ft;
        return;
    }
    float part = sum_ft - have_ft < room_ft ? (sum_ft - have_ft) / room_ft : 1.0f;
    for (unsigned j = 0; j < count && room_ft > 0.0f; j++)
        gap_ft[j] += part * (slack_ft - gap_ft[j]);
}

/* Changes the sum of joints that a wheel has pushed by `missing_ft`. To reduce the sum, closes the
 * joints with the least resistance first; to increase it, opens those with the most resistance
 * first: after a wheel has pushed mats together, a few wide gaps are more likely than many narrow
 * ones. */
static void set_gap_sum(float *gap_ft, unsigned first, unsigned count, float missing_ft,
                        float slack_ft)
{
    bool taken[MR_MATS_PER_SEGMENT] = {false};
    for (unsigned pass = 0; pass < count && missing_ft != 0.0f; pass++) {
        unsigned pick = count;
        for (unsigned j = 0; j < count; j++) {
            bool better = pick == count ||
                          (missing_ft < 0.0f) ==
                              (get_grit_share(first + j + 1u) < get_grit_share(first + pick + 1u));
            if (!taken[j] && better)
                pick = j;
        }
        taken[pick] = true;
        float to_ft = gap_ft[first + pick] + missing_ft;
        to_ft = to_ft < 0.0f ? 0.0f : to_ft > slack_ft ? slack_ft : to_ft;
        missing_ft -= to_ft - gap_ft[first + pick];
        gap_ft[first + pick] = to_ft;
    }
}

/* Number of joints in a segment; 0 beyond the runway. */
static unsigned count_segment_joints(const struct mr_predictor *p, unsigned segment)
{
    unsigned first = segment * MR_MATS_PER_SEGMENT;
    unsigned left = first < get_joint_count(p) ? get_joint_count(p) - first : 0;
    return left < MR_MATS_PER_SEGMENT ? left : MR_MATS_PER_SEGMENT;
}

static float sum_gaps_ft(const struct mr_predictor *p, unsigned segment)
{
    float sum = 0.0f;
    for (unsigned j = 0; j < count_segment_joints(p, segment); j++)
        sum += p->gap_ft[segment * MR_MATS_PER_SEGMENT + j];
    return sum;
}

/* True if the segment's joints can have this sum, within the reading error. */
static bool is_possible_sum(const struct mr_predictor *p, unsigned segment, float sum_in)
{
    float most_in = IN_PER_FT * p->config.chain.slack_ft * (float)count_segment_joints(p, segment);
    return count_segment_joints(p, segment) > 0 &&
           is_between(sum_in, -4.0f * SURVEY_ERROR_IN, most_in + 4.0f * SURVEY_ERROR_IN);
}

void mr_predictor_set_survey(struct mr_predictor *p, const float *sum_in)
{
    float slack_ft = p->config.chain.slack_ft, error_ft = 2.0f * SURVEY_ERROR_IN / IN_PER_FT;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        unsigned first = s * MR_MATS_PER_SEGMENT, count = count_segment_joints(p, s);
        float have_ft = sum_gaps_ft(p, s), off_ft = sum_in[s] / IN_PER_FT - have_ft;
        p->surveyed_sum_in[s] = is_possible_sum(p, s, sum_in[s]) ? sum_in[s] : MR_NAN;
        if (__builtin_isnan(p->surveyed_sum_in[s]))
            continue;
        if (!(off_ft > error_ft || off_ft < -error_ft))
            continue;
        if (p->landing_count == 0 && sum_in[s] / IN_PER_FT > 0.5f * have_ft) {
            rescale_gaps(p->gap_ft + first, count, have_ft, sum_in[s] / IN_PER_FT, slack_ft);
            continue;
        }
        /* The landings before this state are not known: assume as few open joints as possible. */
        if (p->landing_count == 0) {
            for (unsigned j = 0; j < count; j++)
                p->gap_ft[first + j] = 0.0f;
            off_ft = sum_in[s] / IN_PER_FT;
        }
        set_gap_sum(p->gap_ft, first, count, off_ft, slack_ft);
    }
}

void mr_predictor_mark_surveyed(struct mr_predictor *p, const float *sum_in)
{
    float error_in = 2.0f * SURVEY_ERROR_IN + 1e-3f;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float have_in = IN_PER_FT * sum_gaps_ft(p, s),
              most_in = IN_PER_FT * p->config.chain.slack_ft * (float)count_segment_joints(p, s);
        float said_in = sum_in[s] < 0.0f ? 0.0f : sum_in[s] > most_in ? most_in : sum_in[s];
        bool holds = is_possible_sum(p, s, sum_in[s]) &&
                     is_between(have_in - said_in, -error_in, error_in);
        p->surveyed_sum_in[s] = holds ? sum_in[s] : MR_NAN;
    }
}

/* Computes the result from transducers and survey alone, without the model. */
void mr_predictor_find_kinematic_zone(const struct mr_predictor *p, struct mr_closure_zone *zone,
                                      float *remaining_in)
{
    float slack_in[MR_SEGMENTS], moved_in[MR_TRANSDUCERS];
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        /* subtract model_base_in, the movement that the gaps already include */
        moved_in[i] = p->last_reading_in[i] - p->model_base_in[i];
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack_in[s] = count_segment_joints(p, s) == MR_MATS_PER_SEGMENT
                        ? IN_PER_FT * sum_gaps_ft(p, s)
                        : MR_NAN;
    const struct mr_closure_input input = {.station_ft = p->config.station_ft,
                                           .displacement_in = moved_in,
                                           .slack_in = slack_in,
                                           .wheel_ft = p->wheel_ft};
    mr_closure_find_zone(&input, zone, remaining_in);
}

/* Sets the gaps from the transducers alone. */
static void set_gaps_from_readings(struct mr_predictor *p)
{
    struct mr_closure_zone zone;
    float remaining_in[MR_SEGMENTS];
    mr_predictor_find_kinematic_zone(p, &zone, remaining_in);
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float off_ft = remaining_in[s] / IN_PER_FT - sum_gaps_ft(p, s);
        if (off_ft < 0.0f)
            set_gap_sum(p->gap_ft, s * MR_MATS_PER_SEGMENT, count_segment_joints(p, s), off_ft,
                        p->config.chain.slack_ft);
    }
}

/* Sets the gaps from the chain model. */
static void set_gaps_from_chain(struct mr_predictor *p)
{
    const struct mr_chain *chain = &p->chain;
    float slack_ft = p->config.chain.slack_ft;
    for (unsigned j = 1; j <= chain->group_count + 1u; j++) {
        unsigned first = (j - 1u) * chain->mats_per_group, count = chain->mats_per_group;
        float have_ft = 0.0f, to_ft = mr_chain_opening_ft(chain, j);
        if (first >= get_joint_count(p))
            break;
        if (first + count > get_joint_count(p))
            count = get_joint_count(p) - first;
        for (unsigned i = 0; i < count; i++)
            have_ft += p->gap_ft[first + i];
        if (__builtin_isnan(to_ft))
            continue; /* keep the gaps of this group */
        to_ft = to_ft < 0.0f                    ? 0.0f
              : to_ft > slack_ft * (float)count ? slack_ft * (float)count
                                                : to_ft;
        set_gap_sum(p->gap_ft, first, count, to_ft - have_ft, slack_ft);
    }
}

/* --- resistances --- */

/* Returns the resistance of the joint of a group that closes next, relative to the mean. The
 * weakest joint closes first; grit_extent_ft (the extent of the grit) shows how far the group has
 * closed. */
static float get_weakest_joint_share(const struct mr_predictor *p, unsigned j)
{
    unsigned group = p->chain.mats_per_group, first = (j - 1u) * group,
             last = get_joint_count(p) - 1u;
    float grit_extent_ft = p->chain.grit_extent_ft[j] - 1e-7f, best = 0.0f, most = 0.0f, share[4],
          gap_ft[4];
    if (group == 1u)
        return get_grit_share(j);
    for (unsigned i = 0; i < group; i++) {
        share[i] = get_grit_share(first + i + 1u);
        gap_ft[i] = first + i <= last ? p->gap_ft[first + i] : 0.0f;
        most = share[i] > most ? share[i] : most;
    }
    for (unsigned i = 0; i < group; i++) {
        float stronger_ft = 0.0f;
        for (unsigned k = 0; k < group; k++)
            stronger_ft += share[k] > share[i] ? gap_ft[k] : 0.0f;
        if (stronger_ft < grit_extent_ft && (best == 0.0f || share[i] < best))
            best = share[i];
    }
    return best > 0.0f ? best : most;
}

/* Returns the resistance that must be overcome before a group counts as closed, relative to the
 * mean. For four joints it is that of the strongest; for two joints that of the first one, which
 * gives the best results in `make score`. */
static float get_closing_share(const struct mr_predictor *p, unsigned j)
{
    unsigned group = p->chain.mats_per_group;
    float most = 0.0f;
    for (unsigned i = 1; i <= (group == 4u ? 4u : 1u); i++) {
        float share = get_grit_share((j - 1u) * group + i);
        most = share > most ? share : most;
    }
    return most;
}

static void set_grits(struct mr_predictor *p)
{
    struct mr_chain *chain = &p->chain;
    float mean_lb = p->config.grit_lb * p->resistance_scale;
    for (unsigned j = 1; j <= chain->group_count + 1u; j++) {
        chain->grit_lb[j] = mean_lb * get_weakest_joint_share(p, j);
        if (chain->mats_per_group > 1u)
            p->closing_lb[j] = mean_lb * get_closing_share(p, j);
    }
}

/* Updates the resistance of moving groups, in which one joint after the other closes. */
static void update_grits(struct mr_predictor *p)
{
    struct mr_chain *chain = &p->chain;
    unsigned first = (chain->low_bay - 1u) * MR_CHAIN_BAY_GROUPS + 1u,
             last = chain->high_bay * MR_CHAIN_BAY_GROUPS + 1u;
    if (chain->mats_per_group == 1u || chain->low_bay > chain->high_bay ||
        p->block % GRIT_UPDATE_BLOCKS != 0)
        return;
    unsigned followed = 0;
    for (unsigned j = first; j <= last && j <= chain->group_count + 1u; j++) {
        if (chain->v_ft_s[j] == 0.0f && chain->v_ft_s[j - 1u] == 0.0f)
            continue;
        chain->grit_lb[j] = p->config.grit_lb * p->resistance_scale * get_weakest_joint_share(p, j);
        followed++;
    }
    p->examined_joints += GRIT_UPDATE_VISITS * followed;
    p->interval_updates += GRIT_UPDATE_VISITS * followed / MR_PREDICTOR_VISITS_PER_UPDATE;
}

static unsigned get_level_group(enum mr_predictor_level level)
{
    return level == MR_PREDICTOR_TWO ? 2u : level == MR_PREDICTOR_FOUR ? 4u : 1u;
}

static unsigned find_mat_at_station(const struct mr_predictor *p, float station_ft)
{
    if (!(station_ft >= 0.0f && station_ft < 1e6f))
        return 0;
    unsigned mat = (unsigned)(station_ft / p->config.chain.mat_length_ft + 1e-4f) + 1u;
    return mat <= p->config.chain.mats ? mat : 0;
}

/* --- the chain --- */

static enum mr_status start_chain(struct mr_predictor *p)
{
    const struct mr_chain_params params = p->config.chain;
    /* no resistances here (NULL): set_grits sets them afterwards */
    enum mr_status status = mr_chain_start(&p->chain, &params, get_level_group(p->level), p->gap_ft,
                                           NULL);
    p->pending_s = 0.0f;
    if (status == MR_OK)
        set_grits(p);
    return status;
}

/* Displacement that the model predicts at a transducer, inches since arming. */
static float get_model_displacement_in(const struct mr_predictor *p, unsigned i, unsigned mat)
{
    return p->model_base_in[i] + IN_PER_FT * mr_chain_displacement_ft(&p->chain, mat);
}

/* Sets the range of joints and of wheel positions for the search. The last position is the stop at
 * the present deceleration. Before the deceleration is known, it is the stop at twice the assumed
 * deceleration, which the wheel nearly always reaches. */
static void begin_scan(struct mr_predictor *p)
{
    const struct mr_chain *chain = &p->chain;
    float group_ft = p->config.chain.mat_length_ft * (float)chain->mats_per_group,
          end_ft = group_ft * (float)chain->group_count;
    float wheel_ft = p->wheel_ft > 0.0f ? p->wheel_ft : 0.0f;
    struct mr_zonescan_range order = {.search_start_joint = (uint16_t)(chain->group_count + 2u),
                                      .position = 1,
                                      .push_lb = compute_thrust_lb(p),
                                      .grit_lb = chain->mats_per_group > 1u ? p->closing_lb
                                                                            : chain->grit_lb};
    if (wheel_ft < end_ft) {
        order.position = (uint16_t)((unsigned)(wheel_ft / group_ft) + 1u);
        order.search_start_joint = (uint16_t)(order.position + 1u);
    }
    if (p->speed_ft_s > 0.0f && wheel_ft < end_ft) {
        float stopping_ft_s2 = p->is_braking_known ? p->deceleration_ft_s2
                                                   : 2.0f * p->config.deceleration_ft_s2;
        float stop_ft = p->wheel_ft + 0.5f * p->speed_ft_s * p->speed_ft_s / stopping_ft_s2;
        /* without deceleration the wheel rolls to the runway's end */
        float last_ft = stop_ft < end_ft ? (stop_ft > 0.0f ? stop_ft : 0.0f) : end_ft;
        order.last_position = (uint16_t)((unsigned)(last_ft / group_ft) + 1u);
    }
    p->scan_deceleration_ft_s2 = p->deceleration_ft_s2;
    mr_zonescan_begin(&p->scan, chain, &order);
}

static void store_found_zone(struct mr_predictor *p)
{
    p->scan_result = p->scan.result;
    p->scan_result_group = (uint8_t)p->chain.mats_per_group;
    p->is_scan_restarted = false;
    begin_scan(p);
}

/* Completes the search at once; between landings there is no time limit. */
static void complete_scan(struct mr_predictor *p)
{
    begin_scan(p);
    while (!mr_zonescan_continue(&p->scan, &p->chain, MR_CHAIN_INDICES)) {
    }
    store_found_zone(p);
}

/* Continues the search by the work allowed in one block. */
static void continue_scan(struct mr_predictor *p)
{
    float off_ft_s2 = p->deceleration_ft_s2 - p->scan_deceleration_ft_s2,
          same_ft_s2 = BRAKING_TOLERANCE * p->scan_deceleration_ft_s2;
    if ((off_ft_s2 > same_ft_s2 || off_ft_s2 < -same_ft_s2) && !p->is_scan_restarted) {
        begin_scan(p);
        p->is_scan_restarted = true;
    }
    uint32_t before = p->scan.examined_joints;
    bool complete = mr_zonescan_continue(&p->scan, &p->chain, MR_PREDICTOR_VISITS_PER_BLOCK);
    uint32_t visits = p->scan.examined_joints - before;
    p->examined_joints += visits;
    p->interval_scan_updates += (visits + MR_PREDICTOR_VISITS_PER_UPDATE - 1u) /
                                MR_PREDICTOR_VISITS_PER_UPDATE;
    p->interval_updates += (visits + MR_PREDICTOR_VISITS_PER_UPDATE - 1u) /
                           MR_PREDICTOR_VISITS_PER_UPDATE;
    if (complete)
        store_found_zone(p);
}

/* Switches to another level; the mats keep their present positions. */
static void change_level(struct mr_predictor *p, enum mr_predictor_level level)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        unsigned mat = find_mat_at_station(p, p->config.station_ft[i]);
        if (mat)
            p->model_base_in[i] = get_model_displacement_in(p, i, mat);
    }
    set_gaps_from_chain(p);
    p->level = level;
    p->intervals_within_budget = 0;
    p->is_degraded = level > p->config.level;
    (void)start_chain(p); /* cannot fail: mr_predictor_start has checked the parameters */
    begin_scan(p);
}

/* Restarts the chain from the measured state after its state became invalid; after too many
 * restarts, continues without the model. */
static void restart_diverged_chain(struct mr_predictor *p)
{
    p->has_restarted = true;
    p->failures++;
    set_gaps_from_readings(p);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->model_base_in[i] = __builtin_isnan(p->last_reading_in[i]) ? 0.0f : p->last_reading_in[i];
    if (p->failures > GUARD_TRIPS_MAX)
        p->level = MR_PREDICTOR_KINEMATIC;
    (void)start_chain(p);
    begin_scan(p);
}

/* True if the values are plausible for the model runway in feet, pounds and seconds. Implausible
 * values are usually in another unit. */
static bool is_plausible_config(const struct mr_predictor_config *config)
{
    const struct mr_chain_params *chain = &config->chain;
    float length_ft = chain->mat_length_ft, weight_lb = config->mat_weight_lb;
    return is_between(length_ft, 0.1f, 2.0f) && is_between(weight_lb, 0.01f, 100.0f) &&
           is_between(chain->mass_slug * G_FT_S2 / weight_lb, 0.9f, 1.1f) &&
           is_between(chain->friction_lb / weight_lb, 0.0f, 1.5f) &&
           is_between(chain->slack_ft / length_ft, 0.0f, 0.05f) &&
           is_between(config->bump_ft / length_ft, 1e-5f, 0.1f) &&
           (chain->slack_ft == 0.0f ||
            is_between(chain->kl_lb_ft * chain->slack_ft, 100.0f, 20000.0f)) &&
           is_between(config->thrust_lb_per_g / weight_lb, 10.0f, 5000.0f) &&
           is_between(config->grit_lb, 0.0f, 2000.0f) &&
           is_between(config->deceleration_ft_s2, 0.1f, DECELERATION_MAX_FT_S2) &&
           config->level <= MR_PREDICTOR_PLOUGH;
}

enum mr_status mr_predictor_start(struct mr_predictor *p, const struct mr_predictor_config *config)
{
    memset(p, 0, sizeof *p);
    p->config = *config;
    p->resistance_scale = 1.0f;
    p->level = config->level;
    p->deceleration_ft_s2 = config->deceleration_ft_s2;
    p->wheel_ft = p->speed_ft_s = MR_NAN;
    reset_gaps(p);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        p->surveyed_sum_in[s] = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->last_reading_in[i] = p->smoothed_reading_in[i] = MR_NAN;
    if (!is_plausible_config(config))
        return MR_USAGE;
    enum mr_status status = start_chain(p);
    if (status == MR_OK)
        complete_scan(p);
    return status;
}

void mr_predictor_save(const struct mr_predictor *p, struct mr_predictor_state *state)
{
    memset(state, 0, sizeof *state);
    state->mats = p->config.chain.mats;
    state->landing_count = (uint16_t)(p->landing_count < UINT16_MAX ? p->landing_count
                                                                    : UINT16_MAX);
    state->resistance_scale = p->resistance_scale;
    for (unsigned j = 0; j < get_joint_count(p); j++)
        state->gap_counts[j] = (uint16_t)(p->gap_ft[j] * HMIL_PER_FT + 0.5f);
}

enum mr_status mr_predictor_load(struct mr_predictor *p, const struct mr_predictor_state *state)
{
    uint16_t most_hmil = (uint16_t)(p->config.chain.slack_ft * HMIL_PER_FT + 1.5f);
    if (state->mats != p->config.chain.mats ||
        !(state->resistance_scale >= SCALE_MIN && state->resistance_scale <= SCALE_MAX))
        return MR_MALFORMED;
    for (unsigned j = 0; j < get_joint_count(p); j++) {
        if (state->gap_counts[j] > most_hmil)
            return MR_MALFORMED;
    }
    p->landing_count = state->landing_count;
    p->resistance_scale = state->resistance_scale;
    for (unsigned j = 0; j < get_joint_count(p); j++)
        p->gap_ft[j] = (float)state->gap_counts[j] / HMIL_PER_FT;
    enum mr_status status = start_chain(p);
    if (status == MR_OK)
        complete_scan(p);
    return status;
}

static void reset_budget(struct mr_predictor *p)
{
    p->interval_updates = p->interval_scan_updates = p->history_updates = 0;
    memset(p->interval_history, 0, sizeof p->interval_history);
}

void mr_predictor_arm(struct mr_predictor *p)
{
    p->is_armed = true;
    p->is_braking_known = p->is_degraded = p->has_restarted = false;
    p->moved_mask = 0;
    p->level = p->config.level;
    p->block = p->corrected_block = p->updates = p->examined_joints = p->block_updates_max = 0;
    reset_budget(p);
    p->intervals_within_budget = p->failures = p->ploughed_mat = 0;
    p->work_lb_in = 0.0f;
    /* the deceleration of the previous landing does not apply to this one */
    p->deceleration_ft_s2 = p->config.deceleration_ft_s2;
    p->wheel_ft = p->speed_ft_s = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        p->last_reading_in[i] = p->smoothed_reading_in[i] = MR_NAN;
        p->model_base_in[i] = 0.0f;
        p->doubt[i] = MR_PREDICTOR_TRUSTED;
        p->doubtful_blocks[i] = 0;
    }
    (void)start_chain(p); /* cannot fail: mr_predictor_start has checked the parameters */
    complete_scan(p);
}

/* --- a block --- */

/* True if this transducer is to be ignored for the rest of the landing. `off_in`: reading minus
 * model. */
static bool is_transducer_doubted(struct mr_predictor *p, unsigned i, float reading_in,
                                  float off_in)
{
    float ahead_ft = p->config.station_ft[i] - p->wheel_ft;
    if (ahead_ft > SPRING_AHEAD_FT && (reading_in > DRIFT_MAX_IN || reading_in < -DRIFT_MAX_IN))
        p->doubt[i] = MR_PREDICTOR_DRIFTS;
    /* At the level `plough`, the model is not corrected at the stations, so it may differ from the
     * readings. */
    bool near = ahead_ft < EVIDENCE_AHEAD_FT && ahead_ft > -SPRING_BEHIND_FT &&
                p->level != MR_PREDICTOR_PLOUGH;
    if (!near || (off_in < DISAGREEMENT_MAX_IN && off_in > -DISAGREEMENT_MAX_IN))
        p->doubtful_blocks[i] = 0;
    else if (++p->doubtful_blocks[i] >= DISAGREEMENT_MAX_BLOCKS)
        p->doubt[i] = MR_PREDICTOR_DISAGREES;
    return p->doubt[i] != MR_PREDICTOR_TRUSTED;
}

/* Returns the spring force at one transducer, and adds its contribution to the estimate of the
 * resistance. */
static float compute_spring_force_lb(struct mr_predictor *p, unsigned i, unsigned mat,
                                     float reading_in)
{
    float ahead_ft = p->config.station_ft[i] - p->wheel_ft;
    float off_in = reading_in - get_model_displacement_in(p, i, mat);
    if (is_transducer_doubted(p, i, reading_in, off_in)) {
        p->last_reading_in[i] = MR_NAN;
        return 0.0f;
    }
    p->last_reading_in[i] = reading_in;
    if (reading_in > MOVED_MIN_IN || reading_in < -MOVED_MIN_IN)
        p->moved_mask |= 1u << i;
    if (__builtin_isnan(p->smoothed_reading_in[i]))
        p->smoothed_reading_in[i] = reading_in;
    float moved_in = (reading_in - p->smoothed_reading_in[i]) * SMOOTHING_SHARE;
    p->smoothed_reading_in[i] += moved_in;
    if (!(ahead_ft < SPRING_AHEAD_FT && ahead_ft > -SPRING_BEHIND_FT))
        return 0.0f;
    float force_lb = SPRING_LB_FT / IN_PER_FT * off_in;
    force_lb = force_lb > SPRING_MAX_LB  ? SPRING_MAX_LB
             : force_lb < -SPRING_MAX_LB ? -SPRING_MAX_LB
                                         : force_lb;
    p->corrected_block = p->block;
    if (ahead_ft > 0.0f && ahead_ft < EVIDENCE_AHEAD_FT)
        p->work_lb_in += force_lb * moved_in;
    return force_lb;
}

static void correct_with_springs(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        unsigned mat = find_mat_at_station(p, p->config.station_ft[i]);
        float reading_in = input->displacement_in[i];
        if (!mat)
            continue;
        if (!(reading_in < READING_MAX_IN && reading_in > -READING_MAX_IN))
            reading_in = MR_NAN;
        bool missing = __builtin_isnan(reading_in) || p->doubt[i] == MR_PREDICTOR_DRIFTS ||
                       p->doubt[i] == MR_PREDICTOR_DISAGREES;
        if (missing)
            p->last_reading_in[i] = MR_NAN;
        if (__builtin_isnan(reading_in) && p->doubt[i] == MR_PREDICTOR_TRUSTED)
            p->doubt[i] = MR_PREDICTOR_MISSING;
        else if (p->doubt[i] == MR_PREDICTOR_MISSING && !missing)
            p->doubt[i] = MR_PREDICTOR_TRUSTED;
        mr_chain_set_force(&p->chain, mat,
                           missing ? 0.0f : compute_spring_force_lb(p, i, mat, reading_in));
    }
}

/* Moves the mats ahead of the wheel, which is on mat n: starting there, joints close as long as the
 * thrust minus the friction of the mats in between exceeds their resistance. Mats behind the wheel
 * follow when the slack is used up. */
static void push_joints_closed(struct mr_predictor *p, unsigned n)
{
    struct mr_chain *chain = &p->chain;
    float press_lb = compute_thrust_lb(p), shift_ft = 0.0f;
    unsigned last = n;
    for (unsigned j = n + 1u; j <= chain->group_count; j++) {
        press_lb -= chain->friction_lb;
        if (!(press_lb > 0.0f))
            break;
        if (press_lb > chain->grit_lb[j] && mr_chain_opening_ft(chain, j) > 0.0f)
            last = j;
    }
    for (unsigned j = last; j > n; j--) {
        /* from the far end towards the wheel: each mat moves by the sum of the gaps that close
         * beyond it */
        float left_lb = compute_thrust_lb(p) - (float)(j - n) * chain->friction_lb;
        /* mat j already has its new position */
        float open_ft = chain->gap_ft[j] + chain->u_ft[j] - shift_ft - chain->u_ft[j - 1u];
        if (left_lb > chain->grit_lb[j] && open_ft > 0.0f)
            shift_ft += open_ft;
        else if (open_ft > 0.0f)
            open_ft = 0.0f;
        chain->u_ft[j - 1u] += shift_ft;
    }
    p->updates += 2u * (last - n) + 1u;
    p->interval_updates += 2u * (last - n) + 1u;
    for (unsigned j = n; j > 1u; j--) {
        float over_ft = mr_chain_opening_ft(chain, j) - chain->slack_ft;
        if (!(over_ft > 0.0f))
            break;
        chain->u_ft[j - 1u] += over_ft;
        p->interval_updates++;
    }
}

static void advance_wheel(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    float push_lb = input->is_on_runway && input->speed_ft_s > 0.0f ? compute_thrust_lb(p) : 0.0f;
    if (p->level == MR_PREDICTOR_PLOUGH) {
        unsigned mat = find_mat_at_station(p, input->wheel_ft);
        if (mat && push_lb > 0.0f && mat != p->ploughed_mat)
            push_joints_closed(p, mat);
        p->ploughed_mat = mat;
        return;
    }
    float step_s = p->chain.step_s, at_ft = input->wheel_ft;
    for (p->pending_s += BLOCK_S; p->pending_s > 0.999f * step_s; p->pending_s -= step_s) {
        at_ft += input->speed_ft_s * step_s;
        mr_chain_step(
            &p->chain,
            push_lb > 0.0f ? find_mat_at_station(p, at_ft - 0.5f * input->speed_ft_s * step_s) : 0,
            push_lb);
    }
    if (!mr_chain_end_block(&p->chain))
        restart_diverged_chain(p);
    update_grits(p);
    uint32_t updates = mr_chain_reset_updates(&p->chain);
    p->updates += updates;
    p->interval_updates += updates;
}

/* Returns the cost of the next better level relative to the present one: twice the mats times twice
 * the steps. */
static uint32_t compute_next_level_cost(const struct mr_predictor *p)
{
    return p->level == MR_PREDICTOR_PLOUGH ? 1u : 4u;
}

/* True if the work of the last second exceeds the budget, or that of this interval exceeds 1.5
 * times its budget. */
static bool is_over_budget(const struct mr_predictor *p, uint32_t budget)
{
    uint64_t second = (uint64_t)p->history_updates + p->interval_updates;
    return p->interval_updates > budget + budget / 2u ||
           second > (uint64_t)budget * MR_PREDICTOR_INTERVALS_PER_S;
}

static void apply_budget(struct mr_predictor *p, bool is_interval_end)
{
    uint32_t per_block = p->config.updates_per_block,
             most = UINT32_MAX / 2u / MR_PREDICTOR_INTERVAL_BLOCKS;
    uint32_t budget = (per_block < most ? per_block : most) * MR_PREDICTOR_INTERVAL_BLOCKS;
    if (p->level > MR_PREDICTOR_PLOUGH)
        return;
    if (p->level < MR_PREDICTOR_PLOUGH && is_over_budget(p, budget)) {
        change_level(p, p->level + 1);
        /* start the budget anew: work at the previous, more expensive level must not count */
        reset_budget(p);
    }
    if (!is_interval_end)
        return;
    bool fits = (p->interval_updates - p->interval_scan_updates) * compute_next_level_cost(p) +
                    p->interval_scan_updates <
                budget;
    p->intervals_within_budget = fits ? p->intervals_within_budget + 1u : 0;
    uint32_t *oldest = &p->interval_history[p->block / MR_PREDICTOR_INTERVAL_BLOCKS %
                                            (MR_PREDICTOR_INTERVALS_PER_S - 1u)];
    p->history_updates += p->interval_updates - *oldest;
    *oldest = p->interval_updates;
    p->interval_updates = p->interval_scan_updates = 0;
    if (p->intervals_within_budget >= INTERVALS_TO_UPGRADE && p->level > p->config.level)
        change_level(p, p->level - 1);
}

void mr_predictor_reduce_level(struct mr_predictor *p)
{
    if (!p->is_armed || p->level >= MR_PREDICTOR_PLOUGH)
        return;
    change_level(p, p->level + 1);
    p->interval_updates = 0;
}

/* Adapts the closing resistance to the work that the springs did in this interval. */
static void adapt_resistance(struct mr_predictor *p)
{
    /* limits the change to a factor of 2 per interval */
    float factor = 1.0f + SCALE_CHANGE_PER_LB_IN * p->work_lb_in;
    p->resistance_scale /= factor < 0.5f ? 0.5f : factor > 2.0f ? 2.0f : factor;
    p->resistance_scale = p->resistance_scale < SCALE_MIN ? SCALE_MIN
                        : p->resistance_scale > SCALE_MAX ? SCALE_MAX
                                                          : p->resistance_scale;
    p->work_lb_in = 0.0f;
    set_grits(p);
    p->interval_updates += p->chain.group_count / MR_PREDICTOR_VISITS_PER_UPDATE;
}

void mr_predictor_on_block(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    if (!p->is_armed)
        return;
    p->block++;
    bool known = is_between(input->wheel_ft, -STATION_MAX_FT, STATION_MAX_FT) &&
                 is_between(input->speed_ft_s, -1.0f, SPEED_MAX_FT_S);
    p->wheel_ft = known ? input->wheel_ft : MR_NAN;
    /* at rest, rounding can make the speed negative */
    p->speed_ft_s = !known ? MR_NAN : input->speed_ft_s > 0.0f ? input->speed_ft_s : 0.0f;
    if (known && input->is_braking_known && input->deceleration_ft_s2 > 0.0f &&
        input->deceleration_ft_s2 <= DECELERATION_MAX_FT_S2) {
        p->deceleration_ft_s2 = input->deceleration_ft_s2;
        p->is_braking_known = true;
    }
    correct_with_springs(p, input);
    if (p->level == MR_PREDICTOR_KINEMATIC || !known)
        return;
    uint32_t before = p->interval_updates;
    bool is_interval_end = p->block % MR_PREDICTOR_INTERVAL_BLOCKS == 0;
    advance_wheel(p, input);
    continue_scan(p);
    if (is_interval_end)
        adapt_resistance(p);
    if (p->interval_updates - before > p->block_updates_max)
        p->block_updates_max = p->interval_updates - before;
    apply_budget(p, is_interval_end);
}

void mr_predictor_end_landing(struct mr_predictor *p)
{
    if (!p->is_armed)
        return;
    if (p->level == MR_PREDICTOR_KINEMATIC || (__builtin_isnan(p->wheel_ft) && p->moved_mask))
        set_gaps_from_readings(p);
    else
        set_gaps_from_chain(p);
    p->is_armed = false;
    p->landing_count++;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        p->surveyed_sum_in[s] = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->model_base_in[i] = 0.0f;
    p->level = p->config.level;
    (void)start_chain(p);
    complete_scan(p);
}

/* --- result --- */

/* Returns the station of the wheel at a position of the search, at least the present station. */
static float get_position_ft(const struct mr_predictor *p, unsigned place, float group_ft)
{
    float at_ft = (float)(place - 1u) * group_ft;
    return at_ft > p->wheel_ft ? at_ft : p->wheel_ft;
}

/* Reports the zone of the last complete search. The future zone is the longer one of that search
 * and the search in progress. */
static void fill_zone(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    const struct mr_zonescan_result *found = &p->scan_result;
    unsigned group = p->scan_result_group, coming = found->future_groups,
             place = found->future_position;
    float group_ft = p->config.chain.mat_length_ft * (float)group;
    zone->compression_lb = p->level == MR_PREDICTOR_PLOUGH && p->speed_ft_s > 0.0f
                             ? compute_thrust_lb(p)
                             : found->compression_lb;
    if (p->speed_ft_s > 0.0f) {
        float ahead_ft = p->config.chain.mat_length_ft * (float)p->chain.mats_per_group;
        zone->future_mats = coming * group;
        zone->future_wheel_ft = coming ? get_position_ft(p, place, group_ft) : MR_NAN;
        if (p->scan.result.future_groups * p->chain.mats_per_group > zone->future_mats) {
            zone->future_mats = p->scan.result.future_groups * p->chain.mats_per_group;
            zone->future_wheel_ft = get_position_ft(p, p->scan.result.future_position, ahead_ft);
        }
    }
    unsigned first = found->first_joint, end = found->first_joint + found->groups;
    unsigned wheel = p->wheel_ft > 0.0f && p->wheel_ft < 1e6f
                       ? (unsigned)(p->wheel_ft / group_ft) + 2u
                       : 0;
    first = first < wheel ? wheel : first; /* the wheel has moved since the search */
    if (!found->groups || first >= end)
        return;
    zone->mats = (end - first) * group;
    zone->start_ft = (float)(first - 1u) * group_ft;
    zone->end_ft = (float)(end - 1u) * group_ft;
    unsigned passed = (first - found->first_joint) * group, closed = found->closed_joints * group;
    zone->closed_joints = closed > passed + 2u ? closed - passed : 2u;
    zone->mean_gap_in = IN_PER_FT * found->opening_sum_ft / (float)((found->groups + 1u) * group);
}

static void fill_kinematic_zone(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    struct mr_closure_zone found;
    float remaining_in[MR_SEGMENTS];
    mr_predictor_find_kinematic_zone(p, &found, remaining_in);
    zone->mats = zone->future_mats = found.mats;
    zone->start_ft = found.start_ft;
    zone->end_ft = found.end_ft;
    zone->closed_joints = found.mats ? found.mats + 1u : 0;
    zone->future_wheel_ft = found.start_ft;
    zone->mean_gap_in = found.mats ? 0.5f * MR_CLOSED_SEGMENT_MAX_IN / (float)MR_MATS_PER_SEGMENT
                                   : 0.0f;
}

static void set_zone_basis(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    float low_ft = MR_NAN, high_ft = MR_NAN;
    unsigned surveyed = 0, segments = 0;
    bool any = false;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        bool fitted = !__builtin_isnan(p->config.station_ft[i]);
        if (!fitted || p->doubt[i] != MR_PREDICTOR_TRUSTED ||
            (p->block && __builtin_isnan(p->last_reading_in[i])))
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
        surveyed += __builtin_isnan(p->surveyed_sum_in[s]) ? 0u : 1u;
    }
    zone->basis |= !any ? MR_PREDICTOR_NO_TRANSDUCER : 0u;
    zone->basis |= any && zone->mats && zone->start_ft >= low_ft && zone->end_ft <= high_ft
                     ? MR_PREDICTOR_BRACKETED
                     : 0u;
    zone->basis |= segments && 2u * surveyed > segments ? MR_PREDICTOR_SURVEY : 0u;
    zone->basis |= p->is_degraded ? MR_PREDICTOR_DEGRADED : 0u;
    zone->basis |= p->has_restarted ? MR_PREDICTOR_RESTARTED : 0u;
}

/* Standard errors of a zone's ends in mats: 95 % points of the errors in `make score`, series 0 to
 * 309, divided by 1.96 (tests/score/README.md). They are valid only for zones of at least 30 mats.
 * The first four values are without a survey, the last four with one. Start: outside the
 * transducers, at the wheel or ahead of it; between the transducers, likewise. End: within
 * NEAR_TRANSDUCER_FT beyond a valid transducer; farther, with another transducer beyond the end;
 * farther, without one; within NEAR_RUNWAY_END_FT of the runway's end. */
static const float start_error_mats[MR_PREDICTOR_START_CLASSES] = {3.83f, 21.17f, 0.77f, 19.13f,
                                                                   1.28f, 10.97f, 0.77f, 6.89f};
static const float end_error_mats[MR_PREDICTOR_END_CLASSES] = {16.07f, 17.60f, 23.21f, 10.97f,
                                                               9.95f,  15.05f, 12.50f, 8.42f};

/* Factors by which the errors above are multiplied at each level. They are 1 for the levels TWO and
 * FOUR, larger for the levels without the chain model (tests/score/README.md). */
#define LEVEL_COUNT (MR_PREDICTOR_KINEMATIC + 1)
static const float start_error_factor_by_level[LEVEL_COUNT] = {1.0f, 1.0f, 1.0f, 1.2f, 1.7f},
                   end_error_factor_by_level[LEVEL_COUNT] = {1.0f, 1.0f, 1.0f, 1.2f, 2.0f};

static uint8_t classify_end(const struct mr_predictor *p, const struct mr_predictor_zone *zone)
{
    float runway_ft = p->config.chain.mat_length_ft * (float)p->config.chain.mats;
    bool near = false, beyond = false;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        float past_ft = zone->end_ft - p->config.station_ft[i];
        if (__builtin_isnan(p->last_reading_in[i])) /* also NaN if the transducer is not fitted */
            continue;
        near = near || (past_ft >= 0.0f && past_ft < NEAR_TRANSDUCER_FT);
        beyond = beyond || past_ft < 0.0f;
    }
    return zone->end_ft > runway_ft - NEAR_RUNWAY_END_FT ? 3u : near ? 0u : beyond ? 1u : 2u;
}

static void set_zone_errors(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    unsigned surveyed = zone->basis & MR_PREDICTOR_SURVEY ? 4u : 0u,
             between = zone->basis & MR_PREDICTOR_BRACKETED ? 2u : 0u;
    /* the start is less certain if it is ahead of the wheel or if the level is a coarser one */
    bool ahead = zone->distance_ft > AT_WHEEL_MAX_FT || zone->level != MR_PREDICTOR_FULL;
    float mat_ft = p->config.chain.mat_length_ft;
    zone->start_error_class = (uint8_t)(surveyed + between + ahead);
    zone->end_error_class = (uint8_t)(surveyed + classify_end(p, zone));
    zone->start_error_ft = mat_ft * start_error_factor_by_level[zone->level] *
                           start_error_mats[zone->start_error_class];
    zone->end_error_ft = mat_ft * end_error_factor_by_level[zone->level] *
                         end_error_mats[zone->end_error_class];
}

static void set_zone_verdict(struct mr_predictor_zone *zone)
{
    if (zone->future_mats >= MR_PREDICTOR_WARNING_MATS) {
        zone->verdict = MR_PREDICTOR_WARNING;
        zone->reason = zone->mats >= MR_PREDICTOR_WARNING_MATS ? MR_PREDICTOR_LONG_ZONE
                                                               : MR_PREDICTOR_GROWING_ZONE;
    } else if (zone->future_mats >= MR_PREDICTOR_ADVISORY_MATS) {
        zone->verdict = MR_PREDICTOR_ADVISORY;
        zone->reason = zone->mats >= MR_PREDICTOR_ADVISORY_MATS ? MR_PREDICTOR_LONG_ZONE
                                                                : MR_PREDICTOR_GROWING_ZONE;
    }
}

void mr_predictor_get_zone(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    bool unmoved = __builtin_isnan(p->wheel_ft) || __builtin_isnan(p->speed_ft_s);
    *zone = (struct mr_predictor_zone){.level = p->level,
                                       .future_wheel_ft = MR_NAN,
                                       .distance_ft = MR_NAN,
                                       .lead_s = MR_NAN,
                                       .start_error_ft = MR_NAN,
                                       .end_error_ft = MR_NAN};
    zone->critical_lb = p->config.mat_weight_lb * p->config.chain.mat_length_ft /
                        (2.0f * p->config.bump_ft);
    zone->age_blocks = p->block - p->corrected_block;
    if (p->level == MR_PREDICTOR_KINEMATIC || (unmoved && p->moved_mask)) {
        zone->level = MR_PREDICTOR_KINEMATIC;
        fill_kinematic_zone(p, zone);
    } else {
        fill_zone(p, zone);
    }
    zone->basis = unmoved ? MR_PREDICTOR_NO_MOTION : 0u;
    set_zone_basis(p, zone);
    if (zone->mats) {
        float distance_ft = zone->start_ft - p->wheel_ft;
        zone->distance_ft = distance_ft < 0.0f ? 0.0f : distance_ft;
        /* there are no valid errors for the level KINEMATIC */
        if (zone->level != MR_PREDICTOR_KINEMATIC)
            set_zone_errors(p, zone);
        if (!unmoved)
            zone->lead_s = mr_closure_compute_lead_s(zone->distance_ft, p->speed_ft_s,
                                                     p->deceleration_ft_s2);
    }
    set_zone_verdict(zone);
}
