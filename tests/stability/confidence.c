#include "tests/stability/confidence.h"

#include <math.h>

static const char *const group_names[CONFIDENCE_GROUPS] = {
    "all",
    "low, free free",
    "low, free fixed",
    "low, fixed free",
    "low, fixed fixed",
    "full, free free",
    "full, free fixed",
    "full, fixed free",
    "full, fixed fixed",
    "stick, weight",
    "stick, soil",
    "no friction",
    "no wheel load",
    "wheel load",
    "Vac",
    "path",
    "slack",
};

/* Whether a scene belongs to each group, in the order of the names. */
static void sort(const struct sim_scene *scene, bool in[CONFIDENCE_GROUPS])
{
    bool full = scene->profile == SIM_PROFILE_FULL, none = scene->friction_law == SIM_FRICTION_NONE,
         loaded = scene->wheel_load_lb > 0.0;
    bool soil = scene->friction_normal == SIM_NORMAL_SOIL, path = scene->path_count > 0;
    int ends = 4 * full + 2 * (scene->left_end == SIM_END_FIXED) +
               (scene->right_end == SIM_END_FIXED);
    in[0] = true;
    for (int i = 0; i < 8; i++)
        in[1 + i] = i == ends;
    in[9] = !none && !soil;
    in[10] = !none && soil;
    in[11] = none;
    in[12] = !loaded;
    in[13] = loaded;
    in[14] = !path;
    in[15] = path;
    in[16] = scene->slack_ft > 0.0;
}

/* The method that says how it is: event; or implicit, where it sides with fixed against event.
 * NULL: nobody knows. */
static const struct study_answer *truth(const struct sim_scene *scene,
                                        const struct study_answer *answers, bool *alone)
{
    const struct study_answer *fixed = &answers[0], *event = &answers[1], *implicit = &answers[2];
    *alone = false;
    if (event->end != STUDY_OK || implicit->end != STUDY_OK)
        return event->end == STUDY_OK ? event : implicit->end == STUDY_OK ? implicit : NULL;
    struct study_difference d = study_compare(scene, event, implicit),
                            e = study_compare(scene, fixed, implicit);
    *alone = d.contradicts && fmax(e.ratio_u, e.ratio_lift) <= STUDY_DOUBT;
    return *alone ? implicit : event;
}

void confidence_head(FILE *table)
{
    draw_head(table);
    fprintf(table, ",steps,events,peak_u,max_lift,error_u,error_lift,fixed,fixed_s,event,event_s,"
                   "implicit,implicit_s,apart_u,apart_lift,truth_error_u,truth_error_lift,ratio_u,"
                   "ratio_lift\n");
}

static void write_row(FILE *table, size_t index, const double *exponents, const struct sim_scene *s,
                      const struct study_answer *answers, const struct study_answer *true_one,
                      const struct study_difference *d)
{
    const struct study_answer *fixed = &answers[0];
    draw_row(table, index, exponents, s);
    fprintf(table, ",%llu,%llu,%.6g,%.6g,%.2g,%.2g", (unsigned long long)fixed->steps,
            (unsigned long long)fixed->events, fixed->peak_u_ft, fixed->max_lift_ft,
            fixed->error_u_ft, fixed->error_lift_ft);
    for (int i = 0; i < STUDY_FIXED_METHODS; i++)
        fprintf(table, ",%s,%.3f", study_end_names[answers[i].end], answers[i].cpu_s);
    if (true_one)
        fprintf(table, ",%.2g,%.2g,%.2g,%.2g,%.3g,%.3g\n", d->u_ft, d->lift_ft,
                true_one->error_u_ft, true_one->error_lift_ft, d->ratio_u, d->ratio_lift);
    else
        fprintf(table, ",,,,,,\n");
}

void confidence_add(struct confidence *c, FILE *table, size_t index, const double *exponents,
                    const struct sim_scene *scene, const struct study_answer *answers)
{
    bool in[CONFIDENCE_GROUPS], alone;
    const struct study_answer *fixed = &answers[0], *true_one = truth(scene, answers, &alone);
    struct study_difference d = {0};
    c->ends[fixed->end]++;
    c->alone += alone;
    for (int i = 0; i < STUDY_FIXED_METHODS; i++) {
        c->total_s += answers[i].cpu_s;
        c->crashed += answers[i].end == STUDY_CRASHED;
    }
    if (true_one && fixed->end != STUDY_OK) {
        c->reference_only++;
        c->fold_disputed += fixed->end == STUDY_FOLDED;
        true_one = NULL;
    }
    if (true_one)
        d = study_compare(scene, fixed, true_one);
    double ratio = fmax(d.ratio_u, d.ratio_lift);
    sort(scene, in);
    for (int g = 0; g < CONFIDENCE_GROUPS; g++) {
        if (!in[g])
            continue;
        struct confidence_group *group = &c->groups[g];
        group->scenes++;
        group->compared += true_one != NULL;
        group->beyond_1 += ratio > 1.0;
        group->beyond_3 += ratio > CONFIDENCE_BEYOND;
        group->worst = fmax(group->worst, ratio);
    }
    if (true_one) {
        bins_add(&c->u, d.ratio_u);
        bins_add(&c->lift, d.ratio_lift);
        c->verdicts += d.verdict;
    }
    if (ratio > CONFIDENCE_BEYOND)
        printf("OVERCONFIDENT %zu: fixed and %s: u %.3g ft (stated %.3g), lift %.3g ft (stated "
               "%.3g)%s\n",
               index, true_one->solver, d.u_ft, fixed->error_u_ft, d.lift_ft, fixed->error_lift_ft,
               d.verdict ? ", verdicts differ" : "");
    write_row(table, index, exponents, scene, answers, true_one, &d);
}

void confidence_print(const struct confidence *c)
{
    printf("%zu landings, %.0f s of processor time", c->groups[0].scenes, c->total_s);
    if (c->not_run > 0)
        printf("; NOT RUN, as time was up: %zu", c->not_run);
    printf("\nfixed");
    for (int e = 0; e < STUDY_NOT_RUN; e++)
        printf("  %s %zu", study_end_names[e], c->ends[e]);
    printf("\n%-20s %7s %9s %9s %7s %9s %7s %8s\n", "true over stated", "scenes", "compared",
           "beyond 1", "%", "beyond 3", "%", "worst");
    for (int g = 0; g < CONFIDENCE_GROUPS; g++) {
        const struct confidence_group *group = &c->groups[g];
        double percent = group->compared > 0 ? 100.0 / (double)group->compared : 0.0;
        printf("%-20s %7zu %9zu %9zu %7.2f %9zu %7.2f %8.3g\n", group_names[g], group->scenes,
               group->compared, group->beyond_1, percent * (double)group->beyond_1, group->beyond_3,
               percent * (double)group->beyond_3, group->worst);
    }
    bins_print(&c->u, "u");
    bins_print(&c->lift, "lift");
    printf("bow wave or not differs: %zu; fixed does not answer, another does: %zu (folds: %zu); "
           "implicit confirms fixed "
           "against event: %zu; crashed: %zu\n",
           c->verdicts, c->reference_only, c->fold_disputed, c->alone, c->crashed);
}

bool confidence_good(const struct confidence *c, size_t one_in)
{
    return c->not_run + c->crashed + c->fold_disputed == 0 &&
           c->groups[0].beyond_3 * one_in <= c->groups[0].compared;
}
