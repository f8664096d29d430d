/* matrig error SCENE: every solver's error against its run time. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "host/commands/commands.h"
#include "host/commands/error_command.h"
#include "host/base/output.h"
#include "host/report/plot_error.h"
#include "host/sim/check/error_study.h"
#include "host/study/error_predictor.h"
#include "host/study/studies.h"

#define SOLVERS_MAX 8

static json_t *run_json(const struct error_run *run, bool lifts)
{
    bool ok = run->status == SIM_OK;
    return json_pack("{s:s,s:o,s:o,s:I,s:I,s:o,s:o,s:o,s:s,s:o,s:o,s:b}", "solver", run->solver, "rtol",
                     run->rtol > 0.0 ? cli_json_number(run->rtol, 6) : json_null(), "dt_s",
                     run->dt_s > 0.0 ? cli_json_number(run->dt_s, 9) : json_null(), "steps", (json_int_t)run->steps,
                     "rhs", (json_int_t)run->rhs, "run_ms", cli_json_number(run->ms, 6), "err_u",
                     ok ? cli_json_number(run->u_ft, 6) : json_null(), "err_lift",
                     ok ? cli_json_number(run->lift_ft, 6) : json_null(), "status", sim_status_name(run->status),
                     "err_u_rms", ok ? cli_json_number(run->rms_u_ft, 6) : json_null(), "max_lift_ft", ok && lifts ? cli_json_number(run->max_lift_ft, 9) : json_null(), "beyond_limit",
                     run->beyond);
}

static json_t *slope_json(const struct error_slope *slope)
{
    if (slope->points == 0)
        return json_null();
    return json_pack("{s:o,s:o,s:o,s:o,s:i}", "slope", cli_json_number(slope->slope, 4), "scatter",
                     cli_json_number(slope->scatter, 3), "from", cli_json_number(slope->from, 6), "to",
                     cli_json_number(slope->to, 6), "points", slope->points);
}

static json_t *cheapest_json(const struct error_study *study)
{
    json_t *list = json_array();
    for (size_t i = 0; i < error_level_count; i++) {
        const struct error_run *run = error_study_cheapest(study, NULL, error_levels_ft[i]);
        json_t *entry = json_pack("{s:o,s:s?}", study->lifts ? "err_lift" : "err_u",
                                  cli_json_number(error_levels_ft[i], 6), "solver", run ? run->solver : NULL);
        if (run) {
            json_object_set_new(entry, "rtol", run->rtol > 0.0 ? cli_json_number(run->rtol, 6) : json_null());
            json_object_set_new(entry, "dt_s", run->dt_s > 0.0 ? cli_json_number(run->dt_s, 9) : json_null());
            json_object_set_new(entry, "run_ms", cli_json_number(run->ms, 6));
        }
        json_array_append_new(list, entry);
    }
    return list;
}

static json_t *study_json(const struct sim_scene *scene, const struct error_study *study)
{
    json_t *runs = json_array(), *orders = json_array(), *notes = json_array();
    for (size_t i = 0; i < study->run_count; i++)
        json_array_append_new(runs, run_json(&study->runs[i], study->lifts));
    for (size_t i = 0; i < study->order_count; i++) {
        const struct error_order *order = &study->orders[i];
        json_array_append_new(orders, json_pack("{s:s,s:s,s:o,s:o}", "solver", order->solver, "against",
                                                error_against_name(order->against), "u", slope_json(&order->u),
                                                "lift", slope_json(&order->lift)));
    }
    for (size_t i = 0; study->notes[i][0]; i++)
        json_array_append_new(notes, json_string(study->notes[i]));
    return json_pack("{s:s,s:{s:s,s:{s:o,s:o,s:o},s:o,s:o},s:o,s:o,s:o,s:o,s:o}", "scene", scene->name, "reference",
                     "method", study->method, "agreement", "u_ft", cli_json_number(study->agreement_u_ft, 6),
                     "lift_ft", cli_json_number(study->agreement_lift_ft, 6), "rms_u_ft",
                     cli_json_number(study->agreement_rms_u_ft, 6), "peak_u_ft",
                     cli_json_number(study->peak_u_ft, 12), "max_lift_ft", cli_json_number(study->max_lift_ft, 12),
                     "dt_limit_s", cli_json_number(study->dt_limit_s, 9), "runs", runs, "order", orders, "cheapest",
                     cheapest_json(study), "notes", notes);
}

static void print_error(double error_ft, double agreement_ft)
{
    if (isnan(error_ft))
        printf("  %10s", "-");
    else if (error_ft <= ERROR_FLOOR * agreement_ft)
        printf("  <%9.1e", ERROR_FLOOR * agreement_ft);
    else
        printf("  %10.2e", error_ft);
}

static void print_runs(const struct error_study *study)
{
    printf("  %-9s %-14s %9s %10s %10s  %10s  %10s  %s\n", "solver", "rtol or dt", "steps", "rhs", "ms", "err u, ft",
           study->lifts ? "err lift" : "rms of u", "status");
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        char step[24];
        if (run->dt_s > 0.0)
            snprintf(step, sizeof step, "dt %.4g s", run->dt_s);
        else
            snprintf(step, sizeof step, "rtol %.0e", run->rtol);
        printf("  %-9s %-14s %9llu %10llu %10.2f", run->solver, step, (unsigned long long)run->steps,
               (unsigned long long)run->rhs, run->ms);
        print_error(run->u_ft, study->agreement_u_ft);
        if (study->lifts)
            print_error(run->lift_ft, study->agreement_lift_ft);
        else
            print_error(run->rms_u_ft, study->agreement_rms_u_ft);
        printf("  %s", sim_status_name(run->status));
        if (run->status != SIM_OK)
            printf(": mat %d at %.4g s", run->mat, run->t_s);
        else if (run->beyond)
            printf(", but beyond the stability limit: `matrig sim` refuses it");
        putchar('\n');
    }
}

static void print_slope(const char *what, const struct error_slope *slope, const struct error_order *order)
{
    if (slope->points == 0)
        printf("; %s: too few errors to fit, or too alike a cost", what);
    else if (slope->scatter > ERROR_NO_LAW)
        printf("; %s: no power law (%d runs, scatter %.2f decades)", what, slope->points, slope->scatter);
    else
        printf("; %s: %.2f (%d runs, %s %.3g to %.3g, scatter %.2f decades)", what, slope->slope, slope->points,
               error_against_name(order->against), slope->from, slope->to, slope->scatter);
}

static void print_orders(const struct error_study *study)
{
    static const char *const texts[] = {"error ~ dt^p", "error ~ rtol^p", "error ~ rhs^-p"};
    puts("observed orders p:");
    for (size_t i = 0; i < study->order_count; i++) {
        const struct error_order *order = &study->orders[i];
        printf("  %-9s %-14s", order->solver, texts[order->against]);
        print_slope("u", &order->u, order);
        if (study->lifts)
            print_slope("lift", &order->lift, order);
        putchar('\n');
    }
}

static void print_cheapest(const struct error_study *study)
{
    const char *names[SOLVERS_MAX];
    size_t count = error_study_solvers(study, names, SOLVERS_MAX);
    printf("least ms for an error of %s of at most (fixed steps: of the step and both its neighbours):\n",
           study->lifts ? "lift" : "u");
    printf("  %-9s", "");
    for (size_t k = 0; k < error_level_count; k++)
        printf("  %7.0e ft", error_levels_ft[k]);
    putchar('\n');
    for (size_t i = 0; i < count; i++) {
        printf("  %-9s", names[i]);
        for (size_t k = 0; k < error_level_count; k++) {
            const struct error_run *run = error_study_cheapest(study, names[i], error_levels_ft[k]);
            if (run)
                printf("  %10.2f", run->ms);
            else
                printf("  %10s", "-");
        }
        putchar('\n');
    }
    printf("  %-9s", "cheapest");
    for (size_t k = 0; k < error_level_count; k++) {
        const struct error_run *run = error_study_cheapest(study, NULL, error_levels_ft[k]);
        printf("  %10s", run ? run->solver : "none");
    }
    putchar('\n');
}

static void print_study(const struct sim_scene *scene, const struct error_study *study)
{
    printf("%s: model %s, %d mats, %.6g s; largest movement %.6g ft", scene->name, sim_model_name(scene->model),
           scene->mats, study->end_s, study->peak_u_ft);
    if (study->lifts)
        printf(", lift %.6g ft", study->max_lift_ft);
    printf("\n  reference: %s,\n  to %.1e ft (u)", study->method, study->agreement_u_ft);
    if (study->lifts)
        printf(" and %.1e ft (lift)", study->agreement_lift_ft);
    else
        printf(", rms %.1e ft", study->agreement_rms_u_ft);
    puts("\n");
    print_runs(study);
    putchar('\n');
    print_orders(study);
    putchar('\n');
    print_cheapest(study);
    for (size_t i = 0; study->notes[i][0]; i++)
        printf("  note: %s\n", study->notes[i]);
}

static enum mr_status write_plot(const char *path, bool force, const char *name, const struct error_study *study,
                                 struct error *error)
{
    struct output output;
    if (output_begin(&output, path, force, error) != MR_OK)
        return error->status;
    plot_error_file(output.file, name, study);
    return output_end(&output, error);
}

int error_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1];
    struct error_request r = {0};
    struct error error = {0};
    struct sim_scene scene;
    struct error_study study;
    int code = 0;

    if (command_parse(&command_error, argc, argv, cli, &r, words, &error) != MR_OK)
        return cli_fail(&error);
    if (r.predictor && words[0])
        error_set(&error, MR_USAGE, "one word too many: '%s' of error; --predictor takes no SCENE", words[0]);
    else if (!r.predictor && !words[0])
        error_set(&error, MR_USAGE, "something is missing: matrig error needs SCENE or --predictor; see matrig error --help");
    if (error.status == MR_OK)
        output_check(r.plot, r.force, words[0], &error); /* before a minute of computing, not after */
    if (error.status == MR_OK && r.predictor)
        return error_predictor(r.plot, r.force, cli);
    if (error.status != MR_OK || sim_scene_load(&scene, words[0], &error) != MR_OK)
        return cli_fail(&error);
    if (!scene.name[0])
        snprintf(scene.name, sizeof scene.name, "%s", words[0]);
    if (error_study_run(&study, &scene, &error) == MR_OK && r.plot)
        write_plot(r.plot, r.force, scene.name, &study, &error);
    if (error.status != MR_OK)
        code = cli_fail(&error);
    else if (cli->json)
        code = cli_print_json(study_json(&scene, &study), 0);
    else
        print_study(&scene, &study);
    sim_scene_free(&scene);
    return code;
}
