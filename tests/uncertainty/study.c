/* Does the interval of the uncertainty budget hold? Drawn calibrations and landings (draw.h)
 * against the budget's expanded uncertainty, and against the stated error alone.
 *
 * usage: study DRAWS [--without SOURCE]     a table; exit 1 when an interval holds in less than
 *                                           93.5 or more than 97 % of the draws. SOURCE:
 *                                           certificate or temperature, left out of the sum */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/calibrate/budget.h"
#include "tests/uncertainty/draw.h"

#define LEAST  93.5
#define MOST   97.0
#define NORMAL 1.959964

static const struct study {
    const char *name, *unit;
    enum draw_kind kind;
    double certificate_rel, factor; /* expanded, of the reading */
    struct draw_setting setting;
} studies[] = {
    {"transducer",
     "in",
     DRAW_TRANSDUCER,
     0.008,
     2.0,
     {.laboratory_rel = 0.004,
      .setting = 0.001,
      .kelvin = 10.0,
      .least = 0.3,
      .most = 2.5,
      .known_most = 2.7,
      .steps = 10}},
    {"gage",
     "lb",
     DRAW_GAGE,
     0.004,
     2.0,
     {.laboratory_rel = 0.002,
      .setting = 0.05,
      .kelvin = 10.0,
      .least = 50.0,
      .most = 350.0,
      .known_most = 400.0,
      .steps = 10}},
};
#define STUDIES (sizeof studies / sizeof studies[0])

struct tally {
    unsigned stated, expanded;
    double squares[BUDGET_SOURCES]; /* of the contributions */
    double errors, errors_rel;      /* squared; the second in combined standard uncertainties */
};

static void take(const struct study *study, const char *without, uint64_t seed, struct tally *t)
{
    struct drawn drawn;
    struct budget budget;
    draw(study->kind, &study->setting, seed, &drawn);
    bool certificate = !without || strcmp(without, "certificate") != 0,
         temperature = !without || strcmp(without, "temperature") != 0;
    const struct budget_case of = {
        .channel = &drawn.channel,
        .reading = drawn.reading,
        .certificate = certificate ? study->certificate_rel * fabs(drawn.value) : (double)NAN,
        .certificate_factor = study->factor,
        .kelvin = temperature ? study->setting.kelvin : 0.0};
    budget_make(&of, &budget);
    double off = drawn.value - drawn.truth;
    t->stated += fabs(off) <= NORMAL * budget.stated;
    t->expanded += fabs(off) <= budget.expanded;
    t->errors += off * off;
    t->errors_rel += off * off / (budget.combined * budget.combined);
    for (enum budget_source s = 0; s < BUDGET_SOURCES; s++)
        t->squares[s] += budget.row[s].contribution * budget.row[s].contribution;
}

static void print_rows(const struct tally *t, unsigned draws)
{
    printf("\n| contribution, rms of all draws | %s, %s | %s, %s |\n|---|---|---|\n",
           studies[0].name, studies[0].unit, studies[1].name, studies[1].unit);
    for (enum budget_source s = 0; s < BUDGET_SOURCES; s++) {
        printf("| %s |", budget_source_text(s));
        for (size_t i = 0; i < STUDIES; i++)
            printf(" %.2g |", sqrt(t[i].squares[s] / draws));
        printf("\n");
    }
    printf("| error, true |");
    for (size_t i = 0; i < STUDIES; i++)
        printf(" %.2g |", sqrt(t[i].errors / draws));
    printf("\n");
}

int main(int argc, char **argv)
{
    unsigned draws = argc > 1 ? (unsigned)strtoul(argv[1], NULL, 10) : 0;
    const char *without = argc == 4 && strcmp(argv[2], "--without") == 0 ? argv[3] : NULL;
    struct tally tally[STUDIES] = {0};
    bool held = true;
    if (draws < 1 || draws > 100000 || (argc != 2 && !without)) {
        fputs("usage: study DRAWS [--without certificate|temperature]\n", stderr);
        return 2;
    }
    printf("| | draws | expanded holds, %% | Wilson 95 %%, %% | error over combined, rms | stated "
           "alone holds, %% |\n|---|---|---|---|---|---|\n");
    for (size_t i = 0; i < STUDIES; i++) {
        for (unsigned seed = 1; seed <= draws; seed++)
            take(&studies[i], without, seed, &tally[i]);
        const struct tally *t = &tally[i];
        struct wilson wilson = wilson_of(t->expanded, draws);
        double percent = 100.0 * t->expanded / draws;
        printf("| %s | %u | %.1f | %.1f to %.1f | %.2f | %.1f |\n", studies[i].name, draws, percent,
               100.0 * wilson.low, 100.0 * wilson.high, sqrt(t->errors_rel / draws),
               100.0 * t->stated / draws);
        held &= percent >= LEAST && percent <= MOST;
    }
    print_rows(tally, draws);
    return held ? 0 : 1;
}
