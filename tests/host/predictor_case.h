/* A landing on a runway of a predictor's own openings and resistances, by the host's chain in
 * double precision at a step of its own: what the predictor's single-precision chain is held
 * against. */
#ifndef MATRIG_TESTS_HOST_PREDICTOR_CASE_H
#define MATRIG_TESTS_HOST_PREDICTOR_CASE_H

#include <math.h>
#include <stdlib.h>

#include "common/predictor.h"
#include "host/sim/sim.h"

#define CASE_MAT_FT       (2.0 / 7.0)
#define CASE_MAT_LB       0.466
#define CASE_GEAR_LB      1300.0
#define CASE_G_FT_S2      32.174
#define CASE_TOUCHDOWN_FT 3.0
#define CASE_STATIONS     12
#define CASE_ROWS         2000
#define CASE_ROW_S        0.005

/* Braking goes from one deceleration to the other between 1.2 and 3.6 s, as in the report's landing
 * 5. */
struct braking {
    double speed_ft_s, from_ft_s2, to_ft_s2;
};

static inline struct mr_predictor_config case_rig(void)
{
    struct mr_predictor_config config = {.chain = {.mats = 420,
                                                   .mat_length_ft = (float)CASE_MAT_FT,
                                                   .mass_slug = (float)(CASE_MAT_LB / CASE_G_FT_S2),
                                                   .friction_lb = (float)(0.5 * CASE_MAT_LB),
                                                   .kl_lb_ft = 2.9e5f,
                                                   .cl_lb_s_ft = 5.0f,
                                                   .slack_ft = 0.0025f,
                                                   .step_s = 1e-3f / 6.0f},
                                         .grit_lb = 10.0f,
                                         .thrust_lb_per_g = (float)(CASE_GEAR_LB / 12.0),
                                         .deceleration_ft_s2 = 5.0f,
                                         .bump_ft = 0.0036f,
                                         .mat_weight_lb = (float)CASE_MAT_LB,
                                         .updates_per_block = 1u << 30,
                                         .level = MR_PREDICTOR_FULL};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = NAN;
    return config;
}

/* The wheel by time: [0] place, [1] speed, [2] deceleration; after the stop as there. */
static inline double case_gear(const struct braking *braking, double t_s, double at[3])
{
    double x = CASE_TOUCHDOWN_FT, v = braking->speed_ft_s, t = 0.0, a = braking->from_ft_s2,
           h = 1e-3;
    for (; t < t_s && v > 0.0; t += h) {
        a = braking->from_ft_s2 +
            (braking->to_ft_s2 - braking->from_ft_s2) * fmin(fmax(t - 1.2, 0.0) / 2.4, 1.0);
        double part = fmin(h, t_s - t);
        x += v * part - 0.5 * a * part * part;
        v -= a * part;
    }
    at[0] = x;
    at[1] = fmax(v, 0.0);
    at[2] = a;
    return v;
}

/* By millisecond and station 10, 20 .. ; inches. `result->sample_u_ft` is freed with the result. */
static inline bool case_truth(const struct mr_predictor *p, const struct braking *braking,
                              double dt_s, struct sim_result *result, struct error *error)
{
    static double gap_ft[MR_CHAIN_MATS + 1], grit_lb[MR_CHAIN_MATS + 1], stations_ft[CASE_STATIONS];
    static struct sim_path_row rows[CASE_ROWS];
    const struct mr_chain_params *chain = &p->config.chain;
    struct sim_scene scene;
    size_t count = 0;
    double at[3], end_ft = chain->mats * CASE_MAT_FT;
    for (unsigned j = 0; j <= chain->mats; j++) {
        gap_ft[j] = (double)p->gap_ft[j];
        grit_lb[j] = (double)p->chain.grit_lb[j + 1];
    }
    for (; count < CASE_ROWS - 1; count++) {
        double v = case_gear(braking, (double)count * CASE_ROW_S, at);
        rows[count] =
            (struct sim_path_row){(double)count * CASE_ROW_S, at[0],
                                  (double)p->config.thrust_lb_per_g * at[2] / CASE_G_FT_S2};
        if (v <= 0.0 || at[0] >= end_ft)
            break;
    }
    rows[count++].force_lb = 0.0;
    for (unsigned i = 0; i < CASE_STATIONS; i++)
        stations_ft[i] = fmin(10.0 * i + 5.0, end_ft - 0.1);
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = chain->mats;
    scene.length_ft = CASE_MAT_FT;
    scene.weight_lb = CASE_MAT_LB;
    scene.friction = (double)chain->friction_lb / CASE_MAT_LB;
    scene.kl_lb_ft = (double)chain->kl_lb_ft;
    scene.cl_lb_s_ft = (double)chain->cl_lb_s_ft;
    scene.slack_ft = (double)chain->slack_ft;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = 0.2;
    const struct sim_options options = {.dt_s = dt_s,
                                        .rtol = 0.5,
                                        .sample_dt_s = 1e-3,
                                        .station_ft = stations_ft,
                                        .station_count = CASE_STATIONS};
    sim_scene_set_list(&scene.gap0_ft, gap_ft, chain->mats + 1u);
    sim_scene_set_list(&scene.grit_lb, grit_lb, chain->mats + 1u);
    sim_scene_set_path(&scene, rows, count);
    bool good = sim_run(&scene, &options, result, error) == MR_OK;
    sim_scene_free(&scene);
    return good;
}

static inline struct mr_predictor_input case_input(const struct braking *braking, unsigned ms)
{
    double at[3];
    case_gear(braking, 1e-3 * ms, at);
    struct mr_predictor_input input = {.wheel_ft = (float)at[0],
                                       .speed_ft_s = (float)at[1],
                                       .deceleration_ft_s2 = (float)at[2],
                                       .is_braking_known = true,
                                       .is_on_runway = true};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        input.displacement_in[i] = NAN;
    return input;
}

#endif
