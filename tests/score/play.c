#include <math.h>
#include <string.h>

#include "common/closure.h"
#include "common/gates.h"
#include "common/predictor.h"
#include "tests/host/predictor_case.h"
#include "tests/score/score.h"

#define NOISE_IN                0.0015
#define GAIN_ERROR              0.001
#define SURVEY_READING_ERROR_IN 0.005
#define SWITCH_ERROR_FT         (0.02 / 12.0)
#define TOLD_TOUCHDOWN_FT       3.0
#define CLOSED_HMIL             100
#define LOOK_AHEAD_FT           40.0f
#define LAID_SUM_IN             0.175f /* ten gaps evenly up to 0.036 in, none beyond 0.030 */
/* so long after it, an edge has its name (common/switches.h) */
#define GEAR_EDGE_NAMED_S       0.005

/* The gear as a board knows it in the course of a landing: from the switch edges that it has named
 * so far (common/onboard/landing.c does the same, from blocks). Feet and seconds. */
struct known_gear {
    size_t gates, beyond;             /* named so far; of them, beyond touchdown */
    struct mr_motion_estimate motion; /* at the last gate */
    bool known;
};

/* Takes the gates named by t_s; true: there was a new one. `gate`: all of the landing, in order,
 * always the same ones; `gear` all 0 before the first call, t_s never decreasing. */
static bool gear_take(struct known_gear *gear, const struct mr_gate *gate, size_t gates,
                      double touchdown_ft, double switch_error_ft, double t_s)
{
    size_t before = gear->gates;
    while (gear->gates < gates && gate[gear->gates].t_s + GEAR_EDGE_NAMED_S <= t_s)
        gear->beyond += gate[gear->gates++].station_ft >= touchdown_ft;
    if (gear->gates == before)
        return false;
    /* Braking begins at touchdown: gates on the track would bend the parabola, so two beyond it
     * replace them. */
    size_t skip = gear->beyond >= 2 ? gear->gates - gear->beyond : 0;
    gear->known = mr_gates_latest_motion(gate + skip, gear->gates - skip, switch_error_ft,
                                         &gear->motion) == MR_OK;
    return true;
}

/* The predictor's input of t_s but for its displacements: carried on from the last gate, until it
 * stops. NaN: not known. */
static void gear_tell(const struct known_gear *gear, double touchdown_ft, double t_s,
                      struct mr_predictor_input *input)
{
    input->wheel_ft = input->speed_ft_s = input->deceleration_ft_s2 = NAN;
    input->is_braking_known = input->is_on_runway = false;
    if (!gear->known)
        return;
    double v = gear->motion.speed_ft_s.value, a = gear->motion.deceleration_ft_s2.value;
    input->is_braking_known = gear->beyond >= 3 && !isnan(a);
    a = isnan(a) ? 0.0 : a;
    double since_s = t_s - gear->motion.t_s;
    if (a > 0.0 && since_s > v / a)
        since_s = v / a;
    input->wheel_ft = (float)(gear->motion.position_ft.value + (v - 0.5 * a * since_s) * since_s);
    input->speed_ft_s = (float)(v - a * since_s);
    input->deceleration_ft_s2 = (float)a;
    input->is_on_runway = (double)input->wheel_ft >= touchdown_ft;
}

struct score_zone score_longest(const uint16_t *gap_counts, double from_ft)
{
    struct score_zone best = {0, 0};
    int from = from_ft > 0.0 ? (int)ceil(from_ft / SCORE_MAT_FT) : 0;
    for (int first = from; first < SCORE_JOINTS; first++) {
        int last_open = first - 10;
        if (gap_counts[first] > CLOSED_HMIL)
            continue;
        for (int j = first + 1; j < SCORE_JOINTS; j++) {
            if (gap_counts[j] > CLOSED_HMIL) {
                if (j - last_open < 10)
                    break;
                last_open = j;
            } else if (j - first > best.last - best.first) {
                best = (struct score_zone){(int16_t)first, (int16_t)j};
            }
        }
    }
    return best;
}

/* Eight transducers as they are, drawn once a series. */
struct rig {
    float station_ft[MR_TRANSDUCERS];
    double gain[MR_TRANSDUCERS];
    bool missing[MR_TRANSDUCERS];
};

static void draw_rig(struct rig *rig, unsigned view, uint64_t *state)
{
    bool some = score_uniform(state) < 0.3;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        rig->station_ft[i] = view & SCORE_UPFIELD ? 10.0f * (float)(i + 1)
                                                  : 40.0f + 10.0f * (float)i;
        rig->gain[i] = 1.0 + GAIN_ERROR * score_normal(state);
        rig->missing[i] = (score_uniform(state) < 0.25 && some) || view & SCORE_BLIND ||
                          (view & SCORE_HALF && i % 2);
        if (view & SCORE_UPFIELD && i == 7)
            rig->station_ft[i] = NAN; /* 10 to 70 is seven */
    }
}

void score_read_survey(const struct score_landing *landing, float *sum_in, uint64_t *state)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        double sum = SURVEY_READING_ERROR_IN * score_normal(state);
        for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++)
            sum += (double)landing->gap_in[s * MR_MATS_PER_SEGMENT + j];
        sum_in[s] = sum > 0.0 ? (float)sum : 0.0f;
    }
}

static void read_transducers(const struct score_landing *landing, const struct rig *rig,
                             unsigned ms, float *reading_in, uint64_t *state)
{
    unsigned row = ms / SCORE_ROW_MS;
    double part = (double)(ms % SCORE_ROW_MS) / SCORE_ROW_MS;
    if (row + 1 >= landing->rows) {
        row = landing->rows - 2;
        part = 1.0;
    }
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        reading_in[i] = NAN;
        if (isnan(rig->station_ft[i]) || rig->missing[i])
            continue;
        unsigned s = (unsigned)(rig->station_ft[i] / 10.0f + 0.5f) - 1u;
        double u = (1.0 - part) * (double)landing->u_in[row][s] +
                   part * (double)landing->u_in[row + 1][s];
        reading_in[i] = (float)(u * rig->gain[i] + NOISE_IN * score_normal(state));
    }
}

/* Gates as the firmware has them. */
static size_t take_gates(const struct score_landing *landing, struct mr_gate *gate)
{
    for (size_t i = 0; i < landing->edges; i++)
        gate[i] = (struct mr_gate){(double)landing->edge_s[i], (double)landing->edge_ft[i]};
    return landing->edges;
}

static struct score_zone said_zone(unsigned mats, float start_ft)
{
    int first = (int)(start_ft / (float)SCORE_MAT_FT + 0.5f);
    return (struct score_zone){(int16_t)first, (int16_t)(first + (int)mats)};
}

struct player {
    const struct score_truth *truth;
    const struct score_sink *sink;
    unsigned view;
    struct rig rig;
    struct mr_predictor predictor;
    float slack_in[MR_SEGMENTS], left_in[MR_SEGMENTS]; /* of the kinematic method */
    uint64_t noise;
};

static double event_of(const struct score_landing *landing, struct score_zone *zones, int16_t *most)
{
    double event_s = (double)NAN;
    for (unsigned k = 0; k < landing->looks; k++) {
        double wheel_ft = (double)landing->wheel_ft[k];
        zones[k] = score_longest(landing->gap_counts[k], wheel_ft);
        double near_ft = zones[k].first * SCORE_MAT_FT - wheel_ft;
        bool at_it = wheel_ft > 0.0 && near_ft < SCORE_EVENT_FT &&
                     (double)landing->speed_at_ft_s[k] > SCORE_SLOW_FT_S;
        int16_t mats = (int16_t)(zones[k].last - zones[k].first);
        if (at_it && mats > *most)
            *most = mats;
        if (isnan(event_s) && at_it && mats >= SCORE_EVENT_MATS)
            event_s = 1e-3 * SCORE_LOOK_MS * k;
    }
    return event_s;
}

double score_event_s(const struct score_landing *landing, int16_t *most_mats)
{
    static struct score_zone zones[SCORE_LOOKS_MAX];
    int16_t most = 0;
    double event_s = event_of(landing, zones, &most);
    if (most_mats)
        *most_mats = most;
    return event_s;
}

static void rank_waves(const struct player *player, const struct score_landing *landing, double t_s,
                       const struct mr_predictor_zone *zone, const struct mr_closure_zone *closed,
                       struct score_outcome *outcome)
{
    const float by[SCORE_WAVE_RANKS] = {(float)zone->future_mats, zone->compression_lb,
                                        player->predictor.deceleration_ft_s2,
                                        (float)landing->number, (float)closed->mats};
    if (isnan(outcome->advised_s) && zone->verdict != MR_PREDICTOR_QUIET &&
        !(t_s > (double)landing->wave_s))
        outcome->advised_s = (float)t_s;
    for (unsigned r = 0;
         r < SCORE_WAVE_RANKS && !(t_s > 0.0 && t_s > (double)landing->wave_s - SCORE_AHEAD_S); r++)
        outcome->wave_rank[r] = fmaxf(outcome->wave_rank[r], by[r]);
}

/* One look: what both methods say, beside the truth. */
static void look(struct player *player, const struct score_landing *landing, unsigned k,
                 const struct score_zone *zones, const struct mr_predictor_input *input,
                 struct score_outcome *outcome)
{
    double t_s = 1e-3 * SCORE_LOOK_MS * k;
    struct mr_predictor_zone zone;
    struct mr_closure_zone closed;
    mr_predictor_get_zone(&player->predictor, &zone);
    const struct mr_closure_input kinematic = {.station_ft = player->rig.station_ft,
                                               .displacement_in = input->displacement_in,
                                               .slack_in = player->slack_in,
                                               .wheel_ft = input->wheel_ft};
    mr_closure_find_zone(&kinematic, &closed, player->left_in);
    rank_waves(player, landing, t_s, &zone, &closed, outcome);
    if (!(t_s > (double)outcome->event_s) && !(t_s > (double)outcome->wave_s)) {
        if (isnan(outcome->warned_s[SCORE_PREDICTOR]) && zone.verdict == MR_PREDICTOR_WARNING)
            outcome->warned_s[SCORE_PREDICTOR] = (float)t_s;
        if (isnan(outcome->warned_s[SCORE_KINEMATIC]) && closed.mats >= SCORE_EVENT_MATS &&
            !(closed.start_ft - input->wheel_ft > LOOK_AHEAD_FT))
            outcome->warned_s[SCORE_KINEMATIC] = (float)t_s;
    }
    outcome->rank[SCORE_BY_HINDSIGHT] = fmaxf(outcome->rank[SCORE_BY_HINDSIGHT],
                                              player->predictor.deceleration_ft_s2);
    if (k == 0 || !(t_s > (double)outcome->event_s - SCORE_AHEAD_S)) {
        float by[SCORE_RANKS] = {(float)zone.future_mats, player->predictor.deceleration_ft_s2,
                                 (float)landing->number, (float)closed.mats};
        for (unsigned r = 0; r < SCORE_BY_HINDSIGHT; r++)
            outcome->rank[r] = fmaxf(outcome->rank[r], by[r]);
    }
    if (isnan(input->wheel_ft) || !(landing->speed_at_ft_s[k] > (float)SCORE_SLOW_FT_S) ||
        landing->wheel_ft[k] < 12.5f)
        return;
    for (unsigned m = 0; m < SCORE_METHODS; m++) {
        struct score_look seen = {.truth = zones[k],
                                  .start_error = NAN,
                                  .end_error = NAN,
                                  .series = (uint16_t)player->truth->series.number,
                                  .landing = (uint8_t)landing->number,
                                  .view = (uint8_t)player->view,
                                  .method = (uint8_t)m};
        seen.said = m == SCORE_PREDICTOR ? said_zone(zone.mats, zone.start_ft)
                                         : said_zone(closed.mats, closed.start_ft);
        if (m == SCORE_PREDICTOR) {
            seen.start_error = zone.start_error_ft / (float)SCORE_MAT_FT;
            seen.end_error = zone.end_error_ft / (float)SCORE_MAT_FT;
            seen.start_class = zone.start_error_class;
            seen.end_class = zone.end_error_class;
        }
        player->sink->look(player->sink->ctx, &seen);
    }
}

static void play_landing(struct player *player, const struct score_landing *landing)
{
    static struct score_zone zones[SCORE_LOOKS_MAX];
    struct score_outcome outcome = {.series = (uint16_t)player->truth->series.number,
                                    .landing = (uint8_t)landing->number,
                                    .view = (uint8_t)player->view,
                                    .wave_s = landing->wave_s,
                                    .warned_s = {NAN, NAN},
                                    .advised_s = NAN,
                                    .known_s = NAN};
    struct mr_gate gate[MR_GATES_MAX];
    size_t gates = take_gates(landing, gate);
    struct known_gear gear = {0};
    struct mr_predictor_input input;
    outcome.event_s = (float)event_of(landing, zones, &outcome.most_mats);
    if (player->view & SCORE_SURVEYED && (landing->number == 1 || !(player->view & SCORE_ONCE))) {
        score_read_survey(landing, player->slack_in, &player->noise);
        mr_predictor_set_survey(&player->predictor, player->slack_in);
    } else {
        for (unsigned s = 0; s < MR_SEGMENTS; s++)
            player->slack_in[s] = landing->number == 1 ? LAID_SUM_IN : player->left_in[s];
    }
    mr_predictor_arm(&player->predictor);
    if (player->sink->armed)
        player->sink->armed(player->sink->ctx, &player->predictor, landing);
    unsigned last = isnan(landing->wave_s) ? (unsigned)(landing->stop_s * 1000.0) + 300u
                                           : (unsigned)(landing->wave_s * 1000.0f);
    for (unsigned ms = 0; ms < last; ms++) {
        double t_s = 1e-3 * ms;
        gear_take(&gear, gate, gates, TOLD_TOUCHDOWN_FT, SWITCH_ERROR_FT, t_s);
        gear_tell(&gear, TOLD_TOUCHDOWN_FT, t_s, &input);
        if (isnan(outcome.known_s) && input.is_braking_known)
            outcome.known_s = (float)t_s;
        read_transducers(landing, &player->rig, ms, input.displacement_in, &player->noise);
        if (ms % SCORE_LOOK_MS == 0 && ms / SCORE_LOOK_MS < landing->looks)
            look(player, landing, ms / SCORE_LOOK_MS, zones, &input, &outcome);
        mr_predictor_on_block(&player->predictor, &input);
        if (player->sink->block)
            player->sink->block(player->sink->ctx, &player->predictor, &input, ms);
    }
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        outcome.doubted =
            (uint8_t)(outcome.doubted + (player->predictor.doubt[i] > MR_PREDICTOR_MISSING));
    outcome.updates = (float)player->predictor.updates;
    mr_predictor_end_landing(&player->predictor);
    player->sink->outcome(player->sink->ctx, &outcome);
}

void score_play(const struct score_truth *truth, unsigned view, unsigned level,
                const struct score_sink *sink)
{
    static struct player player;
    const struct score_series *series = &truth->series;
    memset(&player, 0, sizeof player);
    player.truth = truth;
    player.sink = sink;
    player.view = view;
    player.noise = 0xd15ea5e0000u + 8u * series->number + view;
    draw_rig(&player.rig, view, &player.noise);
    struct mr_predictor_config config = case_rig();
    config.chain.friction_lb = (float)CASE_MAT_LB * (float)series->told_friction;
    config.level = (enum mr_predictor_level)level;
    memcpy(config.station_ft, player.rig.station_ft, sizeof config.station_ft);
    if (mr_predictor_start(&player.predictor, &config) != MR_OK)
        return;
    for (uint32_t i = 0; i < series->landings; i++)
        play_landing(&player, &truth->landing[i]);
}
