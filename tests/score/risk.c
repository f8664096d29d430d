/* risk: the weights of the board's risk (common/risk.h). How good it is with them: foresight.
 *
 *   risk FOLDER fit   common/risk_weights.def on stdout, from series 100 to 249, chain and late,
 *                     all views, and both without transducers; with charts for 100 to 159
 *
 * Exit: 0; 2 usage; 5 a series failed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/score/advised.h"
#include "tests/score/stats.h"

#define FROM      100u
#define COUNT     150u
#define CHARTED   60u
#define TOUCHDOWN 3.0f
#define ROWS      2
#define SAMPLES   1500000u
#define VIEWS     6u
#define RIDGE     10.0

/* What is given to the board. */
enum mode { BY_NOTHING, BY_PLAN, BY_CHART, MODES };

struct sample {
    float input[MR_RISK_INPUTS];
    uint8_t set;
    bool event;
};

static struct sample *sample;
static size_t samples;

/* Surveyed, transducers sound, the plan off by 10 % rms. */
static const struct advised_told told = {
    .view = SCORE_SURVEYED, .friction_times = 1.0, .plan_error = 0.1, .harder = 1.0};

struct listener {
    const struct score_truth *truth;
    const struct score_landing *landing;
    const struct advised_chart *chart; /* NULL: none */
    unsigned view, modes;
    struct mr_risk_state risk[MODES];
    float event_s;
};

static void on_look(void *ctx, const struct score_look *look)
{
    (void)ctx;
    (void)look;
}

static void on_outcome(void *ctx, const struct score_outcome *outcome)
{
    (void)ctx;
    (void)outcome;
}

static void on_armed(void *ctx, const struct mr_predictor *predictor,
                     const struct score_landing *landing)
{
    struct listener *l = ctx;
    struct mr_risk_plan plan;
    l->landing = landing;
    l->event_s = (float)score_event_s(landing);
    advised_draw_plan(landing, l->truth->series.number, &told, &plan);
    plan.landings = (float)predictor->landings;
    l->modes = l->chart && l->view & SCORE_SURVEYED ? MODES : BY_CHART;
    mr_risk_arm(&l->risk[BY_NOTHING], NULL, predictor, TOUCHDOWN);
    mr_risk_arm(&l->risk[BY_PLAN], &plan, predictor, TOUCHDOWN);
    if (l->modes == MODES) {
        advised_chart_put(&l->chart[landing->number - 1u], ROWS, &plan);
        mr_risk_arm(&l->risk[BY_CHART], &plan, predictor, TOUCHDOWN);
    }
}

static void on_block(void *ctx, const struct mr_predictor *predictor,
                     const struct mr_predictor_input *input, unsigned ms)
{
    struct listener *l = ctx;
    struct mr_predictor_zone zone;
    for (unsigned m = 0; m < l->modes; m++)
        mr_risk_block(&l->risk[m], predictor, input);
    if (ms % SCORE_LOOK_MS || ms / SCORE_LOOK_MS >= l->landing->looks ||
        1e-3 * ms >= (double)l->event_s)
        return;
    mr_predictor_zone(predictor, &zone);
    for (unsigned m = 0; m < l->modes && samples < SAMPLES; m++) {
        struct mr_risk_report said;
        mr_risk_report(&l->risk[m], predictor, &zone, &said);
        if (said.basis & MR_RISK_STOPPED)
            continue;
        struct sample *s = &sample[samples++];
        *s = (struct sample){.set = (uint8_t)said.set, .event = !isnan(l->event_s)};
        memcpy(s->input, said.input, sizeof s->input);
    }
}

static bool play(const char *folder, enum score_kind kind)
{
    static const double factors[ROWS] = {0.85, 1.2};
    static struct score_truth truth;
    for (unsigned n = FROM; n < FROM + COUNT; n++) {
        struct advised_chart chart[SCORE_LANDINGS];
        struct listener l = {.truth = &truth, .chart = n < FROM + CHARTED ? chart : NULL};
        const struct score_sink sink = {on_look, on_outcome, on_armed, on_block, &l};
        if (!score_truth_get(&truth, n, kind, folder) ||
            (l.chart && !advised_charts(&truth, &told, factors, ROWS, chart)))
            return false;
        for (l.view = 0; l.view < VIEWS; l.view++)
            score_play(&truth, l.view, 0, &sink);
    }
    return true;
}

/* Neighbouring looks tell the same, so that thousands of them are not thousands of landings: hence
 * the ridge. */
static void fit_set(unsigned set, double *weight)
{
    static float input[SAMPLES][MR_RISK_INPUTS];
    static bool event[SAMPLES];
    size_t count = 0;
    for (size_t i = 0; i < samples; i++) {
        if (sample[i].set != set)
            continue;
        memcpy(input[count], sample[i].input, sizeof input[count]);
        event[count++] = sample[i].event;
    }
    stats_fit(input[0], event, count, MR_RISK_INPUTS, RIDGE, weight);
}

int main(int argc, char **argv)
{
    sample = calloc(SAMPLES, sizeof *sample);
    if (argc != 3 || strcmp(argv[2], "fit") != 0) {
        fprintf(stderr, "risk: usage: risk FOLDER fit\n");
        return 2;
    }
    if (!sample || !play(argv[1], SCORE_CHAIN) || !play(argv[1], SCORE_LATE))
        return 5;
    printf(
        "/* Weights of common/risk.c, a row for each set, a column for each input: made by\n"
        " * `build/tests/score/risk build/score fit` (tests/score/README.md), which says on what. "
        "*/\n\n");
    for (unsigned set = 0; set < MR_RISK_SETS; set++) {
        double weight[MR_RISK_INPUTS];
        fit_set(set, weight);
        printf("{");
        for (unsigned k = 0; k < MR_RISK_INPUTS; k++)
            printf("%s%.4ff", k ? ", " : "", weight[k]);
        printf("},\n");
    }
    free(sample);
    return 0;
}
