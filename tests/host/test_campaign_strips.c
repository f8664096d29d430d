/* Campaigns on a runway of two strips: how it is divided, what each landing puts on either, the
 * landings by hand, and which side moves, fails and is told. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/campaign/draw.h"
#include "host/campaign/facts.h"
#include "host/campaign/strips.h"
#include "host/sim/sim.h"

#define RIG                                                                                 \
    "\"scene\":{\"N\":100,\"L\":0.2857142857142857,\"W\":0.5,\"I\":1.19e-4,\"KV\":1.3e4,"   \
    "\"CV\":60,\"KT\":41.6,\"CT\":1.57e-4,\"TAD_deg\":7,\"profile\":\"full\",\"KL\":2.9e5," \
    "\"CL\":5,\"slack\":0.0025,\"left\":\"fixed\",\"right\":\"fixed\",\"v0\":0},"           \
    "\"stations_ft\":[2,8,14],\"engine\":{\"use\":\"chain\"},"
#define DIVIDED  "\"strips\":{\"count\":2,\"width_ft\":14,\"offset_ft\":1.4,\"shear_lb_ft\":%g},"
#define LANDINGS "\"landings\":[{\"speed_ft_s\":13,\"deceleration_ft_s2\":5,\"times\":3}]"
#define COUNT(a) (sizeof(a) / sizeof(a)[0])

static struct error error;

static enum mr_status read_text(struct campaign *campaign, const char *text)
{
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    error = (struct error){0};
    enum mr_status status = campaign_from_json(campaign, "test", root, &error);
    json_decref(root);
    return status;
}

static struct campaign read_good(const char *text)
{
    struct campaign campaign;
    if (read_text(&campaign, text) != MR_OK)
        fail_msg("%s", error.text);
    return campaign;
}

static struct campaign divided(double shear_lb_ft, const char *landings)
{
    char text[2000];
    snprintf(text, sizeof text, "{" RIG DIVIDED "%s}", shear_lb_ft, landings);
    return read_good(text);
}

static void refused(const char *rest, const char *says)
{
    char text[2000];
    struct campaign campaign;
    snprintf(text, sizeof text, "{" RIG "%s}", rest);
    assert_int_equal(read_text(&campaign, text), MR_MALFORMED);
    if (!strstr(error.text, says))
        fail_msg("%s: does not say: %s", error.text, says);
}

static void near_to(double value, double expected, double tolerance)
{
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.12g is not %.12g to %g", value, expected, tolerance);
}

/* 5.6 and 8.4 of 14 ft are 0.8 and 1.2 times the mean; 39 and 57 of 96 ft likewise. */
static void each_line_of_wheels_has_what_is_on_its_side(void **state)
{
    (void)state;
    struct campaign c = divided(48.0, LANDINGS);
    const struct sim_scene *left = &c.landings[0].scene, *right = left->beside;
    assert_int_equal(c.strips, 2);
    assert_int_equal(c.landing_count, 3);
    near_to(left->weight_lb, 0.4, 1e-15);
    near_to(right->weight_lb, 0.6, 1e-15);
    near_to(left->kl_lb_ft, 2.32e5, 1e-9);
    near_to(right->kl_lb_ft, 3.48e5, 1e-9);
    near_to(left->kv_lb_ft + right->kv_lb_ft, 2.6e4, 1e-9);
    near_to(right->ct_lb_ft_s_rad / left->ct_lb_ft_s_rad, 1.5, 1e-12);
    assert_true(left->friction == right->friction && left->slack_ft == right->slack_ft);
    assert_true(left->ties.k_lb_ft == 48.0 && isinf(left->ties.most_lb));
    c.width_ft = 96.0;
    c.offset_ft = 9.0;
    near_to(strips_share(&c, 0), 39.0 / 48.0, 1e-15);
    near_to(strips_share(&c, 1), 57.0 / 48.0, 1e-15);
    campaign_free(&c);
    /* a scene that leaves a default to the simulator: 160 lb, 128 and 192 */
    c = read_good("{\"scene\":{\"N\":9},\"strips\":{\"count\":2,\"width_ft\":10,\"offset_ft\":1},"
                  "\"landings\":[{\"deceleration_ft_s2\":5,\"apply\":{\"W\":\"200 lb\"}},"
                  "{\"deceleration_ft_s2\":5,\"remove\":[\"W\"]}]}");
    near_to(c.landings[0].scene.beside->weight_lb, 240.0, 1e-12);
    near_to(c.landings[1].scene.weight_lb, 128.0, 1e-12);
    near_to(c.landings[1].scene.beside->weight_lb, 192.0, 1e-12);
    campaign_free(&c);
}

/* Keys of both go by width; those of one are as written, until both get others or lose them. */
static void a_landing_puts_bands_on_one_side(void **state)
{
    (void)state;
    struct campaign c = divided(
        48.0, "\"landings\":[{\"deceleration_ft_s2\":5,\"apply\":{\"bands\":0.245,\"f\":0.7}},"
              "{\"deceleration_ft_s2\":5,\"apply_left\":{\"bands\":0},\"apply_right\":{\"bands\":"
              "0.49}},{\"deceleration_ft_s2\":5,\"apply_left\":{\"f\":0.6}},"
              "{\"deceleration_ft_s2\":5,\"apply\":{\"bands\":0.1}},"
              "{\"deceleration_ft_s2\":5,\"remove\":[\"f\"]}]");
    static const double bands[][2] = {
        {0.196, 0.294}, {0.0, 0.49}, {0.0, 0.49}, {0.08, 0.12}, {0.08, 0.12}};
    static const double f[][2] = {{0.7, 0.7}, {0.7, 0.7}, {0.6, 0.7}, {0.6, 0.7}, {0.5, 0.5}};
    for (size_t i = 0; i < COUNT(bands); i++) {
        const struct sim_scene *left = &c.landings[i].scene, *right = left->beside;
        near_to(left->mods.band[0].count, bands[i][0], 1e-15);
        near_to(right->mods.band[0].count, bands[i][1], 1e-15);
        assert_true(left->friction == f[i][0] && right->friction == f[i][1]);
        assert_true(c.landings[i].modified);
    }
    campaign_free(&c);
    /* on one strip all of that is not looked at */
    c = read_good("{" RIG "\"strips\":{\"width_ft\":14},\"landings\":[{\"deceleration_ft_s2\":5,"
                  "\"apply\":{\"bands\":0.245},\"apply_right\":{\"bands\":0.49}}]}");
    assert_true(c.strips == 1 && !c.landings[0].scene.beside);
    assert_true(c.landings[0].scene.mods.band[0].count == 0.245);
    assert_true(c.landings[0].scene.weight_lb == 0.5);
    campaign_free(&c);
}

static void what_cannot_be_is_refused(void **state)
{
    (void)state;
    refused("\"strips\":{\"count\":2}," LANDINGS, "strips.width_ft");
    refused("\"strips\":{\"count\":3,\"width_ft\":14}," LANDINGS, "strips.count");
    refused("\"strips\":{\"count\":1.5,\"width_ft\":14}," LANDINGS, "strips.count");
    refused("\"strips\":{\"width_ft\":14,\"offset_ft\":7}," LANDINGS, "strips.offset_ft");
    refused("\"strips\":{\"width\":14}," LANDINGS, "width");
    refused("\"strips\":3," LANDINGS, "strips; give an object with width_ft");
    refused("\"landings\":[{\"deceleration_ft_s2\":5,\"apply\":{\"beside\":{}}}]", "apply");
    refused("\"landings\":[{\"deceleration_ft_s2\":5,\"apply\":{\"shear_lb_ft\":0}}]", "apply");
    refused("\"strips\":{\"count\":2,\"width_ft\":14},\"landings\":[{\"deceleration_ft_s2\":5,"
            "\"apply_left\":{\"shear_lb\":0}}]",
            "apply_left; give scene keys without");
    refused("\"strips\":{\"count\":2,\"width_ft\":14},\"landings\":[{\"deceleration_ft_s2\":5,"
            "\"apply_right\":{\"beside\":{\"W\":1}}}]",
            "apply_right; give scene keys without");
    refused("\"landings\":[{\"deceleration_ft_s2\":5,\"apply_left\":3}]", "apply_left");
    refused("\"strips\":{\"count\":2,\"width_ft\":14},\"landings\":[{\"deceleration_ft_s2\":5,"
            "\"apply_right\":{\"bnds\":3}}]",
            "landings[0], right strip");
    refused("\"facts\":[{\"says\":\"x\",\"quantity\":\"waves\",\"landings\":[1,1],\"at_most\":0,"
            "\"strip\":\"middle\"}]," LANDINGS,
            "facts[0].strip");
    struct campaign c;
    error = (struct error){0};
    assert_int_equal(campaign_load_on(&c, "host/campaign/series/diagonal.json", NULL, 2, &error),
                     MR_MALFORMED);
    assert_non_null(strstr(error.text, "no second strip"));
}

static bool same_landing(const struct campaign *c, const struct campaign_outcome *a,
                         const struct campaign_outcome *b)
{
    bool same = a->peak_in == b->peak_in && a->push_lb == b->push_lb && a->pull_lb == b->pull_lb &&
                a->zone_mats == b->zone_mats && a->reach_ft == b->reach_ft;
    for (size_t k = 0; k < c->station_count; k++)
        same = same && a->total_in[k] == b->total_in[k];
    return same;
}

/* Of equal widths and with nothing between them, the left strip is the runway of one strip to the
 * bit; the right one has draws of its own. */
static void untied_the_left_strip_is_todays_runway(void **state)
{
    (void)state;
    struct campaign one = read_good("{" RIG LANDINGS "}"),
                    two = read_good("{" RIG "\"strips\":{\"count\":2,\"width_ft\":14}," LANDINGS
                                    "}");
    struct campaign_run a, b;
    /* the chain's own step: both strips have the same limit */
    campaign_play(&one, 3, false, &a);
    campaign_play(&two, 3, false, &b);
    assert_true(a.error.status == MR_OK && b.error.status == MR_OK && !a.right);
    assert_int_equal(b.played, 3);
    for (size_t i = 0; i < 3; i++) {
        assert_true(same_landing(&one, &a.outcomes[i], &b.outcomes[i]));
        assert_true(!same_landing(&one, &a.outcomes[i], &b.right[i]));
        assert_true(b.right[i].peak_in > 0.0);
    }
    campaign_run_free(&a);
    campaign_run_free(&b);
    campaign_free(&one);
    campaign_free(&two);
}

static double difference_in(const struct campaign *c, const struct campaign_run *run)
{
    double most = 0.0;
    for (size_t k = 0; k < c->station_count; k++)
        most = fmax(most, fabs(run->outcomes[run->played - 1].total_in[k] -
                               run->right[run->played - 1].total_in[k]));
    return most;
}

/* Path left of the centre line: the lighter left strip goes farther; ties hold them together. */
static void the_lighter_side_goes_farther(void **state)
{
    (void)state;
    static const double shear_lb_ft[] = {0.0, 5.0, 1e4};
    double left = 0.0, right = 0.0, apart[3] = {0};
    for (size_t i = 0; i < COUNT(shear_lb_ft); i++) {
        struct campaign c = divided(shear_lb_ft[i], LANDINGS);
        for (uint64_t seed = 1; seed <= 4; seed++) {
            struct campaign_run run;
            campaign_play(&c, seed, false, &run);
            assert_int_equal(run.error.status, MR_OK);
            apart[i] += difference_in(&c, &run);
            for (size_t k = 0; k < run.played && i == 0; k++) {
                left += run.outcomes[k].peak_in;
                right += run.right[k].peak_in;
            }
            campaign_run_free(&run);
        }
        campaign_free(&c);
    }
    assert_true(left > 1.1 * right);
    assert_true(apart[0] > 1.05 * apart[1] && apart[1] > 5.0 * apart[2]);
}

/* Three landings by hand on even openings: each begins with the openings of either strip and with
 * the stretch of the ties that the one before has left. */
static void openings_and_ties_carry_over(void **state)
{
    (void)state;
    struct campaign c = divided(
        8.0, "\"runway\":{\"gap_in\":0.02,\"closing_lb\":2,\"irregularity_in\":0}," LANDINGS);
    struct campaign_run run;
    struct draw_path path = {0};
    const double closing[] = {0.8 * 2.0, 1.2 * 2.0};
    double gap[2][101], tie[100] = {0};
    campaign_play(&c, 1, false, &run);
    assert_int_equal(run.error.status, MR_OK);
    for (int j = 0; j <= 100; j++)
        gap[0][j] = gap[1][j] = 0.02 / 12.0;
    for (int landing = 0; landing < 3; landing++) {
        struct sim_scene scene = c.landings[0].scene, beside = *c.landings[0].scene.beside;
        struct sim_scene *const strip[] = {&scene, &beside};
        struct sim_result result;
        assert_int_equal(draw_landing(&c, &c.landings[0], 1, 0, &path, &error), MR_OK);
        scene.beside = &beside;
        for (int k = 0; k < 2; k++) {
            strip[k]->model = SIM_CHAIN;
            strip[k]->t_dwell_s = 0.3;
            assert_int_equal(sim_scene_set_list(&strip[k]->gap0_ft, gap[k], 101, &error), MR_OK);
            assert_int_equal(sim_scene_set_list(&strip[k]->grit_lb, &closing[k], 1, &error), MR_OK);
            assert_int_equal(sim_scene_set_path(strip[k], path.rows, path.count, &error), MR_OK);
        }
        assert_int_equal(sim_scene_set_list(&scene.ties.stretch_ft, tie, 100, &error), MR_OK);
        if (sim_run(&scene, &(struct sim_options){.single = true}, &result, &error) != MR_OK)
            fail_msg("%s", error.text);
        for (size_t s = 0; s < 3; s++) {
            int mat = (int)(c.stations_ft[s] / scene.length_ft) + 1;
            near_to(run.outcomes[landing].movement_in[s], 12.0 * result.u_ft[mat], 1e-6);
            near_to(run.right[landing].movement_in[s], 12.0 * result.beside->u_ft[mat], 1e-6);
        }
        assert_true(run.outcomes[landing].peak_in != run.right[landing].peak_in);
        for (int j = 0; j <= 100; j++) {
            gap[0][j] = result.gap_ft[j + 1];
            gap[1][j] = result.beside->gap_ft[j + 1];
        }
        memcpy(tie, result.tie_ft + 1, sizeof tie);
        sim_result_free(&result);
        for (int k = 0; k < 2; k++) {
            free(strip[k]->gap0_ft.values);
            free(strip[k]->grit_lb.values);
            free(strip[k]->path);
        }
        free(scene.ties.stretch_ft.values);
    }
    draw_path_free(&path);
    campaign_run_free(&run);
    campaign_free(&c);
}

/* Two runways written down: on one the right strip buckled in landing 2, on the other both did. */
struct written {
    struct campaign_outcome left[2][2], right[2][2];
    struct campaign_run runs[2];
};

static void write_down(struct written *w)
{
    memset(w, 0, sizeof *w);
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < 2; k++) {
            w->left[i][k].peak_in = 0.4;
            w->right[i][k].peak_in = 0.1 + 0.1 * i;
            w->left[i][k].zone_mats = 10 + k;
            w->right[i][k].zone_mats = 30;
        }
        w->right[i][1].buckled = true;
        w->right[i][1].buckle_ft = 8.0;
        w->right[i][1].failures = 1;
        w->runs[i] = (struct campaign_run){.seed = (uint64_t)i + 1,
                                           .played = 2,
                                           .buckled = 2,
                                           .buckle_ft = 8.0,
                                           .outcomes = w->left[i],
                                           .right = w->right[i]};
    }
    w->left[1][1].buckled = true;
    w->left[1][1].failures = 2;
}

static void facts_are_of_a_strip(void **state)
{
    (void)state;
    static const struct {
        const char *keys;
        double of[2];
    } facts[] = {
        {"\"quantity\":\"each_in\",\"landings\":[1,1]", {0.4, 0.4}},
        {"\"quantity\":\"each_in\",\"landings\":[1,1],\"strip\":\"left\"", {0.4, 0.4}},
        {"\"quantity\":\"each_in\",\"landings\":[1,1],\"strip\":\"right\"", {0.1, 0.2}},
        {"\"quantity\":\"each_in\",\"landings\":[1,1],\"strip\":\"right over left\"", {0.25, 0.5}},
        {"\"quantity\":\"failures\",\"landings\":\"at buckling\",\"strip\":\"left\"", {0, 2}},
        {"\"quantity\":\"failures\",\"landings\":\"at buckling\",\"strips\":2,\"strip\":\"right\"",
         {1, 1}},
        /* the landing in which either buckled is not one before it */
        {"\"quantity\":\"zone_mats\",\"landings\":[1,2],\"strip\":\"left\"", {10, 10}},
        {"\"quantity\":\"zone_mats\",\"landings\":[1,2],\"strip\":\"right\"", {30, 30}},
    };
    char text[3000];
    for (size_t i = 0; i < COUNT(facts); i++) {
        struct written w;
        snprintf(text, sizeof text,
                 "{" RIG DIVIDED "\"facts\":[{\"says\":\"x\",\"at_least\":0,%s}]," LANDINGS "}",
                 1.0, facts[i].keys);
        struct campaign c = read_good(text);
        write_down(&w);
        assert_int_equal(c.fact_count, 1);
        for (int k = 0; k < 2; k++)
            near_to(facts_value(&c, &c.facts[0], &w.runs[k]), facts[i].of[k], 1e-15);
        campaign_free(&c);
    }
    /* a runway of one strip has no ratio, and what is said of two alone is not asked of it */
    snprintf(text, sizeof text,
             "{" RIG "\"facts\":[{\"says\":\"a\",\"at_least\":0,%s},{\"says\":\"b\",\"at_least\":0,"
             "%s},{\"says\":\"c\",\"at_least\":0,%s}]," LANDINGS "}",
             facts[3].keys, facts[5].keys, facts[2].keys);
    struct campaign c = read_good(text);
    struct written w;
    write_down(&w);
    w.runs[0].right = NULL;
    assert_int_equal(c.fact_count, 1);
    assert_string_equal(c.facts[0].says, "c");
    near_to(facts_value(&c, &c.facts[0], &w.runs[0]), 0.4, 1e-15);
    campaign_free(&c);
}

static void the_side_that_buckled_is_counted(void **state)
{
    (void)state;
    struct written w;
    struct campaign c = divided(1.0, LANDINGS);
    struct campaign_summary s;
    write_down(&w);
    c.seeds = 2;
    assert_int_equal(campaign_summarise(&s, &c, w.runs, &error), MR_OK);
    assert_int_equal(s.left_alone, 0);
    assert_int_equal(s.right_alone, 1);
    assert_int_equal(s.both, 1);
    assert_int_equal(s.survived, 0);
    assert_int_equal(s.landing[1].buckled, 2); /* either */
    assert_int_equal(s.right[1].buckled, 2);
    near_to(s.landing[0].peak_in.middle, 0.4, 1e-15);
    near_to(s.right[0].peak_in.middle, 0.15, 1e-15);
    near_to(s.zone_before.middle, 20.0, 1e-12); /* of the strip that buckled: 30, and 10 */
    campaign_summary_free(&s);
    campaign_free(&c);
}

/* The planar engine: a landing that throws one side up is told of that side. */
static void a_wave_is_told_of_its_side(void **state)
{
    (void)state;
    struct campaign c = read_good(
        "{" RIG "\"strips\":{\"count\":2,\"width_ft\":14,\"offset_ft\":4},\"runway\":{\"gap_in\":0,"
        "\"irregularity_in\":[0,0.06]},\"landings\":[{\"speed_ft_s\":15,\"deceleration_ft_s2\":7}]"
        "}");
    struct campaign_run run, all;
    c.engine = CAMPAIGN_AUTO;
    campaign_play(&c, 2, false, &run);
    c.skip_share = -1.0;
    campaign_play(&c, 2, true, &all);
    assert_int_equal(run.error.status, MR_OK);
    assert_int_equal(all.error.status, MR_OK);
    assert_int_equal(run.buckled, 1);
    assert_true(run.outcomes[0].buckled && !run.right[0].buckled);
    assert_true(run.outcomes[0].rise_in > 2.0 && run.right[0].rise_in < 1.0);
    assert_true(run.buckle_ft == run.outcomes[0].buckle_ft && run.buckle_ft > 0.0);
    assert_true(all.buckled == 1 && !all.right[0].buckled);
    campaign_run_free(&run);
    campaign_run_free(&all);
    campaign_free(&c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_line_of_wheels_has_what_is_on_its_side),
        cmocka_unit_test(a_landing_puts_bands_on_one_side),
        cmocka_unit_test(what_cannot_be_is_refused),
        cmocka_unit_test(untied_the_left_strip_is_todays_runway),
        cmocka_unit_test(the_lighter_side_goes_farther),
        cmocka_unit_test(openings_and_ties_carry_over),
        cmocka_unit_test(facts_are_of_a_strip),
        cmocka_unit_test(the_side_that_buckled_is_counted),
        cmocka_unit_test(a_wave_is_told_of_its_side),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
