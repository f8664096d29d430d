/* The gear's position at any time, from the gates alone, with the precision that they allow.
 *
 * The fit of gates.h is a polynomial of low order: it gives speeds, but between the gates changing
 * braking deviates from it by more than its error. Here, from the first gate beyond touchdown to
 * the last, the station is a parabola whose deceleration wanders: its derivative is white noise of
 * intensity q. Added to it are changes faster than the spacing of the gates, a ripple of the
 * station without memory. The gates, each in error by the switches' tolerance, determine the size
 * of both: a grid of both, weighted by restricted likelihood. For each of them the best linear
 * unbiased estimate of the station under that model (universal kriging; a smoothing spline of
 * degree five) runs through the gates as far as they are exact, and its standard error grows
 * between them as it must; what is given is their mean, with the variance within and between them.
 * On either side a cubic joins it to touchdown and stop, the error going over to theirs. Before
 * touchdown the speed is constant (report 2.4), back to the first edge; after the stop the gear
 * rests. Pure. */
#ifndef MATRIG_HOST_ANALYSE_TRACK_H
#define MATRIG_HOST_ANALYSE_TRACK_H

#include "host/analyse/measured.h"

#define TRACK_SIZE (MR_GATES_MAX + 3u) /* gates and parabola */

#define TRACK_MODELS 24u

struct track_moment {
    double t_s;
    struct mr_estimate station_ft;
    double speed_ft_s;
};

struct track {
    bool known;
    double begin_s; /* first edge, or touchdown: nothing is known before */
    struct track_moment touchdown, first, last, stop;
    double speed_error_ft_s;                            /* of the touchdown's */
    size_t points;                                      /* gates */
    double t_s[MR_GATES_MAX], station_ft[MR_GATES_MAX]; /* times since the first */
    double error_ft;                                    /* of each */
    size_t models;                                      /* the likeliest */
    struct track_model {
        double q;         /* (ft/s3)^2 s */
        double ripple_ft; /* standard deviation */
        double weight;
        double inverse[TRACK_SIZE][TRACK_SIZE];
    } model[TRACK_MODELS];
};

/* From a landing with a fit and three gates or more beyond touchdown; else it is not known. */
void track_make(const struct measured *measured, struct track *track);
/* Station of the lead wheel with its standard error; NaN where it is not known. */
struct mr_estimate track_at(const struct track *track, double t_s);

/* The film of a landing: which frame each pulse of the camera was, and where the gear stood on it.
 *
 * Frames are numbered from 1, the first pulse of the landing. A pulse that is not there - the
 * camera gave none, or it was lost with every link - leaves a gap in time: the next frame's number
 * is as much greater as mean periods fit into the gap, the period taken from the steps around it,
 * since a camera may run up or drift. */
struct film_frame {
    int64_t number;
    int64_t pulse; /* the board's own count of pulses */
    double board_us;
    double t_s;                    /* as measured.h counts it */
    struct mr_estimate station_ft; /* of the lead wheel, by its track; NaN: not known */
    struct mr_estimate speed_ft_s;
};

struct film {
    struct film_frame *frame;
    size_t frames;
    double rate_hz;  /* NaN: fewer than two frames */
    int64_t missing; /* frames without a pulse between the first and the last */
};

/* The caller releases it with film_free, also after an error. A landing without a camera has no
 * frames. */
enum mr_status film_load(struct store *store, const struct measured *measured, struct film *film,
                         struct error *error);
void film_free(struct film *film);

/* Frame numbers from pulse times that rise, microseconds. */
void film_number(const double *t_us, size_t count, int64_t *number);

#endif
