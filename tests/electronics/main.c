/* electronics: drawn boards on the emulated rig, counted.
 *
 *     electronics boards N [FROM]   N boards: switches, zeros, spans, bridges
 *     electronics staircase N       N boards at INL of exactly 1.5 and 3 LSB, 3.24 to 3.36 V
 *
 * Prints tables in Markdown, as docs/measured/electronics.md has them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/config.h"
#include "common/staircase.h"
#include "tests/electronics/boards.h"

struct spread {
    double *value;
    size_t count;
};

static void put(struct spread *spread, double value)
{
    if (!isnan(value))
        spread->value[spread->count++] = value;
}

static int by_size(const void *a, const void *b)
{
    double x = fabs(*(const double *)a), y = fabs(*(const double *)b);
    return (x > y) - (x < y);
}

static double rms(const struct spread *spread)
{
    double sum = 0.0;
    for (size_t i = 0; i < spread->count; i++)
        sum += spread->value[i] * spread->value[i];
    return spread->count ? sqrt(sum / (double)spread->count) : (double)NAN;
}

/* Of the sizes. */
static double quantile(const struct spread *spread, double part)
{
    if (!spread->count)
        return (double)NAN;
    qsort(spread->value, spread->count, sizeof *spread->value, by_size);
    return fabs(spread->value[(size_t)(part * (double)(spread->count - 1u))]);
}

static void print_spread(const char *what, struct spread *spread, double scale, int digits)
{
    printf("| %s | %.*f | %.*f | %.*f |\n", what, digits, rms(spread) * scale, digits,
           quantile(spread, 0.95) * scale, digits, quantile(spread, 1.0) * scale);
}

/* ---- boards ---- */

enum figure { ZERO, SPAN, ZEROED, LEFT_ZERO, LEFT_SPAN, LEFT_WORST, FIGURES };

struct totals {
    size_t boards, unnamed_boards, misnamed_boards, unnamed, misnamed, troubled, zeroed;
    size_t bridges, natural_inside, valid;
    struct spread of[2][FIGURES]; /* transducers, gages */
};

/* The amplifier's output lies between the rails from 0 lb to the most that the configuration
 * allows. */
static bool inside(double zero_lb)
{
    return zero_lb > -75.0 && zero_lb < 175.0;
}

static void count_board(struct totals *totals, const struct board_outcome *o)
{
    totals->boards++;
    totals->troubled += o->trouble[0] != '\0';
    totals->unnamed += o->unnamed;
    totals->misnamed += o->misnamed;
    totals->unnamed_boards += o->unnamed != 0;
    totals->misnamed_boards += o->misnamed != 0;
    totals->zeroed += o->zero_taken;
    for (unsigned c = 0; c < HIL_RUN_COLUMNS; c++) {
        const struct board_channel *channel = &o->channel[c];
        bool gage = c >= HIL_RUN_TRANSDUCERS;
        if (gage) {
            totals->bridges++;
            totals->valid += channel->valid;
            totals->natural_inside +=
                inside(o->electronics.gage_natural_lb[c - HIL_RUN_TRANSDUCERS]);
        }
        put(&totals->of[gage][ZERO], channel->zero);
        put(&totals->of[gage][SPAN], channel->span_rel);
        put(&totals->of[gage][ZEROED], o->zero_taken ? channel->zeroed : (double)NAN);
        put(&totals->of[gage][LEFT_ZERO], channel->left_zero);
        put(&totals->of[gage][LEFT_SPAN], channel->left_span);
        put(&totals->of[gage][LEFT_WORST], channel->left_worst);
    }
}

static void print_channels(struct totals *totals, bool gage)
{
    struct spread *of = totals->of[gage];
    const char *unit = gage ? "lb" : "in";
    char what[100];
    int digits = gage ? 2 : 4;
    printf("\n| %s | rms | 95 %% | most |\n|---|---|---|---|\n", gage ? "gages" : "transducers");
    snprintf(what, sizeof what, "zero as configured, %s", unit);
    print_spread(what, &of[ZERO], 1.0, digits);
    print_spread("span as configured, %", &of[SPAN], 100.0, 2);
    snprintf(what, sizeof what, "zero after the command zero, %s", unit);
    print_spread(what, &of[ZEROED], 1.0, digits);
    snprintf(what, sizeof what, "zero after calibration, %s", unit);
    print_spread(what, &of[LEFT_ZERO], 1.0, digits);
    print_spread("span after calibration, %", &of[LEFT_SPAN], 100.0, 3);
    snprintf(what, sizeof what, "worst of four values in between, %s", unit);
    print_spread(what, &of[LEFT_WORST], 1.0, digits);
}

static int boards(uint64_t count, uint64_t from)
{
    struct totals totals = {0};
    struct board_outcome *outcome = malloc(sizeof *outcome);
    for (unsigned i = 0; i < 2u * FIGURES; i++) {
        totals.of[i / FIGURES][i % FIGURES].value =
            malloc(HIL_RUN_COLUMNS * count * sizeof(double));
        if (!outcome || !totals.of[i / FIGURES][i % FIGURES].value)
            abort();
    }
    for (uint64_t seed = from; seed < from + count; seed++) {
        board_play(&(struct board_request){.seed = seed, .vdda_v = board_vdda_v(seed)}, outcome);
        count_board(&totals, outcome);
        if (outcome->trouble[0])
            printf("board %llu: %s\n", (unsigned long long)seed, outcome->trouble);
    }
    printf("%zu boards, VDDA 3.24 to 3.36 V, %zu of them stopped.\n\n", totals.boards,
           totals.troubled);
    printf("| | |\n|---|---|\n");
    printf("| switches opened | %zu |\n", 24u * totals.boards);
    printf("| named wrongly | %zu, on %zu boards |\n", totals.misnamed, totals.misnamed_boards);
    printf("| not named | %zu, on %zu boards |\n", totals.unnamed, totals.unnamed_boards);
    printf("| boards that took the command zero | %zu |\n", totals.zeroed);
    printf("| bridges inside the amplifier's range, 0 to 400 lb, untrimmed | %zu of %zu |\n",
           totals.natural_inside, totals.bridges);
    printf("| bridges inside it, trimmed, by the board's own readings | %zu of %zu |\n",
           totals.valid, totals.bridges);
    print_channels(&totals, false);
    print_channels(&totals, true);
    for (unsigned i = 0; i < 2u * FIGURES; i++)
        free(totals.of[i / FIGURES][i % FIGURES].value);
    free(outcome);
    return totals.troubled ? 1 : 0;
}

/* ---- staircase ---- */

static void play(const struct board_request *request, struct board_outcome *outcome)
{
    board_play(request, outcome);
    if (!outcome->trouble[0])
        return;
    fprintf(stderr, "electronics: board %llu: %s\n", (unsigned long long)request->seed,
            outcome->trouble);
    exit(1);
}

static void staircase_row(uint64_t count, double inl_lsb, double tolerance)
{
    struct hil_figures figures;
    struct board_outcome *first = malloc(sizeof *first);
    size_t unnamed = 0, misnamed = 0, unnamed_boards = 0, misnamed_boards = 0;
    double worst = 0.0;
    if (!first)
        abort();
    hil_figures_reference(&figures);
    figures.adc_inl_typical_lsb = figures.adc_inl_most_lsb = inl_lsb;
    if (tolerance > 0.0)
        figures.staircase_resistor_tol_rel = tolerance;
    for (uint64_t seed = 0; seed < count; seed++) {
        struct board_request request = {
            .seed = seed, .vdda_v = board_vdda_v(seed), .figures = &figures, .only_switches = true};
        play(&request, first);
        unnamed += first->unnamed;
        misnamed += first->misnamed;
        unnamed_boards += first->unnamed != 0;
        misnamed_boards += first->misnamed != 0;
        for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
            worst = fmax(worst, fabs((double)first->step_codes[i] - hil_step_codes(i + 1u)));
    }
    printf("| %llu | %.1f | %.2f | %zu on %zu | %zu on %zu | %.2f |\n", (unsigned long long)count,
           inl_lsb, 100.0 * figures.staircase_resistor_tol_rel, misnamed, misnamed_boards, unnamed,
           unnamed_boards, worst);
    fflush(stdout);
    free(first);
}

static int staircase(uint64_t count)
{
    printf("VDDA 3.24 to 3.36 V.\n\n");
    printf("| boards | INL, LSB | resistors, %% | named wrongly, boards | not named, boards | "
           "worst step, "
           "codes "
           "off |\n|---|---|---|---|---|---|\n");
    staircase_row(count, 1.5, 0.0);
    staircase_row(count, 3.0, 0.0);
    staircase_row((count + 4u) / 5u, 1.5, 0.01); /* what a drawer holds */
    staircase_row((count + 4u) / 5u, 3.0, 0.01);
    return 0;
}

int main(int argc, char **argv)
{
    uint64_t count = argc > 2 ? strtoull(argv[2], NULL, 10) : 0;
    uint64_t from = argc > 3 ? strtoull(argv[3], NULL, 10) : 0;
    if (count && strcmp(argv[1], "boards") == 0)
        return boards(count, from);
    if (count && strcmp(argv[1], "staircase") == 0)
        return staircase(count);
    fputs("usage: electronics boards N [FROM] | staircase N\n", stderr);
    return 2;
}
