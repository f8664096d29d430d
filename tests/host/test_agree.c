/* Whether measured and simulated agree, in a sentence: figures made by hand, words and numbers
 * known. */
#include "tests/cmocka_all.h"

#include <math.h>
#include <string.h>

#include "host/compare/agree.h"
#include "tests/host/scratch.h"

#define NONE ((double)NAN)

/* Two transducers that agree in all six values; `run` 7 against x.json. */
static struct compare_figures agreeing(void)
{
    struct compare_figures figures = {.run = 7, .against = "x.json", .channels = 2};
    for (size_t i = 0; i < 2; i++) {
        struct compare_channel *c = &figures.channel[i];
        c->number = (int64_t)(3 + i);
        c->station_ft = 60.0 + 10.0 * (double)i;
        c->compared = true;
        c->f.peak_measured = (struct signal_moment){.value = 0.8, .error = 0.003, .t_s = 2.4};
        c->f.peak_simulated = (struct signal_moment){.value = 0.804, .error = 0.004, .t_s = 2.5};
        c->peak_en = 0.4;
        c->end_measured = (struct signal_moment){.value = 0.7, .error = 0.003};
        c->end_simulated = (struct signal_moment){.value = 0.7, .error = 0.004};
        c->end_en = 0.0;
        c->f.arrival_measured = (struct signal_moment){.t_s = 1.5, .t_error_s = 0.003};
        c->f.arrival_simulated = (struct signal_moment){.t_s = 1.509, .t_error_s = 0.004};
        c->arrival_en = 0.9;
    }
    return figures;
}

static void assert_says(const struct compare_figures *figures, bool si, const char *expected)
{
    struct compare_agreement agreement;
    char sentence[COMPARE_SENTENCE];
    compare_agreement(figures, &agreement);
    compare_sentence(&agreement, si, sentence);
    assert_string_equal(sentence, expected);
}

static void all_that_agrees_is_said(void **state)
{
    (void)state;
    struct compare_figures figures = agreeing();
    assert_says(&figures, false,
                "RUN 7 as measured agrees with x.json: all 6 peaks, ends and arrivals within twice "
                "their errors, the largest En 0.9 "
                "(arrival, transducer 3, 60.0 ft)");
    figures.channel[0].arrival_en = NONE;
    figures.channel[1].compared = false;
    assert_says(&figures, false,
                "RUN 7 as measured agrees with x.json: all 2 peaks, ends and arrivals within twice "
                "their errors, the largest En 0.4 "
                "(peak, transducer 3, 60.0 ft); 1 not known; 1 transducer not compared");
}

/* 0.8 - 0.85 = -0.05, over 2 hypot(0.003, 0.004) = 0.01: En 5. */
static void who_differs_by_how_much_and_where(void **state)
{
    (void)state;
    struct compare_figures figures = agreeing();
    figures.channel[1].f.peak_simulated.value = 0.85;
    figures.channel[1].peak_en = 5.0;
    figures.channel[0].end_en = 1.01;
    assert_says(
        &figures, false,
        "RUN 7 as measured differs from x.json, most in the peak at transducer 4, 70.0 ft: the "
        "simulated is 0.8500 +- 0.0040 in at 2.500 s, "
        "0.0500 in more than the measured, 0.8000 +- 0.0030 in at 2.400 s; En 5.0, the difference "
        "over twice their common error of "
        "0.0050 in; 2 of 6 values differ by more than twice their errors, 0.3 would by chance");
    assert_says(
        &figures, true,
        "RUN 7 as measured differs from x.json, most in the peak at transducer 4, 21.3 m: the "
        "simulated is 21.59 +- 0.10 mm at 2.500 s, "
        "1.27 mm more than the measured, 20.32 +- 0.08 mm at 2.400 s; En 5.0, the difference over "
        "twice their common error of "
        "0.13 mm; 2 of 6 values differ by more than twice their errors, 0.3 would by chance");
}

static void an_arrival_is_a_time(void **state)
{
    (void)state;
    struct compare_figures figures = agreeing();
    figures.channel[0].f.arrival_simulated.t_s = 1.3;
    figures.channel[0].arrival_en = 20.0;
    assert_says(&figures, true,
                "RUN 7 as measured differs from x.json, most in the arrival at transducer 3, 18.3 "
                "m: the simulated is 1.3000 +- 0.0040 s after touchdown, "
                "0.2000 s earlier than the measured, 1.5000 +- 0.0030 s; En 20.0, the difference "
                "over twice their common error of 0.0050 s; "
                "1 of 6 values differ by more than twice their errors, 0.3 would by chance");
}

static void without_errors_there_is_no_end(void **state)
{
    (void)state;
    struct compare_figures figures = agreeing();
    figures.against[0] = '\0';
    figures.channel[1].end_measured.error = figures.channel[1].end_simulated.error = 0.0;
    figures.channel[1].end_simulated.value = 0.6;
    figures.channel[1].end_en = (double)INFINITY;
    assert_says(&figures, false,
                "RUN 7 as measured differs from the simulation, most in the end at transducer 4, "
                "70.0 ft: the simulated, at rest, is 0.6000 +- 0.0000 in, "
                "0.1000 in less than the measured, 0.7000 +- 0.0000 in; En without end, for "
                "neither has an error; "
                "1 of 6 values differ by more than twice their errors, 0.3 would by chance");
}

static void nothing_known_is_no_agreement(void **state)
{
    (void)state;
    struct compare_figures figures = agreeing();
    for (size_t i = 0; i < 2; i++)
        figures.channel[i].compared = false;
    assert_says(&figures, false,
                "whether RUN 7 agrees with x.json is not known: there is no peak, end or arrival "
                "with its error; 2 transducers not compared");
}

static void of_several_the_worst_is_told(void **state)
{
    (void)state;
    struct compare_figures good = agreeing(), bad = agreeing(), worse = agreeing();
    const struct compare_figures *const all[] = {&good, &worse, &bad};
    char sentence[COMPARE_SENTENCE];
    bad.channel[0].peak_en = 1.5;
    worse.run = 9;
    worse.channel[1].end_en = 3.0;
    compare_sentence_of(all, 3, false, sentence);
    assert_ptr_equal(strstr(sentence,
                            "2 of 3 landings differ from what was simulated; RUN 9 as measured "
                            "differs from x.json, most in the end at transducer 4"),
                     sentence);
    compare_sentence_of(all, 1, false, sentence);
    assert_ptr_equal(strstr(sentence, "RUN 7 as measured agrees with x.json: all 6"), sentence);
    compare_sentence_of(all, 0, false, sentence);
    assert_non_null(strstr(sentence, "is not known"));
}

/* The longest of names does not write beyond the sentence. */
static void a_long_name_is_cut(void **state)
{
    (void)state;
    struct compare_figures figures = agreeing();
    struct compare_agreement agreement;
    char sentence[COMPARE_SENTENCE];
    memset(figures.against, 'x', sizeof figures.against - 1);
    figures.run = INT64_MIN;
    figures.channel[1].number = INT64_MIN;
    figures.channel[1].peak_en = 1e300;
    figures.channel[1].f.peak_simulated.value = figures.channel[1].f.peak_measured.error = 1e300;
    compare_agreement(&figures, &agreement);
    compare_sentence(&agreement, false, sentence);
    assert_true(strlen(sentence) < COMPARE_SENTENCE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_that_agrees_is_said),
        cmocka_unit_test(who_differs_by_how_much_and_where),
        cmocka_unit_test(an_arrival_is_a_time),
        cmocka_unit_test(without_errors_there_is_no_end),
        cmocka_unit_test(nothing_known_is_no_agreement),
        cmocka_unit_test(of_several_the_worst_is_told),
        cmocka_unit_test(a_long_name_is_cut),
    };
    return cmocka_run_group_tests_name("host/agree", tests, NULL, NULL);
}
