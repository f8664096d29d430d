/* Collisions against what mechanics says of them: two equal mats on a joint with slack throw each
 * other to and fro without loss. Units ft, lb, s. */

#include "tests/host/sim_case.h"

#define OUTPUTS 16

/* Mat 1 moves at v0 and finds mat 2 at rest; nothing rubs, nothing damps. */
static void two_mats(struct sim_scene *scene)
{
    double times_s[OUTPUTS];
    sim_scene_defaults(scene);
    scene->model = SIM_CONSISTENT;
    scene->mats = 2;
    scene->left = scene->right = scene->left_torsion = scene->right_torsion = SIM_FREE;
    scene->profile = SIM_LOW;
    scene->friction_law = SIM_NONE;
    scene->friction = 0.0;
    scene->force_lb = 0.0;
    scene->v0_mat = 1;
    scene->v0_ft_s = 2.0;
    scene->slack_ft = 0.005;
    scene->kl_lb_ft = 5e12;
    scene->cl_lb_s_ft = 0.0;
    scene->t_end_s = 0.02;
    for (int i = 0; i < OUTPUTS; i++)
        times_s[i] = scene->t_end_s * (i + 1) / OUTPUTS;
    sim_scene_set_list(&scene->t_out_s, times_s, OUTPUTS);
}

/* Opening of the joint: half a swing pressed, the slack at v0, half a swing hooked, back. */
static double opening_ft(const struct sim_scene *scene, double t_s)
{
    double mass_slug = scene->weight_lb / scene->g_ft_s2,
           swing = sqrt(2.0 * scene->kl_lb_ft / mass_slug), hit_s = M_PI / swing,
           flight_s = scene->slack_ft / scene->v0_ft_s, half_s = hit_s + flight_s;
    double halves = floor(t_s / half_s), in_s = t_s - halves * half_s;
    double out_ft = in_s < hit_s ? -scene->v0_ft_s / swing * sin(swing * in_s)
                                 : scene->v0_ft_s * (in_s - hit_s);
    return fmod(halves, 2.0) < 0.5 ? out_ft : scene->slack_ft - out_ft;
}

/* A step many swings long took the joint's push for a thing of the past, and the mats stayed
 * together: at one tolerance and at another alike, and each said that it was right. */
TEST(mats_that_collide_part_again)
{
    static const struct {
        const char *solver;
        double rtol;
    } runs[] = {{"implicit", 0.0},  {"implicit", 1e-5}, {"implicit", 1e-6}, {"implicit", 1e-8},
                {"implicit", 1e-9}, {"event", 0.0},     {NULL, 0.0}};
    struct sim_scene scene;
    two_mats(&scene);
    for (size_t k = 0; k < sizeof runs / sizeof runs[0]; k++) {
        struct sim_result result =
            run(&scene, (struct sim_options){.solver = runs[k].solver, .rtol = runs[k].rtol});
        assert_true(result.error_u_ft < 0.01 * scene.slack_ft);
        for (int i = 0; i < OUTPUTS; i++) {
            double t_s = scene.t_out_s.values[i], gap_ft = opening_ft(&scene, t_s),
                   middle_ft = 0.5 * scene.v0_ft_s * t_s;
            const double *u_ft = result.outputs[i].u_ft;
            assert_true(fabs(u_ft[1] - (middle_ft - 0.5 * gap_ft)) <= result.error_u_ft + 1e-12);
            assert_true(fabs(u_ft[2] - (middle_ft + 0.5 * gap_ft)) <= result.error_u_ft + 1e-12);
        }
        sim_result_free(&result);
    }
    sim_scene_free(&scene);
}
