#include "tests/stability/draw.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const char *const draw_key_names[DRAW_KEYS] = {"KV", "CV", "KL", "CL", "KT", "CT", "W", "I"};

/* splitmix64 (S. Vigna, public domain): every table comes out the same on every machine. */
static uint64_t next(uint64_t *state)
{
    uint64_t x = *state += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

double draw_uniform(uint64_t *state)
{
    return (double)(next(state) >> 11) * 0x1p-53;
}

size_t draw_below(uint64_t *state, size_t count)
{
    return (size_t)(draw_uniform(state) * (double)count);
}

double (*draw_table(size_t count, uint64_t seed))[DRAW_KEYS]
{
    double(*rows)[DRAW_KEYS] = calloc(count, sizeof *rows);
    for (int key = 0; rows && key < DRAW_KEYS; key++) {
        for (size_t i = 0; i < count; i++) {
            rows[i][key] = DRAW_DECADES * (((double)i + draw_uniform(&seed)) / (double)count - 0.5);
            size_t other = draw_below(&seed, i + 1);
            double kept = rows[other][key];
            rows[other][key] = rows[i][key];
            rows[i][key] = kept;
        }
    }
    return rows;
}

#define PICK(state, ...) \
    ((const double[]){   \
        __VA_ARGS__}[draw_below(state, sizeof((double[]){__VA_ARGS__}) / sizeof(double))])

static enum sim_end end(uint64_t *state)
{
    return draw_below(state, 2) == 0 ? SIM_END_FREE : SIM_END_FIXED;
}

enum mr_status draw_scene(struct sim_scene *scene, const double exponents[DRAW_KEYS], size_t index,
                          uint64_t seed, struct error *error)
{
    static const enum sim_friction laws[] = {
        SIM_FRICTION_STICK, SIM_FRICTION_STICK, SIM_FRICTION_STICK, SIM_FRICTION_STICK,
        SIM_FRICTION_STICK, SIM_FRICTION_STICK, SIM_FRICTION_TANH,  SIM_FRICTION_TANH,
        SIM_FRICTION_TANH,  SIM_FRICTION_NONE,  SIM_FRICTION_NONE,  SIM_FRICTION_SIGN};
    static const enum sim_lift_shear shears[] = {SIM_SHEAR_RISING, SIM_SHEAR_RISING,
                                                 SIM_SHEAR_RISING, SIM_SHEAR_FOLLOWING,
                                                 SIM_SHEAR_BOTH,   SIM_SHEAR_NONE};
    uint64_t state = seed ^ (0xd1342543de82ef95u * (index + 1));
    next(&state);
    sim_scene_set_defaults(scene);
    snprintf(scene->name, sizeof scene->name, "scene %zu", index);
    scene->kv_lb_ft *= pow(10.0, exponents[DRAW_KV]);
    scene->cv_lb_s_ft *= pow(10.0, exponents[DRAW_CV]);
    scene->kl_lb_ft *= pow(10.0, exponents[DRAW_KL]);
    scene->cl_lb_s_ft *= pow(10.0, exponents[DRAW_CL]);
    scene->kt_lb_ft_rad *= pow(10.0, exponents[DRAW_KT]);
    scene->ct_lb_ft_s_rad *= pow(10.0, exponents[DRAW_CT]);
    scene->weight_lb *= pow(10.0, exponents[DRAW_W]);
    /* a slab's inertia is its mass times a length; half the scenes keep that, in half it is on its
     * own */
    bool slab = draw_below(&state, 2) == 0;
    scene->inertia_slug_ft2 *= pow(10.0, slab ? exponents[DRAW_W] : exponents[DRAW_I]);
    double heavier = scene->weight_lb / 160.0;

    scene->model = draw_below(&state, 2) == 0 ? SIM_MODEL_REPORT : SIM_MODEL_CONSISTENT;
    bool consistent = scene->model == SIM_MODEL_CONSISTENT;
    scene->mats = 6 + (int)draw_below(&state, 11);
    scene->profile = draw_below(&state, 2) == 0 ? SIM_PROFILE_LOW : SIM_PROFILE_FULL;
    scene->tad_deg = PICK(&state, 0.0, 1.0, 10.0, 10.0);
    scene->tad_mode = draw_below(&state, 3) == 0 ? SIM_TAD_SWITCHED : SIM_TAD_DEADBAND;
    scene->slack_ft = PICK(&state, 0.0, 0.0, 0.005, 0.25 / 12.0);
    scene->left_end = end(&state);
    scene->right_end = end(&state);
    scene->left_torsion = end(&state);
    scene->right_torsion = end(&state);
    /* thrust in proportion to the mats, or the report's whatever they weigh */
    scene->force_lb *= PICK(&state, 0.1, 0.5, 1.0, 2.0);
    if (draw_below(&state, 2) == 0)
        scene->force_lb *= heavier;
    scene->vac_ft_s = PICK(&state, 60.0, 90.0, 140.0);
    scene->start_ft = PICK(&state, 0.0, 2.0, 5.0);
    scene->thrust = draw_below(&state, 2) == 0 ? SIM_THRUST_JUMP : SIM_THRUST_LINEAR;
    scene->wheel_load_lb = PICK(&state, 0.0, 0.0, 10.0) * scene->weight_lb;
    scene->friction_law = laws[draw_below(&state, sizeof laws / sizeof laws[0])];
    scene->friction = PICK(&state, 0.2, 0.5, 0.9);
    scene->veps_ft_s = PICK(&state, 1e-3, 1e-2);
    scene->friction_normal = consistent && draw_below(&state, 2) == 0 ? SIM_NORMAL_SOIL
                                                                      : SIM_NORMAL_WEIGHT;
    scene->lift_shear_lb *= heavier;
    scene->lift_shear = shears[draw_below(&state, sizeof shears / sizeof shears[0])];
    scene->v0_ft_s = PICK(&state, 0.0, 2.0, 2.0);
    double bump = PICK(&state, 0.0, 0.005, 0.02, 0.02, 0.1);
    scene->bump_first = 3;
    scene->t_end_s = PICK(&state, 0.005, 0.01, 0.02);
    double times[DRAW_OUTPUTS];
    for (int i = 0; i < DRAW_OUTPUTS; i++)
        times[i] = scene->t_end_s * (i + 1) / DRAW_OUTPUTS;
    const double heights[] = {0.495 * bump, bump, 0.495 * bump};
    if (bump > 0.0)
        sim_scene_set_list(&scene->bump_ft, heights, 1 + 2 * draw_below(&state, 2));
    sim_scene_set_list(&scene->t_out_s, times, DRAW_OUTPUTS);
    return error->status;
}

/* Half the landings roll off a path: braking, standing, backwards, on and off the runway. */
static void draw_path(struct sim_scene *scene, uint64_t *state)
{
    double end_s = scene->t_end_s, runway_ft = scene->mats * scene->length_ft;
    double from_ft = (1.2 * draw_uniform(state) - 0.1) * runway_ft;
    double speed_ft_s = PICK(state, -60.0, 0.0, 30.0, 60.0, 90.0, 140.0), f_lb = scene->force_lb;
    double touch_s = PICK(state, 0.0, 0.1) * end_s,
           brake_s = (0.2 + 0.3 * draw_uniform(state)) * end_s;
    double after_lb = f_lb * PICK(state, 0.0, 0.5, 1.0),
           brake_ft = from_ft + speed_ft_s * (brake_s - touch_s);
    const struct sim_path_row rows[] = {
        {touch_s, from_ft, PICK(state, 0.0, 1.0) * f_lb},
        {brake_s, brake_ft, f_lb},
        {brake_s, brake_ft, after_lb},
        {end_s, brake_ft + 0.5 * speed_ft_s * (end_s - brake_s), 0.5 * after_lb}};
    sim_scene_set_path(scene, rows, 4);
}

enum mr_status draw_landing_path(struct sim_scene *scene, const double exponents[DRAW_KEYS],
                                 size_t index, uint64_t seed, struct error *error)
{
    uint64_t state = ~seed ^ (0xd1342543de82ef95u * (index + 1));
    next(&state);
    if (draw_scene(scene, exponents, index, seed, error) != MR_OK)
        return error->status;
    scene->model = SIM_MODEL_CONSISTENT;
    scene->friction_law = draw_below(&state, 6) == 0 ? SIM_FRICTION_NONE : SIM_FRICTION_STICK;
    scene->friction_normal = draw_below(&state, 3) == 0 ? SIM_NORMAL_SOIL : SIM_NORMAL_WEIGHT;
    scene->wheel_load_lb = PICK(&state, 0.0, 0.0, 0.1, 1.0, 10.0) * scene->weight_lb;
    if (draw_below(&state, 3) == 0)
        scene->bump_first = 1 + (int)draw_below(&state, (size_t)scene->mats - 2);
    if (draw_below(&state, 2) != 0)
        draw_path(scene, &state);
    return MR_OK;
}

void draw_head(FILE *table)
{
    fprintf(table, "scene");
    for (int k = 0; k < DRAW_KEYS; k++)
        fprintf(table, ",lg_%s", draw_key_names[k]);
    fprintf(table, ",model,N,I,profile,left,right,TAD_deg,tad_mode,slack,F,friction,thrust,"
                   "lift_shear,bump,wheel_load,path,tend");
}

void draw_row(FILE *table, size_t index, const double exponents[DRAW_KEYS],
              const struct sim_scene *s)
{
    static const char *const laws[] = {"stick", "tanh", "sign", "none"};
    static const char *const shears[] = {"rising", "none", "following", "both"};
    fprintf(table, "%zu", index);
    for (int k = 0; k < DRAW_KEYS; k++)
        fprintf(table, ",%.3f", exponents[k]);
    fprintf(table, ",%s,%d,%.3g,%s,%s,%s,%g,%s,%.3g,%.3g,%s%s,%s,%s,%g,%g,%zu,%g",
            sim_model_name(s->model), s->mats, s->inertia_slug_ft2,
            s->profile == SIM_PROFILE_FULL ? "full" : "low",
            s->left_end == SIM_END_FIXED ? "fixed" : "free",
            s->right_end == SIM_END_FIXED ? "fixed" : "free", s->tad_deg,
            s->tad_mode == SIM_TAD_SWITCHED ? "switched" : "deadband", s->slack_ft, s->force_lb,
            laws[s->friction_law], s->friction_normal == SIM_NORMAL_SOIL ? "/soil" : "",
            s->thrust == SIM_THRUST_LINEAR ? "linear" : "jump", shears[s->lift_shear],
            s->bump_ft.count > 0 ? s->bump_ft.values[s->bump_ft.count / 2] : 0.0, s->wheel_load_lb,
            s->path_count, s->t_end_s);
}
