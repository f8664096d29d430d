/* Running the scenes, and the table of what the text says. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/sim/solvers/pass.h"
#include "host/sim/sim.h"
#include "tests/figures/figures.h"

#define RTOL 1e-9 /* of the profile's pass; the answer itself is the default solver's, checked */

/* Node heights at the end of a run cut off at t_out. */
static enum mr_status take_profile(struct profile *profile, const struct sim_scene *scene,
                                   double t_s, struct error *error)
{
    struct sim_scene cut = *scene;
    struct model model;
    struct pass_outcome outcome = {0};
    const struct pass_request request = {
        .kind = stepper_find("event"), .rtol = RTOL, .most_steps = 100000000};
    const struct sim_options options = {0};
    cut.t_end_s = t_s;
    cut.t_out_s.count = 0;
    if (model_make(&model, &cut, false, error) != MR_OK)
        return error->status;
    if (pass_run(&outcome, &model, &request, &options, error) == MR_OK &&
        outcome.status == SIM_OK) {
        profile->t_s = t_s;
        profile->wheel_ft = cut.s0_ft + cut.vac_ft_s * t_s;
        for (int j = 0; j <= cut.mats; j++) {
            double u = outcome.z[2 * (j < cut.mats ? j : cut.mats - 1) + 1];
            profile->x_ft[j] = j * cut.length_ft + u;
            profile->height_ft[j] = -outcome.z[2 * j];
        }
    } else {
        error_set(error, MR_NUMERICS, "profile failed: %s at %g s", scene->name, t_s);
    }
    pass_free(&outcome);
    model_free(&model);
    return error->status;
}

enum mr_status run_scene(struct run *run, const char *name, struct error *error)
{
    struct sim_scene scene;
    struct sim_result result = {0};
    const struct sim_options options = {0};
    char path[200];
    snprintf(path, sizeof path, "host/scenes/%s.json", name);
    *run = (struct run){.scene = name};
    if (sim_scene_load(&scene, path, error) != MR_OK)
        return error->status;
    if (scene.mats + 1 > FIGURE_NODES || scene.t_out_s.count > FIGURE_TIMES)
        error_set(error, MR_TOO_LONG, "too large for a figure: %s", path);
    else
        sim_run(&scene, &options, &result, error);
    run->mats = scene.mats;
    run->length_ft = scene.length_ft;
    run->max_lift_ft = result.max_lift_ft;
    run->bow_wave = result.bow_wave;
    run->error_u_ft = result.error_u_ft;
    run->error_lift_ft = result.error_lift_ft;
    for (size_t k = 0; error->status == MR_OK && k < result.output_count; k++) {
        struct profile *profile = &run->at[run->times++];
        take_profile(profile, &scene, result.outputs[k].t_s, error);
        profile->lift_ft = result.outputs[k].lift_ft;
        for (int n = 0; n < scene.mats; n++) {
            profile->u_ft[n] = result.outputs[k].u_ft[n + 1];
            profile->station_ft[n] = (n + 0.5) * scene.length_ft;
        }
    }
    sim_result_free(&result);
    sim_scene_free(&scene);
    return error->status;
}

#define WORDS ((double)NAN)
const struct row rows[] = {
    {"3.6", "displacement after three mats, 0.056 ft", "rstar_fig3_6", DISPLACEMENT, 4, 2, 0.056,
     0.02, ""},
    {"3.6", "a bow wave forms", "rstar_fig3_6", VERDICT, 0, 0, 1, 1, ""},
    {"3.7", "u of mat 4 after three mats, 0.1036 ft", "rstar_fig3_7", DISPLACEMENT, 4, 2, 0.1036,
     0.01, ""},
    {"3.7", "a bow wave forms", "rstar_fig3_7", VERDICT, 0, 0, 1, 1, ""},
    {"3.8", "KL 16e5: u of mat 12 as the aircraft crosses mat 1, 0.0075 ft", "rstar_fig3_8_middle",
     DISPLACEMENT, 12, 0, 0.0075, 0, "16 % off, of a steep front: half a mat of wave travel"},
    {"3.8", "KL 16e5: u of mat 16 then, 0.73e-7 ft", "rstar_fig3_8_middle", DISPLACEMENT, 16, 0,
     0.73e-7, 0, "an exponentially small tail: not a number to test"},
    {"3.8", "KL 16e6 forms the larger bow", "rstar_fig3_8_stiff", LARGEST_LIFT, 0, 1, WORDS, 0, ""},
    {"3.8", "KL 16e5 between", "rstar_fig3_8_middle", LIFT_THEN, 0, 1, WORDS, 0, ""},
    {"3.8", "KL 16e4 restores itself to the horizontal", "rstar_fig3_8_soft", LIFT_THEN, 0, 1, 0, 1,
     ""},
    {"3.9", "f 0.5: a bow wave", "rstar_fig3_9_f05", LARGEST_LIFT, 0, 0, WORDS, 0, ""},
    {"3.9", "f 0.9: almost the same bow", "rstar_fig3_9_f09", LARGEST_LIFT, 0, 0, WORDS, 0, ""},
    {"3.9", "f 0.5: displacement of mat 4", "rstar_fig3_9_f05", DISPLACEMENT, 4, 2, WORDS, 0, ""},
    {"3.9", "f 0.9: slightly less displacement", "rstar_fig3_9_f09", DISPLACEMENT, 4, 2, WORDS, 0,
     ""},
    {"3.10", "f 0.5, two mats: a bow wave", "rstar_fig3_10_f05", LARGEST_LIFT, 0, 0, WORDS, 0, ""},
    {"3.10", "f 0.9: again friction is not significant", "rstar_fig3_10_f09", LARGEST_LIFT, 0, 0,
     WORDS, 0, ""},
    {"3.11", "6,000 lb: no bow wave", "rstar_fig3_11_6000", VERDICT, 0, 0, 0, 1, ""},
    {"3.11", "12,000 lb: a wave of about 3 in (6.1.3)", "rstar_fig3_11_12000", LIFT_THEN, 0, 2,
     0.25, 0.05, ""},
    {"3.11", "24,000 lb: a wave of over 1 ft (6.1.3)", "rstar_fig3_11_24000", VERDICT, 0, 0, 1, 1,
     ""},
    {"3.12", "TAD 10: a bow wave", "rstar_fig3_12_tad10", VERDICT, 0, 0, 1, 1, ""},
    {"3.12", "TAD 1: no bow wave", "rstar_fig3_12_tad1", VERDICT, 0, 0, 0, 1, ""},
    {"3.12", "displacement near the bow, 0.1612 ft; right end fixed", "rstar_fig3_12_tad10",
     DISPLACEMENT, 4, 3, 0.1612, 0, "not reproduced: the fixed far end's reflection pushes back"},
    {"3.12", "the same; right end free, 12,375 lb", "rstar_fig3_12_free", DISPLACEMENT, 4, 3,
     0.1612, 0.01, "a reading that fits, see host/sim/README.md"},
    {"text", "full width, 144,000 lb: a bow wave", "full_width_144000", VERDICT, 0, 0, 1, 1, ""},
    {"text", "full width, 40,000 lb: no buckling (6.1.3)", "full_width_40000", VERDICT, 0, 0, 0, 1,
     ""},
    {"text", "full width, 36,000 lb: no bow wave", "full_width_36000", VERDICT, 0, 0, 0, 1, ""},
    {"text", "a flat mat never buckles", "rstar_flat", LARGEST_LIFT, 0, 0, 0, 1, ""},
};
const size_t row_count = sizeof rows / sizeof rows[0];

double row_value(const struct row *row, const struct run *run)
{
    switch (row->quantity) {
    case DISPLACEMENT: return run->at[row->time].u_ft[row->mat - 1];
    case LIFT_THEN: return run->at[row->time].lift_ft;
    case LARGEST_LIFT: return run->max_lift_ft;
    case VERDICT: break;
    }
    return run->bow_wave ? 1 : 0;
}
