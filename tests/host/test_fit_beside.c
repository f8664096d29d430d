/* Landings side by side against host/sim: the same joints, the same statistics but for what a
 * landing magnifies, and on the mean over draws none at all. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>

#include "host/study/fit/beside.h"
#include "tests/fit/runway.h"

enum { DRAWS = 24 };

static double *simulated(struct fit_landings *list)
{
    struct fit_model model = fit_landings_model(list);
    double *statistic = calloc(DRAWS * list->statistics, sizeof *statistic);
    double z[DRAWS * FIT_KEYS];
    uint64_t draw[DRAWS];
    bool good[DRAWS];
    assert_non_null(statistic);
    for (unsigned n = 0; n < DRAWS; n++) {
        draw[n] = 4000 + n;
        for (int k = 0; k < FIT_KEYS; k++)
            z[n * FIT_KEYS + (unsigned)k] = 0.5 * sin(3.0 * n + 2.0 * k);
    }
    for (unsigned n = 0; n < DRAWS; n += FIT_SOME)
        model.simulate_some(model.context, FIT_SOME, z + n * FIT_KEYS, draw + n,
                            statistic + n * list->statistics, good + n);
    for (unsigned n = 0; n < DRAWS; n++)
        assert_true(good[n]);
    return statistic;
}

static void as_host_sim(void **state)
{
    const struct runway_wanted wanted = {.surveyed = true, .landings = 2};
    struct fit_landings list;
    struct error error = {0};
    double z[FIT_KEYS], squares = 0.0, offset = 0.0, worst = 0.0;
    (void)state;
    assert_true(runway_campaign(&wanted, 7, z, &list, &error));
    assert_true(beside_can(&list.landing[0].scene));
    size_t p = list.statistics;
    double *beside = simulated(&list);
    for (size_t l = 0; l < list.count; l++)
        list.landing[l].scene.wheel_load_lb = 1e-9; /* the chains have none */
    assert_false(beside_can(&list.landing[0].scene));
    double *alone = simulated(&list);
    for (size_t s = 0; s < p; s++) {
        double mean = 0.0, spread = 0.0, difference = 0.0, square = 0.0;
        for (size_t n = 0; n < DRAWS; n++) {
            double d = beside[n * p + s] - alone[n * p + s];
            difference += d / DRAWS;
            square += d * d / DRAWS;
            mean += alone[n * p + s] / DRAWS;
        }
        for (size_t n = 0; n < DRAWS; n++)
            spread += pow(alone[n * p + s] - mean, 2.0) / (DRAWS - 1);
        squares += square / spread / (double)p;
        offset += difference / sqrt(spread) / (double)p;
        worst = fmax(worst, fabs(difference) / sqrt(spread));
    }
    print_message("rms %.3f, mean %+.4f, worst mean %.3f of what joints scatter\n", sqrt(squares),
                  offset, worst);
    assert_true(sqrt(squares) < 0.1);
    assert_true(fabs(offset) < 0.01);
    assert_true(worst < 0.1);
    free(beside);
    free(alone);
    fit_landings_free(&list);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(as_host_sim),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
