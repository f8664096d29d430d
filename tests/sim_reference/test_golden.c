/* golden.txt against host/sim's solvers, and against the reference that it came from (a few scenes,
 * coarser). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/sim.h"
#include "tests/cmocka_all.h"
#include "tests/sim_reference/model.h"

#define GOLDEN        "tests/sim_reference/golden.txt"
#define GOLDEN_SCENES 15
#define DIGITS        1e-6 /* of the largest value of its kind: six digits */

struct golden {
    char path[200];
    double max_lift_ft;
    int outputs;
    struct ref_output output[REF_OUTPUTS];
    int mats;
};

static struct golden goldens[GOLDEN_SCENES];

static void read_output(char *text, struct golden *golden)
{
    struct ref_output *output = &golden->output[golden->outputs++];
    int used;
    assert_int_equal(sscanf(text, "at %lf lift %lf node %d u%n", &output->t_s, &output->lift_ft,
                            &output->lift_node, &used),
                     3);
    char *next = text + used;
    for (golden->mats = 0;; golden->mats++) {
        char *end;
        double value = strtod(next, &end);
        if (end == next)
            return;
        output->u_ft[golden->mats] = value;
        next = end;
    }
}

static int read_goldens(void **state)
{
    (void)state;
    FILE *file = fopen(GOLDEN, "r");
    char line[4000];
    int count = 0;
    if (!file)
        return 1;
    while (fgets(line, sizeof line, file)) {
        if (strncmp(line, "scene ", 6) == 0) {
            if (count == GOLDEN_SCENES || sscanf(line, "scene %199s", goldens[count++].path) != 1)
                return 1;
        } else if (strncmp(line, "run ", 4) == 0) {
            goldens[count - 1].max_lift_ft = strtod(strstr(line, "max_lift ") + 9, NULL);
        } else if (strncmp(line, "at ", 3) == 0) {
            read_output(line, &goldens[count - 1]);
        }
    }
    fclose(file);
    return count == GOLDEN_SCENES ? 0 : 1;
}

static void solver_agrees(const char *solver, double rtol, double digits)
{
    for (int i = 0; i < GOLDEN_SCENES; i++) {
        const struct golden *golden = &goldens[i];
        struct sim_scene scene;
        struct sim_options options = {.solver = solver, .rtol = rtol};
        struct sim_result result = {0};
        struct error error = {0};
        double largest_u = 0, worst = 0, lift_scale = golden->max_lift_ft;
        assert_int_equal(sim_scene_load(&scene, golden->path, &error), MR_OK);
        if (sim_run(&scene, &options, &result, &error) != MR_OK)
            fail_msg("%s: %s", golden->path, error.text);
        assert_int_equal(result.output_count, golden->outputs);
        for (int k = 0; k < golden->outputs; k++) {
            for (int n = 0; n < golden->mats; n++) {
                largest_u = fmax(largest_u, fabs(golden->output[k].u_ft[n]));
                worst = fmax(worst,
                             fabs(result.outputs[k].u_ft[n + 1] - golden->output[k].u_ft[n]));
            }
        }
        if (!(worst <= digits * largest_u))
            fail_msg("%s: u is off by %.3g ft of %.3g", golden->path, worst, largest_u);
        for (int k = 0; k < golden->outputs; k++) {
            if (!(fabs(result.outputs[k].lift_ft - golden->output[k].lift_ft) <=
                  digits * lift_scale))
                fail_msg("%s: lift at %g s is %.9g, golden %.9g", golden->path,
                         golden->output[k].t_s, result.outputs[k].lift_ft,
                         golden->output[k].lift_ft);
            if (golden->output[k].lift_ft > 1e-4 * lift_scale)
                assert_int_equal(result.outputs[k].highest_node, golden->output[k].lift_node);
        }
        /* between steps it can be higher */
        assert_near(result.max_lift_ft / golden->max_lift_ft, 1, 1e-3);
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
}

TEST(the_event_solver_agrees)
{
    solver_agrees("event", 1e-10, DIGITS);
}

TEST(the_default_agrees)
{
    solver_agrees(NULL, 0, 1e-4);
}

/* A coarser step of the reference gives the same: the file belongs to this code. */
TEST(the_file_is_the_references)
{
    static struct ref_scene scene;
    static struct ref_run run;
    static const char *const few[] = {"consistent_falls",
                                      "consistent_ground_damping",
                                      "consistent_soil_friction",
                                      "report_frictionless",
                                      "report_rising",
                                      "report_stiff_hinge"};
    size_t at = 0;
    for (int i = 0; i < GOLDEN_SCENES && at < COUNT_OF(few); i++) {
        if (!strstr(goldens[i].path, few[at]))
            continue;
        at++;
        assert_true(ref_load(&scene, goldens[i].path));
        assert_true(ref_march(&scene, 1e-5, &run));
        for (int k = 0; k < goldens[i].outputs; k++) {
            assert_near(run.output[k].lift_ft, goldens[i].output[k].lift_ft, 1e-8);
            for (int n = 0; n < scene.mats; n++)
                assert_near(run.output[k].u_ft[n], goldens[i].output[k].u_ft[n], 1e-8);
        }
    }
    assert_int_equal(at, COUNT_OF(few));
}

TESTS_BETWEEN(read_goldens, NULL);
