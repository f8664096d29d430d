/* The reference of the chain's stability study against formulas. */

#include "tests/host/chain_forms.h"
#include "tests/host/sim_case.h"
#include "tests/stability/chain_reference.h"

#define APART_FT 1e-10

TEST(the_reference_is_right_where_formulas_are)
{
    for (size_t i = 0; i < FORMS; i++) {
        struct sim_scene scene;
        double u_ft[FORM_TIMES * 3];
        form_scene(&forms[i], &scene);
        for (int order = 16; order <= CHAIN_REFERENCE_ORDER; order += 8) {
            struct chain_reference run = {
                .order = order, .tolerance_ft = 1e-17, .most_steps = 100000};
            if (!chain_reference_run(&run, &scene, u_ft))
                fail_msg("%s %zu: no answer after %g s", forms[i].name, i, run.t_s);
            for (int k = 0; k < FORM_TIMES; k++)
                near(u_ft[k * (scene.mats + 1) + 1],
                     forms[i].at(&forms[i], scene.t_out_s.values[k]), APART_FT);
        }
        sim_scene_free(&scene);
    }
}
