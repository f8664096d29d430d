#include "tests/stability/chain_study.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"
#include "host/sim/elements/element.h"
#include "host/sim/sim.h"
#include "tests/stability/chain_draw.h"
#include "tests/stability/chain_reference.h"
#include "tests/stability/study.h"

#define BEYOND_1_ONE_IN 200u
#define UNDECIDED_SHARE 0.1 /* of the stated error, between two runs of the reference */
#define ENGINE_LIMIT_S  60
#define REFERENCE_S     300 /* in double, and again in long double */
#define STEPS_MAX       3000000u
#define WORST           20u
#define PEAK_SHARE      0.1
#define PEAK_LEAST_LB   1e-9 /* below it a force is rounding */
#define PEAK_LOW        0.9
#define COARSE_ORDER    18

enum chain_stage { NOT_RUN, ENGINE, REFERENCE, DONE };

struct chain_row {
    enum chain_stage stage;
    enum chain_kind kind;
    enum study_end end;
    bool lossless, reference_ok, decided;
    double stated_ft, true_ft, reference_ft, peak_ft, ratio; /* reference: its two runs apart */
    double double_ratio; /* of an answer that long double judged: by the reference in double */
    /* largest force in a joint over the right one: of the joint that is most wrong of those with
     * PEAK_SHARE of the scene's largest */
    double push_share, pull_share;
    double engine_s, reference_s, dt_s;
    uint64_t steps, reference_steps, switches;
};

struct shared {
    _Atomic size_t next;
    time_t begin;
    struct chain_row rows[];
};

static bool is_lossless(const struct sim_scene *s)
{
    return s->cl_lb_s_ft == 0.0 && (s->friction_law == SIM_FRICTION_NONE || s->friction == 0.0) &&
           s->grit_lb.count == 0 && s->element_values[ELEMENT_ground_damping] == 0.0 &&
           s->element_values[ELEMENT_gear_ground] == 0.0;
}

static double apart_ft(const double *a, const double *b, size_t count)
{
    double most = 0.0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

/* Largest compressions and tensions by joint. */
struct peaks {
    double push_lb[CHAIN_MATS + 2], pull_lb[CHAIN_MATS + 2];
};

static void engine(const struct sim_scene *scene, struct chain_row *row, double *u_ft,
                   struct peaks *peaks)
{
    struct sim_result result;
    struct error error = {0};
    size_t mats = (size_t)scene->mats + 1;
    enum mr_status status = sim_run(scene, &(struct sim_options){0}, &result, &error);
    row->engine_s = 1e-3 * result.run_ms;
    bool given = status == MR_OK || result.status == SIM_UNPREDICTABLE; /* with its spread */
    row->end = given                 ? STUDY_OK
             : status == MR_NUMERICS ? (enum study_end)result.status
                                     : STUDY_REFUSED;
    row->steps = result.steps;
    row->dt_s = result.dt_s;
    if (given) {
        row->stated_ft = result.error_u_ft;
        row->peak_ft = result.peak_u_ft;
        for (size_t i = 0; i < CHAIN_OUTPUTS; i++)
            memcpy(u_ft + i * mats, result.outputs[i].u_ft, mats * sizeof *u_ft);
        for (size_t i = 0; i < CHAIN_OUTPUTS; i++)
            u_ft[i * mats] = 0.0;
        memcpy(peaks->push_lb, result.max_compression_lb,
               (mats + 1) * sizeof *result.max_compression_lb);
        memcpy(peaks->pull_lb, result.max_tension_lb, (mats + 1) * sizeof *result.max_tension_lb);
    }
    sim_result_free(&result);
}

static void limit_time(int limit_s)
{
    struct itimerval limit = {.it_value = {limit_s, 0}};
    signal(SIGPROF, SIG_DFL);
    setitimer(ITIMER_PROF, &limit, NULL);
}

/* u at all times of a scene. */
typedef double answers[CHAIN_OUTPUTS * (CHAIN_MATS + 1)];

/* Two runs of the reference, the finer one's answer; how far they are apart. */
static void refer(const struct sim_scene *scene, bool long_double, double *fine_ft,
                  struct peaks *peaks, struct chain_row *row)
{
    static answers coarse_ft;
    bool (*run)(struct chain_reference *, const struct sim_scene *,
                double *) = long_double ? chain_reference_run_long : chain_reference_run;
    double last_ft = long_double ? 1e-21 : 1e-18;
    struct chain_reference coarse = {.order = COARSE_ORDER,
                                     .tolerance_ft = 1e3 * last_ft,
                                     .most_steps = STEPS_MAX},
                           fine = {.order = CHAIN_REFERENCE_ORDER,
                                   .tolerance_ft = last_ft,
                                   .most_steps = STEPS_MAX,
                                   .push_lb = peaks->push_lb,
                                   .pull_lb = peaks->pull_lb};
    row->reference_ok = run(&coarse, scene, coarse_ft) && run(&fine, scene, fine_ft);
    row->reference_steps = fine.steps;
    row->switches = fine.switches;
    row->reference_ft = apart_ft(coarse_ft, fine_ft, CHAIN_OUTPUTS * ((size_t)scene->mats + 1));
    row->decided = row->reference_ok &&
                   row->reference_ft <= UNDECIDED_SHARE * row->stated_ft + STUDY_LEAST_FT;
}

static double most_wrong(const double *are, const double *right, int joints, double least_lb)
{
    double share = 1.0;
    for (int j = 1; j <= joints; j++)
        if (right[j] > least_lb && fabs(are[j] / right[j] - 1.0) > fabs(share - 1.0))
            share = are[j] / right[j];
    return share;
}

static double largest(const double *values, int count)
{
    double most = 0.0;
    for (int i = 1; i <= count; i++)
        most = fmax(most, values[i]);
    return most;
}

static void compare(const struct sim_scene *scene, const double *answer_ft, const double *fine_ft,
                    const struct peaks *peaks, const struct peaks *right, struct chain_row *row)
{
    int joints = scene->mats + 1;
    double least_lb = fmax(PEAK_LEAST_LB, PEAK_SHARE * fmax(largest(right->push_lb, joints),
                                                            largest(right->pull_lb, joints)));
    row->push_share = most_wrong(peaks->push_lb, right->push_lb, joints, least_lb);
    row->pull_share = most_wrong(peaks->pull_lb, right->pull_lb, joints, least_lb);
    row->true_ft = apart_ft(answer_ft, fine_ft, CHAIN_OUTPUTS * (size_t)joints);
    row->ratio = row->true_ft /
                 (row->stated_ft + (row->decided ? 0.0 : row->reference_ft) + STUDY_LEAST_FT);
}

/* In a process of its own. Both runs of the reference have a switch late by the same margins, and a
 * chain may magnify that, so their agreement alone accuses nobody: an answer that they refute is
 * judged again in long double, whose margins are a thousand times smaller. So is a scene alone that
 * they do not decide. */
static void judge(const struct sim_scene *scene, bool alone, struct chain_row *row)
{
    static answers answer_ft, fine_ft;
    static struct peaks peaks, right;
    row->lossless = is_lossless(scene);
    row->stage = ENGINE;
    limit_time(ENGINE_LIMIT_S);
    engine(scene, row, answer_ft, &peaks);
    row->stage = REFERENCE;
    limit_time(REFERENCE_S);
    double begin_s = monotonic_s();
    refer(scene, false, fine_ft, &right, row);
    row->reference_s = monotonic_s() - begin_s;
    row->push_share = row->pull_share = 1.0;
    if (row->reference_ok && row->end == STUDY_OK)
        compare(scene, answer_ft, fine_ft, &peaks, &right, row);
    row->stage = DONE; /* so it stays, if long double is too slow */
    if (row->decided ? row->ratio > 1.0 : alone && row->reference_ok && row->end == STUDY_OK) {
        struct chain_row again = *row;
        limit_time(REFERENCE_S);
        refer(scene, true, fine_ft, &right, &again);
        if (!again.decided)
            return;
        again.double_ratio = row->ratio;
        compare(scene, answer_ft, fine_ft, &peaks, &right, &again);
        *row = again;
    }
}

static void run_scene(const struct chain_plan *plan, size_t index, struct chain_row *row)
{
    struct sim_scene scene;
    struct error error = {0};
    int status = 0;
    row->kind = chain_draw(&scene, index, plan->seed);
    if (sim_scene_check(&scene, scene.name, &error) != MR_OK) {
        fprintf(stderr, "stability: %s\n", error.text);
        _exit(3);
    }
    pid_t child = fork();
    if (child == 0) {
        judge(&scene, plan->only < plan->scenes, row);
        _exit(0);
    }
    while (child > 0 && waitpid(child, &status, 0) < 0)
        ;
    if (child < 0 || row->stage == ENGINE)
        row->end = WIFSIGNALED(status) && WTERMSIG(status) == SIGPROF ? STUDY_SLOW : STUDY_CRASHED;
    sim_scene_free(&scene);
}

static void work(const void *of, void *with)
{
    const struct chain_plan *plan = of;
    struct shared *shared = with;
    for (;;) {
        size_t i = plan->from + shared->next++ * plan->every;
        if (i >= plan->scenes || time(NULL) > shared->begin + 60 * (time_t)plan->minutes)
            return;
        run_scene(plan, i, &shared->rows[i]);
    }
}

/* ---- the summary ---- */

struct chain_sum {
    size_t scenes, ends[STUDY_ENDS], compared, beyond_1, beyond_3, not_decided,
        not_decided_beyond_3, no_reference, unstable_lossless, peaks_low;
    double lowest_peak, worst, engine_s, reference_s, slowest_s;
    size_t count;            /* of ratios */
    double *ratios, *stated; /* stated: over the largest movement */
};

static bool is_compared(const struct chain_row *row)
{
    return row->stage == DONE && row->reference_ok && row->decided && row->end == STUDY_OK;
}

static void sum_add(struct chain_sum *sum, const struct chain_row *row)
{
    sum->scenes++;
    sum->ends[row->end]++;
    sum->engine_s += row->engine_s;
    sum->reference_s += row->reference_s;
    sum->slowest_s = fmax(sum->slowest_s, row->engine_s);
    sum->unstable_lossless += row->end == STUDY_UNSTABLE && row->lossless;
    sum->no_reference += !row->reference_ok;
    sum->not_decided += row->reference_ok && !row->decided && row->end == STUDY_OK;
    sum->not_decided_beyond_3 += row->reference_ok && !row->decided && row->end == STUDY_OK &&
                                 row->ratio > STUDY_OVERCONFIDENT;
    if (!is_compared(row))
        return;
    sum->compared++;
    sum->beyond_1 += row->ratio > 1.0;
    sum->beyond_3 += row->ratio > STUDY_OVERCONFIDENT;
    sum->worst = fmax(sum->worst, row->ratio);
    double peak = fmin(row->push_share, row->pull_share);
    sum->peaks_low += peak < PEAK_LOW;
    sum->lowest_peak = fmin(sum->lowest_peak, peak);
    sum->stated[sum->count] = row->peak_ft > 0.0 ? row->stated_ft / row->peak_ft : 0.0;
    sum->ratios[sum->count++] = row->ratio;
}

static int by_value(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

static double median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, by_value);
    return count > 0 ? values[count / 2] : 0.0;
}

static void sum_print(struct chain_sum *sum, const char *name)
{
    double percent = sum->compared > 0 ? 100.0 / (double)sum->compared : 0.0;
    printf(
        "%-6s %6zu %6zu %8zu %6zu %6.2f %8zu %9.3g %8.2g %8.2g %7zu %8zu %8zu %7zu %9zu %6zu %7.2f "
        "%8.2g %8.2g\n",
        name, sum->scenes, sum->ends[STUDY_OK], sum->compared, sum->beyond_1,
        percent * (double)sum->beyond_1, sum->beyond_3, sum->worst, median(sum->ratios, sum->count),
        median(sum->stated, sum->count), sum->not_decided, sum->not_decided_beyond_3,
        sum->no_reference, sum->ends[STUDY_UNSTABLE] + sum->ends[STUDY_UNDERFLOW],
        sum->unstable_lossless, sum->peaks_low, sum->lowest_peak,
        1e3 * sum->engine_s / (double)sum->scenes, 1e3 * sum->reference_s / (double)sum->scenes);
}

static const struct chain_row *sorted_rows;
static int by_ratio(const void *a, const void *b)
{
    const size_t *x = a, *y = b;
    double p = sorted_rows[*x].ratio, q = sorted_rows[*y].ratio;
    return (p < q) - (p > q);
}

static void print_worst(const struct chain_plan *plan, const struct chain_row *rows, size_t *order,
                        size_t count)
{
    sorted_rows = rows;
    qsort(order, count, sizeof *order, by_ratio);
    printf("worst (stability --chain --scenes %zu --seed %llu --only SCENE FOLDER):\n"
           "%7s %-6s %9s %10s %10s %10s %10s %9s %9s\n",
           plan->scenes, (unsigned long long)plan->seed, "scene", "kind", "ratio", "true, ft",
           "stated, ft", "ref., ft", "peak, ft", "steps", "switches");
    for (size_t i = 0; i < count && i < WORST; i++) {
        const struct chain_row *row = &rows[order[i]];
        printf("%7zu %-6s %9.3g %10.3g %10.3g %10.2g %10.3g %9llu %9llu\n", order[i],
               chain_kind_names[row->kind], row->ratio, row->true_ft, row->stated_ft,
               row->reference_ft, row->peak_ft, (unsigned long long)row->steps,
               (unsigned long long)row->switches);
    }
}

static void write_row(FILE *table, const struct chain_plan *plan, size_t i,
                      const struct chain_row *row)
{
    struct sim_scene scene;
    chain_draw(&scene, i, plan->seed);
    fprintf(table,
            "%zu,%s,%d,%.6g,%.4g,%.4g,%.3g,%zu,%.6g,%s,%.4g,%.3g,%.6g,%.4g,%d,%.3g,%llu,%llu,%llu,"
            "%.4f,%.4f,%.4f,%.4f\n",
            i, chain_kind_names[row->kind], scene.mats, scene.weight_lb, scene.kl_lb_ft,
            scene.cl_lb_s_ft, scene.slack_ft, scene.grit_lb.count, scene.t_end_s,
            study_end_names[row->end], row->stated_ft, row->true_ft, row->peak_ft,
            row->reference_ft, row->decided, row->ratio, (unsigned long long)row->steps,
            (unsigned long long)row->switches, (unsigned long long)row->reference_steps,
            row->push_share, row->pull_share, row->engine_s, row->reference_s);
    sim_scene_free(&scene);
}

/* What differs from the defaults, as a file for `matrig sim`. */
static bool write_scene(const char *path, const struct sim_scene *scene)
{
    struct sim_scene usual;
    FILE *file = fopen(path, "w");
    if (!file)
        return false;
    sim_scene_set_defaults(&usual);
    fprintf(file, "{\n  \"_note\": \"drawn by the stability study\"");
    for (size_t i = 0; sim_key_at(i); i++) {
        const struct sim_key *key = sim_key_at(i);
        const char *at = (const char *)scene + key->offset;
        const char *default_at = (const char *)&usual + key->offset;
        const struct sim_list *list = (const void *)at;
        switch (key->kind) {
        case SIM_KEY_TEXT: fprintf(file, ",\n  \"%s\": \"%s\"", key->name, at); break;
        case SIM_KEY_REAL:
            if (memcmp(at, default_at, sizeof(double)) != 0)
                fprintf(file, ",\n  \"%s\": %.17g", key->name, *(const double *)(const void *)at);
            break;
        case SIM_KEY_INTEGER:
            if (memcmp(at, default_at, sizeof(int)) != 0)
                fprintf(file, ",\n  \"%s\": %d", key->name, *(const int *)(const void *)at);
            break;
        case SIM_KEY_CHOICE:
            if (memcmp(at, default_at, sizeof(int)) != 0)
                fprintf(file, ",\n  \"%s\": \"%s\"", key->name,
                        key->choices[*(const int *)(const void *)at]);
            break;
        case SIM_KEY_LIST:
        case SIM_KEY_JOINTS:
        case SIM_KEY_PARTS:
            for (size_t k = 0; k < list->count; k++)
                fprintf(file, "%s%s%s%.17g%s", k == 0 ? ",\n  \"" : ", ", k == 0 ? key->name : "",
                        k == 0 ? "\": [" : "", list->values[k], k + 1 == list->count ? "]" : "");
            break;
        case SIM_KEY_PATH:
            for (size_t k = 0; k < scene->path_count; k++)
                fprintf(file, "%s[%.17g, %.17g, %.17g]%s", k == 0 ? ",\n  \"path\": [" : ", ",
                        scene->path[k].t_s, scene->path[k].x_ft, scene->path[k].force_lb,
                        k + 1 == scene->path_count ? "]" : "");
            break;
        }
    }
    fprintf(file, "\n}\n");
    return fclose(file) == 0;
}

static bool is_run(const struct chain_plan *plan, size_t i)
{
    return plan->only < plan->scenes ? i == plan->only : (i - plan->from) % plan->every == 0;
}

static bool summarise(const struct chain_plan *plan, const struct chain_row *rows, bool *good)
{
    struct chain_sum sums[CHAIN_KINDS + 1];
    size_t *order = calloc(plan->scenes, sizeof *order), count = 0, not_run = 0;
    char path[4096];
    snprintf(path, sizeof path, "%s/chain.csv", plan->folder);
    FILE *table = fopen(path, "w");
    bool room = order != NULL;
    for (int k = 0; k <= CHAIN_KINDS; k++)
        sums[k] = (struct chain_sum){.lowest_peak = 1.0};
    for (int k = 0; k <= CHAIN_KINDS; k++)
        room = (sums[k].ratios = calloc(plan->scenes, sizeof(double))) != NULL &&
               (sums[k].stated = calloc(plan->scenes, sizeof(double))) != NULL && room;
    if (!table || !room) {
        fprintf(stderr, "stability: cannot write %s; make the folder\n", path);
        return false;
    }
    fprintf(table,
            "scene,kind,N,W,KL,CL,slack,grit,tend,end,stated_ft,true_ft,peak_ft,reference_ft,"
            "decided,ratio,steps,switches,reference_steps,push_share,pull_share,chain_s,"
            "reference_s\n");
    for (size_t i = plan->from; i < plan->scenes; i++) {
        const struct chain_row *row = &rows[i];
        if (!is_run(plan, i))
            continue;
        if (row->stage == NOT_RUN) {
            not_run++;
            continue;
        }
        sum_add(&sums[0], row);
        sum_add(&sums[1 + row->kind], row);
        write_row(table, plan, i, row);
        if (row->double_ratio > 0.0)
            printf("LONG DOUBLE %zu (%s): ratio %.3g, in double %.3g\n", i,
                   chain_kind_names[row->kind], row->ratio, row->double_ratio);
        if (is_compared(row))
            order[count++] = i;
        else if (row->stage == DONE && row->reference_ok && row->end == STUDY_OK)
            printf("NOT DECIDED %zu (%s): runs of the reference are %.2g ft apart; stated %.3g, "
                   "difference %.3g\n",
                   i, chain_kind_names[row->kind], row->reference_ft, row->stated_ft, row->true_ft);
        else
            printf("NOT COMPARED %zu (%s%s): chain %s, reference %s\n", i,
                   chain_kind_names[row->kind], row->lossless ? ", no losses" : "",
                   study_end_names[row->end],
                   row->reference_ok    ? "ok"
                   : row->stage == DONE ? "gave up"
                                        : "too slow");
    }
    puts("                              beyond        beyond                     stated/     not  "
         "of them  no ref-     not   of them  peaks  lowest    chain     ref.\n"
         "kind   scenes     ok compared      1      %        3     worst   median     peak decided "
         "beyond 3   erence  stable  lossless  < 0.9    peak       ms       ms");
    for (int k = 0; k <= CHAIN_KINDS; k++)
        if (sums[k].scenes > 0)
            sum_print(&sums[k], k == 0 ? "all" : chain_kind_names[k - 1]);
    printf("not stable: unstable or step_underflow. Slowest chain: %.3g s. Not run, as time was "
           "up: %zu\n",
           sums[0].slowest_s, not_run);
    print_worst(plan, rows, order, count);
    const struct chain_sum *all = &sums[0];
    *good = (all->beyond_1 <= 1 || all->beyond_1 * BEYOND_1_ONE_IN <= all->compared) &&
            all->beyond_3 == 0 && all->unstable_lossless == 0 && not_run == 0 &&
            all->ends[STUDY_CRASHED] == 0;
    for (int k = 0; k <= CHAIN_KINDS; k++) {
        free(sums[k].ratios);
        free(sums[k].stated);
    }
    free(order);
    return fclose(table) == 0;
}

int chain_study(const struct chain_plan *plan)
{
    struct shared *shared = mmap(NULL, sizeof *shared + plan->scenes * sizeof shared->rows[0],
                                 PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    bool good = shared != MAP_FAILED, keeps = false;
    if (!good)
        return 3;
    shared->begin = time(NULL);
    fflush(stdout);
    if (plan->only < plan->scenes) {
        struct sim_scene scene;
        char path[4096];
        snprintf(path, sizeof path, "%s/scene.json", plan->folder);
        chain_draw(&scene, plan->only, plan->seed);
        good = write_scene(path, &scene);
        sim_scene_free(&scene);
        run_scene(plan, plan->only, &shared->rows[plan->only]);
    } else {
        good = study_in_jobs(plan->jobs, work, plan, shared);
    }
    good = good && summarise(plan, shared->rows, &keeps);
    munmap(shared, sizeof *shared + plan->scenes * sizeof shared->rows[0]);
    return !good ? 3 : !keeps;
}
