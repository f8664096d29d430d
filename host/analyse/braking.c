#include "host/analyse/braking.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

#define G_FT_S2                 32.174
#define TICKS_PER_US            84.0
#define LOCK_MIN_PULSES         5.0
/* periods from the last pulse to the lock: mean and standard error */
#define LOCK_DELAY_PULSES       1.2071
#define LOCK_DELAY_ERROR_PULSES 0.6969
/* standard error of the fraction of a pulse, which is uniform from 0 to 1 */
#define PULSE_FRACTION_ERROR    0.288675
/* Error of the onset / error of the touchdown. With this factor, 80, 97 and 100 of 100 simulated
 * landings are within 1, 2 and 3 such errors; it was chosen after seeing them. */
#define ONSET_ERROR_FACTOR      1.5

struct pulse {
    double count, t_s;
};

/* Time of a capture. It is computed from the number of ticks since a switch edge, whose time is
 * exact. The tick counter wraps; of the possible times, the one nearest to the millisecond of the
 * message is used. */
static double compute_capture_time_s(const struct store_braking_edge *row,
                                     const struct store_edge *edge,
                                     const struct measured_landing *measured)
{
    double near_ticks = ((double)row->board_us - edge->board_us) * TICKS_PER_US;
    int64_t expected = llround(fmax(-1e15, fmin(1e15, near_ticks)));
    int32_t beyond = (int32_t)((uint32_t)row->tick - (uint32_t)edge->tick - (uint32_t)expected);
    return (edge->board_us + (double)(expected + beyond) / TICKS_PER_US - (double)measured->t0_us) /
           1e6;
}

/* Number of pulses up to a time between the first and the last pulse, interpolated. */
static double interpolate_pulse_count(const struct pulse *pulse, size_t count, double t_s)
{
    size_t i = 1;
    while (i < count - 1 && pulse[i].t_s < t_s)
        i++;
    const struct pulse *a = &pulse[i - 1], *b = &pulse[i];
    return a->count + (t_s - a->t_s) / (b->t_s - a->t_s) * (b->count - a->count);
}

static struct mr_estimate compute_distance_ft(const struct track *track, double from_s, double to_s)
{
    struct mr_estimate from = track_compute_station(track, from_s),
                       to = track_compute_station(track, to_s);
    return (struct mr_estimate){to.value - from.value, hypot(from.error, to.error)};
}

static void compute_slip(const struct track *track, const struct mr_site_config *site,
                         double per_pulse_ft, const struct pulse *pulse, size_t count,
                         struct braking *braking)
{
    double from_s = braking->has_brake_edge ? fmax(braking->brake_onset_s.value, 0.0) : 0.0;
    double radius_ft = (double)site->wheel_radius_ft;
    bool covered = pulse[0].t_s <= from_s;
    double first = covered ? interpolate_pulse_count(pulse, count, from_s) : pulse[0].count - 0.5;
    struct mr_estimate way = compute_distance_ft(track, from_s, track->stop.t_s);
    double rolled = pulse[count - 1].count + 0.5 - first, ratio = rolled * per_pulse_ft / way.value,
           part = hypot(PULSE_FRACTION_ERROR, covered ? 0.0 : PULSE_FRACTION_ERROR);
    braking->slip.value = 1.0 - ratio;
    braking->slip.error =
        hypot(ratio * hypot((double)site->wheel_radius_error_ft / radius_ft, way.error / way.value),
              part * per_pulse_ft / way.value);
}

/* Returns the time from pulse `i` to the next row, limited to that of a wheel that is about to
 * lock. */
static double estimate_pulse_duration_s(const struct pulse *pulse, size_t count, size_t i,
                                        double limit_s)
{
    bool known = i + 1 < count && pulse[i + 1].count == pulse[i].count + 1.0;
    return known ? fmin(pulse[i + 1].t_s - pulse[i].t_s, limit_s) : limit_s / LOCK_MIN_PULSES;
}

/* Finds the locks of the wheel. Each lasts from a pulse to the next one or to the stop. */
static void find_wheel_locks(const struct track *track, double per_pulse_ft,
                             const struct pulse *pulse, size_t count, struct braking *braking)
{
    braking->locked_duration_s = (struct mr_estimate){0.0, 0.0};
    for (size_t i = 0; i < count && pulse[i].t_s < track->stop.t_s; i++) {
        bool last = i + 1 == count;
        double from_s = pulse[i].t_s, to_s = last ? track->stop.t_s : pulse[i + 1].t_s;
        double way = compute_distance_ft(track, from_s, to_s).value;
        if (from_s < 0.0 || !(way >= LOCK_MIN_PULSES * per_pulse_ft) ||
            (!last && pulse[i + 1].count > pulse[i].count + 1.0))
            continue;
        double limit_s = LOCK_MIN_PULSES * per_pulse_ft * (to_s - from_s) / way;
        double before_s = i ? estimate_pulse_duration_s(pulse, count, i - 1, limit_s)
                            : limit_s / LOCK_MIN_PULSES,
               after_s = estimate_pulse_duration_s(pulse, count, i + 1, limit_s);
        struct wheel_lock lock = {
            {from_s + LOCK_DELAY_PULSES * before_s, LOCK_DELAY_ERROR_PULSES * before_s},
            {to_s - LOCK_DELAY_PULSES * after_s, LOCK_DELAY_ERROR_PULSES * after_s},
        };
        if (last)
            lock.to_s = (struct mr_estimate){to_s, braking->brake_onset_s.error};
        braking->locked_duration_s.value += lock.to_s.value - lock.from_s.value;
        braking->locked_duration_s.error = hypot(braking->locked_duration_s.error,
                                                 hypot(lock.to_s.error, lock.from_s.error));
        if (braking->lock_count < BRAKING_LOCKS_MAX)
            braking->lock[braking->lock_count] = lock;
        braking->lock_count++;
    }
}

/* Computes the mean deceleration from the brake's edge to the stop, and the thrust due to it. The
 * fit assumes braking from touchdown on; the loss of speed before the edge is therefore taken as
 * uniform between 0 and the loss according to the fit. */
static void compute_thrust(const struct measured_landing *measured, double thrust_lb_per_g,
                           struct braking *braking)
{
    const struct mr_gates_summary *summary = &measured->summary;
    struct mr_estimate speed_ft_s, *a = &braking->deceleration_ft_s2;
    double from_s = fmax(braking->brake_onset_s.value, 0.0),
           took_s = summary->stop_t_s.value - from_s;
    double fitted_ft_s = measured_speed_ft_s(measured, from_s, &speed_ft_s.error),
           fall_ft_s = summary->touchdown_speed_ft_s.value - fitted_ft_s;
    speed_ft_s.value = fitted_ft_s + 0.5 * fall_ft_s;
    speed_ft_s.error = hypot(speed_ft_s.error, fall_ft_s / sqrt(12.0));
    if (!(took_s > 0.0) || !(speed_ft_s.value > 0.0))
        return;
    a->value = speed_ft_s.value / took_s;
    a->error = a->value *
               hypot(speed_ft_s.error / speed_ft_s.value,
                     hypot(summary->stop_t_s.error, braking->brake_onset_s.error) / took_s);
    braking->thrust_lb.value = thrust_lb_per_g * a->value / G_FT_S2;
    braking->thrust_lb.error = braking->thrust_lb.value *
                               hypot(BRAKING_THRUST_SHARE_ERROR, a->error / a->value);
}

/* Separates the rows into the edge of the brake and the pulses up to the stop. */
static size_t extract_pulses(const struct store_braking_edge *row, size_t rows,
                             const struct store_edge *edge, const struct measured_landing *measured,
                             struct pulse *pulse, struct braking *braking)
{
    size_t count = 0;
    for (size_t i = 0; i < rows; i++) {
        double t_s = compute_capture_time_s(&row[i], edge, measured);
        if (row[i].number == 0) {
            /* use the first edge after the first switch; if there is none, the last edge before
             * it */
            if (braking->has_brake_edge && braking->brake_onset_s.value >= measured->gate[0].t_s)
                continue;
            braking->has_brake_edge = true;
            braking->brake_onset_s = (struct mr_estimate){
                t_s, ONSET_ERROR_FACTOR * measured->summary.touchdown_t_s.error};
        } else if (count == 0 || t_s > pulse[count - 1].t_s) {
            braking->pulse_count++;
            if (t_s <= measured->summary.stop_t_s.value)
                pulse[count++] = (struct pulse){(double)row[i].number, t_s};
        }
    }
    return count;
}

static void compute_braking(const struct measured_landing *measured, double thrust_lb_per_g,
                            const struct pulse *pulse, size_t count, struct braking *braking)
{
    const struct mr_site_config *site = &measured->site;
    double per_pulse_ft = 2.0 * M_PI * (double)site->wheel_radius_ft / site->wheel_pulses;
    const struct track *track = measured->track;
    if (!track || !track->has_gates)
        return;
    if (braking->has_brake_edge)
        compute_thrust(measured, thrust_lb_per_g, braking);
    if (count < 2 || !site->wheel_pulses)
        return;
    compute_slip(track, site, per_pulse_ft, pulse, count, braking);
    find_wheel_locks(track, per_pulse_ft, pulse, count, braking);
}

enum mr_status braking_load(struct store *store, const struct measured_landing *measured,
                            struct braking *braking, struct error *error)
{
    const struct mr_estimate unknown = {(double)NAN, (double)NAN};
    struct store_braking_edge *row = NULL;
    struct store_edge *edge = NULL;
    struct mr_predictor_config predictor;
    size_t rows = 0, edges = 0, items = 0, i = 0;
    int64_t run = measured->landing.id;
    *braking = (struct braking){.brake_onset_s = unknown,
                                .slip = unknown,
                                .locked_duration_s = unknown,
                                .deceleration_ft_s2 = unknown,
                                .thrust_lb = unknown};
    enum mr_status status = store_braking_edges_get(store, run, &row, &rows, error);
    if (status == MR_OK && rows)
        status = store_edges_get(store, run, &edge, &edges, error)
                   ?: store_predict_config_get(store, run, &predictor, &items, error);
    while (i < edges && isnan(edge[i].board_us))
        i++;
    if (status == MR_OK && i < edges && measured->fit_status == MR_OK &&
        measured->is_t0_touchdown) {
        struct pulse *pulse = xcalloc(rows, sizeof *pulse);
        size_t count = extract_pulses(row, rows, &edge[i], measured, pulse, braking);
        bool known = items == (size_t)MR_PREDICT_ITEM_COUNT;
        compute_braking(measured, known ? (double)predictor.thrust_lb_per_g : (double)NAN, pulse,
                        count, braking);
        free(pulse);
    }
    free(row);
    free(edge);
    return status;
}

static void add_time(struct answer *answer, const char *name, const char *label,
                     struct mr_estimate t_s, int decimals)
{
    answer_add_estimate(answer, name, label, UNIT_TIME, t_s.value, t_s.error, decimals);
}

void braking_to_answer(const struct braking *braking, struct answer *answer)
{
    if (!braking->has_brake_edge && !braking->pulse_count)
        return;
    answer_open_group(answer, "braking", "");
    if (braking->has_brake_edge)
        add_time(answer, "onset", "brake applied", braking->brake_onset_s, 4);
    answer_add_count(answer, "pulses", NULL, (int64_t)braking->pulse_count);
    if (!isnan(braking->slip.value)) {
        answer_add_estimate(answer, "slip", "slip of the wheel", UNIT_NUMBER, braking->slip.value,
                            braking->slip.error, 3);
        add_time(answer, "locked", "wheel locked", braking->locked_duration_s, 3);
        answer_open_table(answer, "locks", braking->lock_count ? "wheel locked" : NULL);
        for (size_t i = 0; i < braking->lock_count && i < BRAKING_LOCKS_MAX; i++) {
            answer_open_row(answer);
            add_time(answer, "from", "from", braking->lock[i].from_s, 3);
            add_time(answer, "to", "to", braking->lock[i].to_s, 3);
        }
        answer_close_group(answer);
    }
    if (braking->has_brake_edge) {
        answer_add_estimate(answer, "deceleration", "braked", UNIT_DECELERATION,
                            braking->deceleration_ft_s2.value, braking->deceleration_ft_s2.error,
                            3);
        answer_add_estimate(answer, "thrust", "thrust on the strip", UNIT_TENSION,
                            braking->thrust_lb.value, braking->thrust_lb.error, 1);
    }
    answer_close_group(answer);
}
