/* Sweeps: designs, the search, the indices, with simulations of the test's own. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/sweep/sweep.h"
#include "host/sweep/sweep_table.h"

#define FILE_NAME "build/test-tmp/test_sweep.json"
#define PI        3.14159265358979323846

static void write_sweep(const char *text)
{
    FILE *file = fopen(FILE_NAME, "w");
    assert_non_null(file);
    fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void load(struct sweep *sweep, const char *text)
{
    struct error error = {0};
    write_sweep(text);
    if (sweep_load(sweep, FILE_NAME, &error) != MR_OK)
        fail_msg("%s", error.text);
}

/* Vectors that the authors of FNV publish with it (draft-eastlake-fnv). */
TEST(fnv_is_as_published)
{
    assert_int_equal(fnv1a_hash(FNV_BASIS, "", 0), 0xcbf29ce484222325u);
    assert_int_equal(fnv1a_hash(FNV_BASIS, "a", 1), 0xaf63dc4c8601ec8cu);
    assert_int_equal(fnv1a_hash(FNV_BASIS, "foobar", 6), 0x85944171f73967e8u);
}

TEST(paths_lead_where_they_say)
{
    json_t *root = json_loads("{\"a\": [1, {\"b\": 5}], \"c\": {\"4\": 7}}", 0, NULL),
           *copy = json_copy(root), *nine = json_integer(9);
    assert_int_equal(json_integer_value(jsonpath_get(root, "a.1.b")), 5);
    assert_int_equal(json_integer_value(jsonpath_get(root, "a.-1.b")), 5);
    assert_int_equal(json_integer_value(jsonpath_get(root, "c.4")), 7);
    static const char *const nowhere[] = {"a.2", "a.-3", "a.x", "d", "a..b", "", "a.0.b", "c."};
    for (size_t i = 0; i + 1 < COUNT_OF(nowhere); i++)
        assert_null(jsonpath_get(root, nowhere[i]));
    assert_true(jsonpath_set(copy, "a.1.b", nine));
    assert_int_equal(json_integer_value(jsonpath_get(copy, "a.1.b")), 9);
    /* what it was copied from is not touched */
    assert_int_equal(json_integer_value(jsonpath_get(root, "a.1.b")), 5);
    assert_true(jsonpath_set(copy, "new", nine));
    assert_false(jsonpath_set(copy, "a.7", nine));
    assert_false(jsonpath_set(copy, "none.x", nine));
    json_decref(nine);
    json_decref(copy);
    json_decref(root);
}

TEST(ranges_end_where_they_should)
{
    struct design_range range;
    struct error error = {0};
    json_t *value = json_loads("{\"from\": 0.1, \"to\": 0.7, \"count\": 7}", 0, NULL);
    assert_int_equal(design_range_read(&range, value, "", "t", &error), MR_OK);
    static const double expected[] = {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
    for (size_t i = 0; i < 7; i++) {
        json_t *level = design_level(&range, i);
        /* the very number that a person would write */
        assert_true(json_number_value(level) == expected[i]);
        json_decref(level);
    }
    json_decref(value);
    value = json_loads("{\"from\": 1, \"to\": 1e6, \"count\": 7, \"scale\": \"log\"}", 0, NULL);
    assert_int_equal(design_range_read(&range, value, "", "t", &error), MR_OK);
    for (size_t i = 0; i < 7; i++) {
        json_t *level = design_level(&range, i);
        assert_true(json_is_integer(level));
        assert_near(json_number_value(level), pow(10.0, (double)i), 0.0);
        json_decref(level);
    }
    json_decref(value);
}

/* ---- simulations of the test's own: x is F ---- */

static double force(const json_t *input)
{
    return json_number_value(json_object_get(input, "F"));
}

static json_t *answer(double y)
{
    return json_pack("{s:s,s:f}", "status", "ok", "y", y);
}

static json_t *bumpy(const json_t *input)
{
    double x = force(input); /* beyond 0 from 30 to 50 and from 80 on */
    return answer((x >= 30.0 && x < 50.0) || x >= 80.0 ? 1.0 : -1.0);
}

static json_t *falling(const json_t *input)
{
    return answer(50.0 - force(input));
}

static json_t *folds(const json_t *input)
{
    double x = force(input);
    if (x > 60.0)
        return json_pack("{s:s,s:s}", "status", "folded", "reason", "mat 3 is upright");
    return answer(0.0);
}

struct found {
    const char *verdict, *status, *reason;
    double low, high;
    int runs;
    json_t *outcome;
};

static struct found search(const char *condition, sweep_simulator *simulate)
{
    struct sweep sweep;
    char text[600];
    snprintf(text, sizeof text,
             "{\"base\": {}, \"vary\": {\"KL\": [8e6]}, \"find\": {\"key\": \"F\", \"from\": 0, "
             "\"to\": 100, \"field\": \"y\", \"scan\": 10, "
             "\"tolerance\": 0.001, %s}}",
             condition);
    load(&sweep, text);
    json_t *outcome = sweep_run_case(&sweep, 0, simulate), *find = json_object_get(outcome, "find");
    sweep_free(&sweep);
    return (struct found){json_string_value(json_object_get(find, "verdict")),
                          json_string_value(json_object_get(outcome, "status")),
                          json_string_value(json_object_get(outcome, "reason")),
                          json_number_value(json_object_get(find, "low")),
                          json_number_value(json_object_get(find, "high")),
                          (int)json_integer_value(json_object_get(find, "runs")),
                          outcome};
}

TEST(the_smallest_crossing_is_found)
{
    struct found f = search("\"above\": 0", bumpy);
    assert_string_equal(f.verdict, "between");
    assert_true(f.low < 30.0 && f.high >= 30.0 && f.high - f.low <= 0.001 * f.high);
    /* 0, 10, 20, 30; then 10 halved to 0.03: log2(333) = 8.4 */
    assert_in_range(f.runs, 4 + 8, 4 + 10);
    json_decref(f.outcome);
    f = search("\"below\": 0", falling);
    assert_true(f.low <= 50.0 && f.high > 50.0 && f.high - f.low <= 0.001 * f.high);
    json_decref(f.outcome);
    f = search("\"below\": 60", falling);
    assert_string_equal(f.verdict, "at_most");
    assert_int_equal(f.runs, 1);
    json_decref(f.outcome);
    f = search("\"above\": 51", falling);
    assert_string_equal(f.verdict, "none");
    assert_int_equal(f.runs, 11);
    json_decref(f.outcome);
}

TEST(a_run_that_fails_ends_the_search)
{
    struct found f = search("\"above\": 1", folds);
    assert_string_equal(f.status, "folded");
    assert_non_null(strstr(f.reason, "at F = 70: mat 3 is upright"));
    json_decref(f.outcome);
    f = search("\"above\": 1, \"beyond_when\": [\"folded\"]", folds);
    assert_string_equal(f.status, "ok");
    assert_true(f.low <= 60.0 && f.high > 60.0 && f.high - f.low <= 0.001 * f.high);
    json_decref(f.outcome);
}

/* Ishigami and Homma (1990) with a 7, b 0.1: sin x1 + a sin^2 x2 + b x3^4 sin x1 on (-pi, pi). */
static double ishigami(double u1, double u2, double u3)
{
    double x[3] = {PI * (2.0 * u1 - 1.0), PI * (2.0 * u2 - 1.0), PI * (2.0 * u3 - 1.0)};
    return sin(x[0]) + 7.0 * sin(x[1]) * sin(x[1]) + 0.1 * pow(x[2], 4.0) * sin(x[0]);
}

/* Its indices on `points` points; the design is the sweeps'. */
static void ishigami_indices(size_t points, uint64_t seed, struct sweep_key_sensitivities result[3])
{
    static const char *const names[] = {"x1", "x2", "x3"};
    size_t count = 5 * points, used;
    double *u[3], *values = calloc(count, sizeof *values);
    for (size_t k = 0; k < 3; k++) {
        u[k] = calloc(count, sizeof *u[k]);
        design_fill_radial(u[k], points, 3, k, seed, names[k]);
    }
    for (size_t i = 0; i < count; i++)
        values[i] = ishigami(u[0][i], u[1][i], u[2][i]);
    values[points + 3] = (double)NAN; /* one point has failed */
    assert_true(sweep_compute_sensitivities(values, points, 3, result, &used));
    assert_int_equal(used, points - 1);
    free(values);
    for (size_t k = 0; k < 3; k++)
        free(u[k]);
}

/* The published values, from the integrals. */
static const double ishigami_first[] = {0.3139, 0.4424, 0.0},
                    ishigami_total[] = {0.5576, 0.4424, 0.2437};

TEST(indices_are_as_published)
{
    struct sweep_key_sensitivities found[3];
    ishigami_indices(20000, 1, found);
    for (size_t k = 0; k < 3; k++) {
        assert_near(found[k].first.value, ishigami_first[k], 0.02);
        assert_near(found[k].total.value, ishigami_total[k], 0.02);
    }
}

/* 95 % intervals of 64 points over 200 designs and six indices: 91 to 98 % of them hold. */
TEST(intervals_of_indices_hold)
{
    unsigned held = 0;
    for (uint64_t seed = 1; seed <= 200; seed++) {
        struct sweep_key_sensitivities found[3];
        ishigami_indices(64, seed, found);
        for (size_t k = 0; k < 3; k++) {
            held += found[k].first.low <= ishigami_first[k] &&
                    ishigami_first[k] <= found[k].first.high;
            held += found[k].total.low <= ishigami_total[k] &&
                    ishigami_total[k] <= found[k].total.high;
        }
    }
    print_message("# %u of 1200 intervals hold\n", held);
    assert_in_range(held, 1092, 1176);
}

TEST(nothing_varies_nothing_is_said)
{
    double values[40] = {0.0};
    struct sweep_key_sensitivities found[2];
    size_t used;
    assert_false(sweep_compute_sensitivities(values, 10, 2, found, &used));
    for (size_t i = 0; i < 7 * 4; i++)
        values[i] = (double)i;
    assert_false(sweep_compute_sensitivities(values, 7, 2, found, &used)); /* too few */
}

TEST(whole_ranges_have_both_ends)
{
    struct design_range range = {.from = 3.0, .to = 5.0, .is_integer = true};
    unsigned seen[6] = {0};
    for (unsigned i = 0; i < 300; i++)
        seen[(unsigned)design_number(&range, (i + 0.5) / 300.0)]++;
    assert_true(seen[3] == 100 && seen[4] == 100 && seen[5] == 100);
    assert_near(design_number(&range, 1.0), 5.0, 0.0);
}
