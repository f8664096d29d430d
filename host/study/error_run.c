/* The command matrig error: runs a scene with every solver and compares errors with run times. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/commands/studies.h"
#include "host/base/answer.h"
#include "host/base/plot.h"
#include "host/base/progress.h"
#include "host/sim/check/error_study.h"

#define SOLVERS_MAX 8

static double value_or_nan(bool known, double value)
{
    return known ? value : (double)NAN;
}

/* Adds an error. `agreement_ft` is the difference between the two reference solutions. If the error
 * is too small to be distinguished from this difference, text shows "less than" the difference. */
static void add_error(struct answer *answer, const char *name, const char *label,
                      const struct error_run *run, double run_error_ft, double agreement_ft)
{
    answer_add_value(answer, name, NULL, UNIT_NUMBER,
                     value_or_nan(run->status == SIM_OK, run_error_ft), 0);
    if (run->status != SIM_OK || isnan(run_error_ft))
        answer_add_text(answer, NULL, label, "%9s", "-");
    else if (run_error_ft <= ERROR_RESOLUTION_FACTOR * agreement_ft)
        answer_add_text(answer, NULL, label, "<%8.1e", ERROR_RESOLUTION_FACTOR * agreement_ft);
    else
        answer_add_text(answer, NULL, label, "%9.2e", run_error_ft);
}

static void add_run(struct answer *answer, const struct error_study *study,
                    const struct error_run *run)
{
    bool fixed = run->dt_s > 0.0;
    answer_open_row(answer);
    answer_add_text(answer, "solver", "solver", "%s", run->solver);
    answer_add_text(answer, NULL, "rtol or dt", fixed ? "dt %.4g s" : "rtol %.0e",
                    fixed ? run->dt_s : run->rtol);
    answer_add_value(answer, "rtol", NULL, UNIT_NUMBER, value_or_nan(run->rtol > 0.0, run->rtol),
                     0);
    answer_add_value(answer, "dt", NULL, UNIT_TIME, value_or_nan(fixed, run->dt_s), 0)->digits = 9;
    answer_add_count(answer, "steps", "steps", (int64_t)run->steps);
    answer_add_count(answer, "rhs", "rhs", (int64_t)run->evaluations);
    answer_add_value(answer, "run_ms", "ms", UNIT_NUMBER, run->ms, 2);
    add_error(answer, "err_u", "error of|u, ft", run, run->u_ft, study->disagreement_u_ft);
    add_error(answer, "err_lift", "error of|lift, ft", run, run->lift_ft,
              study->disagreement_lift_ft);
    answer_add_text(answer, "status", NULL, "%s", sim_status_name(run->status));
    answer_add_text(answer, NULL, "status", run->is_unstable ? "%s, beyond the limit" : "%s",
                    sim_status_name(run->status));
    if (run->status != SIM_OK)
        answer_add_text(answer, NULL, "where", "mat %d at %.4g s", run->mat, run->t_s);
    answer_add_value(answer, "max_lift", NULL, UNIT_STATION,
                     value_or_nan(run->status == SIM_OK, run->max_lift_ft), 0)
        ->digits = 9;
    answer_add_flag(answer, "beyond_limit", NULL, run->is_unstable);
}

static void add_runs(struct answer *answer, const struct error_study *study)
{
    bool beyond = false;
    answer_open_table(answer, "runs", "runs");
    for (size_t i = 0; i < study->run_count; i++) {
        add_run(answer, study, &study->runs[i]);
        beyond = beyond || (study->runs[i].is_unstable && study->runs[i].status == SIM_OK);
    }
    answer_close_group(answer);
    if (beyond)
        answer_add_sentence(answer, NULL,
                            "beyond the limit: the step exceeds the stability limit, so `matrig "
                            "sim` refuses this step");
}

static json_t *slope_to_json(const struct error_slope *slope)
{
    if (slope->point_count == 0)
        return json_null();
    return json_pack("{s:o,s:o,s:o,s:o,s:i}", "slope", cli_json_number(slope->slope, 4), "scatter",
                     cli_json_number(slope->scatter, 3), "from", cli_json_number(slope->fit_min, 6),
                     "to", cli_json_number(slope->fit_max, 6), "points", slope->point_count);
}

static void format_slope(const char *what, const struct error_slope *slope,
                         const struct error_order *order, char *text, size_t size)
{
    if (slope->point_count == 0)
        snprintf(text, size,
                 "%s: the runs have too few errors for a fit, or run times that are too similar",
                 what);
    else if (slope->scatter > ERROR_SCATTER_MAX)
        snprintf(text, size, "%s: the errors of %d runs follow no power law (scatter %.2f decades)",
                 what, slope->point_count, slope->scatter);
    else
        snprintf(text, size, "%s: %.2f (%d runs, %s %.3g to %.3g, scatter %.2f decades)", what,
                 slope->slope, slope->point_count, order->is_step_order ? "dt" : "rtol",
                 slope->fit_min, slope->fit_max, slope->scatter);
}

static void add_slopes(struct answer *answer, const struct error_study *study)
{
    answer_open_list(answer, "order", "observed orders p");
    for (size_t i = 0; i < study->order_count; i++) {
        const struct error_order *order = &study->orders[i];
        const char *law = order->is_step_order ? "error ~ dt^p" : "error ~ rtol^p";
        char u[120], lift[120];
        format_slope("u", &order->u, order, u, sizeof u);
        if (study->has_lift)
            format_slope("lift", &order->lift, order, lift, sizeof lift);
        answer_open_group(answer, NULL, "");
        answer_add_text(answer, NULL, order->solver, "%s, %s", law, u);
        if (study->has_lift)
            answer_add_text(answer, NULL, order->solver, "%s, %s", law, lift);
        answer_add_text(answer, "solver", NULL, "%s", order->solver);
        answer_add_text(answer, "against", NULL, "%s", order->is_step_order ? "dt" : "rtol");
        answer_add_json(answer, "u", slope_to_json(&order->u));
        answer_add_json(answer, "lift", slope_to_json(&order->lift));
        answer_close_group(answer);
    }
    answer_close_group(answer);
}

static void add_cheapest_runs(struct answer *answer, const struct error_study *study)
{
    const char *names[SOLVERS_MAX];
    size_t count = error_study_solvers(study, names, SOLVERS_MAX);
    answer_open_table(
        answer, NULL,
        study->has_lift
            ? "shortest run time (ms) for which the error of the lift is at most the value in the "
              "heading (fixed steps: the largest error of three neighbouring steps)"
            : "shortest run time (ms) for which the error of u is at most the value in the "
              "heading (fixed steps: the largest error of three neighbouring steps)");
    for (size_t i = 0; i <= count; i++) {
        answer_open_row(answer);
        answer_add_text(answer, NULL, "solver", "%s", i < count ? names[i] : "cheapest");
        for (size_t k = 0; k < error_level_count; k++) {
            const struct error_run *run =
                error_study_find_cheapest(study, i < count ? names[i] : NULL, error_levels_ft[k]);
            char level[24];
            snprintf(level, sizeof level, "%.0e ft", error_levels_ft[k]);
            if (i < count)
                answer_add_value(answer, NULL, level, UNIT_NUMBER, run ? run->ms : (double)NAN, 2);
            else
                answer_add_text(answer, NULL, level, "%s", run ? run->solver : "none");
        }
    }
    answer_close_group(answer);
}

/* All lengths are in feet, as in scenes. */
static struct answer *make_answer(const struct sim_scene *scene, const struct error_study *study)
{
    struct answer *answer = answer_new(false);
    answer_add_text(answer, "scene", "scene", "%s", scene->name);
    answer_add_text(answer, NULL, "model", "%s", sim_model_name(scene->model));
    answer_add_count(answer, NULL, "mats", scene->mats);
    answer_add_value(answer, NULL, "end", UNIT_TIME, study->end_s, -6);
    answer_open_group(answer, "reference", "reference");
    answer_add_sentence(answer, "method", "%s", study->reference_method);
    answer_open_group(answer, "agreement", "");
    answer_add_value(answer, "u", "agreement of u", UNIT_STATION, study->disagreement_u_ft, -2);
    answer_add_value(answer, "lift", "of lift", UNIT_STATION, study->disagreement_lift_ft, -2);
    answer_close_group(answer);
    answer_add_value(answer, "peak_u", "largest movement", UNIT_STATION, study->peak_u_ft, -6)
        ->digits = 12;
    answer_add_value(answer, "max_lift", "largest lift", UNIT_STATION, study->max_lift_ft, -6)
        ->digits = 12;
    answer_close_group(answer);
    answer_add_value(answer, "dt_limit", NULL, UNIT_TIME, study->dt_limit_s, 0)->digits = 9;
    add_runs(answer, study);
    add_slopes(answer, study);
    add_cheapest_runs(answer, study);
    answer_open_list(answer, "notes", "notes");
    for (size_t i = 0; study->notes[i][0]; i++)
        answer_add_sentence(answer, NULL, "%s", study->notes[i]);
    answer_close_group(answer);
    return answer;
}

#define PLOT_MIN_FT 1e-16 /* in ft; an error of 0 is shown as this value on the logarithmic axis */

static double run_error_ft(const struct error_run *run, bool lift)
{
    return fmax(PLOT_MIN_FT, lift ? run->lift_ft : run->u_ft);
}

/* Plots the runs of a solver that are within its stability limit, or those beyond the limit. A
 * failed run interrupts the line. */
static void plot_solver(struct plot *plot, const struct error_study *study, const char *solver,
                        unsigned index, bool lift, bool beyond)
{
    double ms[ERROR_RUNS_MAX], error[ERROR_RUNS_MAX];
    size_t count = 0;
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        bool ok = run->status == SIM_OK;
        if (strcmp(run->solver, solver) != 0 || run->is_unstable != beyond)
            continue;
        ms[count] = ok ? run->ms : (double)NAN;
        error[count++] = ok ? run_error_ft(run, lift) : (double)NAN;
    }
    plot_add_series(plot, &(struct plot_series){.kind = beyond ? PLOT_POINTS : PLOT_LINE_POINTS,
                                                .key = beyond ? NULL : solver,
                                                .colour = index,
                                                .shape = index,
                                                .is_hollow = beyond,
                                                .x = ms,
                                                .y = error,
                                                .count = count});
}

static void plot_error_panel(struct plot *plot, const struct error_study *study, bool lift)
{
    const double floor_ft = lift ? study->disagreement_lift_ft : study->disagreement_u_ft;
    const char *names[SOLVERS_MAX];
    size_t count = error_study_solvers(study, names, SOLVERS_MAX);
    plot_begin_panel(
        plot, NULL, (struct plot_axis){.label = "run time (ms)", .is_logarithmic = true},
        (struct plot_axis){.label = lift ? "largest error of lift (ft)" : "largest error of u (ft)",
                           .is_logarithmic = true});
    for (unsigned k = 0; k < count; k++) {
        plot_solver(plot, study, names[k], k, lift, false);
        plot_solver(plot, study, names[k], k, lift, true);
    }
    if (floor_ft > 0.0)
        plot_add_series(plot, &(struct plot_series){.kind = PLOT_HORIZONTAL_LINES,
                                                    .key = "disagreement of the references",
                                                    .colour = PLOT_GREY,
                                                    .y = &floor_ft,
                                                    .count = 1});
}

static enum mr_status write_plot(const char *path, const char *name,
                                 const struct error_study *study, struct error *error)
{
    struct plot *plot = plot_new(name, study->has_lift ? 960 : 640, 480, study->has_lift ? 2 : 1);
    if (study->has_lift)
        plot_error_panel(plot, study, true);
    plot_error_panel(plot, study, false);
    return plot_write(plot, path, error);
}

static void show_progress(void *ctx, size_t started_run_count)
{
    if (started_run_count == 0)
        progress_set(ctx, "reference: refinement of two methods until they agree");
    else
        progress_set(ctx, "run %zu, compared with the reference", started_run_count);
}

int error_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1];
    struct error_request r = {0};
    struct error error = {0};
    struct sim_scene scene;
    struct error_study study;
    struct progress progress;

    command_parse(&command_error, argc, argv, cli, &r, words, fatal);
    plot_check(r.plot, words[0], fatal); /* check before the computation, which takes a minute */
    sim_scene_load(&scene, words[0], fatal);
    if (!scene.name[0])
        snprintf(scene.name, sizeof scene.name, "%s", words[0]);
    progress_begin(&progress, "error", "a smaller tend", cli->quiet);
    enum mr_status status = error_study_run(&study, &scene, show_progress, &progress, &error);
    progress_end(&progress);
    if (status != MR_OK)
        return cli_fail(&error);
    if (r.plot)
        write_plot(r.plot, scene.name, &study, fatal);
    int code = answer_print(cli, make_answer(&scene, &study), 0);
    sim_scene_free(&scene);
    return code;
}
