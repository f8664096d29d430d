#include "tests/score/truth.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/sim/scene/scene.h"
#include "host/sim/sim.h"

#define STEP_S          2.5e-5
#define ELASTIC_STEP_S  5e-5
#define G_FT_S2         32.174
#define GEAR_LB         1300.0
#define AXLES           12.0
#define MAT_LB          0.466
#define SLACK_IN        0.030
#define GAP_MOST_IN     0.036
#define PLANAR_STEP_S   5e-5
/* heights of the ground at the joints, evenly up to this: 0.043 in */
#define IRREGULAR_FT    0.0036
#define WAVE_FT         0.05 /* host/sim calls no less a bow wave */
#define FOLD_TRIES      5
#define FOLD_S          5e-3
#define NODE_S          1e-3
#define AFTER_STOP_S    0.3
#define LOOK_MOST_FT    118.0 /* the runway ends at 120 ft */
#define LEAD_S          0.4   /* rolling on the track before touchdown */
#define SWITCH_ERROR_FT (0.02 / 12.0)

/* Kinds of truth: what each changes of the first one, whose zeros change nothing. */
static const struct kind {
    const char *name; /* of its files */
    uint32_t version; /* of its files; a truth of another one is computed anew */
    bool planar, elastic, late;
    /* so many of the joints are open by no more than that; the others as they would be */
    double shut_share, shut_most_in;
    /* runs of joints, alternately open by no more than that and by no less than the other */
    double patch_mats[2], patch_most_in, patch_least_in;
    double tail; /* exponent of Pareto's distribution that closing resistances have */
    /* anti-skid: a second, what is left of the braking, for what part of the time */
    double pulse_hz[2], pulse_left[2], pulse_part[2];
} kinds[SCORE_KINDS] = {
    [SCORE_CHAIN] = {.name = "truth", .version = 7},
    [SCORE_PLANAR] = {.name = "planar", .version = 8, .planar = true},
    [SCORE_ELASTIC] = {.name = "elastic", .version = 9, .elastic = true},
    [SCORE_LATE] = {.name = "late", .version = 10, .late = true},
    [SCORE_SHUT] = {.name = "shut", .version = 1, .shut_share = 0.8, .shut_most_in = 0.004},
    [SCORE_PATCHY] = {.name = "patchy",
                      .version = 1,
                      .patch_mats = {5.0, 40.0},
                      .patch_most_in = 0.010,
                      .patch_least_in = 0.020},
    [SCORE_HEAVY] = {.name = "heavy", .version = 1, .tail = 1.5},
    [SCORE_PULSED] = {.name = "pulsed",
                      .version = 1,
                      .pulse_hz = {3.0, 8.0},
                      .pulse_left = {0.2, 0.5},
                      .pulse_part = {0.25, 0.45}},
};
#define TAIL_MOST    20.0 /* of the mean: no joint resists more */
#define PULSE_EDGE_S 0.015

const char *score_kind_name(enum score_kind kind)
{
    return kind == SCORE_CHAIN ? "chain" : kinds[kind].name;
}

enum score_kind score_kind_find(const char *name)
{
    unsigned kind = 0;
    while (kind < SCORE_KINDS && strcmp(name, score_kind_name((enum score_kind)kind)) != 0)
        kind++;
    return (enum score_kind)kind;
}

double score_uniform(uint64_t *state)
{
    return mr_splitmix64_uniform(state);
}

double score_normal(uint64_t *state)
{
    double u = 1.0 - score_uniform(state);
    return sqrt(-2.0 * log(u)) * cos(6.283185307179586 * score_uniform(state));
}

static double between(uint64_t *state, double low, double high)
{
    return low + (high - low) * score_uniform(state);
}

static double draw_grit_lb(const struct score_series *series, uint64_t *state)
{
    double m = series->grit_mean_lb;
    switch (series->grit_shape) {
    case 1: return -m * log(1.0 - score_uniform(state));
    case 2: return m * (score_uniform(state) + score_uniform(state));
    case 3: return score_uniform(state) < 0.25 ? 0.0 : between(state, 0.0, 2.0 * m / 0.75);
    default: return between(state, 0.0, 2.0 * m);
    }
}

static void draw_series(struct score_series *series, uint32_t number, uint64_t *state)
{
    *series = (struct score_series){.number = number};
    series->landings = 1u + (uint32_t)(SCORE_LANDINGS * score_uniform(state));
    series->friction = between(state, 0.4, 0.9);
    series->told_friction = series->friction * fmax(0.5, 1.0 + 0.1 * score_normal(state));
    series->kl_lb_ft = 2.9e5 * exp(between(state, -0.5, 0.4));
    series->cl_lb_s_ft = between(state, 2.0, 10.0);
    series->thrust_share = between(state, 0.7, 1.3);
    series->grit_mean_lb = 10.0 * exp(between(state, -0.6, 0.4));
    series->grit_shape = (uint32_t)(4.0 * score_uniform(state));
    series->touchdown_ft = between(state, 2.0, 4.0);
}

/* The gear: rolls on, brakes from touchdown with an onset, a change from one deceleration to
 * another, and a ripple. */
struct gear {
    double v0_ft_s, touchdown_ft, touchdown_s;
    double first_ft_s2, last_ft_s2, bend_from_s, bend_to_s, onset_s;
    double ripple[3], ripple_hz[3], turn[3];
    double pulse_hz, pulse_left, pulse_part;
};

/* Of the braking, 1 on the mean. */
static double pulse_of(const struct gear *gear, double since_s)
{
    double edge = PULSE_EDGE_S * gear->pulse_hz, mean = gear->pulse_part - edge,
           most = (1.0 - gear->pulse_left * mean) / (1.0 - mean),
           at = fmod(since_s * gear->pulse_hz, 1.0),
           deep = fmin(fmax(fmin(at, gear->pulse_part - at) / edge, 0.0), 1.0);
    return most + deep * (gear->pulse_left - most);
}

static double braking_ft_s2(const struct gear *gear, double t_s)
{
    double since_s = t_s - gear->touchdown_s;
    if (since_s <= 0.0)
        return 0.0;
    double onset = fmin(since_s / gear->onset_s, 1.0);
    double bend =
        fmin(fmax((since_s - gear->bend_from_s) / (gear->bend_to_s - gear->bend_from_s), 0.0), 1.0);
    double wave = 1.0;
    for (int i = 0; i < 3; i++)
        wave += gear->ripple[i] *
                sin(6.283185307179586 * (gear->ripple_hz[i] * since_s + gear->turn[i]));
    double a_ft_s2 = onset * onset * (3.0 - 2.0 * onset) *
                     (gear->first_ft_s2 + bend * (gear->last_ft_s2 - gear->first_ft_s2)) * wave *
                     (gear->pulse_hz > 0.0 ? pulse_of(gear, since_s) : 1.0);
    return a_ft_s2;
}

static void draw_gear(struct gear *gear, const struct score_series *series, uint64_t *state)
{
    gear->v0_ft_s = between(state, 24.0, 40.0);
    gear->touchdown_ft = series->touchdown_ft;
    gear->touchdown_s = LEAD_S;
    double stop_ft = between(state, 55.0, 114.0), ratio = between(state, 0.8, 1.6);
    double mean_ft_s2 = gear->v0_ft_s * gear->v0_ft_s / (2.0 * (stop_ft - gear->touchdown_ft));
    gear->first_ft_s2 = mean_ft_s2 * 2.0 / (1.0 + ratio);
    gear->last_ft_s2 = gear->first_ft_s2 * ratio;
    gear->bend_from_s = between(state, 0.2, 2.0);
    gear->bend_to_s = gear->bend_from_s + between(state, 0.3, 3.0);
    gear->onset_s = between(state, 0.03, 0.1);
    gear->pulse_hz = 0.0;
    for (int i = 0; i < 3; i++) {
        gear->ripple[i] = between(state, 0.003, 0.02);
        gear->ripple_hz[i] = between(state, 0.5, 6.0);
        gear->turn[i] = score_uniform(state);
    }
}

/* Light, then hard: for 30 to 70 % of the way a third to two thirds of what would stop it evenly;
 * then what still stops it there. */
static void brake_late(struct gear *gear, uint64_t *state)
{
    double v0_ft_s = gear->v0_ft_s, stop_ft = between(state, 60.0, 114.0) - gear->touchdown_ft,
           mean_ft_s2 = v0_ft_s * v0_ft_s / (2.0 * stop_ft),
           light_ft = between(state, 0.3, 0.7) * stop_ft;
    gear->first_ft_s2 = between(state, 0.33, 0.67) * mean_ft_s2;
    double v1_ft_s = sqrt(v0_ft_s * v0_ft_s - 2.0 * gear->first_ft_s2 * light_ft);
    gear->last_ft_s2 = v1_ft_s * v1_ft_s / (2.0 * (stop_ft - light_ft));
    gear->bend_from_s = (v0_ft_s - v1_ft_s) / gear->first_ft_s2;
    gear->bend_to_s = gear->bend_from_s + between(state, 0.1, 0.3);
}

/* The brake lets go and takes hold again, so many times a second. */
static void brake_in_pulses(struct gear *gear, const struct kind *kind, uint32_t number,
                            uint32_t landing)
{
    uint64_t state = 0x9b150000u + 8u * number + landing;
    gear->pulse_hz = between(&state, kind->pulse_hz[0], kind->pulse_hz[1]);
    gear->pulse_left = between(&state, kind->pulse_left[0], kind->pulse_left[1]);
    gear->pulse_part = between(&state, kind->pulse_part[0], kind->pulse_part[1]);
}

static void note_braking(const struct gear *gear, struct score_landing *landing)
{
    landing->plan_time_s[0] = 0.0f;
    landing->plan_time_s[1] = (float)gear->bend_from_s;
    landing->plan_time_s[2] = (float)gear->bend_to_s;
    landing->plan_deceleration_ft_s2[0] = landing->plan_deceleration_ft_s2[1] =
        (float)gear->first_ft_s2;
    landing->plan_deceleration_ft_s2[2] = (float)gear->last_ft_s2;
}

/* Path of the thrust, looks and edges. */
static void roll(struct score_landing *landing, const struct gear *gear,
                 const struct score_series *series, struct sim_path_row *rows, size_t *count,
                 uint64_t *state)
{
    double at_ft = gear->touchdown_ft - LEAD_S * gear->v0_ft_s, v_ft_s = gear->v0_ft_s;
    double switch_ft[SCORE_SWITCHES];
    unsigned next = 0;
    for (unsigned i = 0; i < SCORE_SWITCHES; i++)
        switch_ft[i] = -2.5 + 5.0 * i + SWITCH_ERROR_FT * (2.0 * score_uniform(state) - 1.0);
    *count = 0;
    landing->speed_ft_s = gear->v0_ft_s;
    landing->touchdown_s = LEAD_S;
    for (unsigned k = 0; v_ft_s > 0.0; k++) {
        double t_s = NODE_S * k, a = braking_ft_s2(gear, t_s + 0.5 * NODE_S);
        if (k % SCORE_LOOK_MS == 0 && landing->looks < SCORE_LOOKS_MAX && at_ft < LOOK_MOST_FT) {
            landing->wheel_ft[landing->looks] = (float)at_ft;
            landing->speed_at_ft_s[landing->looks++] = (float)v_ft_s;
        }
        /* rows are joined by straight lines; from 0 on, or the run, and with it its samples, would
         * begin where the runway does */
        if (k == 0 || (k % 5 == 0 && at_ft > 0.0 && at_ft < SCORE_MATS * SCORE_MAT_FT))
            rows[(*count)++] = (struct sim_path_row){t_s, at_ft,
                                                     series->thrust_share * GEAR_LB / AXLES *
                                                         braking_ft_s2(gear, t_s) / G_FT_S2};
        double to_ft = at_ft + v_ft_s * NODE_S - 0.5 * a * NODE_S * NODE_S;
        for (; next < SCORE_SWITCHES && switch_ft[next] <= to_ft; next++) {
            if (switch_ft[next] < at_ft)
                continue;
            landing->edge_s[landing->edges] =
                (float)(t_s + NODE_S * (switch_ft[next] - at_ft) / (to_ft - at_ft));
            landing->edge_ft[landing->edges++] = (float)(-2.5 + 5.0 * next);
        }
        at_ft = to_ft;
        v_ft_s -= a * NODE_S;
        landing->stop_s = t_s + NODE_S;
        landing->stop_ft = at_ft;
    }
    rows[*count] = (struct sim_path_row){landing->stop_s, at_ft, 0.0};
    (*count)++;
}

/* Mats that heave and turn, joints that transmit moment and shear, over-damped soil, on ground that
 * is uneven under the nodes: the same in all landings of a series. */
static void make_planar(struct sim_scene *scene, uint32_t number)
{
    static double heights_ft[SCORE_JOINTS];
    uint64_t state = 0x640d0000u + number;
    for (int j = 0; j < SCORE_JOINTS; j++)
        heights_ft[j] = IRREGULAR_FT * score_uniform(&state);
    scene->model = SIM_MODEL_CONSISTENT;
    scene->inertia_slug_ft2 = 1.19e-4;
    scene->kv_lb_ft = 1.3e4;
    scene->cv_lb_s_ft = 60.0;
    scene->kt_lb_ft_rad = 41.6;
    scene->ct_lb_ft_s_rad = 1.6e-4;
    scene->tad_deg = 7.0;
    sim_scene_set_list(&scene->ground_ft, heights_ft, SCORE_JOINTS);
}

/* Ground and gear of another rig than the one that host/landing_series's elastic ground was fitted
 * to: stiffness within 1.5 times of that, what springs back, the length that an axle presses and
 * where the lines stand are drawn. */
static void make_elastic(struct sim_scene *scene, uint32_t number)
{
    uint64_t state = 0xe1a50000u + number;
    static const double axles[] = {1.0, 2.0, 1.0, 2.0};
    double lines_ft[] = {0.0, between(&state, 0.6, 1.0), between(&state, 2.3, 2.9),
                         between(&state, 3.1, 3.7)};
    const struct sim_key *key = sim_key_find("gear_k_lb_ft");
    *(double *)(void *)((char *)scene + key->offset) = 7000.0 * exp(between(&state, -0.4, 0.4));
    scene->wheel_load_lb = GEAR_LB / AXLES;
    scene->gear.recovered_share = between(&state, 0.5, 1.0);
    scene->gear.axle_exponent = between(&state, 0.5, 1.0);
    scene->gear.axle_length_ft = between(&state, 0.2, 0.4);
    sim_scene_set_list(&scene->gear.line_setbacks_ft, lines_ft, 4);
    sim_scene_set_list(&scene->gear.axle_counts, axles, 4);
}

/* Runs a scene. A wave that grows until a mat stands upright ends a run without numbers: then the
 * same again, until just before. With another end its step is a little different, and the wave may
 * come a little sooner. */
static bool march(struct sim_scene *scene, const struct sim_options *options,
                  struct score_landing *landing, double *looks_s, struct sim_result *result,
                  struct error *error)
{
    for (unsigned tries = 0; tries < FOLD_TRIES; tries++) {
        if (sim_run(scene, options, result, error) == MR_OK)
            return true;
        if (!options->is_single_pass || result->status != SIM_FOLDED)
            return false;
        landing->wave_s = (float)result->t_s;
        scene->t_end_s = result->t_s - FOLD_S;
        sim_result_free(result);
        *error = (struct error){0};
        while (landing->looks > 1 && looks_s[landing->looks - 1] > scene->t_end_s)
            landing->looks--;
        sim_scene_set_list(&scene->t_out_s, looks_s, landing->looks);
    }
    return false;
}

/* The landing is of use until a bow wave begins. */
static void find_wave(struct score_landing *landing, const struct sim_result *result)
{
    for (unsigned k = 0; k < landing->looks && k < result->output_count; k++) {
        if (result->outputs[k].lift_ft < WAVE_FT)
            continue;
        landing->wave_s = 1e-3f * SCORE_LOOK_MS * (float)k;
        landing->looks = k;
    }
}

static bool land(const struct score_series *series, struct score_landing *landing,
                 enum score_kind kind, const double *gap_ft, const double *grit_lb,
                 double *gap_end_ft, uint64_t *state)
{
    static struct sim_path_row rows[SCORE_ROWS_MAX];
    static double stations_ft[SCORE_STATIONS], looks_s[SCORE_LOOKS_MAX];
    struct error error = {0};
    struct sim_scene scene;
    struct sim_result result;
    struct gear gear;
    size_t count;
    bool planar = kinds[kind].planar, elastic = kinds[kind].elastic;
    draw_gear(&gear, series, state);
    if (kinds[kind].late)
        brake_late(&gear, state);
    if (kinds[kind].pulse_hz[1] > 0.0)
        brake_in_pulses(&gear, &kinds[kind], series->number, landing->number);
    note_braking(&gear, landing);
    roll(landing, &gear, series, rows, &count, state);
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = SCORE_MATS;
    scene.length_ft = SCORE_MAT_FT;
    scene.weight_lb = MAT_LB;
    scene.friction = series->friction;
    scene.kl_lb_ft = series->kl_lb_ft;
    scene.cl_lb_s_ft = series->cl_lb_s_ft;
    scene.slack_ft = SLACK_IN / 12.0;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = AFTER_STOP_S;
    for (unsigned i = 0; i < landing->looks; i++)
        looks_s[i] = 1e-3 * SCORE_LOOK_MS * i;
    for (int i = 0; i < SCORE_STATIONS; i++)
        stations_ft[i] = 10.0 * (i + 1);
    if (planar)
        make_planar(&scene, series->number);
    if (elastic)
        make_elastic(&scene, series->number);
    const struct sim_options options = {.dt_s = planar  ? PLANAR_STEP_S
                                              : elastic ? ELASTIC_STEP_S
                                                        : STEP_S,
                                        .rtol = planar ? 0.0 : 0.5,
                                        .sample_dt_s = 1e-3 * SCORE_ROW_MS,
                                        .station_ft = stations_ft,
                                        .station_count = SCORE_STATIONS,
                                        .is_single_pass = planar};
    sim_scene_set_list(&scene.gap0_ft, gap_ft, SCORE_JOINTS);
    sim_scene_set_list(&scene.grit_lb, grit_lb, SCORE_JOINTS);
    sim_scene_set_list(&scene.t_out_s, looks_s, landing->looks);
    sim_scene_set_path(&scene, rows, count);
    bool good = march(&scene, &options, landing, looks_s, &result, &error);
    if (!good && planar && error.status == MR_NUMERICS) {
        fprintf(stderr, "score: series %u ends before landing %u: %s\n", series->number,
                landing->number, error.text);
        sim_result_free(&result);
        sim_scene_free(&scene);
        landing->rows = 0;
        return true;
    }
    if (good && result.start_s != 0.0)
        good = error_set(&error, MR_NUMERICS, "its samples begin at %g s", result.start_s) == MR_OK;
    if (!good) {
        fprintf(stderr, "score: series %u, landing %u: %s\n", series->number, landing->number,
                error.text);
        return false;
    }
    landing->rows = result.sample_count < SCORE_ROWS_MAX ? (uint32_t)result.sample_count
                                                         : SCORE_ROWS_MAX;
    for (unsigned k = 0; k < landing->rows; k++) {
        for (int i = 0; i < SCORE_STATIONS; i++)
            landing->u_in[k][i] =
                (float)(12.0 * result.sample_u_ft[k * SCORE_STATIONS + (size_t)i]);
    }
    for (unsigned k = 0; k < landing->looks && k < result.output_count; k++) {
        const double *u_ft = result.outputs[k].u_ft;
        for (int j = 1; j <= SCORE_JOINTS; j++) {
            double opening_ft = gap_ft[j - 1] + (j <= SCORE_MATS ? u_ft[j] : 0.0) -
                                (j > 1 ? u_ft[j - 1] : 0.0);
            landing->gap_counts[k][j - 1] = (uint16_t)(fmax(0.0, opening_ft) * 12e5 + 0.5);
        }
    }
    for (int j = 1; j <= SCORE_JOINTS; j++) {
        double g = result.gap_ft[j];
        gap_end_ft[j - 1] = fmin(fmax(g, 0.0), SLACK_IN / 12.0);
    }
    if (planar)
        find_wave(landing, &result);
    sim_result_free(&result);
    sim_scene_free(&scene);
    return true;
}

/* Joints as the kind has them, from a state of its own: what else a series draws stays as it is in
 * the first truth. */
static void change_joints(const struct kind *kind, const struct score_series *series,
                          double *gap_ft, double *grit_lb)
{
    uint64_t state = 0x901475000u + series->number;
    bool open = score_uniform(&state) < 0.5;
    for (int j = 0, until = 0; j < SCORE_JOINTS; j++) {
        if (score_uniform(&state) < kind->shut_share)
            gap_ft[j] = kind->shut_most_in * score_uniform(&state) / 12.0;
        if (j == until && kind->patch_most_in > 0.0) {
            until += (int)between(&state, kind->patch_mats[0], kind->patch_mats[1]);
            open = !open;
        }
        if (kind->patch_most_in > 0.0)
            gap_ft[j] = (open ? fmin(between(&state, kind->patch_least_in, GAP_MOST_IN), SLACK_IN)
                              : kind->patch_most_in * score_uniform(&state)) /
                        12.0;
        if (kind->tail > 0.0)
            grit_lb[j] =
                series->grit_mean_lb *
                fmin((1.0 - 1.0 / kind->tail) * pow(1.0 - score_uniform(&state), -1.0 / kind->tail),
                     TAIL_MOST);
    }
}

static bool compute(struct score_truth *truth, uint32_t number, enum score_kind kind)
{
    static double gap_ft[SCORE_JOINTS], grit_lb[SCORE_JOINTS];
    uint64_t state = 0x5c0e0000u + number;
    memset(truth, 0, sizeof *truth);
    for (unsigned i = 0; i < SCORE_LANDINGS; i++)
        truth->landing[i].wave_s = NAN;
    draw_series(&truth->series, number, &state);
    for (int j = 0; j < SCORE_JOINTS; j++) {
        gap_ft[j] = fmin(GAP_MOST_IN * score_uniform(&state), SLACK_IN) / 12.0;
        grit_lb[j] = draw_grit_lb(&truth->series, &state);
    }
    change_joints(&kinds[kind], &truth->series, gap_ft, grit_lb);
    for (uint32_t i = 0; i < truth->series.landings; i++) {
        struct score_landing *landing = &truth->landing[i];
        landing->number = i + 1;
        for (int j = 0; j < SCORE_JOINTS; j++)
            landing->gap_in[j] = (float)(12.0 * gap_ft[j]);
        if (!land(&truth->series, landing, kind, gap_ft, grit_lb, gap_ft, &state))
            return false;
        if (kinds[kind].planar && landing->rows == 0) {
            truth->series.landings = i;
            break;
        }
        if (kinds[kind].planar && !isnan(landing->wave_s))
            truth->series.landings = i + 1; /* the runway has to be laid again */
    }
    return true;
}

/* A landing on disk: only the rows and looks it has. */
static bool carry(struct score_landing *landing, enum score_kind kind, FILE *file,
                  size_t (*move)(void *, size_t, size_t, FILE *))
{
    size_t head = offsetof(struct score_landing, u_in);
    return move(landing, head, 1, file) == 1 && landing->rows <= SCORE_ROWS_MAX &&
           landing->looks <= SCORE_LOOKS_MAX &&
           move(landing->u_in, sizeof landing->u_in[0], landing->rows, file) == landing->rows &&
           move(landing->wheel_ft, sizeof(float), landing->looks, file) == landing->looks &&
           move(landing->speed_at_ft_s, sizeof(float), landing->looks, file) == landing->looks &&
           move(landing->gap_counts, sizeof landing->gap_counts[0], landing->looks, file) ==
               landing->looks &&
           (!kinds[kind].planar || move(&landing->wave_s, sizeof landing->wave_s, 1, file) == 1);
}

static size_t put(void *from, size_t size, size_t count, FILE *file)
{
    return fwrite(from, size, count, file);
}

static bool carry_all(struct score_truth *truth, enum score_kind kind, FILE *file,
                      size_t (*move)(void *, size_t, size_t, FILE *))
{
    const uint32_t expected = kinds[kind].version;
    uint32_t version = expected;
    if (move(&version, sizeof version, 1, file) != 1 || version != expected ||
        move(&truth->series, sizeof truth->series, 1, file) != 1 ||
        truth->series.landings > SCORE_LANDINGS)
        return false;
    for (uint32_t i = 0; i < truth->series.landings; i++) {
        if (!carry(&truth->landing[i], kind, file, move))
            return false;
    }
    return true;
}

/* Part of the names of the files that keep truths; changes when the truths change. */
#define KEPT_AS "2"

bool score_truth_get(struct score_truth *truth, uint32_t number, enum score_kind kind,
                     const char *folder)
{
    char path[512], made[528];
    snprintf(path, sizeof path, "%s/%s-%u-" KEPT_AS ".bin", folder, kinds[kind].name, number);
    snprintf(made, sizeof made, "%s.new", path);
    FILE *file = fopen(path, "rb");
    if (file) {
        bool good = carry_all(truth, kind, file, fread);
        fclose(file);
        for (uint32_t i = 0; good && !kinds[kind].planar && i < truth->series.landings; i++)
            truth->landing[i].wave_s = NAN;
        if (good)
            return true;
    }
    if (!compute(truth, number, kind))
        return false;
    file = fopen(made, "wb");
    if (!file || !carry_all(truth, kind, file, put) || fclose(file) != 0 ||
        rename(made, path) != 0) {
        fprintf(stderr, "score: %s cannot be written; is the disk full?\n", path);
        return false;
    }
    return true;
}
