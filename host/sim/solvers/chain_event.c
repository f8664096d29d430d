#include "host/sim/solvers/chain_event.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/law.h"
#include "host/sim/solvers/chain_motion.h"

#define MIN_ORDER                6
#define FIRST_ORDER              12
#define STEPS_PER_CALLBACK       256
#define MAX_STEPS                50000000u
/* largest number of switches (changes of mode) per mat at the same time */
#define MAX_SWITCHES_AT_ONCE     64
/* Tolerances of the runs: truncation error of a step, relative to the speed. */
#define COARSE_TOLERANCE         1e-9
#define FINE_TOLERANCE           1e-12
#define FINEST_TOLERANCE         1e-13
/* If the difference of two runs exceeds this multiple of COARSE_TOLERANCE, a third run is made. */
#define THIRD_RUN_FACTOR         1e6
#define ERROR_FACTOR             3.0   /* error estimate / largest difference between runs */
#define ERROR_FLOOR              1e-10 /* smallest error estimate / largest movement */
#define ERROR_FLOOR_LENGTH       1e-13 /* smallest error estimate / mat length */
/* Largest allowed difference / largest movement, if rtol is not given */
#define MAX_DISAGREEMENT         0.1
#define STEP_PER_SWITCH_TIME_MAX 2.0 /* longest step / usual time between switches */

struct tolerance_run {
    double tolerance, longest_step_s, run_ms;
    uint64_t step_count, switch_count;
    double active_mat_time_s;
    int active_mats_max, pass_number;
    enum sim_status status;
    int failed_mat;
    struct sim_record record;
};

bool chain_event_is_supported(const struct sim_scene *scene)
{
    return !mods_are_present(scene) && !sim_scene_is_varied(scene);
}

/* Updates the largest forces of each joint. The largest force in a step is that at one of several
 * points, or at the vertex of the parabola through three of them. */
static void update_peak_tensions(struct motion *m, int first, int last, int order, double h)
{
    int parts = 2 + (int)law_min(2.0 * h * m->max_rate, 60.0);
    for (int j = first; j <= last + 1; j++) {
        double reach = m->tension_change_max[j], s[POLYNOMIAL_DEGREE_MAX], before = 0.0,
               middle = 0.0;
        if (m->tension_terms[0][j] + reach <= m->max_tension_lb[j] &&
            reach - m->tension_terms[0][j] <= m->max_compression_lb[j])
            continue;
        for (int k = 0; k < order; k++)
            s[k] = m->tension_terms[k][j];
        for (int i = 0; i <= parts; i++) {
            double after = polynomial_value(s, order - 1, h * i / parts), top = middle;
            if (i >= 2 && (middle - before) * (middle - after) > 0.0)
                top -= (after - before) * (after - before) /
                       (8.0 * (before - 2.0 * middle + after));
            m->max_tension_lb[j] = law_max(m->max_tension_lb[j], law_max(after, i ? top : after));
            m->max_compression_lb[j] = law_max(m->max_compression_lb[j],
                                               -law_min(after, i ? top : after));
            before = middle;
            middle = after;
        }
    }
}

/* Records the outputs whose times are within the step. The end is included with a margin, so that
 * rounding does not skip outputs. */
static void record_samples(struct motion *m, struct tolerance_run *run, int first, int last,
                           int order, double h, bool at_end)
{
    while (run->record.next_record_s <= (at_end ? DBL_MAX : m->t_s + h)) {
        double at_s = law_min(h, run->record.next_record_s - m->t_s);
        memcpy(m->sampled_u_ft, m->u_terms[0], ((size_t)m->mats + 2) * sizeof *m->sampled_u_ft);
        motion_evaluate(m, first, last, order, at_s, m->sampled_u_ft, NULL);
        sim_record_add(&run->record, run->record.next_record_s, m->sampled_u_ft,
                       m->speed_change_max);
    }
}

/* Finds the range of mats for a step: all moving mats, one more on either side, and mats whose
 * forces have changed; in the first step, all mats. */
static void find_step_window(const struct motion *m, int *first, int *last)
{
    int low = m->moving_low < m->changed_low ? m->moving_low : m->changed_low;
    int high = m->moving_high > m->changed_high ? m->moving_high : m->changed_high;
    *first = m->t_s == 0.0 || low <= 1 ? 1 : low > m->mats ? m->mats : low - 1;
    *last = m->t_s == 0.0 || high >= m->mats ? m->mats : high + 1;
    *last = *last < *first ? *first : *last;
}

/* Updates the force of the elastic ground after a step. */
static void update_ground_force(struct motion *m, struct mat_load *part)
{
    part->ground_force_lb += part->slope_lb_ft * m->u_terms[0][part->mat];
    if (part->axle_count > 0.0 && part->mode == GROUND_YIELDING)
        part->ground_force_lb = part->force_sign * motion_ground_limit_lb(m, part);
    if (part->axle_count > 0.0)
        m->friction_force_lb[part->mat] = part->ground_force_lb;
}

static void run_at_tolerance(struct motion *m, struct tolerance_run *run,
                             const struct sim_options *options)
{
    double begin_s = monotonic_s(), end_s = sim_scene_end_s(m->scene);
    int order = FIRST_ORDER, first, last;
    unsigned at_once = 0;
    double usual_s = end_s;
    motion_start(m);
    while (m->t_s < end_s && run->status == SIM_OK) {
        double until_s = m->break_times_s[m->next_break];
        motion_set_wheel_thrust(m);
        find_step_window(m, &first, &last);
        motion_expand_series(m, first, last, order);
        double allowed_s = motion_longest_step_s(m, first, last, order, run->tolerance);
        double wide_s = law_min(law_min(allowed_s, STEP_PER_SWITCH_TIME_MAX * usual_s),
                                until_s - m->t_s);
        struct event event = motion_first_event(m, first, last, order, wide_s);
        double h = event.h_s;
        bool over = event.mat + event.joint == 0 && h >= until_s - m->t_s;
        update_peak_tensions(m, first, last, order, h);
        if (run->record.next_record_s <= m->t_s + h || (over && until_s >= end_s))
            record_samples(m, run, first, last, order, h, over && until_s >= end_s);
        for (int i = 0; m->has_gear && i < m->load_count; i++)
            m->loads[i].ground_force_lb -= m->loads[i].slope_lb_ft * m->u_terms[0][m->loads[i].mat];
        motion_evaluate(m, first, last, order, h, m->u_terms[0], m->u_terms[1]);
        m->max_speed_ft_s = law_max(m->max_speed_ft_s,
                                    motion_largest_value(m->u_terms[1], first, last));
        if (m->t_s > 0.0 && last - first + 1 > run->active_mats_max)
            run->active_mats_max = last - first + 1;
        m->t_s = over ? until_s : m->t_s + h;
        run->step_count++;
        run->active_mat_time_s += h * (last - first + 1);
        run->longest_step_s = law_max(run->longest_step_s, h);
        usual_s = event.mat + event.joint == 0 ? law_max(2.0 * h, usual_s)
                : h > 0.0                      ? usual_s + 0.25 * (h - usual_s)
                                               : usual_s;
        at_once = h > 0.0 ? 0 : at_once + 1;
        m->changed_low = m->mats + 1;
        m->changed_high = 0;
        for (int i = 0; m->has_gear && i < m->load_count; i++)
            update_ground_force(m, &m->loads[i]);
        if (over && ++m->next_break < m->break_count)
            motion_set_wheel_action(m);
        else
            motion_apply_switch(m, &event);
        run->switch_count += event.mat + event.joint > 0;
        order += law_min(h, STEP_PER_SWITCH_TIME_MAX * usual_s) < 0.5 * allowed_s ? -1 : 1;
        order = order < MIN_ORDER             ? MIN_ORDER
              : order > POLYNOMIAL_DEGREE_MAX ? POLYNOMIAL_DEGREE_MAX
                                              : order;
        if (!isfinite(m->max_speed_ft_s) ||
            at_once > MAX_SWITCHES_AT_ONCE * (unsigned)(m->mats + 1) ||
            run->step_count > MAX_STEPS) {
            run->status = SIM_STEP_UNDERFLOW;
            run->failed_mat = event.mat ? event.mat : event.joint > m->mats ? m->mats : event.joint;
        } else if (run->step_count % STEPS_PER_CALLBACK == 0 && options->may_continue &&
                   !options->may_continue(options->may_continue_ctx, run->pass_number,
                                          m->t_s / end_s)) {
            run->status = SIM_INTERRUPTED;
            run->failed_mat = 1;
        }
    }
    run->run_ms = 1e3 * (monotonic_s() - begin_s);
}

static void start_run(struct tolerance_run *run, struct motion *m, double tolerance,
                      const struct sim_options *options, struct sim_result *result)
{
    *run = (struct tolerance_run){.tolerance = tolerance, .pass_number = ++result->pass_count};
    sim_record_make(&run->record, m->scene, options);
    run_at_tolerance(m, run, options);
    result->evaluations += run->step_count;
    result->other_steps += run->step_count;
}

static void fill_result(const struct motion *m, struct tolerance_run *run,
                        struct sim_result *result)
{
    result->dt_s = run->longest_step_s;
    result->pass_ms = run->run_ms;
    result->steps = run->step_count;
    result->other_steps -= run->step_count;
    result->events = run->switch_count;
    result->integrated_mats_max = run->active_mats_max;
    result->integrated_mats_mean = m->t_s > 0.0 ? run->active_mat_time_s / m->t_s : 0.0;
    if (result->status != SIM_OK && result->status != SIM_INTERRUPTED &&
        result->status != SIM_UNPREDICTABLE)
        return;
    result->speed_end_ft_s = motion_largest_value(m->u_terms[1], 1, m->mats);
    sim_record_move_chain_to_result(&run->record, m->u_terms[0], m->max_compression_lb,
                                    m->max_tension_lb, result);
    for (int j = 1; j <= m->mats + 1; j++)
        result->gap_ft[j] = motion_opening_ft(m, j);
}

/* Finds the first time at which the last run differs from another run by more than apart_ft. */
static struct sim_difference find_first_difference(const struct tolerance_run *runs, int count,
                                                   double apart_ft)
{
    const struct sim_record *last = &runs[count - 1].record;
    for (size_t k = 0; k < last->snapshot_count; k++) {
        for (int n = 1; n <= last->mats; n++) {
            for (int i = 0; i + 1 < count; i++) {
                const struct sim_snapshot *a = &runs[i].record.snapshots[k],
                                          *b = &last->snapshots[k];
                if (fabs(a->u_ft[n] - b->u_ft[n]) > apart_ft)
                    return (struct sim_difference){apart_ft, n, k > 0 ? a[-1].t_s : 0.0};
            }
        }
    }
    return (struct sim_difference){apart_ft, 1, 0.0};
}

enum mr_status chain_event_run(const struct sim_scene *scene, const struct sim_options *options,
                               struct sim_result *result, struct error *error)
{
    struct tolerance_run runs[3] = {0};
    static const double tolerances[] = {COARSE_TOLERANCE, FINE_TOLERANCE, FINEST_TOLERANCE};
    struct motion m;
    double begin_s = monotonic_s(), apart_ft = 0.0, peak_ft = 0.0;
    int count = 0;
    bool again = true;
    motion_make(&m, scene);
    result->solver = "event";
    result->mats = scene->mats;
    result->t_end_s = sim_scene_end_s(scene);
    while (again) {
        struct tolerance_run *run = &runs[count];
        double tolerance = options->is_single_pass && options->rtol > 0.0 ? options->rtol
                                                                          : tolerances[count];
        start_run(run, &m, tolerance, options, result);
        count++;
        peak_ft = sim_record_peak(&run->record).u_ft;
        for (int i = 0; run->status == SIM_OK && i + 1 < count; i++)
            apart_ft = law_max(apart_ft, sim_record_difference(&runs[i].record, &run->record).u_ft);
        again = run->status == SIM_OK && !options->is_single_pass &&
                (count == 1 ||
                 (count == 2 && apart_ft > THIRD_RUN_FACTOR * COARSE_TOLERANCE * peak_ft));
    }
    struct tolerance_run *last = &runs[count - 1];
    result->checked_dt_s = runs[0].longest_step_s;
    if (last->status != SIM_OK)
        sim_result_set_status(result, last->status, last->failed_mat, m.t_s);
    if (!options->is_single_pass)
        result->error_u_ft = ERROR_FACTOR * apart_ft + ERROR_FLOOR * peak_ft +
                             ERROR_FLOOR_LENGTH * scene->length_ft;
    double allowed_ft = (options->rtol > 0.0 ? options->rtol : MAX_DISAGREEMENT) * peak_ft;
    if (last->status == SIM_OK && ERROR_FACTOR * apart_ft > allowed_ft) {
        struct sim_difference first = find_first_difference(runs, count, allowed_ft / ERROR_FACTOR);
        result->diverging_run_count = count;
        sim_result_set_status(result, SIM_UNPREDICTABLE, first.mat, first.t_s);
    }
    fill_result(&m, last, result);
    for (int i = 0; i < 3; i++)
        sim_record_free(&runs[i].record);
    motion_free(&m);
    result->run_ms = 1e3 * (monotonic_s() - begin_s);
    return error->status;
}
