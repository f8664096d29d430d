#include "host/analyse/banddesign.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host/base/xmalloc.h"
#include "host/sim/elements/mods.h"
#include "host/sim/sim.h"

#define IN2_PER_FT2   144.0
#define MATS_MOST     5000
#define PATIENCE_S    120.0 /* of processor time, for all passes */
/* Of the joints, in the model: 9500 lb/in per inch of width over 12 ft (3.4), 1/4 in of play (2.5,
 * 3.2). */
#define JOINT_LB_FT   (9500.0 * 144.0 * 12.0)
#define PLAY_FT       (0.25 / 12.0)
#define G_FT_S2       (9.80665 / 0.3048) /* the g in which a deceleration may be given */
#define ENDS          0.05 /* of the length at either end, where the aircraft does not brake */
#define BUILD_UP_S    0.5  /* until it brakes in full */
/* of critical; not measured. Undamped, mats that knock together never come to an answer */
#define JOINT_DAMPING 0.05

void band_design_defaults(struct band_design *design)
{
    *design = (struct band_design){
        .weight_lb = 480e3,
        .g_ft_s2 = G_FT_S2,
        .deceleration_ft_s2 = 0.5 * G_FT_S2,
        .bands = 4.0,
        .area_ft2 = 6.0 * 0.375 / IN2_PER_FT2,
        .yield_lb_ft2 = 50e3 * IN2_PER_FT2,
        .modulus_lb_ft2 = 29e6 * IN2_PER_FT2,
        .mat_lb = 160.0,
        .friction = 0.5,
        .held = 4.0,
        .every = 10.0,
        .row_ft = 2.0,
        .spring_lb_ft = 0.0,
        .at = 0.5,
        .grip_lb = (double)INFINITY,
        .speed_ft_s = 90.0,
        .passes = 2,
    };
}

static enum mr_status too_weak(const struct band_design *d, struct error *error)
{
    return error_set(error, MR_USAGE,
                     "bands too weak: each takes R = %.6g lb and yields at A fy = %.6g lb (C.10 "
                     "leaves n F' = %.6g lb); give "
                     "more bands, or a larger area or yield",
                     d->r_lb, d->strength_lb, d->strength_lb - d->r_lb);
}

enum mr_status band_design(struct band_design *d, struct error *error)
{
    d->r_lb = d->weight_lb * d->deceleration_ft_s2 / d->g_ft_s2 / d->bands;
    d->strength_lb = d->area_ft2 * d->yield_lb_ft2;
    d->friction_lb = d->strength_lb - d->r_lb;
    if (!(d->friction_lb > 0.0))
        return too_weak(d, error);
    d->connection_lb = d->held * d->friction * d->mat_lb;
    d->most_connections = d->connection_lb > 0.0
                            ? floor(d->friction_lb / d->connection_lb * (1.0 + 1e-12))
                            : HUGE_VAL;
    double apart_ft = d->every * d->row_ft;
    d->longest_ft = d->most_connections * apart_ft;
    d->connections = d->length_ft > 0.0 ? floor(d->length_ft / apart_ft * (1.0 + 1e-12))
                                        : d->most_connections;
    /* without a length the room that C.10 leaves is used up, as the example does: 52.5 kip, not 164
     * x 320 lb */
    double held_lb = d->length_ft > 0.0 ? d->connections * d->connection_lb : d->friction_lb;
    d->least_t0_lb = held_lb + 0.5 * d->r_lb;
    d->most_t0_lb = d->strength_lb - 0.5 * d->r_lb;
    d->t0_lb = d->tension_lb > 0.0 ? d->tension_lb : 0.5 * (d->least_t0_lb + d->most_t0_lb);
    d->spacing_ft = d->width_ft > 0.0 ? d->width_ft / d->bands : 0.0;
    double length_ft = d->length_ft > 0.0 ? d->length_ft : d->longest_ft;
    double band_lb_ft = d->area_ft2 * d->modulus_lb_ft2 / length_ft;
    if (!(d->spring_lb_ft > 0.0))
        d->spring_lb_ft = band_lb_ft;
    double give = d->spring_lb_ft / band_lb_ft; /* K L/(A E) */
    d->ahead_lb = -d->r_lb * (d->at * give + 1.0) / (give + 2.0);
    d->behind_lb = d->r_lb * ((1.0 - d->at) * give + 1.0) / (give + 2.0);
    d->least_lb = d->t0_lb - held_lb - 0.5 * d->r_lb;
    d->most_lb = d->t0_lb + 0.5 * d->r_lb;
    return MR_OK;
}

/* --- in the chain --- */

static double spread(int i)
{
    double x = 0.6180339887498949 * i;
    return x - floor(x);
}

static void lay_mats(struct sim_scene *scene)
{
    double *gaps = xcalloc((size_t)scene->mats + 1, sizeof *gaps);
    for (int j = 0; j <= scene->mats; j++)
        gaps[j] = PLAY_FT * spread(j);
    sim_scene_set_list(&scene->gap0_ft, gaps, (size_t)scene->mats + 1);
    free(gaps);
}

static enum mr_status make_scene(const struct band_design *d, struct sim_scene *scene,
                                 struct error *error)
{
    sim_scene_defaults(scene);
    double length_ft = d->length_ft > 0.0 ? d->length_ft : d->longest_ft;
    double mats = length_ft / d->row_ft;
    if (!(mats <= MATS_MOST) || !(mats > d->every))
        return error_set(error, MR_USAGE,
                         "no model of this band: %g rows; the model takes %g to %d: give a length "
                         "for it, or --design-only",
                         mats, d->every, MATS_MOST);
    snprintf(scene->name, sizeof scene->name, "band");
    scene->model = SIM_CHAIN;
    scene->mats = (int)(mats + 0.5);
    scene->length_ft = d->row_ft;
    scene->weight_lb = d->mat_lb;
    scene->g_ft_s2 = d->g_ft_s2;
    scene->friction = d->friction;
    scene->kl_lb_ft = JOINT_LB_FT;
    scene->slack_ft = PLAY_FT;
    scene->cl_lb_s_ft = JOINT_DAMPING * 2.0 * sqrt(JOINT_LB_FT * d->mat_lb / d->g_ft_s2);
    scene->thrust = SIM_LINEAR;
    scene->v0_ft_s = 0.0;
    scene->left = scene->right = SIM_FREE;
    scene->t_dwell_s = 1.0;
    scene->mods.band[0].count = 1.0;
    scene->mods.band[0].area_ft2 = d->area_ft2;
    scene->mods.band[0].e_lb_ft2 = d->modulus_lb_ft2;
    scene->mods.band[0].every = (int)d->every;
    scene->mods.band[0].first = (int)(0.5 * d->every) + 1;
    scene->mods.band[0].k_lb_ft = d->spring_lb_ft;
    scene->mods.band[0].grip_lb = d->grip_lb;
    double from_ft = ENDS * scene->mats * d->row_ft, to_ft = (1.0 - ENDS) * scene->mats * d->row_ft;
    double run_s = (to_ft - from_ft) / d->speed_ft_s, build_s = fmin(BUILD_UP_S, 0.25 * run_s);
    double build_ft = build_s * d->speed_ft_s;
    const struct sim_path_row path[] = {{0.0, from_ft, 0.0},
                                        {build_s, from_ft + build_ft, d->r_lb},
                                        {run_s - build_s, to_ft - build_ft, d->r_lb},
                                        {run_s, to_ft, 0.0}};
    sim_scene_set_list(&scene->mods.band[0].t0_lb, &d->t0_lb, 1);
    sim_scene_set_path(scene, path, 4);
    lay_mats(scene);
    return MR_OK;
}

/* Middle of segment i of the band. */
static double segment_ft(const struct sim_scene *scene, const struct mods_state *s, size_t i)
{
    double from = i > 0 ? s->band_mat[i - 1] - 0.5 : 0.0;
    double to = i < s->connections ? s->band_mat[i] - 0.5 : scene->mats;
    return 0.5 * (from + to) * scene->length_ft;
}

static void take(const struct band_design *d, const struct sim_scene *scene,
                 const struct sim_result *result, int pass, struct band_check *check)
{
    const struct mods_state *s = result->mods;
    size_t slack = 0;
    check->residual_lb = 0.0;
    for (size_t i = 0; i < s->segments; i++) {
        slack += s->band_least_lb[i] < 0.0;
        if (s->band_least_lb[i] < check->least_lb) {
            check->least_lb = s->band_least_lb[i];
            check->least_ft = segment_ft(scene, s, i);
            check->least_pass = pass;
        }
        if (s->band_most_lb[i] > check->most_lb) {
            check->most_lb = s->band_most_lb[i];
            check->most_ft = segment_ft(scene, s, i);
            check->most_pass = pass;
        }
        check->residual_lb = fmax(check->residual_lb, d->t0_lb - s->band_lb[i]);
    }
    for (size_t c = 0; c < s->connections; c++) {
        check->slip_ft = fmax(check->slip_ft, s->band_slip_ft[c]);
        if (s->band_load_lb[c] > check->load_lb) {
            check->load_lb = s->band_load_lb[c];
            check->load_ft = (s->band_mat[c] - 0.5) * scene->length_ft;
        }
    }
    check->slack_share = fmax(check->slack_share, (double)slack / (double)s->segments);
    check->moved_ft = fmax(check->moved_ft, result->peak_u_ft);
    check->error_lb = fmax(check->error_lb, s->error_lb);
    check->error_ft = fmax(check->error_ft, result->error_u_ft);
    check->run_ms += result->run_ms;
}

static bool go_on(void *ctx, int pass, double part)
{
    (void)pass;
    (void)part;
    return (double)(clock() - *(const clock_t *)ctx) < PATIENCE_S * CLOCKS_PER_SEC;
}

enum mr_status band_check(const struct band_design *d, struct band_check *check,
                          struct error *error)
{
    struct sim_scene scene;
    struct sim_result result = {0};
    clock_t begin = clock();
    struct sim_options options = {.rtol = 0.3, .go_on = go_on, .go_on_ctx = &begin};
    *check = (struct band_check){.least_lb = d->t0_lb, .most_lb = d->t0_lb};
    if (make_scene(d, &scene, error) != MR_OK) {
        sim_scene_free(&scene);
        return error->status;
    }
    check->mats = scene.mats;
    for (int pass = 1; pass <= d->passes && error->status == MR_OK; pass++) {
        if (sim_run(&scene, &options, &result, error) == MR_OK) {
            take(d, &scene, &result, pass, check);
            sim_scene_set_list(&scene.gap0_ft, result.gap_ft + 1, (size_t)scene.mats + 1);
            mods_carry(&scene, &result);
        } else if (result.status == SIM_INTERRUPTED) {
            *error = (struct error){0}; /* say it in the words of this command */
            error_set(error, MR_NUMERICS,
                      "the model of the band takes too long: pass %d came to %.3g of %.3g s in "
                      "%.0f s; give a shorter length or "
                      "--design-only",
                      pass, result.t_s, result.t_end_s, PATIENCE_S);
        }
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
    return error->status;
}
