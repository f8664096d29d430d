/* The planar models against mechanics written down a second time: Lagrange's equations by finite
 * differences, the report's own coordinates, conservation laws, closed forms. Units ft, lb, s,
 * slug, rad. */

#include <math.h>
#include <string.h>

#include "host/sim/models/kernel.h"
#include "host/sim/solvers/pass.h"
#include "tests/cmocka_all.h"

#define N    4
#define SIZE (2 * N + 1)
#define G    32.174

static struct error error;

static void near(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.15g is not %.15g to %g", value, expected, tolerance);
}

static void set_list(struct sim_list *list, const double *values, size_t count)
{
    sim_scene_set_list(list, values, count);
}

static struct sim_scene scene_of(enum sim_model kind, int mats)
{
    struct sim_scene scene;
    memset(&error, 0, sizeof error);
    sim_scene_defaults(&scene);
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

/* --- consistent model: Lagrange's equations --- */

static double positive(double x)
{
    return x > 0.0 ? x : 0.0;
}

static double lean(const struct sim_scene *s, const double *q, int n)
{
    return asin((q[2 * n + 2] - q[2 * n]) / s->length_ft);
}

static double kinetic(const struct sim_scene *s, const double *q, const double *v)
{
    double m = s->weight_lb / s->g_ft_s2, sum = 0.0;
    for (int n = 0; n < N; n++) {
        double d = q[2 * n + 2] - q[2 * n];
        double spin = (v[2 * n + 2] - v[2 * n]) / sqrt(s->length_ft * s->length_ft - d * d);
        double middle = 0.5 * (v[2 * n] + v[2 * n + 2]);
        sum += m * (v[2 * n + 1] * v[2 * n + 1] + middle * middle) +
               s->inertia_slug_ft2 * spin * spin;
    }
    return 0.5 * sum;
}

static double potential(const struct sim_scene *s, const double *q)
{
    double sum = 0.0, tad = s->tad_deg * acos(-1.0) / 180.0, half = 0.5 * s->length_ft;
    for (int j = 0; j <= N; j++) {
        double left = j > 0 ? lean(s, q, j - 1) : 0.0, right = j < N ? lean(s, q, j) : 0.0;
        double g = (j < N ? q[2 * j + 1] : 0.0) - (j > 0 ? q[2 * j - 1] : 0.0) + s->length_ft -
                   half * (cos(left) + cos(right));
        double stretch = g > s->slack_ft ? g - s->slack_ft : g < 0.0 ? g : 0.0;
        double turn = positive(fabs(right - left) - tad);
        double ends = j == 0 || j == N ? 1.0 : 2.0;
        if (j > 0) /* left end free */
            sum += 0.5 * s->kl_lb_ft * stretch * stretch;
        if (j > 0 && j < N) /* ends turn freely */
            sum += 0.5 * s->kt_lb_ft_rad * turn * turn;
        sum += 0.5 * s->kv_lb_ft * ends * positive(q[2 * j]) * positive(q[2 * j]);
        sum -= 0.5 * s->weight_lb * ends * q[2 * j];
    }
    return sum;
}

static void solve_dense(double a[SIZE][SIZE], double *x)
{
    for (int i = 0; i < SIZE; i++) {
        for (int r = i + 1; r < SIZE; r++) {
            double factor = a[r][i] / a[i][i];
            for (int k = i; k < SIZE; k++)
                a[r][k] -= factor * a[i][k];
            x[r] -= factor * x[i];
        }
    }
    for (int i = SIZE - 1; i >= 0; i--) {
        for (int k = i + 1; k < SIZE; k++)
            x[i] -= a[i][k] * x[k];
        x[i] /= a[i][i];
    }
}

/* p_i = dT/dv_i: exact differences, as T is quadratic in the rates. */
static double momentum(const struct sim_scene *s, const double *q, const double *v, int i)
{
    double up[SIZE], down[SIZE];
    memcpy(up, v, sizeof up);
    memcpy(down, v, sizeof down);
    up[i] += 1.0;
    down[i] -= 1.0;
    return 0.5 * (kinetic(s, q, up) - kinetic(s, q, down));
}

TEST(consistent_accelerations_are_lagranges)
{
    for (int slack = 0; slack <= 1; slack++) {
        struct sim_scene s = scene_of(SIM_CONSISTENT, N);
        s.profile = SIM_FULL;
        s.cl_lb_s_ft = s.ct_lb_ft_s_rad = s.cv_lb_s_ft = s.force_lb = 0.0;
        s.friction_law = SIM_NONE;
        s.kl_lb_ft = 3e4; /* soft, so that no term drowns another */
        s.kt_lb_ft_rad = 2e3;
        s.kv_lb_ft = 4e4;
        s.slack_ft = slack ? 0.002 : 0.0;
        struct model model;
        double z[2 * SIZE], accel[SIZE], mass[SIZE][SIZE], right[SIZE];
        make(&model, &s, z);
        scattered(z);
        model_sample(&model, 0.0, z);
        model_rates(&model, 0.0, z, accel);
        const double *q = z, *v = z + SIZE, e = 1e-5;
        for (int i = 0; i < SIZE; i++) {
            double up[SIZE], down[SIZE], along_up[SIZE], along_down[SIZE];
            memcpy(up, q, sizeof up);
            memcpy(down, q, sizeof down);
            up[i] += e;
            down[i] -= e;
            for (int k = 0; k < SIZE; k++) {
                along_up[k] = q[k] + e * v[k];
                along_down[k] = q[k] - e * v[k];
            }
            right[i] = (kinetic(&s, up, v) - potential(&s, up) - kinetic(&s, down, v) +
                        potential(&s, down)) /
                           (2 * e) -
                       (momentum(&s, along_up, v, i) - momentum(&s, along_down, v, i)) / (2 * e);
            for (int k = 0; k < SIZE; k++) {
                double unit[SIZE] = {0};
                unit[k] = 1.0;
                mass[i][k] = momentum(&s, q, unit, i);
            }
        }
        solve_dense(mass, right);
        for (int i = 0; i < SIZE; i++)
            near(accel[i], right[i], 1e-6 * (1.0 + fabs(right[i])));
        model_free(&model);
    }
}

/* --- report model: its own coordinates q1, u, theta, written out plainly --- */

TEST(report_accelerations_are_the_reports)
{
    for (int profile = SIM_LOW; profile <= SIM_FULL; profile++) {
        struct sim_scene s = scene_of(SIM_REPORT, N);
        s.profile = (enum sim_profile)profile;
        s.friction_law = SIM_TANH;
        s.veps_ft_s = 0.5;
        s.s0_ft = 3.0; /* on mat 2 */
        struct model model;
        double z[2 * SIZE], accel[SIZE], b = profile == SIM_FULL ? 1.0 : 0.0;
        make(&model, &s, z);
        scattered(z);
        model_sample(&model, 0.0, z);
        model_rates(&model, 0.0, z, accel);
        double m = 160.0 / G, h = 1.0, tad = 10.0 * acos(-1.0) / 180.0;
        double th[N + 2] = {0}, w[N + 2] = {0}, u[N + 2] = {0}, v[N + 2] = {0}, tension[N + 2],
                      moment[N + 2], soil[N + 2];
        for (int n = 1; n <= N; n++) {
            th[n] = asin((z[2 * n] - z[2 * n - 2]) / 2.0);
            w[n] = (z[SIZE + 2 * n] - z[SIZE + 2 * n - 2]) / (2.0 * cos(th[n]));
            u[n] = z[2 * n - 1];
            v[n] = z[SIZE + 2 * n - 1];
        }
        for (int j = 1; j <= N + 1; j++) {
            double g = u[j] - u[j - 1] + b * (2.0 - h * (cos(th[j]) + cos(th[j - 1])));
            double rate = v[j] - v[j - 1] + b * h * (w[j] * sin(th[j]) + w[j - 1] * sin(th[j - 1]));
            double turn = th[j] - th[j - 1], y = z[2 * j - 2];
            tension[j] = j == 1 ? 0.0 : 8e6 * g + 50.0 * rate;
            moment[j] = j == 1 || j == N + 1 || fabs(turn) <= tad
                          ? 0.0
                          : 1e5 * (turn - copysign(tad, turn)) + 1.0 * (w[j] - w[j - 1]);
            soil[j] = y >= -1e-9 ? 1e7 * y + 2e4 * z[SIZE + 2 * j - 2] : 0.0;
        }
        /* feet down: nodes 1 and 5; apex node 3. V lifts mat 1 (left down, right up) and mat 4 has
         * its right end down, both ends of mat 4 are not up: none there */
        double spin[N + 1], rise = 0.0;
        for (int n = 1; n <= N; n++) {
            double lift = n == 1 ? 120.0 : 0.0;
            spin[n] = (-h * sin(th[n]) * (tension[n] + tension[n + 1]) +
                       h * cos(th[n]) * (soil[n] - soil[n + 1]) - moment[n] + moment[n + 1] +
                       lift * h * cos(th[n])) /
                      2.0;
            double push = tension[n + 1] - tension[n] + (n == 2 ? 12000.0 : 0.0);
            double slide = (push - 80.0 * tanh(v[n] / 0.5)) / m;
            near(accel[2 * n - 1], slide, 1e-9 * (1.0 + fabs(slide)));
        }
        rise = -(soil[1] + soil[2]) / m - h * (cos(th[1]) * spin[1] - sin(th[1]) * w[1] * w[1]);
        for (int j = 1; j <= N + 1; j++) {
            near(accel[2 * j - 2], rise, 1e-9 * (1e3 + fabs(rise)));
            if (j <= N)
                rise += 2.0 * (cos(th[j]) * spin[j] - sin(th[j]) * w[j] * w[j]);
        }
        model_free(&model);
    }
}

/* Jacobians: residual force - M(p) accel differenced, as force = M accel at accel of that state. */
TEST(the_linearisation_is_the_derivative)
{
    for (int kind = SIM_REPORT; kind <= SIM_CONSISTENT; kind++) {
        for (int profile = SIM_LOW; profile <= SIM_FULL; profile++) {
            struct sim_scene s = scene_of((enum sim_model)kind, N);
            s.profile = (enum sim_profile)profile;
            s.friction_law = SIM_TANH;
            s.veps_ft_s = 0.5;
            s.thrust = SIM_LINEAR;
            s.s0_ft = 3.5;
            s.kl_lb_ft = 3e4;
            s.kt_lb_ft_rad = 2e3;
            s.kv_lb_ft = 4e4;
            s.cv_lb_s_ft = 90.0;
            if (kind == SIM_CONSISTENT)
                s.friction_normal = SIM_SOIL;
            struct model model;
            double z[2 * SIZE], accel[SIZE], mass[SIZE * MODEL_ROW], by_p[SIZE * MODEL_ROW],
                by_v[SIZE * MODEL_ROW];
            double drift[SIZE];
            make(&model, &s, z);
            scattered(z);
            model_sample(&model, 0.0, z);
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
                    for (int r = 0; r < MODEL_ROW; r++) {
                        int column = i + r - MODEL_BAND;
                        if (column < 0 || column >= SIZE)
                            continue;
                        left += mass[i * MODEL_ROW + r] * (a[column] - c[column]) / (2.0 * e);
                        if (column == k)
                            right = by_p[i * MODEL_ROW + r];
                        if (column == k - SIZE)
                            right = by_v[i * MODEL_ROW + r];
                    }
                    near(left, right, 5e-7 * (100.0 + fabs(right)));
                }
            }
            model_free(&model);
        }
    }
}

static struct pass_outcome run(struct model *model, double rtol, const struct stepper_kind *kind)
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
    const double *p = z, *v = z + m->size;
    double energy = 0.0;
    struct kernel_mat left = kernel_outside(m, -1);
    for (int n = 0; n <= m->mats; n++) {
        bool ground = n == m->mats;
        struct kernel_mat mat = ground ? kernel_outside(m, n)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
        bool free_end = (n == 0 && m->left_free) || (ground && m->right_free);
        if (!free_end && !(m->slack_ft > 0.0 && m->joint[n] == 0)) {
            double g = kernel_gap_ft(m, n, &left, &mat, m->full) -
                       (m->joint[n] > 0 ? m->slack_ft : 0.0);
            energy += 0.5 * m->kl * g * g;
        }
        if (m->torsion[n]) {
            double wound = hinge_wound_rad(m->jumps, m->torsion[n], kernel_turn_rad(&left, &mat),
                                           m->tad_rad);
            energy += 0.5 * m->kt * wound * wound;
        }
        double ends = n == 0 || ground ? 1.0 : 2.0;
        if (m->contact[n])
            energy += 0.5 * m->kv * ends * p[2 * n] * p[2 * n];
        if (!ground) {
            double middle = 0.5 * (v[2 * n] + v[2 * n + 2]);
            energy += 0.5 * (m->mass_slug * (mat.v * mat.v + middle * middle) +
                             m->inertia * mat.w * mat.w);
            energy -= 0.5 * m->weight_lb * (p[2 * n] + p[2 * n + 2]);
        }
        left = mat;
    }
    return energy;
}

TEST(energy_is_kept_through_every_switch)
{
    const double bump[] = {0.05, 0.12, 0.05};
    struct sim_scene s = scene_of(SIM_CONSISTENT, 20);
    s.profile = SIM_FULL;
    s.cl_lb_s_ft = s.ct_lb_ft_s_rad = s.cv_lb_s_ft = s.force_lb = 0.0;
    s.friction_law = SIM_NONE;
    s.slack_ft = 0.001;
    s.tad_deg = 4.0;
    s.v0_ft_s = 6.0;
    set_list(&s.bump_ft, bump, 3);
    struct model model;
    double z[2 * 41];
    make(&model, &s, z);
    double before = energy_lb_ft(&model, z), scale = 0.5 * 160.0 / G * 36.0;
    struct pass_outcome out = run(&model, 1e-12, &stepper_event);
    double after = energy_lb_ft(&model, out.z);
    assert_true(out.events > 100);
    near((after - before) / scale, 0.0, 1e-9);
    pass_free(&out);
    model_free(&model);
    sim_scene_free(&s);
}

TEST(momentum_is_kept_between_free_ends)
{
    const double bump[] = {0.02};
    for (int kind = SIM_REPORT; kind <= SIM_CONSISTENT; kind++) {
        struct sim_scene s = scene_of((enum sim_model)kind, 12);
        s.right = SIM_FREE;
        s.force_lb = 0.0;
        s.friction_law = SIM_NONE;
        set_list(&s.bump_ft, bump, 1);
        struct model model;
        double z[2 * 25], sum = 0.0;
        make(&model, &s, z);
        struct pass_outcome out = run(&model, 1e-9, &stepper_event);
        for (int n = 0; n < 12; n++)
            sum += out.z[25 + 2 * n + 1];
        near(sum, 2.0, 1e-11);
        pass_free(&out);
        model_free(&model);
        sim_scene_free(&s);
    }
}

/* Both mats of a small vee off the ground, under compression P: theta grows as cosh(t sqrt(P
 * L/I)). */
TEST(a_vee_under_compression_grows_at_its_rate)
{
    const double p = 12000.0, gap = -p / 8e6, heights[] = {1e-4, 1.1e-4, 1e-4};
    static const struct stepper_kind *const kinds[] = {&stepper_event, &stepper_implicit,
                                                       &stepper_cvode};
    struct sim_scene s = scene_of(SIM_REPORT, 2);
    s.left = SIM_FIXED;
    s.force_lb = s.v0_ft_s = s.shear_lb = 0.0;
    s.friction_law = SIM_NONE;
    s.bump_first = 1;
    s.t_end_s = 0.02;
    set_list(&s.bump_ft, heights, 3);
    set_list(&s.gap0_ft, &gap, 1);
    for (int i = 0; i < 3; i++) {
        struct model model;
        double z[10];
        make(&model, &s, z);
        struct pass_outcome out = run(&model, 1e-9, kinds[i]);
        double grown = (out.z[0] - out.z[2]) / (z[0] - z[2]);
        near(acosh(grown) / s.t_end_s, sqrt(p * 2.0 / 2.0), 0.001 * 109.5); /* 109.5 /s */
        pass_free(&out);
        model_free(&model);
    }
    sim_scene_free(&s);
}

/* One mat pushed past its friction, then left: u, and exact rest. */
TEST(a_pushed_mat_comes_to_exact_rest)
{
    static const struct stepper_kind *const kinds[] = {&stepper_event, &stepper_implicit,
                                                       &stepper_cvode};
    for (int kind = SIM_REPORT; kind <= SIM_CONSISTENT; kind++) {
        for (int i = 0; i < 3; i++) {
            struct sim_scene s = scene_of((enum sim_model)kind, 1);
            s.right = SIM_FREE;
            s.vac_ft_s = s.v0_ft_s = 0.0;
            s.s0_ft = 1.0;
            s.force_lb = 160.0; /* twice f W: accelerates and slows with f g */
            s.force_stop_s = 0.1;
            s.t_end_s = 0.3;
            struct model model;
            double z[6];
            make(&model, &s, z);
            struct pass_outcome out = run(&model, 1e-9, kinds[i]);
            near(out.z[1], 0.5 * G * 0.01, 1e-9);
            assert_true(out.z[3 + 1] == 0.0);
            pass_free(&out);
            model_free(&model);
            s.force_lb = 79.999; /* below the limit */
            make(&model, &s, z);
            out = run(&model, 1e-9, kinds[i]);
            assert_true(out.z[1] == 0.0);
            pass_free(&out);
            model_free(&model);
        }
    }
}

/* The soil cannot pull: a mat thrown up falls freely. */
TEST(a_thrown_mat_falls_freely)
{
    const double heights[] = {0.4, 0.4};
    struct sim_scene s = scene_of(SIM_CONSISTENT, 1);
    s.right = SIM_FREE;
    s.force_lb = s.v0_ft_s = 0.0;
    s.bump_first = 1;
    s.t_end_s = 0.1;
    set_list(&s.bump_ft, heights, 2);
    struct model model;
    double z[6];
    make(&model, &s, z);
    struct pass_outcome out = run(&model, 1e-10, &stepper_event);
    near(out.z[0] - z[0], 0.5 * G * 0.01, 1e-14);
    near(out.z[3], G * 0.1, 1e-13);
    pass_free(&out);
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
