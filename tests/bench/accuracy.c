/* Time that a solver needs for a lift within 5e-6 ft on the standard scene of 30 mats with friction
 * tanh, and within 1e-5 ft on the same with exact sticking.
 *
 * The error of a run is its largest lift difference to a reference at 67 times and of the largest
 * lift. A run can hit by luck, fixed steps above all: a run counts when every finer one on the
 * ladder is within the limit too, four of them at least. The ladders: tolerances by half decades
 * from 3e-3 to 1e-10, steps by the factor 0.93 from the stability limit to a thirtieth of it. The
 * time is that of the pass that answers; every solver is checked against a second pass alike. */
#include "tests/bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define REFERENCE_RTOL 1e-12
#define RUNGS_MAX      64
#define REPETITIONS    15
#define STEP_FACTOR    0.93
#define SHORTEST_STEP  (1.0 / 30.0) /* of the stability limit */
#define FINER_LEAST    4
#define SOLVERS        4
#define COARSEST_RTOL  3.1622776601683794e-3
#define FINEST_RTOL    1e-10
#define LONGEST_MS     6000.0 /* a ladder ends at such a run */
#define LONGEST_S      20.0   /* what takes longer, as it chatters, has no answer */

struct part {
    const char *scene;
    double limit_ft;
};

struct rung {
    struct sim_options options;
    double error_ft; /* INFINITY: no answer */
    double ms;
};

struct ladder {
    const char *solver;
    struct rung rungs[RUNGS_MAX];
    int count;
    int chosen; /* -1: none is within the limit */
    double ms;
};

static double apart_ft(const struct sim_result *a, const struct sim_result *b)
{
    double most = fabs(a->max_lift_ft - b->max_lift_ft);
    for (size_t i = 0; i < a->output_count; i++)
        most = fmax(most, fabs(a->outputs[i].lift_ft - b->outputs[i].lift_ft));
    return most;
}

static void climb(struct ladder *ladder, const struct sim_scene *scene, double limit_ft,
                  const struct sim_result *reference)
{
    bool fixed = strcmp(ladder->solver, "rk4") == 0;
    double first = fixed ? 0.999 * reference->dt_limit_s : COARSEST_RTOL;
    double factor = fixed ? STEP_FACTOR : sqrt(0.1);
    double value = first, last = fixed ? SHORTEST_STEP * first : FINEST_RTOL;
    for (ladder->count = 0; ladder->count < RUNGS_MAX && value > 0.999 * last; value *= factor) {
        struct rung *rung = &ladder->rungs[ladder->count++];
        struct sim_result result;
        rung->options = (struct sim_options){.solver = ladder->solver, .limit_s = LONGEST_S};
        *(fixed ? &rung->options.dt_s : &rung->options.rtol) = value;
        rung->error_ft = bench_run(scene, &rung->options, &result, NULL)
                           ? apart_ft(&result, reference)
                           : HUGE_VAL;
        rung->ms = result.pass_ms;
        sim_result_free(&result);
        if (isfinite(rung->error_ft) && rung->ms > LONGEST_MS)
            break;
    }
    int coarsest = ladder->count;
    while (coarsest > 0 && ladder->rungs[coarsest - 1].error_ft <= limit_ft)
        coarsest--;
    ladder->chosen = coarsest + FINER_LEAST < ladder->count ? coarsest : -1;
}

/* The least of interleaved repetitions: a pass is timed by the wall clock, to which others on the
 * machine only add. */
static void time_chosen(struct ladder *ladders, const struct sim_scene *scene)
{
    for (int s = 0; s < SOLVERS; s++)
        ladders[s].ms = ladders[s].chosen < 0 ? (double)NAN : HUGE_VAL;
    for (int r = 0; r < REPETITIONS; r++) {
        for (int s = 0; s < SOLVERS; s++) {
            struct sim_result result;
            if (ladders[s].chosen < 0)
                continue;
            bench_run(scene, &ladders[s].rungs[ladders[s].chosen].options, &result, NULL);
            ladders[s].ms = fmin(ladders[s].ms, result.pass_ms);
            sim_result_free(&result);
        }
    }
}

static void print_ladder(const struct ladder *ladder, double limit_ft)
{
    printf("  %-12s", ladder->solver);
    if (ladder->chosen < 0) {
        double best = HUGE_VAL;
        for (int i = 0; i < ladder->count; i++)
            best = fmin(best, ladder->rungs[i].error_ft);
        printf("never within %g ft with all that is finer; best %.2g ft\n", limit_ft, best);
        return;
    }
    const struct rung *rung = &ladder->rungs[ladder->chosen];
    bool fixed = rung->options.dt_s > 0.0;
    double worst = 0.0;
    for (int i = ladder->chosen; i < ladder->count; i++)
        worst = fmax(worst, ladder->rungs[i].error_ft);
    printf("%8.3f ms a pass at %s %-8.3g error %.2g, worst of %d finer %.2g ft\n", ladder->ms,
           fixed ? "dt  " : "rtol", fixed ? rung->options.dt_s : rung->options.rtol, rung->error_ft,
           ladder->count - 1 - ladder->chosen, worst);
}

static void bench_part(const struct part *part)
{
    struct ladder ladders[SOLVERS] = {
        {.solver = "event"}, {.solver = "implicit"}, {.solver = "cvode"}, {.solver = "rk4"}};
    struct sim_scene scene;
    struct sim_result reference = {0}, second = {0};
    printf("lift within %g ft, %s (event is what auto takes here):\n", part->limit_ft, part->scene);
    if (!bench_load(&scene, part->scene, true))
        return;
    bool ok = bench_run(&scene, &(struct sim_options){.solver = "event", .rtol = REFERENCE_RTOL},
                        &reference, "reference");
    ok = ok &&
         bench_run(&scene, &(struct sim_options){.solver = "implicit", .rtol = REFERENCE_RTOL},
                   &second, "reference");
    if (ok) {
        printf("  reference: event and implicit at %g differ by %.2g ft\n", REFERENCE_RTOL,
               apart_ft(&reference, &second));
        for (int s = 0; s < SOLVERS; s++)
            climb(&ladders[s], &scene, part->limit_ft, &reference);
        time_chosen(ladders, &scene);
        for (int s = 0; s < SOLVERS; s++)
            print_ladder(&ladders[s], part->limit_ft);
        for (int s = 2; s < SOLVERS; s++) {
            char what[80];
            snprintf(what, sizeof what, "time of event over that of %s", ladders[s].solver);
            if (!isnan(ladders[s].ms)) /* one that never comes so near has no time */
                bench_line(what, ladders[0].ms / ladders[s].ms, "", true,
                           strcmp(ladders[s].solver, "rk4") == 0 ? 0.5 : 0.1);
        }
    }
    sim_result_free(&reference);
    sim_result_free(&second);
    sim_scene_free(&scene);
}

void bench_accuracy(void)
{
    static const struct part parts[] = {{"rstar_fig3_7_n30_tanh.json", 5e-6},
                                        {"rstar_fig3_7_n30.json", 1e-5}};
    for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++)
        bench_part(&parts[i]);
}
