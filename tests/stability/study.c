#include "tests/stability/study.h"

#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/sim_reference/model.h"

#define REFERENCE_STEPS 5000.0 /* more are too slow */
#define REFERENCE_REACH 0.3    /* step of the reference times the fastest rate */
#define EVENT_STEPS     30000.0
#define EXPLICIT_REACH  6.0
#define REFERENCE_EVERY 3
#define UMPIRE_S        20.0 /* for event, where two others contradict each other */

const char *const study_method_names[STUDY_METHODS] = {"auto", "event", "implicit", "cvode",
                                                       "reference"};
const char *const study_end_names[STUDY_ENDS] = {"ok",   "unstable", "folded",  "step_underflow",
                                                 "slow", "crashed",  "refused", "-"};

/* What one process does: a solver at a tolerance (0: its own), or the reference for equations of
 * that fastest rate. */
struct task {
    const char *solver;
    double rtol, limit_s, rate;
};

static void solve(const struct sim_scene *scene, const struct task *task,
                  struct study_answer *answer)
{
    struct sim_options options = {.solver = task->solver, .rtol = task->rtol};
    struct sim_result result;
    struct error error = {0};
    enum mr_status status = sim_run(scene, &options, &result, &error);
    bool given = status == MR_OK || result.status == SIM_UNPREDICTABLE;
    answer->end = given                 ? STUDY_OK
                : status == MR_NUMERICS ? (enum study_end)result.status
                                        : STUDY_REFUSED;
    snprintf(answer->solver, sizeof answer->solver, "%s", result.solver ? result.solver : "-");
    answer->t_s = result.t_s;
    answer->rate = 2.785 / result.dt_limit_s;
    answer->steps = result.steps;
    answer->events = result.events;
    if (given) {
        answer->error_u_ft = result.error_u_ft;
        answer->error_lift_ft = result.error_lift_ft;
        answer->peak_u_ft = result.peak_u_ft;
        answer->max_lift_ft = result.max_lift_ft;
        answer->bow_wave = result.bow_wave;
        answer->unsure_s = status == MR_OK ? 0.0 : result.t_s;
        for (size_t i = 0; i < DRAW_OUTPUTS; i++) {
            answer->lift_ft[i] = result.outputs[i].lift_ft;
            memcpy(answer->u_ft[i], result.outputs[i].u_ft,
                   ((size_t)scene->mats + 1) * sizeof(double));
        }
    }
    sim_result_free(&result);
}

/* The same scene in the reference's terms. */
static void translate(const struct sim_scene *scene, struct ref_scene *to)
{
    static const enum ref_shear shears[] = {[SIM_SHEAR_RISING] = REF_RISING,
                                            [SIM_SHEAR_NONE] = REF_NONE,
                                            [SIM_SHEAR_FOLLOWING] = REF_FOLLOWING,
                                            [SIM_SHEAR_BOTH] = REF_BOTH};
    ref_defaults(to);
    to->model = scene->model == SIM_MODEL_REPORT ? REF_REPORT : REF_CONSISTENT;
    to->mats = scene->mats;
    to->W = scene->weight_lb;
    to->I = scene->inertia_slug_ft2;
    to->KV = scene->kv_lb_ft;
    to->CV = scene->cv_lb_s_ft;
    to->KL = scene->kl_lb_ft;
    to->CL = scene->cl_lb_s_ft;
    to->KT = scene->kt_lb_ft_rad;
    to->CT = scene->ct_lb_ft_s_rad;
    to->TAD = scene->tad_deg * M_PI / 180.0;
    to->switched = scene->tad_mode == SIM_TAD_SWITCHED;
    to->full = scene->profile == SIM_PROFILE_FULL;
    to->slack = scene->slack_ft;
    to->left_fixed = scene->left_end == SIM_END_FIXED;
    to->right_fixed = scene->right_end == SIM_END_FIXED;
    to->left_torsion_fixed = scene->left_torsion == SIM_END_FIXED;
    to->right_torsion_fixed = scene->right_torsion == SIM_END_FIXED;
    to->F = scene->force_lb;
    to->Vac = scene->vac_ft_s;
    to->s0 = scene->start_ft;
    to->linear = scene->thrust == SIM_THRUST_LINEAR;
    to->wheel_load = scene->wheel_load_lb;
    to->f = scene->friction;
    to->veps = scene->veps_ft_s;
    to->friction = scene->friction_law == SIM_FRICTION_STICK ? REF_STICK
                 : scene->friction_law == SIM_FRICTION_TANH  ? REF_TANH
                                                             : REF_NO_FRICTION;
    to->soil_normal = scene->friction_normal == SIM_NORMAL_SOIL;
    to->V = scene->lift_shear_lb;
    to->shear = shears[scene->lift_shear];
    for (size_t i = 0; i < scene->bump_ft.count; i++)
        to->bump[(size_t)scene->bump_first - 1 + i] = scene->bump_ft.values[i];
    to->v0 = scene->v0_ft_s;
    to->tend = scene->t_end_s;
    to->outputs = DRAW_OUTPUTS;
    for (int i = 0; i < DRAW_OUTPUTS; i++)
        to->t_out[i] = scene->t_out_s.values[i];
}

/* The reference at a step and at half of it. */
static void refer(const struct sim_scene *scene, double rate, struct study_answer *answer)
{
    static struct ref_scene same;
    static struct ref_run coarse, fine;
    double step_s = fmin(REFERENCE_REACH / rate, scene->t_end_s / 2000.0);
    translate(scene, &same);
    snprintf(answer->solver, sizeof answer->solver, "rk4");
    answer->rate = rate;
    fclose(stderr); /* a child's own: why it stops is of no interest here */
    answer->end = STUDY_UNDERFLOW;
    if (!ref_march(&same, step_s, &coarse) || !ref_march(&same, 0.5 * step_s, &fine))
        return;
    answer->end = STUDY_OK;
    answer->steps = fine.steps;
    answer->events = fine.switches;
    answer->max_lift_ft = fine.max_lift_ft;
    answer->error_lift_ft = fabs(fine.max_lift_ft - coarse.max_lift_ft);
    double bump = 0.0;
    for (size_t i = 0; i < scene->bump_ft.count; i++)
        bump = fmax(bump, scene->bump_ft.values[i]);
    answer->bow_wave = fine.max_lift_ft > fmax(0.05, 2.0 * bump);
    for (int i = 0; i < DRAW_OUTPUTS; i++) {
        answer->lift_ft[i] = fine.output[i].lift_ft;
        answer->error_lift_ft = fmax(answer->error_lift_ft,
                                     fabs(fine.output[i].lift_ft - coarse.output[i].lift_ft));
        for (int n = 1; n <= scene->mats; n++) {
            double u_ft = fine.output[i].u_ft[n - 1];
            answer->u_ft[i][n] = u_ft;
            answer->peak_u_ft = fmax(answer->peak_u_ft, fabs(u_ft));
            answer->error_u_ft = fmax(answer->error_u_ft,
                                      fabs(u_ft - coarse.output[i].u_ft[n - 1]));
        }
    }
}

static double used_s(void)
{
    struct rusage usage;
    getrusage(RUSAGE_CHILDREN, &usage);
    return (double)(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec) +
           1e-6 * (double)(usage.ru_utime.tv_usec + usage.ru_stime.tv_usec);
}

static void run(const struct sim_scene *scene, struct task task, struct study_answer *answer)
{
    double before_s = used_s();
    int status = 0;
    *answer = (struct study_answer){.end = STUDY_CRASHED, .solver = "-"};
    pid_t child = fork();
    if (child < 0)
        return;
    if (child == 0) {
        struct itimerval limit = {
            .it_value = {(time_t)task.limit_s, (suseconds_t)(1e6 * fmod(task.limit_s, 1.0))}};
        signal(SIGPROF, SIG_DFL);
        setitimer(ITIMER_PROF, &limit, NULL);
        if (strcmp(task.solver, study_method_names[STUDY_REFERENCE]) == 0)
            refer(scene, task.rate, answer);
        else
            solve(scene, &task, answer);
        _exit(0);
    }
    while (waitpid(child, &status, 0) < 0)
        ;
    if (WIFSIGNALED(status))
        answer->end = WTERMSIG(status) == SIGPROF ? STUDY_SLOW : STUDY_CRASHED;
    answer->cpu_s = used_s() - before_s;
}

static void run_method(const struct sim_scene *scene, enum study_method method, double limit_s,
                       struct study_answer *answers)
{
    double rate = method == STUDY_AUTO ? 0.0 : answers[STUDY_AUTO].rate;
    run(scene, (struct task){study_method_names[method], 0.0, limit_s, rate}, &answers[method]);
}

void study_scene(const struct sim_scene *scene, size_t index, const struct study_limits *limits,
                 struct study_answer *answers)
{
    static const enum study_method after_event[] = {STUDY_IMPLICIT, STUDY_CVODE};
    static const enum study_method after_implicit[] = {STUDY_EVENT, STUDY_CVODE};
    for (int i = 0; i < STUDY_METHODS; i++)
        answers[i] = (struct study_answer){.end = STUDY_NOT_RUN, .solver = "-"};
    run_method(scene, STUDY_AUTO, limits->auto_s, answers);
    const struct study_answer *first = &answers[STUDY_AUTO];
    bool explicit = strcmp(first->solver, "event") == 0, agreed = false;
    for (int i = 0; i < 2 && !agreed && scene->friction_law != SIM_FRICTION_SIGN; i++) {
        enum study_method method = explicit ? after_event[i] : after_implicit[i];
        if (method == STUDY_EVENT && !(first->rate * scene->t_end_s / EXPLICIT_REACH < EVENT_STEPS))
            continue;
        run_method(scene, method, limits->other_s, answers);
        if (first->end == STUDY_OK && answers[method].end == STUDY_OK)
            agreed = !study_compare(scene, first, &answers[method]).contradicts;
        else if (first->end == STUDY_FOLDED)
            agreed = answers[method].end == STUDY_FOLDED;
    }
    struct study_answer *cvode = &answers[STUDY_CVODE];
    if (first->end == STUDY_OK && cvode->end == STUDY_OK && !agreed &&
        answers[STUDY_EVENT].end == STUDY_NOT_RUN) {
        run_method(scene, STUDY_EVENT, UMPIRE_S, answers);
        cvode->alone = answers[STUDY_EVENT].end == STUDY_OK &&
                       !study_compare(scene, first, &answers[STUDY_EVENT]).contradicts;
    }
    if (index % REFERENCE_EVERY == 0 && first->end == STUDY_OK &&
        scene->friction_law != SIM_FRICTION_SIGN &&
        first->rate * scene->t_end_s / REFERENCE_REACH < REFERENCE_STEPS)
        run_method(scene, STUDY_REFERENCE, limits->other_s, answers);
}

void study_fixed(const struct sim_scene *scene, const struct study_limits *limits,
                 struct study_answer *answers)
{
    static const struct {
        const char *solver;
        double rtol;
    } methods[STUDY_FIXED_METHODS] = {
        {"staggered", 0.0}, {"event", STUDY_TRUTH_RTOL}, {"implicit", STUDY_TRUTH_RTOL}};
    for (int i = 0; i < STUDY_FIXED_METHODS; i++)
        answers[i] = (struct study_answer){.end = STUDY_NOT_RUN, .solver = "-"};
    for (int i = 0; i < STUDY_FIXED_METHODS; i++) {
        double limit_s = i == 0 ? limits->auto_s : limits->other_s;
        run(scene, (struct task){methods[i].solver, methods[i].rtol, limit_s, 0.0}, &answers[i]);
        struct study_difference d = study_compare(scene, &answers[0], &answers[i]);
        if (i > 0 && answers[i].end == STUDY_OK && answers[0].end == STUDY_OK && !d.verdict &&
            fmax(d.ratio_u, d.ratio_lift) <= STUDY_DOUBT)
            break;
    }
}

/* Grit and ground are not drawn; friction tanh and sign are not for fixed. */
static bool fixed_has(const struct sim_scene *scene)
{
    return scene->model == SIM_MODEL_CONSISTENT &&
           (scene->friction_law == SIM_FRICTION_STICK || scene->friction_law == SIM_FRICTION_NONE);
}

const char *study_bars_solver(const struct sim_scene *scene, size_t index)
{
    static const char *const turns[] = {"rk4", "event", "cvode", "implicit", "rkgs", "hamming"};
    if (index % 24 == 23)
        return "moreau"; /* every other of hamming's landings */
    return fixed_has(scene) && index % 4 == 1 ? "staggered" : turns[index / 2 % 6];
}

/* Whether `a` is more than STUDY_DOUBT of its stated errors from this answer. */
static bool doubtful(const struct sim_scene *scene, const struct study_answer *a,
                     const struct study_answer *b)
{
    if (a->end != STUDY_OK || b->end != STUDY_OK)
        return false;
    struct study_difference d = study_compare(scene, a, b);
    return d.verdict || fmax(d.ratio_u, d.ratio_lift) > STUDY_DOUBT;
}

void study_bars(const struct sim_scene *scene, size_t index, const struct study_limits *limits,
                struct study_answer *answers)
{
    struct study_answer *first = &answers[STUDY_BARS_AUTO], *other = &answers[STUDY_BARS_OTHER],
                        *event = &answers[STUDY_BARS_EVENT],
                        *implicit = &answers[STUDY_BARS_IMPLICIT];
    for (int i = 0; i < STUDY_METHODS; i++)
        answers[i] = (struct study_answer){.end = STUDY_NOT_RUN, .solver = "-"};
    run(scene, (struct task){"auto", 0.0, STUDY_LATE_S, 0.0}, first);
    if (scene->friction_law == SIM_FRICTION_SIGN)
        return;
    const char *name = study_bars_solver(scene, index);
    run(scene, (struct task){name, 0.0, limits->other_s, 0.0}, other);
    if (other->solver[0] == '-')
        snprintf(other->solver, sizeof other->solver, "%s", name);
    run(scene, (struct task){"event", STUDY_TRUTH_RTOL, limits->other_s, 0.0}, event);
    bool known = event->end == STUDY_OK && !doubtful(scene, first, event) &&
                 !doubtful(scene, other, event);
    if (!known || strcmp(first->solver, "event") == 0 || strcmp(other->solver, "event") == 0)
        run(scene, (struct task){"implicit", STUDY_TRUTH_RTOL, limits->other_s, 0.0}, implicit);
    bool second = implicit->end == STUDY_OK && event->end == STUDY_OK;
    if (!second && scene->path_count == 0 && first->rate > 0.0 &&
        first->rate * scene->t_end_s / REFERENCE_REACH < REFERENCE_STEPS)
        run(scene, (struct task){"reference", 0.0, limits->other_s, first->rate},
            &answers[STUDY_BARS_REFERENCE]);
}

struct study_truth study_truth(const struct sim_scene *scene, const struct study_answer *answers,
                               const struct study_answer *of)
{
    struct study_truth truth = {0};
    const struct study_answer *same = NULL;
    for (int i = STUDY_BARS_EVENT; i <= STUDY_BARS_REFERENCE; i++) {
        const struct study_answer *a = &answers[i];
        if (a->end != STUDY_OK)
            continue;
        if (strcmp(a->solver, of->solver) == 0) {
            same = a;
            continue;
        }
        if (!truth.is) {
            truth.is = a;
            continue;
        }
        bool beyond = doubtful(scene, of, truth.is);
        truth.other_alone = beyond && !doubtful(scene, of, a) &&
                            study_compare(scene, a, truth.is).contradicts;
        if (truth.other_alone)
            truth.is = a;
    }
    /* a second method, at odds with this one at both of its tolerances */
    if (truth.is && same && doubtful(scene, of, truth.is) && !doubtful(scene, of, same) &&
        study_compare(scene, same, truth.is).contradicts)
        truth.contested = true;
    if (!truth.is && same)
        truth = (struct study_truth){.is = same, .by_itself = true};
    return truth;
}

struct study_difference study_compare(const struct sim_scene *scene, const struct study_answer *a,
                                      const struct study_answer *b)
{
    struct study_difference d = {.verdict = a->bow_wave != b->bow_wave,
                                 .lift_ft = fabs(a->max_lift_ft - b->max_lift_ft)};
    for (int i = 0; i < DRAW_OUTPUTS; i++) {
        d.lift_ft = fmax(d.lift_ft, fabs(a->lift_ft[i] - b->lift_ft[i]));
        for (int n = 1; n <= scene->mats; n++)
            d.u_ft = fmax(d.u_ft, fabs(a->u_ft[i][n] - b->u_ft[i][n]));
    }
    double stated_u = a->error_u_ft + b->error_u_ft,
           stated_lift = a->error_lift_ft + b->error_lift_ft;
    d.ratio_u = d.u_ft / (stated_u + STUDY_LEAST_FT);
    d.ratio_lift = d.lift_ft / (stated_lift + STUDY_LEAST_FT);
    d.contradicts =
        d.verdict ||
        d.u_ft > STUDY_MULTIPLE * stated_u + STUDY_PART * a->peak_u_ft + STUDY_LEAST_FT ||
        d.lift_ft > STUDY_MULTIPLE * stated_lift + STUDY_PART * a->max_lift_ft + STUDY_LEAST_FT;
    return d;
}

static const double edges[BINS - 1] = {0.1, 0.3, 1.0, 3.0, 10.0};

void bins_add(struct bins *bins, double ratio)
{
    size_t i = 0;
    while (i < BINS - 1 && ratio > edges[i])
        i++;
    bins->counts[i]++;
    bins->worst = fmax(bins->worst, ratio);
}

void bins_print(const struct bins *bins, const char *what)
{
    printf("  %-5s", what);
    for (size_t i = 0; i < BINS - 1; i++)
        printf("  <=%g: %zu", edges[i], bins->counts[i]);
    printf("  more: %zu  worst: %.3g\n", bins->counts[BINS - 1], bins->worst);
}

bool study_in_jobs(size_t jobs, void (*work)(const void *plan, void *shared), const void *plan,
                   void *shared)
{
    bool good = true;
    int status;
    for (size_t j = 0; j < jobs; j++) {
        pid_t child = fork();
        if (child == 0) {
            work(plan, shared);
            _exit(0);
        }
        good = good && child > 0;
    }
    while (wait(&status) > 0)
        good = good && WIFEXITED(status) && WEXITSTATUS(status) == 0;
    return good;
}
