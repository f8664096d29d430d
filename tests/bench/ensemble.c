/* What a member of an ensemble of runways costs: eight chains side by side against the same eight
 * one by one, and a landing of 256 members as `matrig advise` plays it. */
#include "tests/bench/bench.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "common/splitmix.h"
#include "host/advise/members.h"
#include "host/sim/models/chains.h"

#define MATS        420u
#define JOINTS      (MATS + 1u)
#define STEPS       6u    /* in a millisecond, */
#define BLOCKS      7000u /* of which a landing of 28 ft/s at 4.2 ft/s2 has so many */
#define MEMBERS     256u
#define REPETITIONS 3
#define SPEED_FT_S  28.0f
#define FROM_FT     3.0f
#define MATS_PER_FT 3.5f

struct eight {
    struct mr_chain_params params[CHAINS_LANES];
    float gap_ft[CHAINS_LANES][JOINTS], grit_lb[CHAINS_LANES][JOINTS];
    float braking_ft_s2[CHAINS_LANES], thrust_lb[CHAINS_LANES];
};

/* Runways as the standard series has them. */
static void draw(struct eight *e)
{
    uint64_t state = 1973;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        e->params[k] = (struct mr_chain_params){
            .mats = MATS,
            .mat_length_ft = 1.0f / MATS_PER_FT,
            .mass_slug = 0.466f / 32.174f,
            .friction_lb = 0.466f * (float)(0.45 + 0.1 * mr_splitmix64_uniform(&state)),
            .kl_lb_ft = 2.9e5f * (float)(0.7 + 0.3 * mr_splitmix64_uniform(&state)),
            .cl_lb_s_ft = 5.0f,
            .slack_ft = 0.0025f,
            .step_s = 1e-3f / (float)STEPS};
        for (unsigned j = 0; j < JOINTS; j++) {
            e->gap_ft[k][j] = fminf(0.003f * (float)mr_splitmix64_uniform(&state), 0.0025f);
            e->grit_lb[k][j] = (float)(20.0 * mr_splitmix64_uniform(&state));
        }
        e->braking_ft_s2[k] = (float)(4.2 + 0.4 * mr_splitmix64_uniform(&state));
        e->thrust_lb[k] = 1300.0f / 12.0f / 32.174f * e->braking_ft_s2[k];
    }
}

static unsigned wheel_of(const struct eight *e, unsigned k, unsigned step, float *thrust_lb)
{
    float t_s = (float)step * e->params[k].step_s, a = e->braking_ft_s2[k];
    *thrust_lb = t_s < SPEED_FT_S / a ? e->thrust_lb[k] : 0.0f;
    t_s = fminf(t_s, SPEED_FT_S / a);
    return (unsigned)((FROM_FT + SPEED_FT_S * t_s - 0.5f * a * t_s * t_s) * MATS_PER_FT) + 1u;
}

static double one_by_one_ms(const struct eight *e)
{
    static struct mr_chain chain;
    double begin_ms = bench_clock_ms();
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        mr_chain_start(&chain, &e->params[k], 1, e->gap_ft[k], e->grit_lb[k]);
        for (unsigned step = 0; step < BLOCKS * STEPS; step++) {
            float thrust_lb;
            unsigned mat = wheel_of(e, k, step, &thrust_lb);
            mr_chain_step(&chain, mat, thrust_lb);
            if (step % STEPS == STEPS - 1u)
                mr_chain_settle(&chain);
        }
    }
    return bench_clock_ms() - begin_ms;
}

static double side_by_side_ms(const struct eight *e)
{
    const float *gap_ft[CHAINS_LANES], *grit_lb[CHAINS_LANES];
    enum mr_status status;
    double begin_ms = bench_clock_ms();
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        gap_ft[k] = e->gap_ft[k];
        grit_lb[k] = e->grit_lb[k];
    }
    struct chains *chains = chains_new(e->params, gap_ft, grit_lb, &status);
    for (unsigned step = 0; chains && step < BLOCKS * STEPS; step++) {
        unsigned mat[CHAINS_LANES];
        float thrust_lb[CHAINS_LANES];
        for (unsigned k = 0; k < CHAINS_LANES; k++)
            mat[k] = wheel_of(e, k, step, &thrust_lb[k]);
        chains_step(chains, mat, thrust_lb);
        if (step % STEPS == STEPS - 1u)
            chains_settle(chains);
    }
    chains_free(chains);
    return bench_clock_ms() - begin_ms;
}

/* Processor time of all threads. */
static double processor_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double landing_s(void)
{
    const struct advise_runway runway = {.chain = {.mats = MATS,
                                                   .mat_length_ft = 1.0f / MATS_PER_FT,
                                                   .mass_slug = 0.466f / 32.174f,
                                                   .friction_lb = 0.233f,
                                                   .kl_lb_ft = 2.9e5f,
                                                   .cl_lb_s_ft = 5.0f,
                                                   .slack_ft = 0.0025f,
                                                   .step_s = 1e-4f},
                                         .grit_lb = 10.0,
                                         .thrust_lb_per_g = 1300.0 / 12.0};
    struct advise_members members;
    struct advise_braking *braking = calloc(MEMBERS, sizeof *braking);
    struct advise_met *met = calloc(MEMBERS, sizeof *met);
    double took_s = (double)NAN;
    if (braking && met && advise_members_draw(&members, &runway, MEMBERS, 1) == MR_OK) {
        for (unsigned m = 0; m < MEMBERS; m++)
            braking[m] = (struct advise_braking){.speed_ft_s = (double)SPEED_FT_S,
                                                 .touchdown_ft = (double)FROM_FT,
                                                 .mean_ft_s2 = 4.2 + 0.0015 * m};
        double begin_s = processor_s();
        if (advise_play(&members, braking, false, met))
            took_s = processor_s() - begin_s;
        advise_members_free(&members);
    }
    free(braking);
    free(met);
    return took_s;
}

void bench_ensemble(void)
{
    static struct eight eight;
    double one[REPETITIONS], side[REPETITIONS], whole[REPETITIONS];
    printf("ensembles, a landing of 7 s on 420 mats:\n");
    draw(&eight);
    for (int r = 0; r < REPETITIONS; r++) {
        one[r] = one_by_one_ms(&eight);
        side[r] = side_by_side_ms(&eight);
        whole[r] = landing_s();
    }
    double one_ms = bench_median(one, REPETITIONS), side_ms = bench_median(side, REPETITIONS);
    printf("  a member alone %.3g ms, one of eight side by side %.3g ms\n", one_ms / CHAINS_LANES,
           side_ms / CHAINS_LANES);
    bench_line("time of eight side by side over eight one by one", side_ms / one_ms, "", true, 0.4);
    bench_line("processor time of 256 members on all cores", bench_median(whole, REPETITIONS), "s",
               true, 0.8);
}
