#include "host/sim/solvers/pass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"

#define FOLDED_MIN_DEG        85.0
/* In degrees. If the step is given and a mat turns by more than this in one step, the run is
 * reported as unstable, not as folded. */
#define STEP_TURN_MAX_DEG     30.0
#define FOUND_SWITCHES_MAX    64
#define ROOT_STEPS_MAX        100
#define INNER_PARTS           6
#define EVENT_ROUNDS_MAX      8
/* Number of consecutive events without progress, per mat, after which the run ends because its
 * switches chatter. */
#define STALLS_PER_MAT_MAX    20
/* Smallest step, as a fraction of the time since the start or of 1 s, whichever is larger. */
#define MIN_STEP_SHARE        1e-14
#define MIN_STEP_TIME_S       1.0
/* Time in a run after which the resolution of the clock matters. A moving point's position then has
 * an error of its speed times a few units of the resolution, which is coarse late in a run: at 1e9
 * s a double resolves 1e-7 s. */
#define CLOCK_ERROR_FROM_S    100.0 /* before this time the resolution of the clock is negligible */
#define CLOCK_ERROR_UNITS     4.0
#define REPEATED_STEPS        100
/* Two switches coincide if the times are closer than this fraction of the step. */
#define COINCIDENT_STEP_SHARE 1e-8
/* Tolerance of heights and displacements / (rtol times mat length). */
#define POSITION_TOLERANCE    0.0005
#define SPEED_TOLERANCE       0.25 /* tolerance of rates / (rtol times sqrt(g L)) */

struct pass {
    struct stepper stepper;
    struct model *model;
    struct pass_outcome *outcome;
    double *storage;
    double *z_event;
    double
        *z_searched; /* state at the end of the part of the last step that is searched for events */
    double until_s;
    double *u, *v, *height; /* displacement, speed and height of each mat, for the record */
    /* modes of contact, torsion and joint after the last step, if the stepper samples them */
    signed char *sampled_modes;
    unsigned *flip_counts; /* number of mode changes of each contact, torsion and joint */
    int stall_count;
    /* number of further steps that repeat_step_until repeats */
    int remaining_repeated_steps;
    struct model_switch last_flip; /* switch that caused the last event */
    double last_flip_s;
    double active_mat_time_s;
    double max_angle_deg; /* largest joint angle after the last step */
};

/* Reasons why a run makes no progress. */
#define REASON_STEP_TOO_SMALL "the step became too small"
#define REASON_SWITCHES_TOO_CLOSE \
    "events (contact, sticking, slipping) follow each other too closely"
#define REASON_STEPS_EXHAUSTED "the run reached its limit of steps"

static bool fail_pass(struct pass *p, enum sim_status status, int mat_from_1, double t_s)
{
    p->outcome->status = status;
    p->outcome->mat = mat_from_1;
    p->outcome->t_s = t_s;
    return false;
}

static bool fail_without_progress(struct pass *p, int mat_from_1, double t_s, const char *why)
{
    p->outcome->reason = why;
    return fail_pass(p, SIM_STEP_UNDERFLOW, mat_from_1, t_s);
}

/* Finds the fastest mat, or the first mat whose state is not finite. */
static int find_fastest_mat(const struct model *m, const double *z, double *speed)
{
    int mat = m->first_mat;
    *speed = 0.0;
    for (int n = m->first_mat; n <= m->last_mat; n++) {
        double v = z[m->coordinate_count + 2 * n + 1];
        if (!isfinite(v) || !isfinite(z[2 * n]) || !isfinite(z[m->coordinate_count + 2 * n]))
            return n + 1;
        double most = fmax(fabs(v), fabs(z[m->coordinate_count + 2 * n]));
        if (most > *speed) {
            *speed = most;
            mat = n;
        }
    }
    return mat + 1;
}

static void store_state(struct pass *p, double t_s, double *z)
{
    const struct model *m = p->model;
    struct sim_record *record = &p->outcome->record;
    model_fill_outside_window(m, z);
    for (int n = 0; n < m->mats; n++) {
        p->u[n + 1] = z[2 * n + 1];
        p->v[n + 1] = z[m->coordinate_count + 2 * n + 1];
        p->height[n + 1] = 0.0 - z[2 * n]; /* the subtraction avoids -0 */
    }
    record->height_ft = p->height;
    record->lift_ft = model_lift_ft(m, z, &record->lift_node);
    sim_record_add(record, t_s, p->u, p->v);
}

/* Records all outputs up to t_s, which is within the stepper's last step. */
static void store_state_until(struct pass *p, double t_s)
{
    struct stepper *s = &p->stepper;
    while (p->outcome->record.next_record_s <= t_s) {
        double at = p->outcome->record.next_record_s;
        stepper_copy(s, s->z, p->z_event);
        s->kind->interpolate(s, at, stepper_first_index(s), stepper_end_index(s), p->z_event);
        store_state(p, at, p->z_event);
    }
}

static double switch_margin(struct pass *p, double t_s, const double *z, struct model_switch which)
{
    if (p->stepper.kind->samples_shape_switches)
        model_sample_shape_modes(p->model, z);
    return model_margin(p->model, t_s, z, which);
}

/* Finds the first time in the last step at which the margin of a switch is negative. It must be
 * negative at the end of the step. */
static double find_switch_time(struct pass *p, struct model_switch which)
{
    struct stepper *s = &p->stepper;
    double *z = p->z_event;
    int low = stepper_first_index(s), high = stepper_end_index(s);
    if (!s->kind->samples_shape_switches)
        model_switch_range(p->model, which, &low, &high);
    double a = s->t_s, b = p->until_s, close = 1e-12 * (b - a);
    double at_a = switch_margin(p, a, s->z, which),
           at_b = switch_margin(p, b, p->z_searched, which);
    if (at_a < 0.0)
        return a;
    int side = 0;
    for (int i = 0; i < ROOT_STEPS_MAX && b - a > close; i++) {
        double share = at_a > 0.0 && i % 8 != 7 ? at_a / (at_a - at_b) : 0.5;
        double t = a + fmin(fmax(share, 1e-4), 0.9999) * (b - a);
        if (!(t > a && t < b))
            break;
        s->kind->interpolate(s, t, low, high, z);
        double value = switch_margin(p, t, z, which);
        if (value < 0.0) {
            b = t;
            at_b = value;
            if (side == -1)
                at_a *= 0.5;
            side = -1;
        } else {
            a = t;
            at_a = value;
            if (side == 1)
                at_b *= 0.5;
            side = 1;
        }
    }
    return b;
}

/* Keeps only the switches of mats that stop or start in the list. Returns their number. */
static int select_slide_switches(struct model_switch *found, int count)
{
    int kept = 0;
    for (int i = 0; i < count && i < FOUND_SWITCHES_MAX; i++) {
        if (found[i].kind == MODEL_SLIDE || found[i].kind == MODEL_STICK)
            found[kept++] = found[i];
    }
    return kept;
}

/* Searches for violations (negative margins) at five points between the start of the last step and
 * `to`, up to the first point that has one; the step is then searched up to this point. This finds
 * a mat that breaks loose and stops again within a step, or a foot that touches the ground and
 * leaves it again, which both passes could miss otherwise. */
static int find_violations_within_step(struct pass *p, double to, struct model_switch *found)
{
    struct stepper *s = &p->stepper;
    struct model *m = p->model;
    if (s->kind->samples_shape_switches || !s->kind->has_long_steps)
        return 0;
    for (int i = 1; i < INNER_PARTS; i++) {
        double t = s->t_s + (to - s->t_s) * i / INNER_PARTS;
        stepper_copy(s, s->z, p->z_event);
        s->kind->interpolate(s, t, stepper_first_index(s), stepper_end_index(s), p->z_event);
        int count = model_find_violations(m, t, p->z_event, found, FOUND_SWITCHES_MAX);
        if (p->remaining_repeated_steps > 0)
            count = select_slide_switches(found, count);
        if (count > 0) {
            stepper_copy(s, p->z_event, p->z_searched);
            p->until_s = t;
            return count;
        }
    }
    return 0;
}

/* Finds violations (negative margins) within the last step or at its end. */
static int find_violations(struct pass *p, struct model_switch *found)
{
    struct stepper *s = &p->stepper;
    struct model *m = p->model;
    bool may = !s->rate ||
               model_can_switch(m, s->t_s, s->z, s->rate, s->t_new_s, s->z_new, s->rate_new);
    int count = may ? find_violations_within_step(p, s->t_new_s, found) : 0;
    if (count > 0)
        return count;
    p->until_s = s->t_new_s;
    stepper_copy(s, s->z_new, p->z_searched);
    return model_find_violations(m, s->t_new_s, s->z_new, found, FOUND_SWITCHES_MAX);
}

/* Records the peak of a lift that is within the last step. */
static void record_lift_peak(struct pass *p, double end_s, const double *z_end, double *spare)
{
    struct stepper *s = &p->stepper;
    const struct model *m = p->model;
    int node, rate;
    double lift = model_lift_ft(m, z_end, &node);
    rate = m->coordinate_count + 2 * (node - 1);
    if (lift > p->outcome->max_lift_ft)
        p->outcome->max_lift_ft = lift;
    if (lift <= 0.0 || lift < 0.9 * p->outcome->max_lift_ft ||
        !(s->z[rate] < 0.0 && z_end[rate] > 0.0))
        return;
    double a = s->t_s, b = end_s;
    for (int i = 0; i < 40 && b - a > 1e-9 * (end_s - s->t_s); i++) {
        double middle = 0.5 * (a + b);
        s->kind->interpolate(s, middle, 2 * (node - 1), 2 * node - 1, spare);
        if (spare[rate] < 0.0)
            a = middle;
        else
            b = middle;
        p->outcome->max_lift_ft = fmax(p->outcome->max_lift_ft, -spare[2 * (node - 1)]);
    }
}

/* Repeats the last step up to the time `at` of an event. If the step is long compared with the
 * fastest rate, the dense output can be wrong although the state at the end is right (with strong
 * soil damping, a force of 80 lb became 0). It then causes false switches, which are reversed at
 * once. After such a reversal, the next REPEATED_STEPS steps are repeated too. Returns false if the
 * step failed. */
static bool repeat_step_until(struct pass *p, double at)
{
    struct stepper *s = &p->stepper;
    double h = s->h_s;
    uint64_t rejected = s->rejected_steps;
    s->h_s = at - s->t_s;
    if (!s->kind->advance(s, at))
        return false;
    if (s->rejected_steps == rejected)
        s->h_s = h;
    return true;
}

static bool is_flipping_back(const struct pass *p, double at, const struct model_switch *flips,
                             int count)
{
    bool same = false;
    for (int i = 0; i < count; i++)
        same = same || (flips[i].kind == p->last_flip.kind && flips[i].index == p->last_flip.index);
    return same && at - p->last_flip_s <= COINCIDENT_STEP_SHARE * p->stepper.h_s;
}

/* Returns a number that identifies a switch. Their sum over several switches does not depend on the
 * order of the switches. Uses the finalizer of splitmix64 (S. Vigna, public domain). */
static uint64_t switch_hash(struct model_switch flip)
{
    uint64_t x = ((uint64_t)flip.kind << 32) + (uint64_t)(flip.index + 1);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return x ^ (x >> 31);
}

/* Goes back to the first event of the last step, if there is one, and changes the modes. */
static bool handle_events(struct pass *p, bool *event)
{
    struct stepper *s = &p->stepper;
    struct model *m = p->model;
    struct model_switch found[FOUND_SWITCHES_MAX], together[FOUND_SWITCHES_MAX],
        chosen = {MODEL_CONTACT, 0};
    double when[FOUND_SWITCHES_MAX];
    int flips = 0;
    if (s->kind->samples_shape_switches)
        model_sample_shape_modes(m, s->z_new);
    int count = find_violations(p, found);
    double at = p->until_s;
    *event = count > 0;
    if (p->remaining_repeated_steps > 0)
        p->remaining_repeated_steps--;
    if (count == 0)
        return true;
    bool nearer = true; /* a new entry may be an event before or after until_s */
    for (int round = 0; round < EVENT_ROUNDS_MAX; round++) {
        double first = (double)INFINITY;
        for (int i = 0; i < count && i < FOUND_SWITCHES_MAX; i++) {
            when[i] = find_switch_time(p, found[i]);
            if (when[i] < first) {
                first = when[i];
                chosen = found[i];
            }
        }
        if (first >= at && !nearer)
            break;
        at = fmin(at, first);
        flips = 0;
        for (int i = 0; i < count && i < FOUND_SWITCHES_MAX; i++) {
            if (when[i] <= at + 1e-11 * (p->until_s - s->t_s))
                together[flips++] = found[i];
        }
        /* copied to detect a switch that changed and then changed back */
        struct model_switch before[FOUND_SWITCHES_MAX];
        int earlier = at > s->t_s ? find_violations_within_step(p, at, before) : 0;
        nearer = earlier > 0;
        if (nearer && round + 1 < EVENT_ROUNDS_MAX) {
            memcpy(found, before, sizeof found);
            count = earlier;
            at = p->until_s;
            continue;
        }
        stepper_copy(s, s->z, p->z_event);
        if (at > s->t_s)
            s->kind->interpolate(s, at, stepper_first_index(s), stepper_end_index(s), p->z_event);
        if (s->kind->samples_shape_switches)
            model_sample_shape_modes(m, p->z_event);
        count = model_find_violations(m, at, p->z_event, found, FOUND_SWITCHES_MAX);
        int others = 0;
        for (int i = 0; i < count && i < FOUND_SWITCHES_MAX; i++) {
            bool known = false;
            for (int k = 0; k < flips; k++)
                known = known ||
                        (found[i].kind == together[k].kind && found[i].index == together[k].index);
            if (!known)
                found[others++] = found[i];
        }
        count = others;
        if (count == 0)
            break;
    }
    if (is_flipping_back(p, at, together, flips))
        p->remaining_repeated_steps = REPEATED_STEPS;
    bool again = p->remaining_repeated_steps > 0 && s->kind->has_long_steps &&
                 at - s->t_s > s->min_step_s;
    if (again) {
        double speed;
        if (!repeat_step_until(p, at))
            return fail_without_progress(p, find_fastest_mat(m, s->z, &speed), s->t_s,
                                         REASON_STEP_TOO_SMALL);
        at = s->t_new_s;
        flips = model_find_violations(m, at, s->z_new, together, FOUND_SWITCHES_MAX);
        flips = flips < FOUND_SWITCHES_MAX ? flips : FOUND_SWITCHES_MAX;
        *event = flips > 0;
        if (!*event)
            return true;
    }
    if (at - s->t_s <= s->min_step_s) {
        if (++p->stall_count > STALLS_PER_MAT_MAX * m->mats + 200)
            return fail_without_progress(p, chosen.index < m->mats ? chosen.index + 1 : m->mats, at,
                                         REASON_SWITCHES_TOO_CLOSE);
    } else
        p->stall_count = 0;
    if (at > s->t_s)
        store_state_until(p, at);
    stepper_copy(s, again ? s->z_new : s->z, p->z_event);
    if (at > s->t_s && !again)
        s->kind->interpolate(s, at, stepper_first_index(s), stepper_end_index(s), p->z_event);
    record_lift_peak(p, at, p->z_event, p->z_searched);
    stepper_copy(s, p->z_event, s->z_new);
    s->t_new_s = at;
    for (int i = 0; i < flips; i++) {
        model_apply_switch(m, at, s->z_new, together[i]);
        p->outcome->switch_hash_sum += switch_hash(together[i]);
        if (together[i].kind <= MODEL_SLACK) {
            unsigned *flipped =
                &p->flip_counts[(int)together[i].kind * (m->mats + 1) + together[i].index];
            p->outcome->max_flips = ++*flipped > p->outcome->max_flips ? *flipped
                                                                       : p->outcome->max_flips;
        }
    }
    model_update_modes(m, at, s->z_new);
    p->last_flip = together[0];
    p->last_flip_s = at;
    p->outcome->events++;
    return true;
}

/* Stops, at the end of the step, mats that changed direction within it. For steppers that sample
 * switches. */
static bool stop_reversed_mats(struct pass *p)
{
    struct stepper *s = &p->stepper;
    bool any = false;
    if (p->model->friction_law != SIM_FRICTION_STICK)
        return false;
    for (int i = p->model->coordinate_count + stepper_first_index(s) + 1;
         i < p->model->coordinate_count + stepper_end_index(s); i += 2) {
        if (s->z[i] * s->z_new[i] < 0.0) {
            s->z_new[i] = 0.0;
            p->outcome->events++;
            any = true;
        }
    }
    return any;
}

/* Counts the sampled modes that the last step changed. */
static void count_sampled_changes(struct pass *p)
{
    const struct model *m = p->model;
    size_t length = (size_t)(m->slide_direction - m->contact);
    for (size_t i = 0; i < length; i++)
        p->outcome->sampled_change_count += m->contact[i] != p->sampled_modes[i];
    memcpy(p->sampled_modes, m->contact, length);
}

static bool advance_pass(struct pass *p, double limit_s)
{
    struct stepper *s = &p->stepper;
    struct model *m = p->model;
    double speed;
    int mat;
    bool event = false;
    if (!s->kind->advance(s, limit_s))
        return fail_without_progress(p, find_fastest_mat(m, s->z, &speed), s->t_s,
                                     REASON_STEP_TOO_SMALL);
    if (s->kind->samples_switches) {
        store_state_until(p, s->t_new_s);
        record_lift_peak(p, s->t_new_s, s->z_new, p->z_event);
        event = !s->kind->finds_stops_in_step && stop_reversed_mats(p);
        count_sampled_changes(p);
    } else {
        if (!handle_events(p, &event))
            return false;
        if (!event) {
            store_state_until(p, s->t_new_s);
            record_lift_peak(p, s->t_new_s, s->z_new, p->z_event);
        }
    }
    p->outcome->steps++;
    p->outcome->longest_step_s = fmax(p->outcome->longest_step_s, s->t_new_s - s->t_s);
    int live = m->last_mat - m->first_mat + 1;
    p->active_mat_time_s += live * (s->t_new_s - s->t_s);
    p->outcome->active_mats_max = live > p->outcome->active_mats_max ? live
                                                                     : p->outcome->active_mats_max;
    double *old = s->z;
    s->z = s->z_new;
    s->z_new = old;
    s->t_s = s->t_new_s;
    if (s->t_s > CLOCK_ERROR_FROM_S) {
        find_fastest_mat(m, s->z, &speed);
        p->outcome->clock_error_ft =
            fmax(p->outcome->clock_error_ft,
                 CLOCK_ERROR_UNITS * speed * (nextafter(s->t_s, HUGE_VAL) - s->t_s));
    }
    if (model_update_window(m, s->z)) {
        model_update_modes(m, s->t_s, s->z);
        event = true;
    }
    if (event)
        s->kind->restart(s);
    double angle = model_largest_angle_deg(m, s->z, &mat);
    if (!isfinite(angle) || !isfinite(s->z[m->coordinate_count + 2 * mat - 1]) ||
        !isfinite(s->z[2 * mat - 1]))
        return fail_pass(p, SIM_UNSTABLE, find_fastest_mat(m, s->z, &speed), s->t_s);
    if (angle > FOLDED_MIN_DEG)
        return fail_pass(p,
                         s->kind->has_fixed_step && angle - p->max_angle_deg > STEP_TURN_MAX_DEG
                             ? SIM_UNSTABLE
                             : SIM_FOLDED,
                         mat, s->t_s);
    p->max_angle_deg = angle;
    return true;
}

static bool can_pass_continue(const struct pass *p, const struct pass_request *request,
                              const struct sim_options *options)
{
    return !options->may_continue || p->outcome->steps % PASS_STEPS_PER_CALLBACK != 0 ||
           options->may_continue(options->may_continue_ctx, request->pass_number,
                                 p->stepper.t_s / sim_scene_end_s(p->model->scene));
}

static void run_spans(struct pass *p, const struct pass_request *request,
                      const struct sim_options *options)
{
    struct stepper *s = &p->stepper;
    struct model *m = p->model;
    double speed, end_s = sim_scene_end_s(m->scene);
    for (size_t i = 0; i < m->spans.count; i++) {
        double end = m->spans.spans[i].t1_s;
        model_enter_span(m, i, s->z);
        if (s->kind->has_fixed_step && request->first_step_factor > 0.0)
            s->dt_s = fmin(request->dt_s, request->first_step_factor * (end - s->t_s));
        s->kind->restart(s);
        while (s->t_s < end) {
            s->min_step_s = MIN_STEP_SHARE * fmin(end_s, fmax(MIN_STEP_TIME_S, s->t_s));
            if (!advance_pass(p, end))
                return;
            if (!can_pass_continue(p, request, options)) {
                fail_pass(p, SIM_INTERRUPTED, find_fastest_mat(m, s->z, &speed), s->t_s);
                return;
            }
            if (p->outcome->steps + s->rejected_steps > request->max_steps) {
                fail_without_progress(p, find_fastest_mat(m, s->z, &speed), s->t_s,
                                      REASON_STEPS_EXHAUSTED);
                return;
            }
        }
    }
    model_fill_outside_window(m, s->z);
    int mat = find_fastest_mat(m, s->z, &speed);
    for (int i = 0; i < 2 * m->coordinate_count; i++) {
        if (!isfinite(s->z[i])) {
            fail_pass(p, SIM_UNSTABLE, mat, s->t_s);
            return;
        }
    }
    p->outcome->speed_end_ft_s = speed;
}

void pass_run(struct pass_outcome *out, struct model *m, const struct pass_request *request,
              const struct sim_options *options)
{
    size_t length = 2 * (size_t)m->coordinate_count;
    double end_s = sim_scene_end_s(m->scene), begin_s = monotonic_s();
    struct pass p = {.model = m, .outcome = out};
    *out = (struct pass_outcome){0};
    p.storage = xcalloc(4 * length + 4 * ((size_t)m->mats + 1), sizeof *p.storage);
    out->end_z = xcalloc(length, sizeof *out->end_z);
    p.z_event = p.storage + 2 * length;
    p.z_searched = p.z_event + length;
    p.u = p.z_searched + length;
    p.v = p.u + m->mats + 1;
    p.height = p.v + m->mats + 1;
    p.sampled_modes = (signed char *)(p.height + m->mats + 1);
    p.flip_counts = xcalloc(3 * ((size_t)m->mats + 1), sizeof *p.flip_counts);
    const struct stepper_kind *kind = request->kind;
    if (kind->kind_for_loose_rtol && request->rtol >= kind->loose_rtol)
        kind = kind->kind_for_loose_rtol;
    p.stepper = (struct stepper){
        .kind = kind,
        .model = m,
        .rtol = request->rtol,
        .atol_ft = request->rtol * POSITION_TOLERANCE * m->length_ft,
        .atol_ft_s = request->rtol * SPEED_TOLERANCE * sqrt(m->scene->g_ft_s2 * m->length_ft),
        .dt_s = request->dt_s,
        .h_s = fmin(1e-5, 0.01 * end_s) *
               (kind->samples_switches && request->first_step_factor > 0.0
                    ? request->first_step_factor
                    : 1.0),
        .z = p.storage,
        .z_new = p.storage + length,
    };
    sim_record_make(&out->record, m->scene, options);
    stepper_make(&p.stepper);
    int node;
    m->evaluations = 0;
    m->can_omit_mats = request->kind->can_omit_mats && !options->integrates_all_mats;
    model_start(m, p.stepper.z);
    out->max_lift_ft = model_lift_ft(m, p.stepper.z, &node);
    if (out->record.next_record_s <= 0.0)
        store_state(&p, 0.0, p.stepper.z);
    run_spans(&p, request, options);
    model_fill_outside_window(m, p.stepper.z);
    memcpy(out->end_z, p.stepper.z, length * sizeof *out->end_z);
    out->evaluations = m->evaluations;
    out->rejected_steps = p.stepper.rejected_steps;
    out->active_mats_mean = p.stepper.t_s > 0.0 ? p.active_mat_time_s / p.stepper.t_s : m->mats;
    stepper_free(&p.stepper);
    out->ms = 1e3 * (monotonic_s() - begin_s);
    free(p.flip_counts);
    free(p.storage);
}

void pass_outcome_free(struct pass_outcome *out)
{
    sim_record_free(&out->record);
    free(out->end_z);
    out->end_z = NULL;
}

/* ---- outcome of a run ---- */

#define BOW_WAVE_MIN_FT 0.05

double pass_bow_threshold_ft(const struct sim_scene *scene)
{
    double bump = 0.0;
    for (size_t i = 0; i < scene->bump_ft.count; i++)
        bump = fmax(bump, scene->bump_ft.values[i]);
    return fmax(BOW_WAVE_MIN_FT, 2.0 * bump);
}

static void fill_final_shape(const struct model *m, const double *z, struct sim_result *result)
{
    for (int n = 1; n <= m->mats; n++)
        result->u_ft[n] = z[2 * n - 1];
    double left = 0.0;
    for (int j = 1; j <= m->mats + 1; j++) {
        double right = j <= m->mats ? result->u_ft[j] : 0.0;
        double shortened = 0.0;
        if (m->has_full_profile) {
            for (int n = j - 1; n <= j; n++) {
                bool there = n >= 1 && n <= m->mats;
                double tilt = there && m->tilt_ft ? m->tilt_ft[n - 1] / m->length_ft : 0.0;
                double s = there ? (z[2 * n] - z[2 * n - 2]) / m->length_ft + tilt : 0.0;
                shortened += m->half_ft * (sqrt(1.0 - tilt * tilt) - sqrt(1.0 - s * s));
            }
        }
        result->gap_ft[j] = sim_scene_joint_value(&m->scene->gap0_ft, j) + right - left + shortened;
        left = right;
    }
}

void pass_fill_outputs(const struct model *m, const double *z, struct sim_record *record,
                       double max_lift_ft, double speed_end_ft_s, struct sim_result *result)
{
    size_t mats = (size_t)m->mats;
    if (result->status != SIM_OK && result->status != SIM_INTERRUPTED &&
        result->status != SIM_UNPREDICTABLE)
        return;
    struct sim_difference peak = sim_record_peak(record);
    result->peak_u_ft = peak.u_ft;
    result->peak_mat = peak.mat;
    result->speed_end_ft_s = speed_end_ft_s;
    result->max_lift_ft = max_lift_ft;
    result->bow_wave = max_lift_ft > pass_bow_threshold_ft(m->scene);
    result->u_ft = xcalloc(mats + 1, sizeof *result->u_ft);
    result->gap_ft = xcalloc(mats + 2, sizeof *result->gap_ft);
    fill_final_shape(m, z, result);
    sim_record_move_to_result(record, result);
}

void pass_fill_result(const struct model *m, struct pass_outcome *pass,
                      const struct pass_outcome *other, struct sim_result *result)
{
    result->pass_ms = pass->ms;
    result->steps = pass->steps;
    result->events = pass->events;
    result->dt_s = pass->longest_step_s;
    result->checked_dt_s = other->longest_step_s;
    result->integrated_mats_max = pass->active_mats_max;
    result->integrated_mats_mean = pass->active_mats_mean;
    pass_fill_outputs(m, pass->end_z, &pass->record, pass->max_lift_ft, pass->speed_end_ft_s,
                      result);
}

/* ---- difference of two passes ---- */

struct pass_difference pass_compare(const struct pass_outcome *a, const struct pass_outcome *b)
{
    return (struct pass_difference){sim_record_difference(&a->record, &b->record),
                                    fmax(sim_record_lift_difference(&a->record, &b->record),
                                         fabs(a->max_lift_ft - b->max_lift_ft))};
}

bool passes_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                  const struct pass_outcome *b, struct pass_difference apart)
{
    double threshold = pass_bow_threshold_ft(scene);
    double peak = fmin(sim_record_peak(&a->record).u_ft, sim_record_peak(&b->record).u_ft);
    double lift = fmin(a->max_lift_ft, b->max_lift_ft);
    return apart.u.u_ft <= PASS_DISAGREEMENT_MAX * peak + 1e-9 * scene->length_ft &&
           apart.lift_ft <= PASS_DISAGREEMENT_MAX * lift + 0.01 * threshold &&
           (a->max_lift_ft > threshold) == (b->max_lift_ft > threshold);
}

/* ---- runs that diverge ---- */

void pass_find_divergence(struct sim_result *result, const struct sim_record *given,
                          const struct sim_record *other, double limit_u_ft, double limit_lift_ft)
{
    bool parted = false;
    result->error_u_ft = fmax(result->error_u_ft, sim_record_difference(given, other).u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, sim_record_lift_difference(given, other));
    for (size_t i = 0; i < given->snapshot_count && !parted; i++) {
        const struct sim_snapshot *a = &given->snapshots[i], *b = &other->snapshots[i];
        double apart_ft = 0.0;
        int mat = 1;
        for (int n = 1; n <= given->mats; n++) {
            if (fabs(a->u_ft[n] - b->u_ft[n]) > apart_ft) {
                apart_ft = fabs(a->u_ft[n] - b->u_ft[n]);
                mat = n;
            }
        }
        parted = apart_ft > limit_u_ft || fabs(a->lift_ft - b->lift_ft) > limit_lift_ft;
        if (parted && (result->status != SIM_UNPREDICTABLE || a->t_s < result->t_s))
            sim_result_set_status(result, SIM_UNPREDICTABLE, mat, a->t_s);
    }
    /* if the runs are not apart yet, only the lift differs between the two times */
    if (!parted && result->status != SIM_UNPREDICTABLE)
        sim_result_set_status(result, SIM_UNPREDICTABLE, 1, given->end_s);
}
