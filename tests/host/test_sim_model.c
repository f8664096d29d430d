/* The planar models: Jacobians, conservation laws, closed forms. tests/sim_reference has their
 * accelerations a second time. Units ft, lb, s, slug, rad. */

#include "host/sim/elements/element.h"
#include "host/sim/models/kernel.h"
#include "host/sim/solvers/pass.h"
#include "tests/host/sim_case.h"

#define N    4
#define SIZE (2 * N + 1)

static struct sim_scene scene_of(enum sim_model kind, int mats)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    sim_scene_set_defaults(&scene);
    scene.model = kind;
    scene.mats = mats;
    scene.t_end_s = 0.05;
    return scene;
}

static void make(struct model *model, const struct sim_scene *scene, double *z)
{
    if (model_make(model, scene, false, &error) != MR_OK)
        fail_msg("%s", error.text);
    model_start(model, z);
}

/* A state with every mat at an angle of its own, some of them beyond TAD, nodes above and below the
 * ground. */
static void scattered(double *z)
{
    static const double heights[N + 1] = {0.002, -0.31, -0.52, -0.05, 0.004};
    static const double moves[N] = {0.011, 0.004, -0.003, 0.0007};
    static const double rates[SIZE] = {0.2, 1.1, -0.7, -0.4, 0.9, 2.0, 0.3, -0.1, -0.2};
    for (int j = 0; j <= N; j++)
        z[2 * j] = heights[j];
    for (int n = 0; n < N; n++)
        z[2 * n + 1] = moves[n];
    memcpy(z + SIZE, rates, sizeof rates);
}

/* Jacobians: residual force - M(p) accel differenced, as force = M accel at accel of that state. */
TEST(the_linearisation_is_the_derivative)
{
    for (int kind = SIM_MODEL_REPORT; kind <= SIM_MODEL_CONSISTENT; kind++) {
        for (int profile = SIM_PROFILE_LOW; profile <= SIM_PROFILE_FULL; profile++) {
            struct sim_scene s = scene_of((enum sim_model)kind, N);
            s.profile = (enum sim_profile)profile;
            s.friction_law = SIM_FRICTION_TANH;
            s.veps_ft_s = 0.5;
            s.thrust = SIM_THRUST_LINEAR;
            s.start_ft = 3.5;
            s.kl_lb_ft = 3e4;
            s.kt_lb_ft_rad = 2e3;
            s.kv_lb_ft = 4e4;
            s.cv_lb_s_ft = 90.0;
            s.element_values[ELEMENT_ground_damping] = profile == SIM_PROFILE_LOW ? 50.0 : 0.0;
            if (kind == SIM_MODEL_CONSISTENT)
                s.friction_normal = SIM_NORMAL_SOIL;
            struct model model;
            double z[2 * SIZE], accel[SIZE], mass[SIZE * MODEL_ROW_LENGTH],
                by_p[SIZE * MODEL_ROW_LENGTH], by_v[SIZE * MODEL_ROW_LENGTH];
            double drift[SIZE];
            make(&model, &s, z);
            scattered(z);
            model_sample_modes(&model, 0.0, z);
            model_rates(&model, 0.0, z, accel);
            model_linearise(&model, 0.0, z, accel, mass, by_p, by_v, drift);
            /* M d accel/dx = dR/dx: both sides as products with a direction */
            for (int k = 0; k <= 2 * SIZE; k++) {
                double up[2 * SIZE], down[2 * SIZE], a[SIZE], c[SIZE], e = k < SIZE ? 1e-6 : 1e-4,
                                                                       t = 0.0;
                memcpy(up, z, sizeof up);
                memcpy(down, z, sizeof down);
                if (k < 2 * SIZE) {
                    up[k] += e;
                    down[k] -= e;
                } else {
                    t = e = 1e-6; /* by time */
                }
                model_rates(&model, t, up, a);
                model_rates(&model, -t, down, c);
                for (int i = 0; i < SIZE; i++) {
                    double left = 0.0, right = k == 2 * SIZE ? drift[i] : 0.0;
                    for (int r = 0; r < MODEL_ROW_LENGTH; r++) {
                        int column = i + r - MODEL_HALF_BANDWIDTH;
                        if (column < 0 || column >= SIZE)
                            continue;
                        left += mass[i * MODEL_ROW_LENGTH + r] * (a[column] - c[column]) /
                                (2.0 * e);
                        if (column == k)
                            right = by_p[i * MODEL_ROW_LENGTH + r];
                        if (column == k - SIZE)
                            right = by_v[i * MODEL_ROW_LENGTH + r];
                    }
                    near(left, right, 5e-7 * (100.0 + fabs(right)));
                }
            }
            model_free(&model);
        }
    }
}

static struct pass_outcome pass(struct model *model, double rtol, const struct stepper_kind *kind)
{
    struct pass_outcome out;
    struct pass_request request = {kind, rtol, 0.0, 1000000, 0, 0.0};
    struct sim_options options = {0};
    pass_run(&out, model, &request, &options);
    assert_int_equal(out.status, SIM_OK);
    return out;
}

/* What springs, soil, weight and motion hold. */
static double energy_lb_ft(const struct model *m, const double *z)
{
    const double *p = z, *v = z + m->coordinate_count;
    double energy = 0.0;
    struct kernel_mat left = kernel_outside(m, -1);
    for (int n = 0; n <= m->mats; n++) {
        bool ground = n == m->mats;
        struct kernel_mat mat = ground ? kernel_outside(m, n)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
        bool free_end = (n == 0 && m->is_left_free) || (ground && m->is_right_free);
        if (!free_end && !(m->slack_ft > 0.0 && m->joint_mode[n] == 0)) {
            double g = kernel_gap_ft(m, n, &left, &mat, m->has_full_profile) -
                       (m->joint_mode[n] > 0 ? m->slack_ft : 0.0);
            energy += 0.5 * m->kl_lb_ft * g * g;
        }
        if (m->torsion[n]) {
            double wound = hinge_effective_angle_rad(m->has_torsion_jump, m->torsion[n],
                                                     kernel_joint_angle_rad(&left, &mat),
                                                     m->tad_rad);
            energy += 0.5 * m->kt_lb_ft_rad * wound * wound;
        }
        double ends = n == 0 || ground ? 1.0 : 2.0;
        if (m->contact[n])
            energy += 0.5 * m->kv_lb_ft * ends * p[2 * n] * p[2 * n];
        if (!ground) {
            double middle = 0.5 * (v[2 * n] + v[2 * n + 2]);
            energy += 0.5 * (m->mass_slug * (mat.v * mat.v + middle * middle) +
                             m->inertia_slug_ft2 * mat.w * mat.w);
            energy -= 0.5 * m->weight_lb * (p[2 * n] + p[2 * n + 2]);
        }
        left = mat;
    }
    return energy;
}

TEST(energy_is_kept_through_every_switch)
{
    const double bump[] = {0.05, 0.12, 0.05};
    struct sim_scene s = scene_of(SIM_MODEL_CONSISTENT, 20);
    s.profile = SIM_PROFILE_FULL;
    s.cl_lb_s_ft = s.ct_lb_ft_s_rad = s.cv_lb_s_ft = s.force_lb = 0.0;
    s.friction_law = SIM_FRICTION_NONE;
    s.slack_ft = 0.001;
    s.tad_deg = 4.0;
    s.v0_ft_s = 6.0;
    sim_scene_set_list(&s.bump_ft, bump, 3);
    struct model model;
    double z[2 * 41];
    make(&model, &s, z);
    double before = energy_lb_ft(&model, z), scale = 0.5 * 160.0 / G * 36.0;
    struct pass_outcome out = pass(&model, 1e-12, &stepper_event);
    double after = energy_lb_ft(&model, out.end_z);
    assert_true(out.events > 100);
    near((after - before) / scale, 0.0, 1e-9);
    pass_outcome_free(&out);
    model_free(&model);
    sim_scene_free(&s);
}

TEST(momentum_is_kept_between_free_ends)
{
    const double bump[] = {0.02};
    for (int kind = SIM_MODEL_REPORT; kind <= SIM_MODEL_CONSISTENT; kind++) {
        struct sim_scene s = scene_of((enum sim_model)kind, 12);
        s.right_end = SIM_END_FREE;
        s.force_lb = 0.0;
        s.friction_law = SIM_FRICTION_NONE;
        sim_scene_set_list(&s.bump_ft, bump, 1);
        struct model model;
        double z[2 * 25], sum = 0.0;
        make(&model, &s, z);
        struct pass_outcome out = pass(&model, 1e-9, &stepper_event);
        for (int n = 0; n < 12; n++)
            sum += out.end_z[25 + 2 * n + 1];
        near(sum, 2.0, 1e-11);
        pass_outcome_free(&out);
        model_free(&model);
        sim_scene_free(&s);
    }
}

/* One mat pushed past its friction, then left: u, and exact rest. */
TEST(a_pushed_mat_comes_to_exact_rest)
{
    static const struct stepper_kind *const kinds[] = {&stepper_event, &stepper_implicit,
                                                       &stepper_cvode};
    for (int kind = SIM_MODEL_REPORT; kind <= SIM_MODEL_CONSISTENT; kind++) {
        for (int i = 0; i < 3; i++) {
            struct sim_scene s = scene_of((enum sim_model)kind, 1);
            s.right_end = SIM_END_FREE;
            s.vac_ft_s = s.v0_ft_s = 0.0;
            s.start_ft = 1.0;
            s.force_lb = 160.0; /* twice f W: accelerates and slows with f g */
            s.force_stop_s = 0.1;
            s.t_end_s = 0.3;
            struct model model;
            double z[6];
            make(&model, &s, z);
            struct pass_outcome out = pass(&model, 1e-9, kinds[i]);
            near(out.end_z[1], 0.5 * G * 0.01, 1e-9);
            assert_true(out.end_z[3 + 1] == 0.0);
            pass_outcome_free(&out);
            model_free(&model);
            s.force_lb = 79.999; /* below the limit */
            make(&model, &s, z);
            out = pass(&model, 1e-9, kinds[i]);
            assert_true(out.end_z[1] == 0.0);
            pass_outcome_free(&out);
            model_free(&model);
        }
    }
}

/* The soil cannot pull: a mat thrown up falls freely. */
TEST(a_thrown_mat_falls_freely)
{
    const double heights[] = {0.4, 0.4};
    struct sim_scene s = scene_of(SIM_MODEL_CONSISTENT, 1);
    s.right_end = SIM_END_FREE;
    s.force_lb = s.v0_ft_s = 0.0;
    s.bump_first = 1;
    s.t_end_s = 0.1;
    sim_scene_set_list(&s.bump_ft, heights, 2);
    struct model model;
    double z[6];
    make(&model, &s, z);
    struct pass_outcome out = pass(&model, 1e-10, &stepper_event);
    near(out.end_z[0] - z[0], 0.5 * G * 0.01, 1e-14);
    near(out.end_z[3], G * 0.1, 1e-13);
    pass_outcome_free(&out);
    model_free(&model);
    sim_scene_free(&s);
}

TEST(many_tanhs_are_the_librarys)
{
    double in[2 * 997], out[997];
    for (int round = 0; round < 200; round++) {
        for (int i = 0; i < 997; i++)
            in[2 * i] = ldexp(sin(1e3 * i + round), round % 40 - 30);
        vector_tanh(in, 20.0, out, 997 - round % 7);
        for (int i = 0; i < 997 - round % 7; i++)
            assert_true(fabs(out[i] - tanh(20.0 * in[2 * i])) < 4e-16);
    }
    in[0] = 0.0;
    vector_tanh(in, 20.0, out, 1);
    assert_true(out[0] == 0.0);
    in[0] = -0.0;
    vector_tanh(in, 20.0, out, 1);
    assert_true(out[0] == 0.0 && signbit(out[0]));
}
