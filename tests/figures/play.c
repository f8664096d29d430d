#include "tests/figures/play.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/sim/solvers/pass.h"
#include "host/sim/solvers/planar.h"

#define RISEN_FT      0.05
#define FINE_RTOL     1e-8
#define STEP_SHARE    2.4 /* of 1 / fastest rate; rk4 is stable to 2.785 */
#define MOST_STEPS    200000u
#define LOCATED       8000u /* more steps: switches pile up */
#define FINER         4.0   /* times, of rk4 where the switches of the accurate method pile up */
#define W_12FT_LB     160.0 /* of the mat of 12 ft that a scene is a multiple of */
#define BUMP_FT       0.015625
#define BUMP38_FT     0.0299
/* scenes have heights to so much: 0.015 for a half of 0.0299 */
#define BUMP_DIGIT_FT 1e-4

/* Which raised joints a scene has, and what of it is stated, so that no reading changes it. */
enum bump { BUMP_NONE, BUMP_36, BUMP_38, BUMP_39, BUMP_310, BUMP_311, BUMP_312, BUMP_STATED };
enum stated { NOTHING = 0, SPEED = 1, SOIL = 2 };

static const struct source {
    const char *scene;
    enum bump bump;
    unsigned stated;
    double kl_lb_ft; /* 0: the scene's */
    double crossed[PLAY_TIMES];
} sources[RUNS] = {
    [RUN_36] = {"rstar_fig3_6", BUMP_36, NOTHING, 0, {1, 2, 3}},
    [RUN_37] = {"rstar_fig3_7", BUMP_36, NOTHING, 0, {1, 2, 3}},
    [RUN_38_STIFF] = {"rstar_fig3_8_stiff", BUMP_38, SPEED, 0, {1, 2}},
    [RUN_38_MIDDLE] = {"rstar_fig3_8_middle", BUMP_38, SPEED, 0, {1, 2}},
    [RUN_38_SOFT] = {"rstar_fig3_8_soft", BUMP_38, SPEED, 0, {1, 2}},
    [RUN_39_F05] = {"rstar_fig3_9_f05", BUMP_39, NOTHING, 0, {1, 2, 3}},
    [RUN_39_F09] = {"rstar_fig3_9_f09", BUMP_39, NOTHING, 0, {1, 2, 3}},
    [RUN_310_F05] = {"rstar_fig3_10_f05", BUMP_310, NOTHING, 0, {1, 2, 3}},
    [RUN_310_F09] = {"rstar_fig3_10_f09", BUMP_310, NOTHING, 0, {1, 2, 3}},
    [RUN_311_6] = {"rstar_fig3_11_6000", BUMP_311, NOTHING, 0, {1, 2, 2.5}},
    [RUN_311_12] = {"rstar_fig3_11_12000", BUMP_311, NOTHING, 0, {1, 2, 2.5}},
    [RUN_311_24] = {"rstar_fig3_11_24000", BUMP_311, NOTHING, 0, {1, 2, 2.5}},
    [RUN_311_TIGHT] = {"rstar_fig3_11_12000", BUMP_311, NOTHING, 16e6, {1, 2, 2.5}},
    [RUN_312_TAD10] = {"rstar_fig3_12_tad10", BUMP_312, NOTHING, 0, {1, 2, 3, 4}},
    [RUN_312_TAD1] = {"rstar_fig3_12_tad1", BUMP_312, NOTHING, 0, {1, 2, 3, 4}},
    [RUN_FULL_144] = {"full_width_144000", BUMP_STATED, NOTHING, 0, {1, 2, 3}},
    [RUN_FULL_40] = {"full_width_40000", BUMP_STATED, NOTHING, 0, {1, 2, 3}},
    [RUN_FULL_36] = {"full_width_36000", BUMP_STATED, NOTHING, 0, {1, 2, 3}},
    [RUN_FLAT] = {"rstar_flat", BUMP_NONE, NOTHING, 0, {3}},
    [RUN_SOIL_SOFT] = {"rstar_soil_soft", BUMP_311, SOIL, 0, {2.5}},
    [RUN_SOIL_HARD] = {"rstar_soil_hard", BUMP_311, SOIL, 0, {2.5}},
    [RUN_SOIL_LOOSE] = {"rstar_soil_loose", BUMP_311, SOIL, 0, {2.5}},
    [RUN_SOIL_DULL] = {"rstar_soil_dull", BUMP_311, SOIL, 0, {2.5}},
    [RUN_WIDE] = {"rstar_wide", BUMP_311, NOTHING, 0, {2.5}},
    [RUN_SLOW] = {"rstar_velocity_60", BUMP_311, SPEED, 0, {2.5}},
    [RUN_FAST] = {"rstar_velocity_140", BUMP_311, SPEED, 0, {2.5}},
};

static struct sim_scene loaded[RUNS];
static int loaded_count;

enum mr_status play_load(struct error *error)
{
    for (; loaded_count < RUNS && error->status == MR_OK; loaded_count++) {
        char path[200];
        snprintf(path, sizeof path, "host/scenes/%s.json", sources[loaded_count].scene);
        if (sim_scene_load(&loaded[loaded_count], path, error) != MR_OK)
            break;
    }
    return error->status;
}

void play_free(void)
{
    while (loaded_count > 0)
        sim_scene_free(&loaded[--loaded_count]);
}

/* `nodes` raised joints of which the highest has `height_ft`: one, both alike, or the middle. */
static size_t raise(double *bump_ft, double nodes, double height_ft, double ratio)
{
    bump_ft[0] = nodes > 2.5 ? ratio * height_ft : height_ft;
    bump_ft[1] = nodes > 2.5 ? height_ft : ratio * height_ft;
    bump_ft[2] = ratio * height_ft;
    return (size_t)nodes;
}

static void lay_bump(struct sim_scene *scene, enum bump bump, const double *in,
                     struct play_room *room)
{
    double *h = room->bump_ft;
    switch (bump) {
    case BUMP_NONE:
    case BUMP_STATED: return;
    case BUMP_36:
        h[0] = 0.0099;
        h[1] = 0.02;
        h[2] = in[IN_THIRD36];
        scene->bump_ft = (struct sim_list){h, 3};
        return;
    case BUMP_38: scene->bump_ft.count = raise(h, 3, BUMP38_FT, in[IN_RATIO]); break;
    case BUMP_39:
        scene->bump_ft.count = raise(h, in[IN_NODES39], in[IN_HEIGHT], in[IN_RATIO]);
        break;
    case BUMP_310: scene->bump_ft.count = raise(h, 1, in[IN_HEIGHT], 1); break;
    case BUMP_311: scene->bump_ft.count = raise(h, in[IN_NODES311], BUMP_FT, in[IN_RATIO]); break;
    case BUMP_312: scene->bump_ft.count = raise(h, in[IN_NODES312], BUMP_FT, in[IN_RATIO]); break;
    }
    scene->bump_ft.values = h;
}

static enum sim_end end_of(double choice)
{
    return choice > 0.5 ? SIM_FREE : SIM_FIXED;
}

static void set_times(struct sim_scene *scene, enum run_id id, const double *in,
                      struct play_room *room)
{
    const struct source *source = &sources[id];
    size_t count = 0;
    for (; count < PLAY_TIMES && source->crossed[count] > 0; count++) {
        double mats = source->crossed[count];
        bool first38 = source->bump == BUMP_38 && count == 0;
        double way_ft = mats * scene->length_ft * (first38 ? in[IN_CROSS38] : 1.0);
        if (in[IN_TO_EDGE] > 0.5 && !first38)
            way_ft -= in[IN_S0];
        room->t_out_s[count] = way_ft / scene->vac_ft_s;
    }
    scene->t_out_s = (struct sim_list){room->t_out_s, count};
    scene->t_end_s = room->t_out_s[count - 1];
}

struct sim_scene play_scene(enum run_id id, const struct reading *reading, struct play_room *room)
{
    static const enum sim_lift_shear shears[] = {SIM_RISING, SIM_NO_SHEAR, SIM_FOLLOWING, SIM_BOTH};
    const struct source *source = &sources[id];
    const double *in = reading->value;
    struct sim_scene scene = loaded[id];
    double wide = scene.weight_lb / W_12FT_LB; /* mats of 12 ft beside each other */
    bool fig312 = source->bump == BUMP_312;
    scene.weight_lb = wide * in[IN_W];
    scene.v0_ft_s = in[IN_V0];
    if (!(source->stated & SPEED))
        scene.vac_ft_s = in[IN_VAC];
    scene.s0_ft = in[IN_S0];
    scene.mats = (int)in[IN_N];
    scene.left = end_of(in[IN_LEFT]);
    scene.right = end_of(in[fig312 ? IN_RIGHT312 : IN_RIGHT]);
    if (fig312)
        scene.force_lb = in[IN_F312];
    scene.cl_lb_s_ft = wide * in[IN_CL];
    scene.thrust = in[IN_THRUST] > 0.5 ? SIM_LINEAR : SIM_JUMP;
    scene.friction_law = in[IN_FRICTION] > 0.5 ? SIM_TANH : SIM_STICK;
    scene.shear_lb = in[IN_SHEAR] * scene.weight_lb;
    scene.lift_shear = shears[(int)in[IN_SHEAR_LAW]];
    if (!(source->stated & SOIL))
        scene.kv_lb_ft = wide * in[IN_KV];
    scene.tad_mode = in[IN_TAD_MODE] > 0.5 ? SIM_SWITCHED : SIM_DEADBAND;
    scene.bump_first = (int)in[IN_BUMP_FIRST];
    if (source->kl_lb_ft > 0)
        scene.kl_lb_ft = source->kl_lb_ft;
    lay_bump(&scene, source->bump, in, room);
    set_times(&scene, id, in, room);
    return scene;
}

/* A scene in what readings change, lists apart. */
static bool same_scene(const struct sim_scene *a, const struct sim_scene *b)
{
    bool bumps = a->bump_ft.count == b->bump_ft.count;
    for (size_t i = 0; bumps && i < a->bump_ft.count; i++)
        bumps = fabs(a->bump_ft.values[i] - b->bump_ft.values[i]) < BUMP_DIGIT_FT;
    return bumps && a->weight_lb == b->weight_lb && a->v0_ft_s == b->v0_ft_s &&
           a->vac_ft_s == b->vac_ft_s && a->s0_ft == b->s0_ft && a->mats == b->mats &&
           a->left == b->left && a->right == b->right && a->force_lb == b->force_lb &&
           a->cl_lb_s_ft == b->cl_lb_s_ft && a->thrust == b->thrust &&
           a->friction_law == b->friction_law && a->shear_lb == b->shear_lb &&
           a->lift_shear == b->lift_shear && a->kv_lb_ft == b->kv_lb_ft &&
           a->tad_mode == b->tad_mode && a->bump_first == b->bump_first &&
           fabs(a->t_end_s - sim_scene_end_s(b)) < 1e-9;
}

enum mr_status play_check_rstar(struct error *error)
{
    const struct reading rstar = reading_rstar();
    for (int id = 0; id < RUNS && error->status == MR_OK; id++) {
        struct play_room room;
        struct sim_scene scene = play_scene((enum run_id)id, &rstar, &room);
        if (!same_scene(&scene, &loaded[id]))
            error_set(error, MR_LIMIT, "%s: R* of tests/figures/inputs.c is not what it has",
                      sources[id].scene);
    }
    return error->status;
}

static void take(struct played *played, const struct sim_record *record)
{
    double before_s = 0, before_ft = 0;
    played->rise_s = (double)INFINITY;
    for (size_t i = 0; i < record->snapshot_count; i++) {
        const struct sim_snapshot *shot = &record->snapshots[i];
        if (shot->lift_ft >= RISEN_FT && isinf(played->rise_s))
            played->rise_s = before_s + (shot->t_s - before_s) * (RISEN_FT - before_ft) /
                                            (shot->lift_ft - before_ft);
        before_s = shot->t_s;
        before_ft = shot->lift_ft;
        if (shot->output < 0)
            continue;
        int k = shot->output;
        for (int n = 1; n <= PLAY_MATS && n <= record->mats; n++)
            played->u_ft[k][n] = shot->u_ft[n];
        played->last_ft[k] = shot->u_ft[record->mats];
        played->lift_ft[k] = shot->lift_ft;
    }
}

/* One pass of a scene: by the accurate method, or, where that is not asked for or does not end
 * well, by the one that samples its switches. True: it came to its end. Either way the caller
 * frees. */
static bool pass(struct pass_outcome *outcome, const struct sim_scene *scene, bool fine)
{
    struct model model;
    struct error error = {0};
    const struct sim_options options = {0};
    const struct pass_request located = {
        .kind = stepper_find("event"), .rtol = FINE_RTOL, .most_steps = LOCATED};
    struct pass_request sampled = {.kind = stepper_find("rk4"), .most_steps = MOST_STEPS};
    bool ended = false;
    *outcome = (struct pass_outcome){0};
    if (model_make(&model, scene, false, &error) != MR_OK)
        return false;
    double *z = calloc(2 * (size_t)model.size, sizeof *z);
    if (z && fine) {
        pass_run(outcome, &model, &located, &options);
        ended = outcome->status == SIM_OK;
    }
    if (z && !ended) {
        pass_free(outcome);
        model_start(&model, z);
        sampled.dt_s = STEP_SHARE / model_fastest_rate(&model, z, MODEL_EXPLICIT);
        sampled.dt_s /= fine ? FINER : 1.0;
        pass_run(outcome, &model, &sampled, &options);
        ended = outcome->status == SIM_OK;
    }
    free(z);
    model_free(&model);
    return ended;
}

const struct played *play_run(struct playing *playing, enum run_id id)
{
    struct played *played = &playing->run[id];
    struct play_room room;
    struct pass_outcome outcome;
    if (played->done)
        return played;
    struct sim_scene scene = play_scene(id, &playing->reading, &room);
    *played = (struct played){.done = true, .threshold_ft = pass_bow_threshold_ft(&scene)};
    if (pass(&outcome, &scene, playing->fine)) {
        played->ok = true;
        played->times = (int)scene.t_out_s.count;
        played->peak_ft = outcome.max_lift_ft;
        take(played, &outcome.record);
    }
    pass_free(&outcome);
    return played;
}

enum mr_status play_profile(struct profile *profile, enum run_id id, const struct reading *reading,
                            int at, struct error *error)
{
    struct play_room room;
    struct pass_outcome outcome;
    struct sim_scene scene = play_scene(id, reading, &room);
    *profile = (struct profile){.t_s = room.t_out_s[at], .mats = scene.mats};
    profile->wheel_ft = scene.s0_ft + scene.vac_ft_s * profile->t_s;
    scene.t_end_s = profile->t_s;
    scene.t_out_s.count = 0;
    if (pass(&outcome, &scene, true)) {
        for (int j = 0; j <= scene.mats; j++) {
            double u = outcome.z[2 * (j < scene.mats ? j : scene.mats - 1) + 1];
            profile->x_ft[j] = j * scene.length_ft + u;
            profile->height_ft[j] = -outcome.z[2 * j];
            profile->station_ft[j] = (j + 0.5) * scene.length_ft;
            profile->u_ft[j] = u;
        }
    } else {
        error_set(error, MR_NUMERICS, "no profile: %s at %g s", sources[id].scene, profile->t_s);
    }
    pass_free(&outcome);
    return error->status;
}
