/* Sentences and tables from a study. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/html.h"
#include "tests/error_report/report.h"

#define SOLVERS_MAX 8
#define BENCH_FT    5e-6 /* the level at which solvers are held against each other */

/* Least time of a solver at a level; NaN when it does not get there. */
static double least_ms(const struct error_study *study, const char *solver, double level_ft)
{
    const struct error_run *run = error_study_cheapest(study, solver, level_ft);
    return run ? run->ms : (double)NAN;
}

/* The second cheapest solver at a level, or NULL. */
static const char *runner_up(const struct error_study *study, const char *best, double level_ft)
{
    const char *names[SOLVERS_MAX], *second = NULL;
    size_t count = error_study_solvers(study, names, SOLVERS_MAX);
    for (size_t i = 0; i < count; i++) {
        double ms = least_ms(study, names[i], level_ft);
        if (strcmp(names[i], best) != 0 && isfinite(ms) &&
            (!second || ms < least_ms(study, second, level_ft)))
            second = names[i];
    }
    return second;
}

static void say_reference(FILE *out, const struct error_study *study)
{
    if (study->lifts)
        fprintf(out,
                "Two methods agree to %.1e ft on u and %.1e ft on lift, so errors down to %.0e ft "
                "can be told. ",
                study->agreement_u_ft, study->agreement_lift_ft,
                ERROR_FLOOR * study->agreement_lift_ft);
    else
        fprintf(out,
                "Two methods agree to %.1e ft on u (rms %.1e ft), so errors down to %.0e ft can be "
                "told. ",
                study->agreement_u_ft, study->agreement_rms_u_ft,
                ERROR_FLOOR * study->agreement_u_ft);
}

static void say_cheapest(FILE *out, const struct error_study *study)
{
    for (size_t i = 0; i < error_level_count; i++) {
        double level = error_levels_ft[i];
        const struct error_run *best = error_study_cheapest(study, NULL, level);
        fprintf(out, "%s %.0e ft ", i == 0 ? "For an error of at most" : "for", level);
        if (!best) {
            fprintf(out, "%s",
                    level < ERROR_FLOOR *
                                (study->lifts ? study->agreement_lift_ft : study->agreement_u_ft)
                        ? "the reference is not good enough to say"
                        : "no run suffices");
        } else {
            const char *second = runner_up(study, best->solver, level);
            fprintf(out, "<b>%s</b> is cheapest with %.3g ms", best->solver, best->ms);
            if (second)
                fprintf(out, " (%s: %.1f times that)", second,
                        least_ms(study, second, level) / best->ms);
        }
        fputs(i + 1 < error_level_count ? "; " : ". ", out);
    }
}

static void say_ratio(FILE *out, const struct error_study *study)
{
    double event = least_ms(study, "event", BENCH_FT), cvode = least_ms(study, "cvode", BENCH_FT);
    double rk4 = least_ms(study, "rk4", BENCH_FT);
    if (!isfinite(event))
        return;
    fprintf(out, "At %.0e ft event takes ", BENCH_FT);
    if (isfinite(cvode))
        fprintf(out, "1/%.1f of cvode's time", cvode / event);
    else
        fputs("its time alone, as cvode does not get there", out);
    if (isfinite(rk4))
        fprintf(out, " and %.2f of rk4's. ", event / rk4);
    else
        fputs("; rk4 does not get there with any step tried. ", out);
}

static void say_order(FILE *out, const struct error_study *study)
{
    for (size_t i = 0; i < study->order_count; i++) {
        const struct error_order *order = &study->orders[i];
        const struct error_slope *slope = study->lifts && order->lift.points > 0 ? &order->lift
                                                                                 : &order->u;
        double nominal = strcmp(order->solver, "rk4") == 0 ? 4.0 : 2.0;
        if (!order->of_step)
            continue;
        if (slope->points == 0 || slope->scatter > ERROR_NO_LAW) {
            fprintf(out, "%s's errors follow no power of the step here. ", order->solver);
            continue;
        }
        fprintf(out, "%s's error falls as dt<sup>%.2f</sup> (%d steps, %.1e to %.1e s)",
                order->solver, slope->slope, slope->points, slope->from, slope->to);
        if (slope->slope < nominal - 0.5)
            fprintf(out, ", not as dt<sup>%.0f</sup>: %s cost it its order", nominal,
                    nominal == 4.0 ? "switches inside its steps"
                                   : "switches inside its steps and dampers half a step late");
        fputs(". ", out);
    }
}

static void say_wrong(FILE *out, const struct error_study *study)
{
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        if (run->beyond && run->status == SIM_OK && run->lift_ft > 0.1 * study->max_lift_ft &&
            study->max_lift_ft > 0.0)
            fprintf(out,
                    "<b>%s at %.3g s, beyond the limit of %.3g s, ends without complaint and "
                    "wrong</b>: largest lift %.3g "
                    "ft instead of %.3g, off by up to %.3g ft at one time. ",
                    run->solver, run->dt_s, study->dt_limit_s, run->max_lift_ft, study->max_lift_ft,
                    run->lift_ft);
    }
    size_t failed = 0;
    for (size_t i = 0; i < study->run_count; i++)
        failed += study->runs[i].status != SIM_OK;
    if (failed > 0)
        fprintf(out, "%zu of %zu runs end without an answer and say so. ", failed,
                study->run_count);
}

/* Of a chain single mats can be far off where all together are not. */
static void say_rms(FILE *out, const struct error_study *study)
{
    double least = HUGE_VAL, most = 0.0;
    for (size_t i = 0; i < study->run_count; i++) {
        if (study->runs[i].status != SIM_OK || study->runs[i].beyond)
            continue;
        least = fmin(least, study->runs[i].rms_u_ft);
        most = fmax(most, study->runs[i].rms_u_ft);
    }
    if (!study->lifts && least <= most)
        fprintf(out,
                "Over all steps the rms error lies between %.1e and %.1e ft, %.2g to %.2g %% of "
                "the largest movement. ",
                least, most, 100.0 * least / study->peak_u_ft, 100.0 * most / study->peak_u_ft);
}

void write_conclusion(FILE *out, const struct error_study *study)
{
    fputs("<p>", out);
    say_reference(out, study);
    say_cheapest(out, study);
    say_rms(out, study);
    say_ratio(out, study);
    say_order(out, study);
    say_wrong(out, study);
    fputs("</p>\n", out);
}

static void close_table(FILE *out)
{
    fputs("</tbody></table></div>\n", out);
}

static void error_cell(FILE *out, double error_ft, double agreement_ft)
{
    if (isnan(error_ft))
        html_cell(out, "-");
    else if (error_ft <= ERROR_FLOOR * agreement_ft)
        html_cell(out, "< %.1e", ERROR_FLOOR * agreement_ft);
    else
        html_cell(out, "%.2e", error_ft);
}

static void slope_cell(FILE *out, const struct error_slope *slope)
{
    if (slope->points == 0)
        html_cell(out, "too few errors, or too alike a cost");
    else if (slope->scatter > ERROR_NO_LAW)
        html_cell(out, "no power law, scatter %.2f decades", slope->scatter);
    else
        html_cell(out, "%.2f, %.3g to %.3g, scatter %.2f decades", slope->slope, slope->from,
                  slope->to, slope->scatter);
}

void write_tables(FILE *out, const struct error_study *study)
{
    const char *const cheap_heads[] = {study->lifts ? "least ms for an error of lift of"
                                                    : "least ms for an error of u of",
                                       "1e-3 ft",
                                       "1e-5 ft",
                                       "5e-6 ft",
                                       "1e-7 ft",
                                       NULL};
    const char *const order_heads[] = {"solver", "error ~", "p of u",
                                       study->lifts ? "p of lift" : NULL, NULL};
    const char *const run_heads[] = {"solver",
                                     "rtol or dt",
                                     "steps",
                                     "rhs",
                                     "ms",
                                     "err u, ft",
                                     study->lifts ? "err lift, ft" : "rms of u, ft",
                                     "status",
                                     NULL};
    const char *names[SOLVERS_MAX];
    size_t count = error_study_solvers(study, names, SOLVERS_MAX);
    html_table(out, cheap_heads);
    for (size_t i = 0; i < count; i++) {
        fputs("<tr>", out);
        html_cell(out, "%s", names[i]);
        for (size_t k = 0; k < error_level_count; k++) {
            const struct error_run *best = error_study_cheapest(study, NULL, error_levels_ft[k]);
            double ms = least_ms(study, names[i], error_levels_ft[k]);
            if (!isfinite(ms))
                html_cell(out, "-");
            else if (best && strcmp(best->solver, names[i]) == 0)
                fprintf(out, "<td><b>%.2f</b></td>", ms);
            else
                html_cell(out, "%.2f", ms);
        }
        fputs("</tr>\n", out);
    }
    close_table(out);
    html_table(out, order_heads);
    for (size_t i = 0; i < study->order_count; i++) {
        const struct error_order *order = &study->orders[i];
        fputs("<tr>", out);
        html_cell(out, "%s", order->solver);
        html_cell(out, "%s", order->of_step ? "dt^p" : "rtol^p");
        slope_cell(out, &order->u);
        if (study->lifts)
            slope_cell(out, &order->lift);
        fputs("</tr>\n", out);
    }
    close_table(out);
    fputs("<details><summary>All runs</summary>\n", out);
    html_table(out, run_heads);
    for (size_t i = 0; i < study->run_count; i++) {
        const struct error_run *run = &study->runs[i];
        fputs("<tr>", out);
        html_cell(out, "%s", run->solver);
        html_cell(out, run->dt_s > 0.0 ? "dt %.4g s" : "rtol %.0e",
                  run->dt_s > 0.0 ? run->dt_s : run->rtol);
        html_cell(out, "%llu", (unsigned long long)run->steps);
        html_cell(out, "%llu", (unsigned long long)run->rhs);
        html_cell(out, "%.2f", run->ms);
        error_cell(out, run->u_ft, study->agreement_u_ft);
        error_cell(out, study->lifts ? run->lift_ft : run->rms_u_ft,
                   study->lifts ? study->agreement_lift_ft : study->agreement_rms_u_ft);
        if (run->status != SIM_OK)
            html_cell(out, "%s: mat %d at %.4g s", sim_status_name(run->status), run->mat,
                      run->t_s);
        else
            html_cell(out, "ok%s", run->beyond ? ", beyond the stability limit" : "");
        fputs("</tr>\n", out);
    }
    close_table(out);
    fputs("</details>\n", out);
}
