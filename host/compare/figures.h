/* A landing's comparison in numbers: two series, the zones of both sides, the table of each
 * transducer, and whether they agree. */
#ifndef MATRIG_HOST_COMPARE_FIGURES_H
#define MATRIG_HOST_COMPARE_FIGURES_H

#include "host/analyse/track.h"
#include "host/analyse/zones.h"
#include "host/store/store.h"

/* Two series of the same quantity, sample by sample: how far apart, how alike, and whether their
 * errors explain it. Pure.
 *
 * Values in inches (or any one unit), times in seconds since touchdown; d = measured - simulated;
 * u: standard errors.
 *
 *     bias         mean of d
 *     rms          root mean square of d
 *     chi          root mean square of d / sqrt(u_m^2 + u_s^2): 1 when the errors explain all of it
 *     peak         extreme, by size, of the mean over SIGNAL_WINDOW samples; its time: when that
 *                  first comes within SIGNAL_NEAR of it, or five standard deviations of the noise
 *                  if that is more: on a plateau noise says where the most is
 *     arrival      first time at which that mean crosses SIGNAL_ARRIVAL of its own peak, between
 *                  two samples by a straight line. Error: noise and error of the value over the
 *                  slope there; alignment; spacing of the samples / sqrt(12). Not known when the
 *                  threshold is below five standard deviations of the noise
 *     En           |difference| / (2 sqrt(u_m^2 + u_s^2)): up to 1 the two agree (ISO 13528,
 *                  coverage factor 2)
 *
 * NaN: a sample that is missing; in a result: not known. */
#define SIGNAL_WINDOW  11
#define SIGNAL_ARRIVAL 0.1
#define SIGNAL_NEAR    0.01

/* Sample i is at t0_s + i dt_s. Arrays are the caller's. */
struct signal {
    size_t count;
    double t0_s, dt_s;
    const double *measured, *simulated;
    const double *measured_error, *simulated_error; /* of a sample: all there is */
    const double *time_error_s;                     /* of the alignment */
    /* of a measured sample, independent of the next; part of measured_error */
    double noise;
};

struct signal_moment {
    double value, error;
    double t_s, t_error_s;
};

struct signal_figures {
    size_t compared; /* samples that both have */
    double bias, bias_error;
    double rms, chi;
    struct signal_moment peak_measured, peak_simulated;
    struct signal_moment arrival_measured, arrival_simulated; /* value: the threshold */
};

void signal_compare(const struct signal *signal, struct signal_figures *figures);

/* En of two values; NaN when either is not known; INFINITY when they differ without any error. */
double signal_en(double measured, double measured_error, double simulated, double simulated_error);

/* How well the measured wheel's times are known: the error of its station (host/analyse/track.h)
 * over its speed, at most that of the stop. This is what the timing of edges and the places of
 * switches leave uncertain when two movements are laid over each other. Times in seconds since
 * touchdown. */
#define COMPARE_CLOCK_POINTS 128
struct compare_clock {
    double stop_s, stop_error_s;
    double error_s[COMPARE_CLOCK_POINTS + 1]; /* evenly from touchdown to the stop */
};
void compare_clock_make(const struct measured *measured, struct compare_clock *clock);
double compare_time_error(const struct compare_clock *clock, double t_s);

/* Zones of closed mats as measured (survey and transducers, common/closure.h), as the board said,
 * and as simulated, at the same moment.
 *
 * A simulated segment of ten mats counts as closed when its joints, added up, are open by less than
 * MR_CLOSURE_OPEN_IN: the measure by which the measured one does. Both therefore begin and end at
 * segments, 2.86 ft apart, or at the wheel; an end is good to a segment / sqrt(12). The board's own
 * statement comes with standard errors. Stations in ft. */

enum compare_zone_source { COMPARE_MEASURED, COMPARE_BOARD, COMPARE_SIMULATED, COMPARE_SOURCES };

struct compare_zone {
    bool known;  /* false: nobody said */
    double mats; /* 0: none */
    double start_ft, end_ft, start_error_ft, end_error_ft;
};

struct compare_overlap {
    bool known;
    double common_mats, all_mats; /* intersection and union */
    double share;                 /* common / all; 1 when neither has a zone */
    double start_ft, end_ft;      /* measured - the other; NaN when either has none */
};

/* One moment. */
struct compare_zone_moment {
    const char *what; /* "longest measured", ... */
    double t_s, wheel_ft;
    struct compare_zone zone[COMPARE_SOURCES];
    struct compare_overlap board, simulated; /* each against the measured */
};

#define COMPARE_MOMENTS 2u /* where the zone is at its longest, and at rest */

struct compare_zones {
    size_t count; /* 0: no moment */
    struct compare_zone_moment moment[COMPARE_MOMENTS];
};

/* The moment at rest, or the other one; NULL: there is none. */
const struct compare_zone_moment *compare_moment_of(const struct compare_zones *zones, bool rest);
struct compare_overlap compare_overlap_of(const struct compare_zone *measured,
                                          const struct compare_zone *other);

/* Longest run of segments with less than MR_CLOSURE_OPEN_IN left whose end is ahead of the wheel;
 * one that the wheel is in begins there. */
struct compare_zone compare_closed_run(const float *remaining_in, double wheel_ft);

/* What the board said, in order of time; predictions (their errors) may be none. */
struct compare_said {
    const struct store_zone *zone;
    size_t zones;
    const struct store_prediction *prediction;
    size_t predictions;
};
/* What is left of the simulated segments every dt_s since touchdown: rows x MR_SEGMENTS. None: no
 * simulated zone is known. */
struct compare_segments {
    const float *remaining_in;
    size_t rows;
    double dt_s;
};
void compare_zones(const struct measured *measured, const struct zones_closure *survey,
                   const struct compare_said *said, const struct compare_segments *segments,
                   struct compare_zones *zones);

/* A landing's comparison as figures, from what was measured and a simulation along its motion: a
 * fresh one, or the newest one that the campaign keeps. The table of `matrig compare` and of
 * the report.
 *
 * Errors are standard errors. Measured: noise, calibration and baseline (common/channels.h) and
 * alignment, how far the simulated movement changes within the error of the wheel's time.
 * Simulated: the solver's own estimate and the spread over an ensemble. Inches, feet, seconds since
 * touchdown; NaN: not known. */

#define COMPARE_LEAST_VALID 0.5 /* share of the samples */

struct compare_channel {
    int64_t number;
    double station_ft;
    bool compared;
    char why[100]; /* not compared: why; else what is to be known of it, or empty */
    double valid;  /* share of the samples */
    struct signal_figures f;
    struct signal_moment end_measured, end_simulated; /* mean of the last 0.2 s */
    double bias_en, peak_en, end_en, arrival_en;
};

struct compare_figures {
    int64_t run;
    char against[120]; /* file; empty: not kept */
    /* why the measured numbers are doubtful (measured_torn_text); "": they are not */
    char torn[MEASURED_TORN_TEXT];
    const char *marks;       /* measured_marks */
    double run_ms, error_in; /* of the simulation, and its own estimate */
    int64_t seeds;
    size_t surveyed; /* segments whose slack was known */
    size_t channels; /* fitted */
    struct compare_channel channel[MR_TRANSDUCERS];
    struct compare_zones zones;
    struct compare_clock clock;
};

/* Rows of channels that measured lacks are left out; a channel that is measured without a row is
 * there, not compared. */
void compare_figures(const struct measured *measured, const struct zones_closure *survey,
                     const struct compare_said *said, const struct store_simulation_head *head,
                     const struct store_simulation *rows, size_t count,
                     struct compare_figures *figures);
/* Over the channels that were compared, weighted by their samples. */
struct compare_mean {
    size_t channels;
    double samples, bias_in, rms_in; /* NaN: no channel */
    double worst_rms_in, peak_en;    /* of any */
};
struct compare_mean compare_mean_of(const struct compare_figures *figures);
/* The channel in full, as it was compared: arrays of measured->samples, NaN where not compared. The
 * caller frees `storage`. */
struct compare_curves {
    double *storage, *t_s, *measured_in, *measured_error_in, *simulated_in, *simulated_error_in,
        *time_error_s, *alignment_in;
};
void compare_curves(const struct measured *measured, const struct compare_clock *clock,
                    const struct measured_channel *channel, const struct store_simulation *row,
                    double solver_error_in, struct compare_curves *curves);

/* Whether measured and simulated agree, by the peak, the end and the arrival of each transducer
 * that was compared: two values agree while En, their difference over twice their common standard
 * error (signal.h), is at most 1. */
struct compare_agreement {
    int64_t run;
    const char *against;
    size_t judged, differ; /* values whose En is known; of them beyond 1 */
    /* The value with the largest En, in inches, of an arrival in seconds; channel NULL: none is
     * known. */
    const struct compare_channel *channel; /* of the figures */
    const char *value;                     /* "peak", "end", "arrival" */
    bool is_time;
    double measured, simulated, en;
};
void compare_agreement(const struct compare_figures *figures, struct compare_agreement *agreement);
/* In one sentence, without an end of line. */
#define COMPARE_SENTENCE 400
void compare_sentence(const struct compare_agreement *agreement, bool si,
                      char out[COMPARE_SENTENCE]);

#endif
