/* Whether the model can be the data's: rows made here, of which the measured one is like the others
 * or is not, and a campaign whose gaps were laid in stretches. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/study/fit/misfit.h"
#include "tests/fit/cheap.h"
#include "tests/fit/runway.h"
#include "tests/host/scratch.h"

enum { REPLICAS = 99, ROWS = REPLICAS + 1 };

struct rows {
    struct fit_landings list;
    struct fit_answer answer;
};

/* A campaign's statistics with residuals that are normal, neighbours' correlated by a third. */
static void begin(struct rows *rows, uint64_t seed)
{
    const struct runway_wanted wanted = {.surveyed = true, .landings = 1, .mats = 100};
    static struct error error;
    double z[FIT_KEYS];
    struct cheap_random random = {seed};
    assert_true(runway_campaign(&wanted, seed, z, &rows->list, &error));
    size_t p = rows->list.statistics;
    rows->answer = (struct fit_answer){.statistics = p, .replicas = REPLICAS};
    rows->answer.residual = calloc(ROWS * p, sizeof(double));
    assert_non_null(rows->answer.residual);
    for (size_t i = 0; i < ROWS; i++) {
        for (size_t s = 0; s < p; s++) {
            double *at = &rows->answer.residual[i * p + s];
            *at = cheap_normal(&random) + (s > 0 ? 0.35 * at[-1] : 0.0);
        }
    }
}

static void end(struct rows *rows)
{
    fit_free(&rows->answer);
    fit_landings_free(&rows->list);
}

static struct misfit check(const struct rows *rows)
{
    return misfit_check(&rows->list, &rows->answer, 3);
}

/* The measured row is one of a hundred: five of them are said to be odd, whichever it is. */
static void one_among_equals(void **state)
{
    struct rows rows;
    unsigned cannot = 0;
    (void)state;
    begin(&rows, 11);
    size_t p = rows.list.statistics;
    double *first = calloc(p, sizeof *first);
    assert_non_null(first);
    for (size_t s = 0; s < MR_SEGMENTS; s++) /* the survey stays the same: leave it out */
        rows.list.landing[0].survey_in[s] = (double)NAN;
    for (size_t i = 0; i < ROWS; i++) {
        struct misfit misfit = check(&rows);
        assert_true(misfit.checked);
        cannot += misfit.cannot;
        memcpy(first, rows.answer.residual, p * sizeof *first);
        for (size_t k = 0; k + 1 < ROWS; k++)
            memcpy(rows.answer.residual + k * p, rows.answer.residual + (k + 1) * p,
                   p * sizeof *first);
        memcpy(rows.answer.residual + (ROWS - 1) * p, first, p * sizeof *first);
    }
    assert_int_equal(cannot, 5);
    free(first);
    end(&rows);
}

static double station(const struct rows *rows, size_t s)
{
    const struct fit_landing *landing = &rows->list.landing[0];
    const struct fit_window *window = &landing->window[s];
    return window->channel == SIZE_MAX ? -1.0 : landing->channel[window->channel].station_ft;
}

/* Four standard deviations on the second half alone; one residual of 9. */
static void what_is_odd_is_found(void **state)
{
    struct rows rows;
    (void)state;
    begin(&rows, 12);
    for (size_t s = 0; s < rows.list.statistics; s++)
        rows.answer.residual[s] += station(&rows, s) > 50.0 / 3.5 ? 4.0 : 0.0;
    assert_true(check(&rows).cannot);
    end(&rows);

    begin(&rows, 14);
    rows.answer.residual[7] = 9.0;
    assert_true(check(&rows).cannot);
    end(&rows);
}

static void too_few_are_not_checked(void **state)
{
    struct rows rows;
    (void)state;
    begin(&rows, 15);
    rows.answer.replicas = MISFIT_LEAST - 1;
    struct misfit misfit = check(&rows);
    assert_false(misfit.checked || misfit.cannot);
    end(&rows);
}

/* From the landing to the check: gaps laid in stretches, and gaps that were not. */
static void gaps_in_stretches(void **state)
{
    (void)state;
    for (int patchy = 0; patchy < 2; patchy++) {
        const struct runway_wanted wanted = {.kind = patchy ? RUNWAY_PATCHY : RUNWAY_MODEL,
                                             .surveyed = true,
                                             .landings = 1,
                                             .mats = 100};
        struct fit_options options = {.draws = 60, .replicas = 59, .seed = 3};
        struct rows rows = {0};
        struct error error = {0};
        double z[FIT_KEYS];
        assert_true(runway_campaign(&wanted, 21, z, &rows.list, &error));
        for (int k = 0; k < FIT_KEYS; k++)
            rows.list.parameter[k].fitted = k == FIT_GRIT;
        struct fit_model model = fit_landings_model(&rows.list);
        fit_run(&model, rows.list.measured, &options, &rows.answer, &error);
        assert_no_error(&error);
        struct misfit misfit = check(&rows);
        assert_true(misfit.checked);
        assert_int_equal(misfit.cannot, patchy);
        end(&rows);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_among_equals),
        cmocka_unit_test(what_is_odd_is_found),
        cmocka_unit_test(too_few_are_not_checked),
        cmocka_unit_test(gaps_in_stretches),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
