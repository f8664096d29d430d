/* Which survey a fit takes for a landing: gage points read before and after it, and what the board
 * had. */
#include <math.h>

#include "host/study/fit/campaign.h"
#include "host/store/store_survey.h"
#include "tests/host/scratch.h"

static struct error error;

static struct store *fresh(const char *name)
{
    char path[200];
    struct store *store = NULL;
    error = (struct error){0};
    store_open(scratch_path(path, sizeof path, name), STORE_CREATE, &store, &error);
    assert_no_error(&error);
    return store;
}

static int64_t land(struct store *store, int64_t number)
{
    struct store_session session = {.started_us = 1000 * number, .can_link = "file:a"};
    assert_int_equal(store_session_add(store, &session, &error), MR_OK);
    struct store_landing landing = {.session = session.id,
                                    .board_landing = number,
                                    .armed_block = 800,
                                    .armed_us = 1000 * number,
                                    .state = 4,
                                    .board_uid = "AB",
                                    .image_crc = STORE_NONE,
                                    .switch_error_ft = (double)NAN};
    assert_int_equal(store_landing_add(store, &landing, &error), MR_OK);
    return landing.id;
}

/* Lines 1 and 2 of `count` spans from 0 on, `add` and 0.02 in beyond closed: their mean is add +
 * 0.01. */
static void survey(struct store *store, int64_t made_us, int64_t count, double add, double error_in)
{
    struct store_gage_survey row = {.made_us = made_us,
                                    .ended_us = STORE_NONE,
                                    .pattern = "standard",
                                    .edges = "none",
                                    .error_in = error_in,
                                    .closed_in = 33.5};
    assert_int_equal(store_gage_survey_add(store, &row, &error), MR_OK);
    for (int64_t place = 0; place < count; place++) {
        for (int64_t line = 1; line <= 2; line++) {
            struct store_gage_reading reading = {.kind = "gap",
                                                 .line = line,
                                                 .place = place,
                                                 .taken_us = made_us,
                                                 .source = "typed",
                                                 .value_in = 33.5 + add + (line == 2 ? 0.02 : 0.0)};
            assert_int_equal(store_gage_reading_add(store, row.id, &reading, &error), MR_OK);
        }
    }
}

static void board(struct store *store, int64_t run, double slack_in)
{
    for (int64_t s = 0; s < (int64_t)MR_SEGMENTS; s++) {
        struct store_segment segment = {.segment = s, .slack_in = slack_in, .joints = 10};
        assert_int_equal(store_segment_put(store, run, &segment, &error), MR_OK);
    }
}

static void nothing_is_known(void **state)
{
    struct store *store = fresh("surveyed0.db");
    struct fit_surveyed found;
    (void)state;
    int64_t run = land(store, 1);
    assert_int_equal(fit_surveyed_before(store, run, &found, &error), MR_OK);
    assert_int_equal(found.segments, 0);
    assert_true(isnan(found.sum_in[0]) && found.error_in == 0.0);
    assert_int_equal(fit_surveyed_after(store, run, STORE_NONE, &found, &error), MR_OK);
    assert_int_equal(found.segments, 0);
    store_close(store);
}

/* Survey, landing 1, an old and a new survey of ten segments, landing 2, a survey of all. The board
 * knew 0.20 in, then 0.18. */
static void the_newest_between_two_landings(void **state)
{
    struct store *store = fresh("surveyed1.db");
    struct fit_surveyed found;
    (void)state;
    survey(store, 500, 42, 0.25, 0.004);
    int64_t first = land(store, 1);
    board(store, first, 0.20);
    survey(store, 1500, 10, 0.40, 0.004);
    survey(store, 1600, 10, 0.15, 0.1);
    int64_t second = land(store, 2);
    board(store, second, 0.18);
    survey(store, 2500, 42, 0.05, 0.004);

    assert_int_equal(fit_surveyed_before(store, first, &found, &error), MR_OK);
    assert_int_equal(found.gages, 42);
    assert_near(found.sum_in[0], 0.26, 1e-9);
    assert_near(found.sum_in[41], 0.26, 1e-9);
    /* two lines 0.02 in apart say more than 0.004/sqrt 2 */
    assert_near(found.error_in, 0.01, 1e-9);

    assert_int_equal(fit_surveyed_after(store, first, second, &found, &error), MR_OK);
    assert_int_equal(found.gages, 10);
    assert_int_equal(found.segments, 42);
    assert_near(found.sum_in[9], 0.16, 1e-9);
    assert_near(found.sum_in[10], 0.18, 1e-6); /* not read: the board's */
    assert_near(found.error_in, 0.1 / sqrt(2.0), 1e-9);

    struct fit_surveyed before;
    assert_int_equal(fit_surveyed_before(store, second, &before, &error), MR_OK);
    for (size_t s = 0; s < MR_SEGMENTS; s++)
        assert_near(before.sum_in[s], found.sum_in[s], 0.0);

    assert_int_equal(fit_surveyed_after(store, second, STORE_NONE, &found, &error), MR_OK);
    assert_int_equal(found.gages, 42);
    assert_near(found.sum_in[20], 0.06, 1e-9);
    store_close(store);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_is_known),
        cmocka_unit_test(the_newest_between_two_landings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
