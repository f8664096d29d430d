/* How long a run may take and what it says on the way, on a clock that goes on by itself: nobody
 * waits here. Units s. */
#include <stdio.h>

#include "tests/host/sim_case.h"
#include "tests/host/beads.h"

struct clock {
    double now_s, tick_s; /* what every look at it adds */
    int looks;
};

static double look(void *ctx)
{
    struct clock *clock = ctx;
    double now_s = clock->now_s;
    clock->now_s += clock->tick_s;
    clock->looks++;
    return now_s;
}

/* Every kind of solver asks: located, implicit, sampled, settled, chain, landing engine. */
TEST(a_limit_ends_every_solver)
{
    static const char *const solvers[] = {"event",   "implicit", "rk4",       "rkgs",
                                          "hamming", "moreau",   "staggered", "staggered"};
    for (size_t i = 0; i < sizeof solvers / sizeof solvers[0]; i++) {
        struct sim_scene scene = load(i == 6 ? "host/scenes/wave.json"
                                             : "host/scenes/consistent_fig3_7.json");
        struct clock clock = {100.0, 1.0, 0};
        struct sim_options options = {
            .solver = solvers[i], .time_limit_s = 2.0, .clock_s = look, .clock_ctx = &clock};
        struct sim_result result;
        memset(&error, 0, sizeof error);
        if (sim_run(&scene, &options, &result, &error) != MR_NUMERICS)
            fail_msg("%s: not stopped after %d looks", solvers[i], clock.looks);
        assert_int_equal(result.status, SIM_INTERRUPTED);
        if (!strstr(error.text, "limit of 2 s"))
            fail_msg("%s: %s", solvers[i], error.text);
        assert_true(result.t_s < result.t_end_s);
        assert_int_equal(clock.looks, 3); /* at the beginning, and twice until it is over */
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

TEST(without_a_limit_nobody_looks)
{
    struct sim_scene scene = load("host/scenes/friction_block.json");
    struct clock clock = {100.0, 1e9, 0};
    struct sim_options options = {.clock_s = look, .clock_ctx = &clock};
    struct sim_result result;
    assert_int_equal(sim_run(&scene, &options, &result, &error), MR_OK);
    assert_int_equal(clock.looks, 0);
    sim_result_free(&result);
    options.time_limit_s = -1.0;
    assert_int_equal(sim_run(&scene, &options, &result, &error), MR_USAGE);
    assert_non_null(strstr(error.text, "limit"));
    sim_result_free(&result);
    sim_scene_free(&scene);
}

/* Beads (beads.h) under an aircraft that stands by: no step of fixed decides them, and
 * what auto asks then has a minute. The result is fixed's, and says so. */
TEST(what_auto_tries_next_has_a_minute)
{
    static const struct sim_path_row rows[] = {{0.0, 2.0, 40.5972}, {0.005, 2.0, 40.5972}};
    for (int late = 0; late < 2; late++) {
        struct clock clock = {100.0, late ? 61.0 : 0.0, 0};
        struct sim_options options = {.clock_s = look, .clock_ctx = &clock};
        struct sim_result result;
        struct sim_scene scene = beads();
        bool said = false;
        memset(&error, 0, sizeof error);
        sim_scene_set_path(&scene, rows, 2);
        sim_run(&scene, &options, &result, &error);
        assert_int_equal(result.status, SIM_UNPREDICTABLE);
        assert_int_equal(error.status, MR_NUMERICS);
        assert_string_equal(result.solver, "staggered");
        for (int i = 0; i < SIM_NOTES_MAX; i++)
            said = said || strstr(result.notes[i],
                                  "the other solvers reached their computing limit of 60 s");
        assert_int_equal(said, late);
        assert_true(late ? clock.looks == 2 : clock.looks > 2);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}
