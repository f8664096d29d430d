#include "host/sim/solvers/staggered.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/models/chain.h"
#include "host/sim/solvers/record.h"
#include "host/sim/elements/wheel.h"

/* of the stability limit, to begin with when the step is not given: the check is at the limit */
#define STEP_SHARE           0.5
/* of a mat the aircraft may cross in a step, when the step is not given */
#define HOP_SHARE            0.25
#define LEAST_STEPS          1000
#define MOST_STEPS           400000000u
#define MOST_HALVINGS        8
#define THIRD_STEPS          1.37 /* of the coarser one of two */
#define ENERGY_EXCESS        4.0
#define STEPS_BETWEEN_ASKING 1024 /* whether to go on */
#define ENERGY_STEPS         61   /* between energy checks; odd, so that what alternates shows */
#define DISAGREEMENT         0.1
/* between looks at the largest tensions: a wave takes about as long to cross a mat */
#define NOTE_STEPS           4
/* at rest before the window leaves a mat: one for its damper, one for the grit, one more */
#define QUIET_STEPS          3

/* Mats that are integrated: all awake ones and one at rest on either side. */
struct window {
    int first;
    int last;
    int quiet_first; /* steps that the two mats at this end have been at rest */
    int quiet_last;
};

/* One run over the whole time. */
struct pass {
    uint64_t steps;
    uint64_t done; /* fewer when it failed, or when nothing could move any more */
    double h_s;
    double ms;
    uint64_t events;
    uint64_t awake_sum;
    int awake_max;
    int number; /* of this pass, for go_on */
    bool interrupted;
    bool failed;
    int mat; /* where, when failed */
    double t_s;
    double speed_end_ft_s;
    struct sim_record record;
    struct mods_state *mods; /* at its end; NULL without modifications */
};

/* Nothing in the window has moved for a while. */
static bool asleep(const struct window *window)
{
    return window->last - window->first <= 3 && window->quiet_first >= QUIET_STEPS &&
           window->quiet_last >= QUIET_STEPS;
}

/* Take in the mats under the wheel. A window in which all have rested for a while goes there
 * instead of stretching. */
static void cover(struct window *window, const struct chain *chain, const struct sim_touch *touch,
                  int count)
{
    if (count > 0 && asleep(window))
        window->first = window->last = touch[0].mat;
    for (int i = 0; i < count; i++) {
        if (touch[i].mat <= window->first && window->first > 1)
            window->first = touch[i].mat > 1 ? touch[i].mat - 1 : 1;
        if (touch[i].mat >= window->last && window->last < chain->mats)
            window->last = touch[i].mat < chain->mats ? touch[i].mat + 1 : chain->mats;
    }
}

/* After a kick. Growing is a must: the mat at the end moves, so the next one will feel it. Leaving
 * a mat waits a little. */
static void follow(struct window *window, const struct chain *chain)
{
    if (chain->v_ft_s[window->first] != 0.0 && window->first > 1)
        window->first--;
    if (chain->v_ft_s[window->last] != 0.0 && window->last < chain->mats)
        window->last++;
    bool first_rests = chain->v_ft_s[window->first] == 0.0 &&
                       chain->v_ft_s[window->first + 1] == 0.0;
    bool last_rests = chain->v_ft_s[window->last] == 0.0 && chain->v_ft_s[window->last - 1] == 0.0;
    window->quiet_first = first_rests ? window->quiet_first + 1 : 0;
    window->quiet_last = last_rests ? window->quiet_last + 1 : 0;
    if (window->quiet_first >= QUIET_STEPS && window->last - window->first > 2) {
        window->first++;
        window->quiet_first = 0;
    }
    if (window->quiet_last >= QUIET_STEPS && window->last - window->first > 2) {
        window->last--;
        window->quiet_last = 0;
    }
}

/* The first kick has been given to all: whoever is still at rest sleeps. */
static void settle(struct window *window, const struct chain *chain)
{
    int first = 1, last = chain->mats;
    while (first < chain->mats && chain->v_ft_s[first] == 0.0)
        first++;
    while (last > first && chain->v_ft_s[last] == 0.0)
        last--;
    if (chain->v_ft_s[first] == 0.0)
        first = last = 2; /* nobody: anywhere */
    window->first = first > 1 ? first - 1 : 1;
    window->last = last < chain->mats ? last + 1 : chain->mats;
}

static int fastest(const struct chain *chain)
{
    int mat = 1;
    for (int n = 1; n <= chain->mats; n++) {
        if (!isfinite(chain->v_ft_s[n]) || !isfinite(chain->u_ft[n]))
            return n;
        if (fabs(chain->v_ft_s[n]) > fabs(chain->v_ft_s[mat]))
            mat = n;
    }
    return mat;
}

static void run_pass(struct pass *pass, struct chain *chain, const struct sim_scene *scene,
                     const struct sim_options *options)
{
    struct sim_touch touch[SIM_TOUCH_MAX];
    bool prune = !options->no_prune && scene->mats > 4 && element_rests(&chain->elements);
    struct sim_wheel wheel;
    struct window window = {1, chain->mats, 0, 0};
    double h = pass->h_s;
    double begin_s = monotonic_s();
    double put_in_lb_ft;
    int count = 0;

    chain_reset(chain, scene);
    put_in_lb_ft = chain_energy_lb_ft(chain, 1, chain->mats);
    sim_wheel_start(&wheel, scene);
    if (chain->gear)
        gear_start(chain->gear, h);
    sim_record_take(&pass->record, 0.0, chain->u_ft, chain->v_ft_s);
    for (uint64_t i = 0; i < pass->steps; i++) {
        double from_s = i == 0 ? 0.0 : ((double)i - 0.5) * h;
        double to_s = ((double)i + 0.5) * h;

        chain_release(chain, touch, count);
        count = chain->gear ? gear_span(chain->gear, from_s, to_s, touch)
                            : sim_wheel_span(&wheel, from_s, to_s, touch);
        cover(&window, chain, touch, count);
        chain_touch(chain, touch, count);
        if (chain->mods)
            chain_brace(chain, to_s - from_s, touch, count, &window.first, &window.last);
        pass->events += chain_kick(chain, to_s - from_s, window.first, window.last);
        if (chain->mods)
            chain_unbrace(chain);
        if (prune && i == 0)
            settle(&window, chain);
        else if (prune)
            follow(&window, chain);
        /* at rest under forces that no longer change: nothing will ever move again */
        bool still = prune && i > 0 && asleep(&window) && sim_wheel_is_over(&wheel, from_s);
        bool last = still || i + 1 == pass->steps;
        pass->done = i + 1;
        int awake = window.last - window.first + 1;
        pass->awake_sum += (uint64_t)awake;
        pass->awake_max = awake > pass->awake_max ? awake : pass->awake_max;
        for (int k = 0; k < count; k++)
            put_in_lb_ft += fabs(touch[k].thrust_lb * chain->v_ft_s[touch[k].mat]) * h;
        if (i % NOTE_STEPS == 0)
            chain_note(chain, window.first, window.last);
        chain_drift(chain, h, window.first, window.last);

        double t_s = (double)(i + 1) * h;
        if (i % ENERGY_STEPS == 0 || last) {
            double energy_lb_ft = chain_energy_lb_ft(chain, window.first, window.last);
            if (!(energy_lb_ft <= ENERGY_EXCESS * put_in_lb_ft)) {
                pass->failed = true;
                pass->mat = fastest(chain);
                pass->t_s = t_s;
                break;
            }
        }
        if (last)
            /* a rounding must not miss what is wanted at the end */
            t_s = (double)pass->steps * h * (1.0 + 1e-11);
        if (pass->record.next_s <= t_s)
            sim_record_take(&pass->record, t_s, chain->u_ft, chain->v_ft_s);
        if (i % STEPS_BETWEEN_ASKING == 0 && options->go_on &&
            !options->go_on(options->go_on_ctx, pass->number, (double)i / (double)pass->steps)) {
            pass->interrupted = true;
            pass->mat = fastest(chain);
            pass->t_s = t_s;
            break;
        }
        if (still) {
            pass->awake_sum += (uint64_t)awake * (pass->steps - pass->done);
            break;
        }
    }
    if (chain->mods) {
        struct mods_view view = chain_view(chain);
        pass->mods = mods_finish(chain->mods, &view);
    }
    pass->speed_end_ft_s = fabs(chain->v_ft_s[fastest(chain)]);
    pass->ms = 1e3 * (monotonic_s() - begin_s);
}

static void drop_pass(struct pass *pass)
{
    sim_record_free(&pass->record);
    free(pass->mods);
    *pass = (struct pass){0};
}

static void start_pass(struct pass *pass, struct chain *chain, const struct sim_scene *scene,
                       const struct sim_options *options, uint64_t steps, struct sim_result *result)
{
    *pass = (struct pass){
        .steps = steps, .h_s = sim_scene_end_s(scene) / (double)steps, .number = ++result->passes};
    sim_record_make(&pass->record, scene, options);
    run_pass(pass, chain, scene, options);
    result->rhs += pass->done;
    result->rejected += pass->done; /* until this pass is the one that answers */
}

/* What a chain has come to. `record` and `mods` are the result's from then on. */
static void deliver(struct chain *chain, struct sim_record *record, struct mods_state **mods,
                    struct sim_result *result)
{
    size_t mats = (size_t)chain->mats;
    result->mods = *mods;
    *mods = NULL;
    struct sim_difference peak = sim_record_peak(record);
    result->peak_u_ft = peak.u_ft;
    result->peak_mat = peak.mat;
    result->u_ft = xcalloc(mats + 1, sizeof *result->u_ft);
    result->gap_ft = xcalloc(mats + 2, sizeof *result->gap_ft);
    result->push_lb = xcalloc(mats + 2, sizeof *result->push_lb);
    result->pull_lb = xcalloc(mats + 2, sizeof *result->pull_lb);
    if (result->status == SIM_OK)
        memcpy(chain->u_ft, record->snapshots[record->snapshot_count - 1].u_ft,
               (mats + 1) * sizeof *chain->u_ft);
    memcpy(result->u_ft, chain->u_ft, (mats + 1) * sizeof *result->u_ft);
    for (int j = 1; j <= chain->mats + 1; j++)
        result->gap_ft[j] = chain_opening_ft(chain, j);
    memcpy(result->push_lb, chain->push_lb, (mats + 2) * sizeof *chain->push_lb);
    memcpy(result->pull_lb, chain->pull_lb, (mats + 2) * sizeof *chain->pull_lb);
    sim_record_deliver(record, result);
}

static void answer(struct chain *chain, struct pass *pass, const struct pass *other,
                   struct sim_result *result)
{
    result->dt_s = pass->h_s;
    result->checked_dt_s = other->h_s;
    result->pass_ms = pass->ms;
    result->steps = pass->done;
    result->rejected -= pass->done;
    result->events = pass->events;
    result->mats_max = pass->awake_max;
    result->mats_mean = (double)pass->awake_sum /
                        (double)(pass->failed || pass->interrupted ? pass->done : pass->steps);
    if (result->status != SIM_OK && result->status != SIM_INTERRUPTED)
        return;
    if (pass->mods && other->mods)
        pass->mods->error_lb = mods_difference_lb(pass->mods, other->mods);
    result->speed_end_ft_s = pass->speed_end_ft_s;
    deliver(chain, &pass->record, &pass->mods, result);
}

/* The finer pass is the coarser one of the next pair. */
static void take_over(struct pass *to, struct pass *from)
{
    drop_pass(to);
    *to = *from;
    *from = (struct pass){0};
}

static void run_single(struct chain *chain, const struct sim_scene *scene,
                       const struct sim_options *options, uint64_t steps, struct sim_result *result)
{
    struct pass only = {0};
    start_pass(&only, chain, scene, options, steps, result);
    if (only.failed || only.interrupted)
        sim_result_end(result, only.failed ? SIM_UNSTABLE : SIM_INTERRUPTED, only.mat, only.t_s);
    answer(chain, &only, &only, result);
    drop_pass(&only);
}

/* Whether a joint tears hangs on a peak of tension, which two runs can both see on one side. So a
 * third, at a step between them, widens what is stated. */
static bool tears(const struct sim_scene *scene)
{
    return scene->mods.tear_lb < HUGE_VAL;
}

/* Run at `steps` and at twice that, on and on while they differ and the step is ours to halve; one
 * of the two answers. */
static void run_pairs(struct chain *chain, const struct sim_scene *scene,
                      const struct sim_options *options, uint64_t steps, bool coarser_answers,
                      struct sim_result *result)
{
    struct pass third = {0}, coarse = {0}, fine = {0};
    struct sim_difference apart = {0};
    double tolerance = options->rtol > 0.0 ? options->rtol : DISAGREEMENT;
    bool refine = options->rtol > 0.0 || options->dt_s == 0.0;
    bool asks = tears(scene);
    if (asks)
        start_pass(&third, chain, scene, options, (uint64_t)ceil(THIRD_STEPS * (double)steps),
                   result);
    start_pass(&coarse, chain, scene, options, steps, result);
    for (int halvings = 0;; halvings++) {
        if (coarse.interrupted) {
            take_over(&fine, &coarse);
            break;
        }
        start_pass(&fine, chain, scene, options, 2 * coarse.steps, result);
        if (fine.interrupted)
            break;
        bool near_limit = refine && coarse.h_s > 0.51 * result->dt_limit_s;
        if (coarse.failed && !fine.failed && near_limit) {
            take_over(&coarse, &fine);
            continue;
        }
        if (coarse.failed || fine.failed) {
            const struct pass *failed = fine.failed ? &fine : &coarse;
            sim_result_end(result, SIM_UNSTABLE, failed->mat, failed->t_s);
            break;
        }
        apart = sim_record_difference(&coarse.record, &fine.record);
        double peak_ft = sim_record_peak(&fine.record).u_ft;
        result->error_u_ft = apart.u_ft * (coarser_answers ? 2.0 : 1.0);
        if (result->error_u_ft <= tolerance * peak_ft)
            break;
        if (!refine) {
            sim_result_end(result, SIM_UNSTABLE, apart.mat, apart.t_s);
            break;
        }
        if (halvings == MOST_HALVINGS || 4 * coarse.steps > MOST_STEPS) {
            sim_result_end(result, SIM_STEP_UNDERFLOW, apart.mat, apart.t_s);
            break;
        }
        take_over(&coarse, &fine);
    }
    if (fine.interrupted) {
        sim_result_end(result, SIM_INTERRUPTED, fine.mat, fine.t_s);
        coarser_answers = false;
    } else if (asks && !third.failed && !third.interrupted && result->status == SIM_OK) {
        double most_ft = fmax(sim_record_difference(&coarse.record, &third.record).u_ft,
                              sim_record_difference(&fine.record, &third.record).u_ft);
        result->error_u_ft = fmax(result->error_u_ft, 2.0 * most_ft);
    }
    drop_pass(&third);
    answer(chain, coarser_answers ? &coarse : &fine, coarser_answers ? &fine : &coarse, result);
    drop_pass(&coarse);
    drop_pass(&fine);
}

enum mr_status staggered_run(const struct sim_scene *scene, const struct sim_options *options,
                             struct sim_result *result, struct error *error)
{
    struct chain chain = {0};
    struct sim_wheel wheel;
    double end_s = sim_scene_end_s(scene);
    double begin_s = monotonic_s();

    sim_wheel_start(&wheel, scene);
    chain_make(&chain, scene, sim_wheel_first_mat(&wheel));
    double hop_s =
        /* INFINITY for an aircraft that stands */
        scene->length_ft / sim_wheel_fastest_ft_s(&wheel);
    result->solver = "staggered";
    result->mats = scene->mats;
    result->t_end_s = end_s;
    result->dt_limit_s = fmin(chain_step_limit_s(&chain), hop_s);
    chain_describe(&chain, scene, result);

    bool given = options->dt_s > 0.0;
    double h = given ? options->dt_s
                     : fmin(STEP_SHARE * result->dt_limit_s,
                            fmin(HOP_SHARE * hop_s, end_s / LEAST_STEPS));
    double steps = ceil(end_s / h * (1.0 - 1e-12));
    bool coarser_answers = given && options->rtol == 0.0 && 2.0 * h > 0.95 * result->dt_limit_s;
    if (h > result->dt_limit_s) {
        result->dt_s = h;
        sim_result_end(result, SIM_UNSTABLE, sim_wheel_first_mat(&wheel), 0.0);
    } else if (!(steps <= MOST_STEPS)) {
        error_set(error, MR_USAGE,
                  "too many steps: %s: %g s in steps of %g s; give a shorter tend or a larger dt",
                  scene->name[0] ? scene->name : "scene", end_s, h);
    } else if (options->single) {
        run_single(&chain, scene, options, (uint64_t)steps, result);
    } else {
        uint64_t first = coarser_answers ? (uint64_t)steps : (uint64_t)ceil(steps / 2.0);
        run_pairs(&chain, scene, options, first, coarser_answers, result);
    }
    result->run_ms = 1e3 * (monotonic_s() - begin_s);
    chain_free(&chain);
    return error->status;
}
