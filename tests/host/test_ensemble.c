/* Members of an ensemble side by side against the same chains one by one (common/matchain.h). */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host/sim/models/chains.h"

#define MATS   420u
#define JOINTS (MATS + 1u)
#define STEPS  6u /* a block */

static double uniform(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)(*state >> 33) * 0x1p-31;
}

struct members {
    struct mr_chain_params params[CHAINS_LANES];
    float gap_ft[CHAINS_LANES][JOINTS], grit_lb[CHAINS_LANES][JOINTS];
    float touchdown_ft[CHAINS_LANES], speed_ft_s[CHAINS_LANES], braking_ft_s2[CHAINS_LANES];
    float thrust_lb[CHAINS_LANES];
};

/* Eight runways and landings that have nothing in common but their mats. */
static void draw(struct members *m, uint64_t seed)
{
    uint64_t state = seed;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        m->params[k] =
            (struct mr_chain_params){.mats = MATS,
                                     .mat_length_ft = 2.0f / 7.0f,
                                     .mass_slug = 0.466f / 32.174f,
                                     .friction_lb = 0.466f * (float)(0.3 + 0.6 * uniform(&state)),
                                     .kl_lb_ft = 2.9e5f * (float)(0.7 + 0.3 * uniform(&state)),
                                     .cl_lb_s_ft = (float)(2.0 + 4.0 * uniform(&state)),
                                     .slack_ft = (float)(0.002 + 0.001 * uniform(&state)),
                                     .step_s = 1e-3f / (float)STEPS};
        for (unsigned j = 0; j < JOINTS; j++) {
            /* some closed, some hooked, some not known */
            double g = 0.0036 * uniform(&state) - 0.0003;
            m->gap_ft[k][j] = j % 97 == 5 ? NAN : (float)g;
            m->grit_lb[k][j] = j % 89 == 7 ? NAN : (float)(20.0 * uniform(&state));
        }
        m->touchdown_ft[k] = (float)(2.0 + 2.0 * uniform(&state));
        m->speed_ft_s[k] = (float)(24.0 + 16.0 * uniform(&state));
        m->braking_ft_s2[k] = (float)(3.0 + 7.0 * uniform(&state));
        m->thrust_lb[k] = 1300.0f / 12.0f / 32.174f * m->braking_ft_s2[k];
    }
}

static unsigned wheel_of(const struct members *m, unsigned k, unsigned step, float *thrust_lb)
{
    float t_s = (float)step * m->params[0].step_s, v = m->speed_ft_s[k], a = m->braking_ft_s2[k];
    *thrust_lb = t_s < v / a ? m->thrust_lb[k] : 0.0f;
    return (unsigned)((m->touchdown_ft[k] + v * t_s - 0.5f * a * t_s * t_s) * 3.5f) + 1u;
}

static void start(const struct members *m, struct mr_chain *one[CHAINS_LANES],
                  struct chains **eight)
{
    const float *gap_ft[CHAINS_LANES], *grit_lb[CHAINS_LANES];
    enum mr_status status;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        gap_ft[k] = m->gap_ft[k];
        grit_lb[k] = m->grit_lb[k];
        one[k] = malloc(sizeof *one[k]);
        assert_int_equal(mr_chain_start(one[k], &m->params[k], 1, gap_ft[k], grit_lb[k]), MR_OK);
    }
    *eight = chains_make(m->params, gap_ft, grit_lb, &status);
    assert_int_equal(status, MR_OK);
}

static void agree(struct mr_chain *const one[CHAINS_LANES], const struct chains *eight)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        for (unsigned n = 1; n <= MATS; n++) {
            float single = mr_chain_displacement_ft(one[k], n),
                  lane = chains_displacement_ft(eight, k, n);
            if (memcmp(&single, &lane, sizeof single) != 0)
                fail_msg("lane %u mat %u: %.9g, alone %.9g", k, n, (double)lane, (double)single);
        }
        for (unsigned j = 1; j <= MATS + 1u; j++) {
            float single = mr_chain_opening_ft(one[k], j), lane = chains_opening_ft(eight, k, j);
            assert_memory_equal(&single, &lane, sizeof single);
        }
    }
}

TEST(eight_are_as_each_alone)
{
    static struct members m;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        struct mr_chain *one[CHAINS_LANES];
        struct chains *eight;
        float most_in = 0.0f;
        draw(&m, seed);
        start(&m, one, &eight);
        for (unsigned step = 0; step < 9000u * STEPS; step++) {
            unsigned mat[CHAINS_LANES];
            float thrust_lb[CHAINS_LANES];
            for (unsigned k = 0; k < CHAINS_LANES; k++) {
                mat[k] = wheel_of(&m, k, step, &thrust_lb[k]);
                mr_chain_step(one[k], mat[k], thrust_lb[k]);
            }
            chains_step(eight, mat, thrust_lb);
            if (step % STEPS != STEPS - 1u)
                continue;
            for (unsigned k = 0; k < CHAINS_LANES; k++)
                assert_true(mr_chain_end_block(one[k]));
            assert_int_equal(chains_end_block(eight), 0);
            if (step % 997u == 0 || step % (100u * STEPS) == STEPS - 1u)
                agree(one, eight);
        }
        agree(one, eight);
        for (unsigned k = 0; k < CHAINS_LANES; k++) {
            most_in = fmaxf(most_in, 12.0f * chains_displacement_ft(eight, k, 200));
            free(one[k]);
        }
        assert_true(most_in > 0.05f); /* mats did move */
        chains_free(eight);
    }
}

TEST(what_runs_away_is_named)
{
    static struct members m;
    struct mr_chain *one[CHAINS_LANES];
    struct chains *eight;
    const unsigned mat[CHAINS_LANES] = {9, 9, 9, 9, 9, 9, 9, 9};
    float thrust_lb[CHAINS_LANES] = {0};
    draw(&m, 4);
    start(&m, one, &eight);
    thrust_lb[3] = 1e6f;
    for (unsigned step = 0; step < 60; step++)
        chains_step(eight, mat, thrust_lb);
    assert_int_equal(chains_end_block(eight), 1u << 3);
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        free(one[k]);
    chains_free(eight);
}

TEST(nonsense_is_refused)
{
    static struct members m;
    const float *gap_ft[CHAINS_LANES], *grit_lb[CHAINS_LANES];
    enum mr_status status;
    draw(&m, 5);
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        gap_ft[k] = m.gap_ft[k];
        grit_lb[k] = m.grit_lb[k];
    }
    m.params[6].kl_lb_ft = 2.9e8f;
    assert_null(chains_make(m.params, gap_ft, grit_lb, &status));
    assert_int_equal(status, MR_NUMERICS);
}
