/* The onboard predictor beside the solver that it is held against: error against run time on the
 * landings of the standard series, and what it costs on the board. */
#include <math.h>

#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/report/plot_predictor.h"
#include "host/sim/check/predictor_study.h"
#include "tests/error_report/report.h"

#define CLOCK_KHZ 168e3

/* A model at one cost, over all landings. */
struct cost {
    const char *name;
    double ms, board_ms, own_in, most_in, other_in; /* NaN: it has none */
};

static struct cost of_variant(const struct predictor_variant *variant)
{
    struct cost cost = {.name = variant->name};
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        const struct predictor_run *run = &variant->run[k];
        cost.ms += run->ms / PREDICTOR_STUDY_LANDINGS;
        cost.board_ms += run->cycles / CLOCK_KHZ / PREDICTOR_STUDY_LANDINGS;
        cost.own_in += run->own.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.other_in += run->other.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.most_in = fmax(cost.most_in, run->own.most_in);
    }
    return cost;
}

static struct cost of_solver(const struct predictor_solver *solver)
{
    struct cost cost = {.board_ms = (double)NAN, .other_in = (double)NAN};
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++) {
        cost.ms += solver->run[k].ms / PREDICTOR_STUDY_LANDINGS;
        cost.own_in += solver->run[k].own.rms_in / PREDICTOR_STUDY_LANDINGS;
        cost.most_in = fmax(cost.most_in, solver->run[k].own.most_in);
    }
    return cost;
}

static void table_row(FILE *out, const char *model, const char *name, const struct cost *cost)
{
    fputs("<tr>", out);
    html_cell(out, "%s", model);
    html_cell(out, "%s", name);
    html_number(out, cost->ms, 1);
    html_number(out, cost->board_ms, 0);
    html_number(out, cost->own_in, 4);
    html_number(out, cost->most_in, 3);
    html_number(out, cost->other_in, 4);
    fputs("</tr>\n", out);
}

static void draw(FILE *out, const struct cost *predictor, size_t predictors,
                 const struct cost *solver)
{
    double low = HUGE_VAL, high = 0.0, fast = HUGE_VAL, slow = 0.0;
    double x[PREDICTOR_STUDY_VARIANTS], y[PREDICTOR_STUDY_VARIANTS];
    for (size_t i = 0; i < predictors + PREDICTOR_STUDY_SOLVERS; i++) {
        const struct cost *cost = i < predictors ? &predictor[i] : &solver[i - predictors];
        low = fmin(low, cost->own_in);
        high = fmax(high, cost->own_in);
        fast = fmin(fast, cost->ms);
        slow = fmax(slow, cost->ms);
    }
    struct svg_plot plot = {
        .out = out,
        .left = 70,
        .top = 20,
        .width = 500,
        .height = 240,
        .log_x = true,
        .log_y = true,
        .x = {fast / 1.3, slow * 1.3, "run time of a landing on this computer, ms", true},
        .y = {low / 1.5, high * 1.5, "rms error of movement, in", true}};
    svg_open(out, 600, 310, "error against run time of the predictor and of the chain");
    fputs("<style>.q0,.q1{fill:none;stroke-width:1.6}.q0{stroke:#3465a4}.q1{stroke:#cc0000}"
          "</style>",
          out);
    svg_axes(&plot);
    for (size_t i = 0; i < predictors; i++) {
        svg_mark(out, "q1", 1, svg_x(&plot, predictor[i].ms), svg_y(&plot, predictor[i].own_in), 4);
        svg_text(&plot, "label", "start", predictor[i].ms, predictor[i].own_in, 6, -6,
                 i == 0 || i + 3 >= predictors ? predictor[i].name : "");
    }
    for (size_t i = 0; i < PREDICTOR_STUDY_SOLVERS; i++) {
        x[i] = solver[i].ms;
        y[i] = solver[i].own_in;
        svg_mark(out, "q0", 0, svg_x(&plot, x[i]), svg_y(&plot, y[i]), 4);
    }
    svg_line(&plot, "q0", x, y, PREDICTOR_STUDY_SOLVERS);
    svg_text(&plot, "label", "start", x[0], y[0], 6, 14, "staggered");
    svg_close(out);
}

enum mr_status write_predictor(FILE *out, struct error *error)
{
    static const char *const heads[] = {"model",
                                        "step or level",
                                        "ms a landing",
                                        "ms on the board",
                                        "rms error, in",
                                        "largest error, in",
                                        "rms, another runway, in",
                                        NULL};
    static struct predictor_study study;
    struct cost predictor[PREDICTOR_STUDY_VARIANTS], solver[PREDICTOR_STUDY_SOLVERS];
    size_t count = 0;
    if (predictor_study_run(&study, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < study.count; i++) {
        if (!study.variant[i].refused)
            predictor[count++] = of_variant(&study.variant[i]);
    }
    for (size_t i = 0; i < PREDICTOR_STUDY_SOLVERS; i++)
        solver[i] = of_solver(&study.solver[i]);
    fprintf(out,
            "<h2>The onboard predictor</h2>\n<p>The model that runs on the board while a landing "
            "is recorded (single precision, each millisecond as it comes), beside the chain's "
            "solver <b>fixed</b> (double precision, single passes): means of %d landings of the "
            "standard series, errors of the movement at every tenth mat and all milliseconds "
            "against the chain at 25 us. Both have the runway's true openings; the last column is "
            "a runway of which the predictor knows a survey and eight transducers. Largest error: "
            "of all landings. On the board: its cycles at 168 MHz. %zu of %zu steps are refused "
            "as beyond the stability limit.</p>\n",
            PREDICTOR_STUDY_LANDINGS, study.count - count, study.count);
    draw(out, predictor, count, solver);
    html_table(out, heads);
    for (size_t i = 0; i < count; i++)
        table_row(out, "predictor", predictor[i].name, &predictor[i]);
    for (size_t i = 0; i < PREDICTOR_STUDY_SOLVERS; i++) {
        char step[40];
        snprintf(step, sizeof step, "%.3g ms", 1e3 * study.solver[i].step_s);
        table_row(out, "staggered", step, &solver[i]);
    }
    fputs("</tbody></table></div>\n", out);
    plot_predictor_file(out, &study);
    return MR_OK;
}
