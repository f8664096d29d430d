#include "tests/stability/chain_draw.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/sim/elements/element.h"
#include "tests/stability/draw.h"

#define G          32.174
#define ROWS_MAX   40
#define RIG_MAT_FT (2.0 / 7.0)

const char *const chain_kind_names[CHAIN_KINDS] = {"row",  "rig",   "box",  "pulse",
                                                   "late", "limit", "gear", "other"};

#define PICK(state, ...) \
    ((const double[]){   \
        __VA_ARGS__}[draw_below(state, sizeof((double[]){__VA_ARGS__}) / sizeof(double))])

static double between(uint64_t *state, double low, double high)
{
    return low + (high - low) * draw_uniform(state);
}

static double decades(uint64_t *state, double low, double high)
{
    return pow(10.0, between(state, low, high));
}

static bool one_in(uint64_t *state, double times)
{
    return draw_uniform(state) * times < 1.0;
}

static enum sim_end end(uint64_t *state)
{
    return one_in(state, 2.0) ? SIM_END_FREE : SIM_END_FIXED;
}

/* Fewer mats more often. */
static int some_mats(uint64_t *state, int most)
{
    return (int)fmin(most, floor(pow(most + 1.0, draw_uniform(state))));
}

static double mass(const struct sim_scene *scene)
{
    return scene->weight_lb / scene->g_ft_s2;
}

/* Of a mat on one joint. */
static double rate(const struct sim_scene *scene)
{
    return sqrt(scene->kl_lb_ft / mass(scene));
}

/* Openings within the slack, and grit in some joints. */
static void dirt(struct sim_scene *scene, double most_grit_lb, uint64_t *state)
{
    double gaps[CHAIN_MATS + 1], grit[CHAIN_MATS + 1];
    size_t count = (size_t)scene->mats + 1;
    bool even = one_in(state, 4.0);
    double all = draw_uniform(state);
    for (size_t j = 0; j < count; j++) {
        gaps[j] = scene->slack_ft * (even ? all : draw_uniform(state));
        grit[j] = one_in(state, 5.0) ? 0.0 : most_grit_lb * draw_uniform(state);
    }
    sim_scene_set_list(&scene->gap0_ft, gaps, count);
    if (most_grit_lb > 0.0)
        sim_scene_set_list(&scene->grit_lb, grit, count);
}

static void materials(struct sim_scene *scene, double soft, double hard, uint64_t *state)
{
    scene->weight_lb = decades(state, -1.0, 2.5);
    scene->kl_lb_ft = scene->weight_lb * decades(state, soft, hard);
    scene->cl_lb_s_ft = one_in(state, 3.0) ? between(state, 0.0, 0.3) * rate(scene) * mass(scene)
                                           : 0.0;
    scene->length_ft = PICK(state, RIG_MAT_FT, 2.0);
    scene->left_end = end(state);
    scene->right_end = end(state);
    scene->friction = between(state, 0.2, 0.8);
    scene->start_ft = 0.5 * scene->length_ft;
    scene->vac_ft_s = scene->force_lb = 0.0;
}

static void row(struct sim_scene *scene, uint64_t *state)
{
    scene->mats = some_mats(state, CHAIN_MATS);
    materials(scene, 2.5, 5.0, state);
    double hold_lb = scene->friction * scene->weight_lb;
    scene->v0_ft_s = decades(state, -1.0, 0.7);
    scene->v0_mat = 1 + (int)draw_below(state, (size_t)scene->mats);
    double slide_s = scene->v0_ft_s / (scene->friction * G);
    if (one_in(state, 2.5)) {
        scene->slack_ft = between(state, 0.0, 3.0) * scene->v0_ft_s / rate(scene);
        dirt(scene, one_in(state, 2.0) ? 3.0 * hold_lb : 0.0, state);
    }
    scene->t_end_s = PICK(state, 2.0, 5.0, 20.0) * slide_s + 10.0 / rate(scene);
    if (one_in(state, 2.0)) {
        scene->force_lb = between(state, 0.0, 6.0) * hold_lb;
        scene->force_stop_s = between(state, 0.2, 3.0) * slide_s;
        scene->wheel_load_lb = PICK(state, 0.0, 0.0, 0.5, 2.0) * scene->weight_lb;
    }
    if (one_in(state, 2.0)) { /* the wheel rolls over most of the row */
        scene->start_ft = between(state, -0.1, 0.5) * scene->mats * scene->length_ft;
        scene->vac_ft_s = between(state, 0.1, 1.5) * scene->mats * scene->length_ft /
                          scene->t_end_s;
        scene->thrust = one_in(state, 2.0) ? SIM_THRUST_JUMP : SIM_THRUST_LINEAR;
        double rolled_ft = scene->vac_ft_s * scene->t_end_s;
        const struct sim_path_row back[] = {
            {0.0, scene->start_ft + rolled_ft, scene->force_lb},
            {0.7 * scene->t_end_s, scene->start_ft, 0.5 * scene->force_lb},
            {scene->t_end_s, scene->start_ft + 0.2 * rolled_ft, 0.0}};
        if (one_in(state, 4.0))
            sim_scene_set_path(scene, back, 3);
    }
}

/* A braking aircraft: touches down, brakes to a stop or until the row ends. */
static void brake(struct sim_scene *scene, double thrust_lb, uint64_t *state)
{
    struct sim_path_row rows[ROWS_MAX];
    double runway_ft = scene->mats * scene->length_ft, x = between(state, 0.0, 0.3) * runway_ft;
    double v = between(state, 5.0, 30.0), slows = between(state, 2.0, 40.0);
    double step_s = 0.03 + 0.04 * draw_uniform(state), t = PICK(state, 0.0, 0.0, 0.02);
    size_t count = 0;
    for (; count + 2 < ROWS_MAX; count++) {
        double grown = fmin(1.0, (double)count / 4.0);
        rows[count] = (struct sim_path_row){t, x, thrust_lb * grown * grown * (3.0 - 2.0 * grown)};
        double long_s = count < 4 ? 0.01 : step_s;
        if (v <= 0.0 || x > runway_ft)
            break;
        long_s = fmin(long_s, v / slows);
        x += v * long_s - 0.5 * slows * long_s * long_s;
        v = long_s >= v / slows ? 0.0 : v - slows * long_s;
        t += long_s;
    }
    if (count + 2 >= ROWS_MAX)
        count = ROWS_MAX - 3;
    struct sim_path_row stands = rows[count];
    stands.force_lb = 0.0;
    rows[++count] = stands;
    sim_scene_set_path(scene, rows, count + 1);
    scene->t_end_s = rows[count].t_s * between(state, 0.5, 1.5);
}

static void rig(struct sim_scene *scene, uint64_t *state)
{
    scene->mats = 5 + (int)draw_below(state, CHAIN_MATS - 4);
    scene->length_ft = RIG_MAT_FT;
    scene->weight_lb = 0.466 * decades(state, -0.3, 0.3);
    scene->kl_lb_ft = 2.9e5 * decades(state, -1.0, 0.5);
    scene->cl_lb_s_ft = PICK(state, 0.0, 1.0, 5.0, 10.0);
    scene->slack_ft = 0.0025 * decades(state, -0.3, 0.3);
    scene->friction = between(state, 0.3, 0.8);
    scene->left_end = end(state);
    scene->right_end = end(state);
    scene->v0_ft_s = 0.0;
    dirt(scene, PICK(state, 0.0, 2.0, 20.0), state);
    brake(scene, 13.5 * decades(state, -0.5, 0.5), state);
}

static void box(struct sim_scene *scene, uint64_t *state)
{
    double gaps[CHAIN_MATS + 1];
    scene->mats = one_in(state, 4.0) ? 2 + (int)draw_below(state, 4) : 1;
    scene->kl_lb_ft = decades(state, 4.0, 7.0);
    scene->cl_lb_s_ft = 0.0;
    scene->slack_ft = 1.0;
    scene->left_end = scene->right_end = SIM_END_FIXED;
    scene->friction_law = SIM_FRICTION_NONE;
    scene->force_lb = scene->vac_ft_s = 0.0;
    scene->v0_ft_s = between(state, 0.5, 3.0);
    scene->v0_mat = 1;
    double room_ft = 0.0;
    for (int j = 0; j <= scene->mats; j++)
        room_ft += gaps[j] = between(state, 0.05, 0.2);
    sim_scene_set_list(&scene->gap0_ft, gaps, (size_t)scene->mats + 1);
    double period_s = 2.0 * (room_ft / scene->v0_ft_s + M_PI / rate(scene));
    double periods = scene->mats == 1 ? PICK(state, 3.0, 10.0, 30.0, 100.0, 300.0)
                                      : PICK(state, 1.0, 2.0, 4.0);
    scene->t_end_s = period_s * (periods + draw_uniform(state));
}

/* A push by `force_lb` from t_s for long_s, the wheel on mat 1. */
static void push(struct sim_scene *scene, double t_s, double long_s, double force_lb)
{
    double x_ft = 0.5 * scene->length_ft, end_s = t_s + long_s;
    const struct sim_path_row rows[] = {{0.0, x_ft, 0.0},      {t_s, x_ft, 0.0},
                                        {t_s, x_ft, force_lb}, {end_s, x_ft, force_lb},
                                        {end_s, x_ft, 0.0},    {scene->t_end_s, x_ft, 0.0}};
    sim_scene_set_path(scene, rows, 6);
}

static void few_mats(struct sim_scene *scene, uint64_t *state)
{
    scene->mats = one_in(state, 2.0) ? 1 : some_mats(state, 8);
    materials(scene, 2.0, 3.5, state);
    scene->left_end = scene->mats == 1 ? SIM_END_FREE : end(state);
    scene->right_end = scene->mats == 1 ? SIM_END_FREE : end(state);
    scene->v0_ft_s = 0.0;
    if (one_in(state, 3.0)) {
        scene->slack_ft = decades(state, -4.0, -1.0);
        dirt(scene, 0.0, state);
    }
}

static void pulse(struct sim_scene *scene, uint64_t *state)
{
    few_mats(scene, state);
    double hold_lb = scene->friction * scene->weight_lb, long_s = decades(state, -4.0, -1.5);
    double speed_ft_s = decades(state, -1.0, 1.0);
    scene->t_end_s = decades(state, 0.0, 2.3);
    push(scene, between(state, 0.1, 0.9) * scene->t_end_s, long_s,
         hold_lb + speed_ft_s * mass(scene) / long_s);
}

static void late(struct sim_scene *scene, uint64_t *state)
{
    few_mats(scene, state);
    double hold_lb = scene->friction * scene->weight_lb, wait_s = decades(state, 1.0, 2.7);
    if (one_in(state, 2.0)) {
        scene->v0_ft_s = decades(state, -1.3, 1.0);
        scene->v0_mat = 1;
        scene->t_end_s = wait_s;
        return;
    }
    double long_s = decades(state, -2.0, 0.0);
    scene->t_end_s = wait_s + 10.0 * long_s;
    push(scene, wait_s, long_s, hold_lb * between(state, 1.05, 4.0));
}

static void limit(struct sim_scene *scene, uint64_t *state)
{
    few_mats(scene, state);
    double hold_lb = scene->friction * scene->weight_lb, x_ft = 0.5 * scene->length_ft;
    double off = PICK(state, 0.0, 0.0, 1e-9, 1e-6, 1e-3, 1e-2) * (one_in(state, 2.0) ? -1.0 : 1.0);
    double force_lb = hold_lb * (1.0 + off);
    scene->t_end_s = decades(state, -1.0, 1.0);
    scene->force_lb = force_lb;
    if (one_in(state, 2.0)) {
        scene->v0_ft_s = decades(state, -2.0, 0.3);
        scene->v0_mat = 1 + (int)draw_below(state, (size_t)scene->mats);
    }
    if (one_in(state, 2.0)) { /* it comes to the limit, stays and goes */
        double end_s = scene->t_end_s;
        const struct sim_path_row rows[] = {{0.0, x_ft, 0.0},
                                            {0.3 * end_s, x_ft, force_lb},
                                            {0.6 * end_s, x_ft, force_lb},
                                            {end_s, x_ft, PICK(state, 0.0, 1.1, -1.1) * force_lb}};
        sim_scene_set_path(scene, rows, 4);
    }
}

static void gear(struct sim_scene *scene, uint64_t *state)
{
    static const double lines_ft[] = {0.0, 0.77, 2.62, 3.39};
    double axles[4];
    size_t lines = 1 + draw_below(state, 4);
    rig(scene, state);
    scene->element_values[ELEMENT_gear_ground] = decades(state, 3.0, 4.5);
    scene->wheel_load_lb = decades(state, 0.5, 2.3);
    for (size_t i = 0; i < lines; i++)
        axles[i] = PICK(state, 1.0, 2.0);
    if (lines > 1) {
        sim_scene_set_list(&scene->gear.line_setbacks_ft, lines_ft, lines);
        sim_scene_set_list(&scene->gear.axle_counts, axles, lines);
    }
    scene->gear.axle_length_ft = PICK(state, 0.0, 1.0, 1.6) * scene->length_ft;
    scene->gear.damping = PICK(state, 0.0, 0.2, 0.5, 1.0);
    scene->gear.recovered_share = PICK(state, 1.0, 0.7, 0.4);
    scene->gear.axle_exponent = PICK(state, 0.0, 0.5, 1.0);
}

static void other(struct sim_scene *scene, uint64_t *state)
{
    row(scene, state);
    switch (draw_below(state, 3)) {
    case 0:
        scene->friction_law = SIM_FRICTION_TANH;
        scene->veps_ft_s = decades(state, -3.0, -1.0);
        break;
    case 1: scene->friction_law = SIM_FRICTION_NONE; break;
    default: break;
    }
    if (scene->friction_law == SIM_FRICTION_STICK || one_in(state, 2.0))
        scene->element_values[ELEMENT_ground_damping] = scene->friction * scene->weight_lb /
                                                        scene->v0_ft_s * decades(state, -2.0, 1.0);
}

enum chain_kind chain_draw(struct sim_scene *scene, size_t index, uint64_t seed)
{
    static void (*const draws[CHAIN_KINDS])(struct sim_scene *, uint64_t *) = {
        row, rig, box, pulse, late, limit, gear, other};
    static const enum chain_kind turns[] = {
        CHAIN_ROW,   CHAIN_RIG,   CHAIN_PULSE, CHAIN_GEAR, CHAIN_ROW,  CHAIN_BOX,
        CHAIN_LATE,  CHAIN_OTHER, CHAIN_RIG,   CHAIN_ROW,  CHAIN_GEAR, CHAIN_PULSE,
        CHAIN_LIMIT, CHAIN_BOX,   CHAIN_ROW,   CHAIN_RIG,  CHAIN_OTHER};
    enum chain_kind kind = turns[index % (sizeof turns / sizeof turns[0])];
    uint64_t state = seed ^ (0xd1342543de82ef95u * (index + 1));
    double times[CHAIN_OUTPUTS];
    draw_uniform(&state);
    sim_scene_set_defaults(scene);
    snprintf(scene->name, sizeof scene->name, "chain %zu", index);
    scene->model = SIM_MODEL_CHAIN;
    scene->g_ft_s2 = G;
    draws[kind](scene, &state);
    /* even times in half of the scenes, any times in the other */
    bool even = one_in(&state, 2.0);
    for (int i = 0; i < CHAIN_OUTPUTS; i++)
        times[i] = scene->t_end_s * (i + (even ? 1.0 : draw_uniform(&state))) / CHAIN_OUTPUTS;
    times[CHAIN_OUTPUTS - 1] = scene->t_end_s;
    sim_scene_set_list(&scene->t_out_s, times, CHAIN_OUTPUTS);
    return kind;
}
