/* The gear's motion at any time, computed from the gates only, with standard errors.
 *
 * A polynomial through all gates does not follow a braking that changes: of its deceleration, 95 %
 * intervals held in 47 to 74 % of drawn landings (tests/host/test_track.c). The model here, from
 * the first gate beyond touchdown to the last, is a parabola whose deceleration varies randomly:
 * its derivative is white noise of intensity q. A ripple is added to the station for changes faster
 * than the gate spacing; ripple values at different times are independent. The intensity q and the
 * size of the ripple are determined from the gates, whose errors are the switches' tolerance: pairs
 * of the two on a grid are weighted by their restricted likelihood. For each pair, the best linear
 * unbiased estimate (universal kriging; a smoothing spline of degree five) runs through the gates
 * within their errors, and its standard error grows between them. The result is the weighted mean
 * over the pairs, with the variance within and between them. Speed and deceleration are the
 * derivatives of the same estimate.
 *
 * Cubics connect the estimate to touchdown and stop at both ends, where its error changes gradually
 * to theirs. Before touchdown the speed is assumed constant, back to the first edge; after the
 * stop the gear is at rest. Pure functions. */
#ifndef MATRIG_HOST_ANALYSE_TRACK_H
#define MATRIG_HOST_ANALYSE_TRACK_H

#include "host/analyse/measured.h"

#define TRACK_MATRIX_SIZE (MR_GATES_MAX + 3u) /* gates and the 3 terms of the parabola */

#define TRACK_MODELS_MAX 24u

struct track_moment {
    double t_s;
    struct mr_estimate station_ft, speed_ft_s;
};

struct track {
    double start_s; /* time from which on the station is known: first edge, or touchdown */
    struct track_moment touchdown, first_gate, last_gate, stop;
    double brake_error_ft_s;          /* standard error of the speed while the deceleration rises */
    double stopping_speed_error_ft_s; /* standard error of the speed just before the stop */
    /* false: fewer than three gates beyond touchdown; a cubic connects touchdown and stop */
    bool has_gates;
    size_t gate_count;                                  /* number of gates beyond touchdown */
    double t_s[MR_GATES_MAX], station_ft[MR_GATES_MAX]; /* times are relative to the first gate */
    double gate_error_ft;                               /* standard error of each gate station */
    size_t model_count;                                 /* the models with the largest weights */
    struct track_model {
        double intensity;           /* intensity of the white noise, (ft/s3)^2 s */
        double ripple_deviation_ft; /* standard deviation of the ripple */
        double weight;
        double inverse[TRACK_MATRIX_SIZE][TRACK_MATRIX_SIZE];
        double factor_ft[TRACK_MATRIX_SIZE]; /* the inverse times the stations */
    } model[TRACK_MODELS_MAX];
};

/* Makes the track from a landing with a summary whose times count from touchdown. */
void track_make(const struct measured_landing *measured, struct track *track);
/* Returns the station of the lead wheel; NaN where it is not known. */
double track_station_ft(const struct track *track, double t_s);
/* Station and speed of the lead wheel with their standard errors; NaN where they are not known. The
 * speed is without the ripple. Without `has_gates` only the value of the speed is known. */
struct mr_estimate track_compute_station(const struct track *track, double t_s);
struct mr_estimate track_compute_speed(const struct track *track, double t_s);
/* Returns the deceleration without the ripple, in ft/s2, with its standard error; NaN outside the
 * first gate beyond touchdown and the last gate. */
struct mr_estimate track_compute_deceleration(const struct track *track, double t_s);
/* Returns the station of a gate (index below gate_count) minus its prediction from the other gates,
 * with the standard error of this difference. Requires TRACK_RESIDUAL_GATES_MIN gates. */
#define TRACK_RESIDUAL_GATES_MIN 4u
struct mr_estimate track_compute_residual_ft(const struct track *track, size_t gate);

/* The film of a landing: the frame number of each camera pulse, and the gear position in that
 * frame.
 *
 * Frames are numbered from 1, the first pulse of the landing. A missing pulse (not sent by the
 * camera, or lost on every link) leaves a gap in time. The next frame number is then increased by
 * the number of mean periods that fit into the gap. The period is taken from the steps around the
 * gap, because the rate of a camera may rise at first or drift. */
struct film_frame {
    int64_t number;
    int64_t board_pulse_count; /* the board's own count of pulses */
    double board_us;
    double t_s;                    /* time since touchdown, as in measured.h */
    struct mr_estimate station_ft; /* station of the lead wheel, from its track; NaN: not known */
    struct mr_estimate speed_ft_s;
};

struct film {
    struct film_frame *frame;
    size_t frame_count;
    double rate_hz;              /* mean frame rate; NaN: fewer than two frames */
    int64_t missing_frame_count; /* number of missing pulses between the first and the last frame */
};

/* The caller releases the film with film_free, also after an error. A landing without a camera has
 * no frames. */
enum mr_status film_load(struct store *store, const struct measured_landing *measured,
                         struct film *film, struct error *error);
void film_free(struct film *film);

/* Computes frame numbers from ascending pulse times in microseconds. */
void film_compute_frame_numbers(const double *t_us, size_t count, int64_t *number);

#endif
