/* Facts of a series: what is computed for them, on runways written down by hand. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/landing_series/summary.h"
#include "host/landing_series/play.h"

#define LANDINGS "\"landings\":[{\"deceleration_ft_s2\":5,\"times\":4}],\"stations_ft\":[5,10],"
#define SCENE    "\"scene\":{\"N\":60,\"L\":0.2857142857142857,\"slack\":0.0025}"

static struct error error;

static enum mr_status read(const char *facts, struct landing_series *series)
{
    char text[1200];
    snprintf(text, sizeof text, "{" LANDINGS SCENE ",\"facts\":[%s]}", facts);
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    error = (struct error){0};
    enum mr_status status = series_from_json(series, "test", root, &error);
    json_decref(root);
    return status;
}

/* Two runways: one takes four landings; the other buckles in its third. */
struct case_ {
    struct series_outcome lasting[4], buckling[4];
    struct series_run runs[2];
};

static void write_down(struct case_ *c)
{
    static const double movement_in[4] = {0.25, -0.125, 0.5, 0.375};
    memset(c, 0, sizeof *c);
    for (int i = 0; i < 4; i++) {
        c->lasting[i].peak_in = 1.0 + i;
        c->lasting[i].movement_in[0] = movement_in[i];
        c->lasting[i].movement_in[1] = -2.0 * movement_in[i];
        c->lasting[i].zone_mats = 10 * (i + 1);
        c->lasting[i].waves = i == 1 ? 3 : 0;
        c->lasting[i].band_slack = i > 1;
        c->lasting[i].tears = i == 3 ? 7 : 0;
        c->buckling[i] = c->lasting[i];
    }
    c->buckling[2].buckled = true;
    c->buckling[2].waves = 1;
    c->buckling[2].failures = 2;
    c->buckling[2].failure_ft[0] = 85.0;
    c->buckling[2].failure_ft[1] = 91.0;
    c->runs[0] = (struct series_run){.seed = 1, .played = 4, .outcomes = c->lasting};
    c->runs[1] = (struct series_run){.seed = 2, .played = 3, .buckled = 3, .outcomes = c->buckling};
}

/* The value of a fact on both runways. */
static void values(const char *keys, double of[2])
{
    char fact[300];
    struct landing_series series;
    struct case_ c;
    write_down(&c);
    snprintf(fact, sizeof fact, "{\"says\":\"x\",\"at_least\":0,%s}", keys);
    if (read(fact, &series) != MR_OK)
        fail_msg("%s", error.text);
    assert_int_equal(series.fact_count, 1);
    for (int i = 0; i < 2; i++)
        of[i] = facts_value(&series, &series.facts[0], &c.runs[i]);
    series_free(&series);
}

static void test_quantities(void **state)
{
    static const struct {
        const char *keys;
        double lasting, buckling; /* worked by hand; NaN: none */
    } cases[] = {
        {"\"quantity\":\"moved_in\",\"landings\":[1,4],\"station_ft\":5", 1.0, (double)NAN},
        {"\"quantity\":\"moved_in\",\"landings\":[1,4]", 2.0, (double)NAN},
        {"\"quantity\":\"moved_in\",\"landings\":[1,2],\"station_ft\":6", 0.125, 0.125},
        {"\"quantity\":\"each_in\",\"landings\":[1,4],\"station_ft\":5", 0.3125, 0.1875},
        {"\"quantity\":\"each_in\",\"landings\":[2,3]", 2.5, 2.0},
        {"\"quantity\":\"each_in\",\"landings\":[3,4],\"against\":[1,2]", 3.5 / 1.5, (double)NAN},
        {"\"quantity\":\"most_in\",\"landings\":[1,3],\"station_ft\":9", 1.0, 0.5},
        {"\"quantity\":\"mean_in\",\"landings\":[1,4]", 0.46875, 0.28125},
        {"\"quantity\":\"zone_mats\",\"landings\":[1,4]", 40.0, 20.0},
        {"\"quantity\":\"zone_mats\",\"landings\":\"before buckling\"", (double)NAN, 20.0},
        {"\"quantity\":\"zone_mats\",\"landings\":\"at buckling\"", (double)NAN, 30.0},
        {"\"quantity\":\"waves\",\"landings\":[1,4]", 1.0, 1.0},
        {"\"quantity\":\"slack\",\"landings\":[1,4]", 2.0, 0.0},
        {"\"quantity\":\"torn\",\"landings\":[4,4]", 1.0, (double)NAN},
        {"\"quantity\":\"failures\",\"landings\":\"at buckling\"", (double)NAN, 2.0},
        {"\"quantity\":\"failures\",\"landings\":[1,4]", 0.0, 0.0},
        {"\"quantity\":\"apart_ft\",\"landings\":\"at buckling\"", (double)NAN, 6.0},
        {"\"quantity\":\"apart_ft\",\"landings\":[1,4]", (double)NAN, (double)NAN},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        double of[2], wanted[2] = {cases[i].lasting, cases[i].buckling};
        values(cases[i].keys, of);
        for (int k = 0; k < 2; k++) {
            if (isnan(wanted[k]) ? !isnan(of[k]) : fabs(of[k] - wanted[k]) > 1e-12)
                fail_msg("%s: runway %d has %g, should have %g", cases[i].keys, k + 1, of[k],
                         wanted[k]);
        }
    }
}

/* Nodes 0.5 ft apart; 3 in is a failure. Drawn: two waves and a low one; what the wheel met of
 * them. */
/* Joints 3, 5 and 10 came apart in one wave, 5 first; 20 before them, in another. */
static void joints_apart_are_failures(void **state)
{
    (void)state;
    double unhinged_s[31] = {0}, at_ft[SERIES_FAILURES_MAX], first_ft = 0.0;
    assert_int_equal(failures_apart(unhinged_s, 30, 0.5, at_ft, &first_ft), 0);
    unhinged_s[3] = 4.2;
    unhinged_s[5] = 4.1;
    unhinged_s[10] = 4.3;
    unhinged_s[20] = 4.0;
    assert_int_equal(failures_apart(unhinged_s, 30, 0.5, at_ft, &first_ft), 2);
    assert_true(at_ft[0] == 2.0 && at_ft[1] == 9.5 && first_ft == 9.5);
    unhinged_s[17] = 4.4; /* seven mats from both sides: one failure */
    assert_int_equal(failures_apart(unhinged_s, 30, 0.5, at_ft, &first_ft), 1);
    assert_true(at_ft[0] == 9.5);
}

static void test_failures(void **state)
{
    /* by node, 1 to 12 */
    static const double rise_ft[] = {0, 9, 0.1, 0.25, 0.3, 0.26, 0.2, 0.24, 0.27, 0.4, 0.3, 0.1, 9};
    static const double met_ft[] = {4.5, 1.5}, low_ft[] = {2.5};
    double at_ft[SERIES_FAILURES_MAX];
    (void)state;
    /* the ends are held */
    assert_int_equal(failures_find(rise_ft, 12, 0.5, 0.25, NULL, 0, at_ft), 2);
    assert_near(at_ft[0], 1.5, 1e-12); /* crests: nodes 4 and 9 */
    assert_near(at_ft[1], 4.0, 1e-12);
    assert_int_equal(failures_find(rise_ft, 12, 0.5, 0.25, met_ft, 2, at_ft), 2);
    assert_near(at_ft[0], 1.5, 1e-12);
    assert_near(at_ft[1], 4.5, 1e-12);
    /* met between them: neither's */
    assert_int_equal(failures_find(rise_ft, 12, 0.5, 0.25, low_ft, 1, at_ft), 2);
    assert_near(at_ft[1], 4.0, 1e-12);
    /* nothing lies between them */
    assert_int_equal(failures_find(rise_ft, 12, 0.5, 0.2, NULL, 0, at_ft), 1);
    assert_int_equal(failures_find(rise_ft, 12, 0.5, 0.5, NULL, 0, at_ft), 0);
}

static void test_agreement(void **state)
{
    static const char two[] =
        "{\"says\":\"a\",\"quantity\":\"zone_mats\",\"landings\":[1,4],\"at_least\":15,\"at_most\":"
        "25,\"needed\":0.5},"
        "{\"says\":\"b\",\"quantity\":\"torn\",\"landings\":[4,4],\"at_least\":1,\"needed\":1}";
    struct landing_series series;
    struct case_ c;
    struct series_summary summary;
    (void)state;
    write_down(&c);
    assert_int_equal(read(two, &series), MR_OK);
    series.seeds = 2;
    series_summarise(&summary, &series, c.runs);
    assert_int_equal(summary.fact[0].agree, 1);
    assert_true(summary.fact[0].enough);
    assert_int_equal(summary.fact[0].value.count, 2);
    assert_near(summary.fact[0].value.middle, 30.0, 1e-12);
    /* the other never came to landing 4: it does not agree */
    assert_int_equal(summary.fact[1].agree, 1);
    assert_false(summary.fact[1].enough);
    assert_int_equal(summary.fact[1].value.count, 1);
    series_summary_free(&summary);
    series_free(&series);
}

static void test_mistakes(void **state)
{
    static const struct {
        const char *fact, *says;
    } cases[] = {
        {"{\"says\":\"x\",\"landings\":[1,2],\"at_least\":1}", "facts[0].quantity"},
        {"{\"says\":\"x\",\"quantity\":\"moved\",\"landings\":[1,2],\"at_least\":1}",
         "facts[0].quantity"},
        {"{\"quantity\":\"torn\",\"landings\":[1,2],\"at_least\":1}", "facts[0].says"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":[1,5],\"at_least\":1}",
         "facts[0].landings"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":[2,1],\"at_least\":1}",
         "facts[0].landings"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"at_least\":1}", "facts[0].landings"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":\"after\",\"at_least\":1}",
         "before buckling, at buckling"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":\"\",\"at_least\":1}",
         "before buckling, at buckling"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":[1,2]}", "facts[0].at_least"},
        {"{\"says\":\"x\",\"quantity\":\"torn\",\"landings\":[1,2],\"at_least\":2,\"at_most\":1}",
         "facts[0].at_least"},
        {"{\"says\":\"x\",\"quantity\":\"each_in\",\"landings\":[1,2],\"station_ft\":90,\"at_"
         "least\":2}",
         "facts[0].station_ft"},
        {"{\"says\":\"x\",\"quantity\":\"apart_ft\",\"landings\":[1,2],\"station_ft\":9,\"at_"
         "least\":2}",
         "facts[0].station_ft"},
        {"{\"says\":\"x\",\"quantity\":\"each_in\",\"landings\":[1,2],\"most\":90}", "\"most\""},
    };
    struct landing_series series;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        assert_int_equal(read(cases[i].fact, &series), MR_MALFORMED);
        if (!strstr(error.text, cases[i].says))
            fail_msg("%s: '%s' does not name %s", cases[i].fact, error.text, cases[i].says);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_quantities), cmocka_unit_test(joints_apart_are_failures),
        cmocka_unit_test(test_failures),   cmocka_unit_test(test_agreement),
        cmocka_unit_test(test_mistakes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
