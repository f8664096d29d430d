#include "tests/stability/bars.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const row_names[BARS_ROWS] = {"auto", "event", "implicit", "staggered", "cvode",
                                                 "rk4",  "rkgs",  "hamming",  "moreau"};

bool bars_make(struct bars *bars, size_t scenes)
{
    *bars = (struct bars){0};
    for (int r = 0; r < BARS_ROWS; r++) {
        bars->rows[r].ratios = calloc(2 * scenes + 1, sizeof *bars->rows[r].ratios);
        if (!bars->rows[r].ratios)
            return false;
    }
    return true;
}

void bars_free(struct bars *bars)
{
    for (int r = 0; r < BARS_ROWS; r++)
        free(bars->rows[r].ratios);
}

void bars_head(FILE *table)
{
    draw_head(table);
    fprintf(table, ",asked,solver,end,cpu_s,steps,events,peak_u,max_lift,error_u,error_lift,"
                   "unsure_s,truth,apart_u,apart_lift,truth_error_u,truth_error_lift,ratio_u,"
                   "ratio_lift\n");
}

static void write_row(FILE *table, size_t index, const double *exponents, const struct sim_scene *s,
                      const char *asked, const struct study_answer *a,
                      const struct study_answer *truth, const struct study_difference *d)
{
    draw_row(table, index, exponents, s);
    fprintf(table, ",%s,%s,%s,%.3f,%llu,%llu,%.6g,%.6g,%.2g,%.2g,%.3g", asked, a->solver,
            study_end_names[a->end], a->cpu_s, (unsigned long long)a->steps,
            (unsigned long long)a->events, a->peak_u_ft, a->max_lift_ft, a->error_u_ft,
            a->error_lift_ft, a->unsure_s);
    if (truth)
        fprintf(table, ",%s,%.2g,%.2g,%.2g,%.2g,%.3g,%.3g\n", truth->solver, d->u_ft, d->lift_ft,
                truth->error_u_ft, truth->error_lift_ft, d->ratio_u, d->ratio_lift);
    else
        fprintf(table, ",,,,,,,\n");
}

static void count(struct bars *bars, const char *name, const struct study_answer *a,
                  const struct study_truth *truth, const struct study_difference *d)
{
    for (int r = 0; r < BARS_ROWS; r++) {
        struct bars_row *row = &bars->rows[r];
        if (strcmp(row_names[r], name) != 0)
            continue;
        row->scenes++;
        row->ends[a->end]++;
        row->slowest_s = fmax(row->slowest_s, a->cpu_s);
        row->unsure += a->end == STUDY_OK && a->unsure_s > 0.0;
        if (!truth->is)
            continue;
        double ratio = fmax(d->ratio_u, d->ratio_lift);
        row->ratios[row->compared++] = (float)ratio;
        row->beyond_1 += ratio > 1.0;
        row->beyond_3 += ratio > STUDY_OVERCONFIDENT;
        row->verdicts += d->verdict && a->unsure_s <= 0.0;
        row->alone += truth->other_alone;
        row->contested += truth->contested;
        row->by_itself += truth->by_itself;
        row->worst = fmax(row->worst, ratio);
    }
}

/* One answer: `asked` for by that name, and given by a solver that may have another. */
static void judge(struct bars *bars, FILE *table, size_t index, const double *exponents,
                  const struct sim_scene *scene, const struct study_answer *answers, int which,
                  const char *asked)
{
    const struct study_answer *a = &answers[which];
    struct study_truth truth = study_truth(scene, answers, a);
    struct study_difference d = {0};
    bool given = a->end == STUDY_OK;
    if (a->end == STUDY_FOLDED && truth.is) {
        bars->fold_disputed++;
        printf("FOLD DISPUTED %zu: %s at %.6g s, %s ok\n", index, a->solver, a->t_s,
               truth.is->solver);
    }
    if (!given)
        truth.is = NULL;
    if (truth.is)
        d = study_compare(scene, a, truth.is);
    count(bars, asked, a, &truth, &d);
    if (strcmp(asked, "auto") == 0)
        count(bars, a->solver, a, &truth, &d);
    if (fmax(d.ratio_u, d.ratio_lift) > STUDY_OVERCONFIDENT)
        printf("OVERCONFIDENT %zu: %s (%s) and %s: u %.3g ft (stated %.3g), lift %.3g ft (stated "
               "%.3g)%s%s\n",
               index, asked, a->solver, truth.is->solver, d.u_ft, a->error_u_ft, d.lift_ft,
               a->error_lift_ft, d.verdict ? ", verdicts differ" : "",
               truth.contested ? ", contested by its own finer run" : "");
    write_row(table, index, exponents, scene, asked, a, truth.is, &d);
}

void bars_add(struct bars *bars, FILE *table, size_t index, const double *exponents,
              const struct sim_scene *scene, const struct study_answer *answers)
{
    bars->scenes++;
    for (int i = 0; i < STUDY_METHODS; i++) {
        bars->total_s += answers[i].cpu_s;
        bars->crashed += answers[i].end == STUDY_CRASHED;
    }
    bars->late += answers[STUDY_BARS_AUTO].end == STUDY_SLOW;
    judge(bars, table, index, exponents, scene, answers, STUDY_BARS_AUTO, "auto");
    if (answers[STUDY_BARS_OTHER].end != STUDY_NOT_RUN)
        judge(bars, table, index, exponents, scene, answers, STUDY_BARS_OTHER,
              study_bars_solver(scene, index));
}

static int ascending(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

void bars_print(const struct bars *bars)
{
    printf("%zu scenes, %.0f s of processor time", bars->scenes, bars->total_s);
    if (bars->not_run > 0)
        printf("; NOT RUN, as time was up: %zu", bars->not_run);
    printf("\n%-9s", "how ended");
    for (int e = 0; e < STUDY_NOT_RUN; e++)
        printf(" %14s", study_end_names[e]);
    printf(" %10s\n", "slowest s");
    for (int r = 0; r < BARS_ROWS; r++) {
        printf("%-9s", row_names[r]);
        for (int e = 0; e < STUDY_NOT_RUN; e++)
            printf(" %14zu", bars->rows[r].ends[e]);
        printf(" %10.1f\n", bars->rows[r].slowest_s);
    }
    printf("true over stated error\n%-9s %8s %8s %6s %8s %6s %9s %8s %9s %6s %6s %9s %9s\n",
           "solver", "compared", "beyond 1", "%", "beyond 3", "%", "worst", "median", "99.5 %",
           "unsure", "alone", "contested", "by itself");
    for (int r = 0; r < BARS_ROWS; r++) {
        const struct bars_row *row = &bars->rows[r];
        double percent = row->compared > 0 ? 100.0 / (double)row->compared : 0.0;
        qsort(row->ratios, row->compared, sizeof *row->ratios, ascending);
        printf("%-9s %8zu %8zu %6.2f %8zu %6.2f %9.3g %8.2g %9.2g %6zu %6zu %9zu %9zu\n",
               row_names[r], row->compared, row->beyond_1, percent * (double)row->beyond_1,
               row->beyond_3, percent * (double)row->beyond_3, row->worst,
               (double)row->ratios[row->compared / 2],
               (double)row->ratios[(size_t)(0.995 * (double)row->compared)], row->unsure,
               row->alone, row->contested, row->by_itself);
    }
    printf(
        "auto and event, implicit, fixed where it took them; bow wave or not differs: %zu; folds "
        "disputed: %zu; auto not done after %g s: %zu; crashed: %zu\n",
        bars->rows[0].verdicts, bars->fold_disputed, STUDY_LATE_S, bars->late, bars->crashed);
}

bool bars_good(const struct bars *bars, size_t one_in)
{
    const struct bars_row *first = &bars->rows[0];
    size_t compared = first->compared > one_in ? first->compared : one_in;
    return bars->not_run + bars->crashed + bars->fold_disputed + bars->late == 0 &&
           first->beyond_3 == 0 && first->beyond_1 * one_in <= compared;
}
