/* error-report FOLDER: the onboard predictor beside the solver that it is held against, error
 * against run time on the landings of the standard series, and what it costs on the board. Markdown
 * on stdout, FOLDER/predictor.svg. */
#include <math.h>
#include <stdio.h>

#include "host/base/plot.h"
#include "tests/error_report/predictor_study.h"

#define CLOCK_KHZ 168e3

/* A model at one cost, over all landings. */
struct cost {
    double ms, board_ms, own_in, most_in, other_in, share_percent; /* NaN: it has none */
};

static struct cost of_variant(const struct predictor_variant *variant)
{
    struct cost cost = {0};
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        const struct predictor_run *run = &variant->run[k];
        cost.ms += run->ms / PREDICTOR_STUDY_LANDINGS;
        cost.board_ms += run->cycles / CLOCK_KHZ / PREDICTOR_STUDY_LANDINGS;
        cost.own_in += run->own.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.other_in += run->other.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.most_in = fmax(cost.most_in, run->own.most_in);
        cost.share_percent = fmax(cost.share_percent, 100.0 * run->share);
    }
    return cost;
}

static struct cost of_solver(const struct predictor_solver *solver)
{
    struct cost cost = {
        .board_ms = (double)NAN, .other_in = (double)NAN, .share_percent = (double)NAN};
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        cost.ms += solver->run[k].ms / PREDICTOR_STUDY_LANDINGS;
        cost.own_in += solver->run[k].own.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.most_in = fmax(cost.most_in, solver->run[k].own.most_in);
    }
    return cost;
}

static void row(const char *model, const char *name, const struct cost *cost)
{
    printf("| %s | %s | %.1f | %.0f | %.4f | %.3f | %.4f | %.1f |\n", model, name, cost->ms,
           cost->board_ms, cost->own_in, cost->most_in, cost->other_in, cost->share_percent);
}

static void draw_panel(struct plot *plot, const struct predictor_study *study, bool own)
{
    plot_panel(plot, own ? "the runway it assumes" : "another runway: survey, eight transducers",
               (struct plot_axis){.label = "million cycles on the board", .log = true},
               (struct plot_axis){.label = "rms error of u (in)", .log = true});
    for (unsigned k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        double x[PREDICTOR_STUDY_VARIANTS], y[PREDICTOR_STUDY_VARIANTS];
        char key[24];
        size_t count = 0;
        for (size_t i = 0; i < study->count; i++) {
            const struct predictor_run *run = &study->variant[i].run[k];
            if (study->variant[i].refused)
                continue;
            x[count] = run->cycles / 1e6;
            y[count++] = own ? run->own.rms_in : run->other.rms_in;
        }
        snprintf(key, sizeof key, "landing %u", k + 1);
        plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE_POINTS,
                                              .key = key,
                                              .colour = k,
                                              .shape = k,
                                              .x = x,
                                              .y = y,
                                              .count = count});
    }
}

static enum mr_status write_predictor(const char *folder, struct error *error)
{
    static struct predictor_study study;
    char path[400];
    if (predictor_study_run(&study, error) != MR_OK)
        return error->status;
    printf("\n## The onboard predictor\n\nThe model that runs on the board while a landing is "
           "recorded (single precision, each millisecond as it comes), beside the chain's solver "
           "`staggered` (double precision, single passes): means of %d landings of the standard "
           "series, errors of the movement at every tenth mat and all milliseconds against the "
           "chain at 25 us. Both have the runway's true openings; \"another runway\" is one of "
           "which the predictor knows a survey and eight transducers. On the board: its cycles at "
           "168 MHz, and their share of the worst second of any landing.\n\n"
           "| model | step or level | ms a landing | ms on the board | rms error (in) | largest "
           "error (in) | rms, another runway (in) | of the worst second (%%) |\n"
           "|---|---|---|---|---|---|---|---|\n",
           PREDICTOR_STUDY_LANDINGS);
    for (size_t i = 0; i < study.count; i++) {
        struct cost cost = of_variant(&study.variant[i]);
        if (study.variant[i].refused)
            printf("| predictor | %s | refused: beyond the stability limit | | | | | |\n",
                   study.variant[i].name);
        else
            row("predictor", study.variant[i].name, &cost);
    }
    for (size_t i = 0; i < PREDICTOR_STUDY_SOLVERS; i++) {
        struct cost cost = of_solver(&study.solver[i]);
        char step[40];
        snprintf(step, sizeof step, "%.3g ms", 1e3 * study.solver[i].step_s);
        row("staggered", step, &cost);
    }
    struct plot *plot = plot_new("onboard predictor: error against the fine chain, by cost", 960,
                                 480, 2);
    draw_panel(plot, &study, true);
    draw_panel(plot, &study, false);
    snprintf(path, sizeof path, "%s/predictor.svg", folder);
    return plot_write(plot, path, error);
}

int main(int argc, char **argv)
{
    struct error error = {0};
    if (argc != 2) {
        fputs("usage: error-report FOLDER\n", stderr);
        return 2;
    }
    if (write_predictor(argv[1], &error) == MR_OK)
        return 0;
    fprintf(stderr, "error-report: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
