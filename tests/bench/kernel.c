/* What one mat's accelerations cost in the report model, and what its arithmetic alone would cost.
 *
 * Counted in kernel.h and report.c, for a mat on soil, low profile, no slack, torsion within its
 * dead band: angle 7 and a root and a division, tension 5, soil 3, push 1, friction and u'' 4,
 * turning 11, (sin theta)'' 5, height 2. Friction tanh adds a division, a call and a product. */
#include "tests/bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/sim/models/model.h"

#define MATS        1000
#define FLOPS       38.0
#define EVALUATIONS 200
#define REPETITIONS 15
#define CHAINS      8
#define ROUNDS      20000

#if defined __GNUC__ && !defined __clang__
#define SCALAR __attribute__((noinline, optimize("no-tree-vectorize,no-tree-slp-vectorize")))
#else
#define SCALAR __attribute__((noinline))
#endif

static volatile double sink;

/* ns of one product or sum when eight chains of them run side by side. */
SCALAR static double flop_ns(void)
{
    double x[CHAINS], a = 1.0 - 1e-9, b = 1e-9;
    for (int k = 0; k < CHAINS; k++)
        x[k] = 1.0 + 0.1 * k;
    double x0 = x[0], x1 = x[1], x2 = x[2], x3 = x[3], x4 = x[4], x5 = x[5], x6 = x[6], x7 = x[7];
    double begin_ms = bench_clock_ms();
    for (int i = 0; i < ROUNDS; i++) {
        x0 = x0 * a + b;
        x1 = x1 * a + b;
        x2 = x2 * a + b;
        x3 = x3 * a + b;
        x4 = x4 * a + b;
        x5 = x5 * a + b;
        x6 = x6 * a + b;
        x7 = x7 * a + b;
    }
    double ms = bench_clock_ms() - begin_ms;
    sink = x0 + x1 + x2 + x3 + x4 + x5 + x6 + x7;
    return 1e6 * ms / (2.0 * CHAINS * ROUNDS);
}

/* ns of a root and a division, one pair after the other not waiting for it. */
SCALAR static double root_ns(void)
{
    double sum = 0.0, x = 0.5;
    double begin_ms = bench_clock_ms();
    for (int i = 0; i < ROUNDS; i++) {
        x += 1e-6;
        sum += 1.0 / sqrt(x);
    }
    double ms = bench_clock_ms() - begin_ms;
    sink = sum;
    return 1e6 * ms / ROUNDS;
}

/* ns of a tanh and its division, at speeds such as the mats have. */
SCALAR static double tanh_ns(const struct model *m, const double *z)
{
    double sum = 0.0;
    double begin_ms = bench_clock_ms();
    for (int n = 0; n < m->mats; n++)
        sum += tanh(z[m->size + 2 * n + 1] / m->veps_ft_s);
    double ms = bench_clock_ms() - begin_ms;
    sink = sum;
    return 1e6 * ms / m->mats;
}

/* Numbers between -1 and 1 that look random. */
static double spread(int i)
{
    double x = 0.6180339887498949 * i + 0.31 * i * (double)i / 97.0;
    return 2.0 * (x - floor(x)) - 1.0;
}

/* Every mat turned and moving, some nodes on the ground and some off it. */
static void scatter(struct model *m, double *z)
{
    for (int i = 0; i < m->size; i++) {
        z[i] = (i % 2 ? 1e-3 : 0.01) * spread(i);
        z[m->size + i] = (i % 2 ? 0.05 : 0.5) * spread(i + 7);
    }
    m->first = 0;
    m->last = m->mats - 1;
    model_sample(m, 0.0, z);
}

static double evaluation_ns(struct model *m, const double *z, double *accel)
{
    double ns[REPETITIONS];
    for (int r = 0; r < REPETITIONS; r++) {
        double begin_ms = bench_clock_ms();
        for (int i = 0; i < EVALUATIONS; i++)
            model_rates(m, 0.0, z, accel);
        ns[r] = 1e6 * (bench_clock_ms() - begin_ms) / EVALUATIONS / m->mats;
        sink = accel[0];
    }
    return bench_median(ns, REPETITIONS);
}

void bench_kernel(void)
{
    const enum sim_friction laws[] = {SIM_STICK, SIM_TANH};
    double flop[REPETITIONS], root[REPETITIONS];
    printf("report model, %d mats, all in motion, ns a mat and evaluation:\n", MATS);
    for (int r = 0; r < REPETITIONS; r++) {
        flop[r] = flop_ns();
        root[r] = root_ns();
    }
    double arithmetic_ns = FLOPS * bench_median(flop, REPETITIONS) +
                           bench_median(root, REPETITIONS);
    for (int i = 0; i < 2; i++) {
        struct sim_scene scene;
        struct model model;
        struct error error = {0};
        sim_scene_defaults(&scene);
        scene.mats = MATS;
        scene.friction_law = laws[i];
        scene.veps_ft_s = 1e-2;
        double *z = calloc(3 * (2 * MATS + 1), sizeof *z);
        if (!z || model_make(&model, &scene, false, &error) != MR_OK) {
            printf("  %s\n", error.text);
            free(z);
            return;
        }
        model_start(&model, z);
        scatter(&model, z);
        double limit_ns = arithmetic_ns;
        if (laws[i] == SIM_TANH) {
            double ns[REPETITIONS];
            for (int r = 0; r < REPETITIONS; r++)
                ns[r] = tanh_ns(&model, z);
            limit_ns += bench_median(ns, REPETITIONS);
        }
        printf(
            "  arithmetic alone, friction %-5s %38.1f ns    (%.0f flops, a root, a division%s)\n",
            laws[i] == SIM_TANH ? "tanh" : "stick", limit_ns, FLOPS,
            laws[i] == SIM_TANH ? ", a tanh" : "");
        bench_line(laws[i] == SIM_TANH ? "friction tanh" : "friction stick",
                   evaluation_ns(&model, z, z + 2 * model.size), "ns", true, 15.0);
        model_free(&model);
        free(z);
        sim_scene_free(&scene);
    }
}
