/* What a poor fit says: how poor, where it is farthest off, and what may be the reason. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/study/fit/print.h"

static double measured[6], expected[6], scatter[6];

static size_t verdicts(double fits, bool later, char *text[FIT_VERDICTS])
{
    struct fit_landing landing = {.run = 7, .windows = 6, .later = later};
    struct fit_landings list = {
        .landing = &landing, .count = 1, .measured = measured, .statistics = 6};
    struct fit_answer answer = {.fits = fits, .expected = expected, .scatter = scatter};
    landing.channels = 1;
    landing.channel[0].number = 6;
    landing.channel[0].station_ft = 90.0;
    for (size_t w = 0; w < 6; w++) {
        landing.window[w].channel = w == 0 ? 0 : SIZE_MAX;
        landing.window[w].segment = 10 + w;
        snprintf(landing.window[w].name, sizeof landing.window[w].name, "w%zu", w);
    }
    const struct misfit unchecked = {0};
    return fit_verdicts(&list, &answer, &unchecked, text);
}

static void release(char *text[FIT_VERDICTS], size_t lines)
{
    for (size_t i = 0; i < lines; i++)
        free(text[i]);
}

/* Residuals in standard deviations: -2, 1, 5.5, -3, 2.6, 4: three are named, the farthest first. */
static void the_farthest_are_named(void **state)
{
    static const double away[6] = {-2.0, 1.0, 5.5, -3.0, 2.6, 4.0};
    char *text[FIT_VERDICTS];
    (void)state;
    for (size_t s = 0; s < 6; s++) {
        expected[s] = 0.25;
        scatter[s] = 0.01;
        measured[s] = 0.25 + 0.01 * away[s];
    }
    size_t lines = verdicts(0.008, true, text);
    assert_int_equal(lines, 3);
    assert_non_null(strstr(text[0], "only 0.8 %"));
    assert_string_equal(text[1], "farthest off (in standard deviations): RUN 7 segment 13, w2: "
                                 "0.305 in, expected 0.250 (+5.5); RUN 7 segment 16, "
                                 "w5: 0.290 in, expected 0.250 (+4.0); RUN 7 segment 14, w3: 0.220 "
                                 "in, expected 0.250 (-3.0)");
    assert_non_null(strstr(text[2], "RUN 7 began on joints that earlier landings had closed"));
    release(text, lines);
    measured[0] = 0.25 - 0.01 * 6.0;
    lines = verdicts(0.008, false, text);
    assert_int_equal(lines, 2);
    assert_non_null(strstr(text[1], "RUN 7 transducer 6 at 90 ft, w0: "));
    release(text, lines);
}

static void a_good_fit_says_nothing(void **state)
{
    char *text[FIT_VERDICTS];
    (void)state;
    assert_int_equal(verdicts(0.3, true, text), 0);
    for (size_t s = 0; s < 6; s++)
        measured[s] = expected[s];
    size_t lines = verdicts(0.01, false, text); /* no single one is far */
    assert_int_equal(lines, 1);
    release(text, lines);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_farthest_are_named),
        cmocka_unit_test(a_good_fit_says_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
