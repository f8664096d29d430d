/* The small single-precision chain of common/ against the host's chain in double precision at a
 * quarter of the step. */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/matchain.h"
#include "host/sim/sim.h"
#include "tests/cmocka_all.h"
#include "tests/host/model_mat.h"

#define MATS         420
#define STATIONS     8
#define ROWS         600
#define ROW_S        0.01
#define STEP_S       1e-4f
#define TOUCHDOWN_FT 3.0

static struct error error;
static struct sim_path_row rows[ROWS];
static size_t row_count;
static double gaps_ft[MATS + 1], grits_lb[MATS + 1];

static double uniform(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

/* As in the report's landing 5: 35.5 ft/s, braking from 6.6 to 9.2 ft/s2; or gentler. */
static void make_landing(uint64_t seed, double speed_ft_s, double from_ft_s2, double to_ft_s2)
{
    double at_ft = TOUCHDOWN_FT, v_ft_s = speed_ft_s;
    for (int j = 0; j <= MATS; j++) {
        gaps_ft[j] = fmin(0.036 * uniform(&seed), 0.030) / 12.0;
        grits_lb[j] = 20.0 * uniform(&seed);
    }
    for (row_count = 0; row_count < ROWS && v_ft_s > 0.0; row_count++) {
        double t_s = ROW_S * (double)row_count;
        double a_ft_s2 = from_ft_s2 +
                         (to_ft_s2 - from_ft_s2) * fmin(fmax(t_s - 1.2, 0.0) / 2.4, 1.0);
        rows[row_count] = (struct sim_path_row){t_s, at_ft, 1300.0 / 12.0 * a_ft_s2 / 32.174};
        at_ft += v_ft_s * ROW_S - 0.5 * a_ft_s2 * ROW_S * ROW_S;
        v_ft_s -= a_ft_s2 * ROW_S;
    }
    rows[row_count - 1].force_lb = 0.0;
}

static void fine(struct sim_result *result, struct sim_scene *scene)
{
    static double stations_ft[STATIONS];
    sim_scene_defaults(scene);
    scene->model = SIM_CHAIN;
    scene->mats = MATS;
    model_mat_chain(scene);
    scene->left = scene->right = SIM_FIXED;
    scene->v0_ft_s = 0.0;
    scene->t_dwell_s = 0.3;
    sim_scene_set_list(&scene->gap0_ft, gaps_ft, MATS + 1);
    sim_scene_set_list(&scene->grit_lb, grits_lb, MATS + 1);
    sim_scene_set_path(scene, rows, row_count);
    for (int i = 0; i < STATIONS; i++)
        stations_ft[i] = 40.0 + 10.0 * i;
    const struct sim_options options = {
        .dt_s = 2.5e-5, .sample_dt_s = 1e-3, .station_ft = stations_ft, .station_count = STATIONS};
    memset(&error, 0, sizeof error);
    sim_run(scene, &options, result, &error);
    assert_string_equal(error.text, "");
}

static void thrust_at(double t_s, unsigned *mat, float *thrust_lb)
{
    size_t i = (size_t)(t_s / ROW_S);
    if (i + 1 >= row_count) {
        *mat = 0;
        *thrust_lb = 0.0f;
        return;
    }
    double part = t_s / ROW_S - (double)i;
    double at_ft = rows[i].x_ft + part * (rows[i + 1].x_ft - rows[i].x_ft);
    *mat = (unsigned)(at_ft / (2.0 / 7.0) + 1e-9) + 1u;
    *thrust_lb = (float)(rows[i].force_lb + part * (rows[i + 1].force_lb - rows[i].force_lb));
}

/* rms over stations and milliseconds, inches. */
static double rms_in(unsigned group, const struct sim_result *truth, double *updates)
{
    static struct mr_chain chain;
    static float gap_ft[MATS + 1], grit_lb[MATS + 1];
    const struct mr_chain_params params = {.mats = MATS,
                                           .mat_length_ft = 2.0f / 7.0f,
                                           .mass_slug = 0.466f / 32.174f,
                                           .friction_lb = 0.5f * 0.466f,
                                           .kl_lb_ft = 2.9e5f,
                                           .cl_lb_s_ft = 5.0f,
                                           .slack_ft = 0.0025f,
                                           .step_s = STEP_S};
    double sum = 0.0;
    size_t count = 0, block = 0;
    for (int j = 0; j <= MATS; j++) {
        gap_ft[j] = (float)gaps_ft[j];
        grit_lb[j] = (float)grits_lb[j];
    }
    assert_int_equal(mr_chain_start(&chain, &params, group, gap_ft, grit_lb), MR_OK);
    double step_s = (double)chain.step_s, t_s = 0.0;
    for (block = 1; block < truth->sample_count; block++) {
        while (t_s < 1e-3 * (double)block - 1e-9) {
            unsigned mat;
            float thrust_lb;
            thrust_at(t_s + 0.5 * step_s, &mat, &thrust_lb);
            mr_chain_step(&chain, mat, thrust_lb);
            t_s += step_s;
        }
        assert_true(mr_chain_settle(&chain));
        for (unsigned i = 0; i < STATIONS; i++) {
            unsigned mat = (unsigned)((40.0 + 10.0 * i) / (2.0 / 7.0) + 1e-9) + 1u;
            double off_in = 12.0 * ((double)mr_chain_displacement_ft(&chain, mat) -
                                    truth->sample_u_ft[block * STATIONS + i]);
            sum += off_in * off_in;
            count++;
        }
    }
    *updates = (double)mr_chain_take_updates(&chain);
    return sqrt(sum / (double)count);
}

TEST(agrees_with_the_hosts_chain)
{
    static const struct {
        uint64_t seed;
        double speed_ft_s, from_ft_s2, to_ft_s2;
    } landings[] = {
        {1, 28.0, 4.0, 4.0}, {2, 35.5, 6.6, 9.2}, {3, 35.5, 6.6, 9.2}, {4, 40.0, 12.0, 20.0}};
    for (size_t i = 0; i < sizeof landings / sizeof landings[0]; i++) {
        struct sim_scene scene;
        struct sim_result truth;
        double updates[3];
        make_landing(landings[i].seed, landings[i].speed_ft_s, landings[i].from_ft_s2,
                     landings[i].to_ft_s2);
        fine(&truth, &scene);
        double one = rms_in(1, &truth, &updates[0]), two = rms_in(2, &truth, &updates[1]),
               four = rms_in(4, &truth, &updates[2]);
        print_message("landing %zu: rms %.4f in (%.2f M updates), two in one %.3f in (%.2f), four "
                      "%.3f in (%.2f)\n",
                      i + 1, one, updates[0] / 1e6, two, updates[1] / 1e6, four, updates[2] / 1e6);
        assert_true(one < 0.005);
        sim_result_free(&truth);
        sim_scene_free(&scene);
    }
}
