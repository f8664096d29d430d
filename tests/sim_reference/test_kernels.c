/* host/sim's accelerations against the reference's, at scattered states of every golden scene. */
#include <math.h>
#include <stdio.h>

#include "host/sim/models/model.h"
#include "tests/cmocka_all.h"
#include "tests/sim_reference/model.h"

#define SCENES "tests/sim_reference/scenes/"
#define STATES 400

static double scatter(unsigned *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (double)(*seed >> 8) / (double)(1u << 23) - 1;
}

/* The reference's coordinates from node heights and displacements. */
static void to_reference(const struct ref_scene *s, const double *y, const double *y_rate,
                         const double *u, const double *u_rate, double *q, double *v)
{
    for (int n = 0; n < s->mats; n++) {
        q[ref_u(s, n)] = u[n];
        v[ref_u(s, n)] = u_rate[n];
    }
    for (int j = 0; s->model == REF_CONSISTENT && j <= s->mats; j++) {
        q[j] = y[j];
        v[j] = y_rate[j];
    }
    if (s->model == REF_REPORT) {
        for (int n = 0; n < s->mats; n++) {
            double th = asin((y[n + 1] - y[n]) / s->L);
            q[s->mats + 1 + n] = th;
            v[s->mats + 1 + n] = (y_rate[n + 1] - y_rate[n]) / (s->L * cos(th));
        }
        q[0] = (y[0] + y[1]) / 2;
        v[0] = (y_rate[0] + y_rate[1]) / 2;
    }
}

/* Node accelerations: the report's follow from q1'' and theta''. */
static void heights_accelerate(const struct ref_scene *s, const double *q, const double *v,
                               const double *a, double *y2)
{
    for (int j = 0; j <= s->mats; j++)
        y2[j] = s->model == REF_CONSISTENT ? a[j] : a[0];
    for (int n = 0; s->model == REF_REPORT && n < s->mats; n++) {
        double th = q[s->mats + 1 + n], w = v[s->mats + 1 + n];
        double sine2 = cos(th) * a[s->mats + 1 + n] - sin(th) * w * w; /* (sin th)'' */
        for (int j = 0; j <= s->mats; j++)
            y2[j] += (n == 0 ? (j == 0 ? -0.5 : 0.5) : j > n ? 1 : 0) * s->L * sine2;
    }
}

static void compare(const char *path, unsigned seed)
{
    static struct ref_scene s;
    struct sim_scene scene;
    struct error error = {0};
    struct model model;
    double z[4 * REF_COORDINATES], accel[REF_COORDINATES];
    assert_true(ref_load(&s, path));
    assert_int_equal(sim_scene_load(&scene, path, &error), MR_OK);
    assert_int_equal(model_make(&model, &scene, false, &error), MR_OK);
    model_start(&model, z);
    int size = 2 * s.mats + 1;
    for (int k = 0; k < STATES; k++) {
        double y[REF_NODES], y_rate[REF_NODES], u[REF_MATS], u_rate[REF_MATS], y2[REF_NODES];
        double q[REF_COORDINATES], v[REF_COORDINATES], a[REF_COORDINATES];
        struct ref_regime regime = {0};
        const struct span *span = &model.spans.spans[(size_t)k % model.spans.count];
        double t = 0.5 * (span->t0_s + fmin(span->t1_s, s.tend)), steep = k % 4 == 0 ? 0.3 : 0.003;
        for (int j = 0; j <= s.mats; j++) {
            y[j] = steep * scatter(&seed);
            y_rate[j] = 2 * scatter(&seed);
        }
        for (int n = 0; n < s.mats; n++) {
            u[n] = 0.004 * scatter(&seed);
            u_rate[n] = k % 3 == 0 && n % 2 == 0 ? 0 : scatter(&seed);
        }
        for (int j = 0; j <= s.mats; j++) {
            z[2 * j] = y[j];
            z[size + 2 * j] = y_rate[j];
        }
        for (int n = 0; n < s.mats; n++) {
            z[2 * n + 1] = u[n];
            z[size + 2 * n + 1] = u_rate[n];
        }
        if (span->t0_s >= s.tend)
            continue;
        model_enter_span(&model, (size_t)k % model.spans.count, z);
        model_sample_modes(&model, t, z);
        model_rates(&model, t, z, accel);
        struct ref_wheel wheel = ref_wheel_between(&s, t, t);
        to_reference(&s, y, y_rate, u, u_rate, q, v);
        ref_regime_of(&s, &wheel, t, q, v, &regime);
        ref_accelerations(&s, &regime, &wheel, t, q, v, a);
        heights_accelerate(&s, q, v, a, y2);
        double largest = 1;
        for (int j = 0; j <= s.mats; j++)
            largest = fmax(largest, fabs(y2[j]));
        for (int j = 0; j <= s.mats; j++) {
            if (!(fabs(accel[2 * j] - y2[j]) <= 1e-10 * largest))
                fail_msg("%s: state %d: node %d accelerates %.15g, reference %.15g", path, k, j + 1,
                         accel[2 * j], y2[j]);
        }
        for (int n = 0; n < s.mats; n++) {
            double expected = a[ref_u(&s, n)];
            if (!(fabs(accel[2 * n + 1] - expected) <= 1e-10 * fmax(1e4, fabs(expected))))
                fail_msg("%s: state %d: mat %d accelerates %.15g, reference %.15g", path, k, n + 1,
                         accel[2 * n + 1], expected);
        }
    }
    model_free(&model);
    sim_scene_free(&scene);
}

#define SCENE_TEST(name)                         \
    TEST(name)                                   \
    {                                            \
        compare(SCENES #name ".json", __LINE__); \
    }
SCENE_TEST(consistent_falls)
SCENE_TEST(consistent_ground_damping)
SCENE_TEST(consistent_low)
SCENE_TEST(consistent_slack)
SCENE_TEST(consistent_soil_friction)
SCENE_TEST(consistent_standard)
SCENE_TEST(report_following)
SCENE_TEST(report_frictionless)
SCENE_TEST(report_ground_damping)
SCENE_TEST(report_full_both)
SCENE_TEST(report_no_shear)
SCENE_TEST(report_rising)
SCENE_TEST(report_scaled)
SCENE_TEST(report_slack)
SCENE_TEST(report_stiff_hinge)
