/* Right-hand sides four mats at a time against the same one mat after the other: the same bits, in
 * every mode that a model can be in, for windows of 1 to 70 mats. And tanh against libm's. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/models/kernel.h"

#define MATS   70
#define STATES 60 /* of each window */

static struct error error;
static uint64_t seed = 1;

/* xorshift64* (S. Vigna, public domain). */
static uint64_t next(void)
{
    seed ^= seed >> 12;
    seed ^= seed << 25;
    seed ^= seed >> 27;
    return seed * 0x2545f4914f6cdd1du;
}

static double between(double low, double high)
{
    return low + (high - low) * (double)(next() >> 11) * 0x1p-53;
}

static int one_of(int count)
{
    return (int)(next() >> 33) % count;
}

/* Some mats flat and at rest, some flat and moving, some steep; some past 90 degrees now and then;
 * zeros of both signs. */
static void scatter(const struct model *m, double *z)
{
    double most_ft = one_of(20) == 0 ? 1.1 * m->length_ft : 0.4 * m->length_ft;
    for (int k = 0; k < 2 * m->size; k++)
        z[k] = between(-1.0, 1.0) * (k % 2 ? 0.01 : most_ft * 0.5);
    for (int j = 1; j <= m->mats; j++) {
        if (one_of(3) == 0)
            z[2 * j] = z[2 * j - 2];
        if (one_of(3) == 0)
            z[m->size + 2 * j] = z[m->size + 2 * j - 2];
        if (one_of(4) == 0)
            z[m->size + 2 * j - 1] = one_of(2) ? 0.0 : -0.0;
        if (one_of(8) == 0)
            z[2 * j] = z[2 * j - 2] = one_of(2) ? 0.0 : -0.0;
    }
}

static void any_modes(struct model *m)
{
    static const enum sim_friction laws[] = {SIM_STICK, SIM_TANH, SIM_SIGN, SIM_NONE};
    bool calm = one_of(3) == 0; /* nothing turns flat mats */
    m->law = laws[one_of(4)];
    m->full = one_of(2);
    m->slack_ft = one_of(2) ? 0.004 : 0.0;
    m->jumps = one_of(2);
    m->left_free = one_of(2);
    m->right_free = one_of(2);
    m->soil_normal = m->consistent && one_of(2);
    m->q1_lb = m->consistent || one_of(2) ? 0.0 : 13.7;
    m->shear_lb = one_of(2) ? 120.0 : 0.0;
    m->wheel_load_lb = one_of(2) ? 77.0 : 0.0;
    m->veps_ft_s = one_of(2) ? 1e-2 : 1e-3;
    for (int j = 0; j <= m->mats; j++) {
        m->contact[j] = calm || one_of(2);
        m->torsion[j] = (signed char)(calm || one_of(2) ? 0 : one_of(3) - 1);
        m->joint[j] = (signed char)(m->slack_ft > 0.0 ? one_of(3) - 1 : 0);
        m->slide[j] = (signed char)(one_of(3) - 1);
        m->lift[j] = (signed char)(calm || one_of(2) ? 0 : one_of(3) - 1);
    }
    for (int n = 0; n < m->mats; n++)
        m->rest_u_ft[n] = between(-0.01, 0.01);
    m->held = one_of(6) == 0 && !m->consistent ? m->first + one_of(m->last - m->first + 2) : -1;
    m->held_lift[0] = (signed char)(one_of(3) - 1);
    m->held_lift[1] = (signed char)(one_of(3) - 1);
    m->span = (struct span){.t1_s = 1.0,
                            .x0_ft = 3.0,
                            .speed_ft_s = 9.0,
                            .force_lb = 30.0,
                            .force_rate = 4.0,
                            .mat = one_of(m->mats + 1) - 1};
    int share = one_of(3);
    m->span.share = share == 0 ? -2 : share == 1 ? -1 : one_of(m->mats);
}

static void same(const struct model *m, const double *by_lanes, const double *by_mat)
{
    for (int k = 0; k < m->size; k++) {
        bool numbers = !(isnan(by_lanes[k]) && isnan(by_mat[k]));
        if (numbers && memcmp(by_lanes + k, by_mat + k, sizeof *by_mat) != 0)
            fail_msg(
                "%s, mats %d to %d, law %d, full %d, slack %g, held %d: entry %d is %a, not %a",
                m->consistent ? "consistent" : "report", m->first, m->last, (int)m->law, m->full,
                m->slack_ft, m->held, k, by_lanes[k], by_mat[k]);
    }
}

static void all_windows(enum sim_model kind)
{
    struct sim_scene scene;
    struct model m;
    sim_scene_defaults(&scene);
    scene.mats = MATS;
    scene.model = kind;
    scene.length_ft = 1.9; /* no power of two: products in another order are other bits */
    if (model_make(&m, &scene, true, &error) != MR_OK)
        fail_msg("%s", error.text);
    double *z = calloc(2 * (size_t)m.size, sizeof *z);
    double *accel = calloc(2 * (size_t)m.size, sizeof *accel);
    assert_non_null(z);
    assert_non_null(accel);
    model_start(&m, z);
    for (int count = 1; count <= MATS; count++) {
        for (int i = 0; i < STATES; i++) {
            m.first = one_of(3) == 0 ? 0 : one_of(MATS - count + 1);
            m.last = m.first + count - 1;
            any_modes(&m);
            scatter(&m, z);
            for (int k = 0; k < 2 * m.size; k++)
                accel[k] = 7.0; /* what is not written stays, in both */
            double t_s = between(0.0, 0.1);
            if (kind == SIM_CONSISTENT) {
                consistent_rates(&m, t_s, z, accel);
                consistent_rates_by_mat(&m, t_s, z, accel + m.size);
            } else {
                report_rates(&m, t_s, z, accel);
                report_rates_by_mat(&m, t_s, z, accel + m.size);
            }
            same(&m, accel, accel + m.size);
        }
    }
    free(z);
    free(accel);
    model_free(&m);
    sim_scene_free(&scene);
}

static void report_is_the_same_bits(void **state)
{
    (void)state;
    all_windows(SIM_REPORT);
}

static void consistent_is_the_same_bits(void **state)
{
    (void)state;
    all_windows(SIM_CONSISTENT);
}

/* Openings at the start are looked up mat by mat. */
static void gaps_are_not_lost(void **state)
{
    (void)state;
    const double gap_ft[] = {0.001, 0.002, 0.003};
    double z[2 * 17] = {0.0}, accel[17], without[17];
    struct sim_scene scene;
    struct model m;
    sim_scene_defaults(&scene);
    scene.mats = 8;
    scene.friction = 0.0;
    assert_int_equal(model_make(&m, &scene, false, &error), MR_OK);
    model_start(&m, z);
    m.first = 0;
    m.last = 7;
    report_rates(&m, 0.0, z, without);
    assert_int_equal(sim_scene_set_list(&scene.gap0_ft, gap_ft, 3, &error), MR_OK);
    report_rates(&m, 0.0, z, accel);
    /* joint 2 is open by 2e-3 ft, joint 1 by 1e-3: mat 1 is pulled by KL times what joint 2 has
     * more than joint 1, of which its left end, free, has none */
    double pull_ft_s2 = scene.kl_lb_ft * (scene.left == SIM_FREE ? 0.002 : 0.001) /
                        (scene.weight_lb / scene.g_ft_s2);
    assert_true(fabs(accel[1] - without[1] - pull_ft_s2) < 1e-9 * pull_ft_s2);
    model_free(&m);
    sim_scene_free(&scene);
}

static void tanh_is_libms(void **state)
{
    (void)state;
    double from[2 * 9], to[9], again[9];
    for (int i = 0; i < 20000; i++) {
        int count = 1 + one_of(9);
        double widest = pow(10.0, between(-12.0, 2.0));
        for (int k = 0; k < 18; k++)
            from[k] = between(-widest, widest);
        lanes_tanh(from, 3.0, to, count);
        for (int k = 0; k < count; k++) {
            double x = 3.0 * from[2 * k];
            assert_true(fabs(to[k] - tanh(x)) <= 4e-16);
            lanes_tanh(from + 2 * k, 3.0, again + k, 1);
            assert_memory_equal(again + k, to + k, sizeof *to);
        }
    }
    from[0] = -0.0;
    lanes_tanh(from, 1.0, to, 1);
    assert_true(to[0] == 0.0 && signbit(to[0]));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(report_is_the_same_bits),
        cmocka_unit_test(consistent_is_the_same_bits),
        cmocka_unit_test(gaps_are_not_lost),
        cmocka_unit_test(tanh_is_libms),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
