/* The chain's answers, and the errors that it states, against formulas. */

#include "tests/host/chain_forms.h"
#include "tests/host/sim_case.h"

#define LEAST_FT 1e-9

/* By the events, and by the fixed steps, which may find that no step of theirs is fine enough. */
static void hold_by(const char *name, const char *solver)
{
    int answered = 0, count = 0;
    for (size_t i = 0; i < FORMS; i++) {
        struct sim_scene scene;
        struct sim_result result;
        if (strcmp(forms[i].name, name) != 0)
            continue;
        form_scene(&forms[i], &scene);
        enum mr_status status = attempt(&scene, solver, 0.0, 0.0, &result);
        if (status != MR_OK && !(solver && status == MR_NUMERICS))
            fail_msg("%s %zu: %s", name, i, error.text);
        answered += status == MR_OK;
        count++;
        for (size_t k = 0; status == MR_OK && k < FORM_TIMES; k++) {
            double t_s = scene.t_out_s.values[k], is = result.outputs[k].u_ft[1];
            double right = forms[i].at(&forms[i], t_s);
            if (!(fabs(is - right) <= result.error_u_ft + LEAST_FT))
                fail_msg("%s %zu by %s: %.9g ft at %g s is not %.9g to the stated %.3g", name, i,
                         result.solver, is, t_s, right, result.error_u_ft);
        }
        sim_result_free(&result);
        sim_scene_free(&scene);
    }
    assert_true(4 * answered >= 3 * count);
}

static void hold(const char *name)
{
    hold_by(name, NULL);
    hold_by(name, "staggered");
}

TEST(a_thrown_mat_slides_and_rests)
{
    hold("thrown");
}

TEST(a_short_or_late_push_is_all_there)
{
    hold("pushed");
}

TEST(thrust_at_the_limit_neither_starts_nor_stops_a_mat)
{
    hold("at_limit");
}

TEST(a_mat_that_is_tied_stops_and_stays)
{
    hold("tied");
}

TEST(a_mat_bounces_between_walls_without_loss)
{
    hold("box");
}

TEST(grit_gives_is_compacted_and_gives_back)
{
    hold("grit");
}

TEST(elastic_ground_takes_a_mat_to_its_rest)
{
    hold("gear");
    hold("spring_back");
}

TEST(two_mats_swing)
{
    hold("swing");
}
