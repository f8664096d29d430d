/* Figures of the comparison of a landing with a simulation: differences of two series; the zones of
 * measurement, board and simulation; the table of the transducers; and how well measured and
 * simulated values agree. */
#ifndef MATRIG_HOST_COMPARE_FIGURES_H
#define MATRIG_HOST_COMPARE_FIGURES_H

#include "host/analyse/track.h"
#include "host/analyse/zones.h"
#include "host/store/store.h"

/* Comparison of two series of the same quantity, sample by sample: their difference, their
 * similarity, and whether their errors explain the difference. Pure functions.
 *
 * Values are in inches (or any one unit), times in seconds since touchdown; d = measured -
 * simulated; u: standard errors.
 *
 *     bias     mean of d
 *     rms      root mean square of d
 *     chi      root mean square of d / sqrt(u_m^2 + u_s^2) (rms_per_error): 1 if the errors explain
 *              all of d
 *     peak     extreme, by magnitude, of the mean over SIGNAL_MEAN_SAMPLES samples. Its time is
 *              when this mean first differs from the peak by at most SIGNAL_PEAK_TOLERANCE times
 *              the peak, or by five standard deviations of the noise if that is more: on a plateau,
 *              noise determines where the largest value is
 *     arrival  first time at which this mean crosses SIGNAL_ARRIVAL_FRACTION of its peak,
 *              interpolated linearly between two samples. Its error has three parts: noise and
 *              error of the value, divided by the slope there; alignment; sample spacing /
 *              sqrt(12). Not known if the threshold is below five standard deviations of the noise
 *     En       |difference| / (2 sqrt(u_m^2 + u_s^2)): up to 1 the two values agree
 *              (ISO 13528, coverage factor 2)
 *
 * NaN: a missing sample; in a result: not known. */
#define SIGNAL_MEAN_SAMPLES     11
#define SIGNAL_ARRIVAL_FRACTION 0.1
#define SIGNAL_PEAK_TOLERANCE   0.01

/* Two series. Sample i is at t0_s + i dt_s. The caller owns the arrays. */
struct signal {
    size_t count;
    double t0_s, dt_s;
    const double *measured, *simulated;
    /* standard error of each sample, from all sources */
    const double *measured_error, *simulated_error;
    const double *time_error_s; /* standard error of the alignment of the time axes, per sample */
    /* Standard deviation of a measured sample, independent between samples; included in
     * measured_error. */
    double noise_deviation;
};

struct signal_moment {
    double value, error;
    double t_s, t_error_s;
};

struct signal_figures {
    size_t compared_sample_count; /* number of samples that both series have */
    double bias, bias_error;
    double rms, rms_per_error;
    struct signal_moment peak_measured, peak_simulated;
    /* crossing of the threshold; value: the threshold */
    struct signal_moment arrival_measured, arrival_simulated;
};

void signal_compute_figures(const struct signal *signal, struct signal_figures *figures);

/* Computes En of two values. Returns NaN if a value is not known, INFINITY if the values differ
 * although their errors are 0. */
double signal_compute_en_score(double measured, double measured_error, double simulated,
                               double simulated_error);

/* Error of the measured wheel's times: the error of its station (host/analyse/track.h) divided by
 * its speed, limited to the error of the stop time. It is the uncertainty with which two movements
 * can be aligned, due to the timing of edges and the positions of switches. Times are in seconds
 * since touchdown. */
#define COMPARE_TIMING_POINTS 128
struct compare_timing {
    double stop_s, stop_error_s;
    /* errors at equal steps from touchdown to the stop */
    double error_s[COMPARE_TIMING_POINTS + 1];
};
void compare_timing_init(const struct measured_landing *measured, struct compare_timing *clock);
double compare_compute_time_error_s(const struct compare_timing *clock, double t_s);

/* Zones of closed mats at the same moment: measured (survey and transducers), reported by the
 * board, and simulated. The measured and the simulated zone are both found from the remaining slack
 * of segments of ten mats, with the same errors (host/analyse/zones.h). The zone that the board
 * reports has its own standard errors. Stations are in ft. */

enum compare_zone_source {
    COMPARE_MEASURED,
    COMPARE_BOARD,
    COMPARE_SIMULATED,
    COMPARE_SOURCE_COUNT
};

struct compare_zone {
    bool is_known; /* false: the zone was not measured, reported or simulated */
    double mats;   /* length of the zone; 0: no zone */
    double start_ft, end_ft, start_error_ft, end_error_ft;
};

struct compare_overlap {
    bool is_known;
    double common_mats, all_mats; /* length of the intersection and of the union */
    double share;                 /* common_mats / all_mats; 1 if both have no zone */
    double start_difference_ft,
        end_difference_ft; /* measured zone minus the other zone; NaN if either is missing */
};

/* The zones at the same moment. */
struct compare_zone_moment {
    const char *description; /* name of the moment: "longest measured", ... */
    double t_s, wheel_ft;
    struct compare_zone zone[COMPARE_SOURCE_COUNT];
    struct compare_overlap board_overlap, simulated_overlap; /* overlap with the measured zone */
};

/* largest number of moments: when the zone is longest, and when the mats are at rest */
#define COMPARE_MOMENT_COUNT 2u

struct compare_zones {
    size_t count; /* number of moments; 0: no moment is known */
    struct compare_zone_moment moment[COMPARE_MOMENT_COUNT];
};

/* Returns the moment at rest (`rest` true) or of the longest zone; NULL: not known. */
const struct compare_zone_moment *compare_find_moment(const struct compare_zones *zones, bool rest);
struct compare_overlap compare_compute_overlap(const struct compare_zone *measured,
                                               const struct compare_zone *other);

/* zones_find_longest_zone, with standard errors; an end at the wheel has none. */
struct compare_zone compare_find_closed_zone(const float *slack_in, const float *remaining_in,
                                             double wheel_ft);

/* The board's messages in order of time. `prediction` has the errors of the zones and may be
 * empty. */
struct compare_board_reports {
    const struct store_zone *zone;
    size_t zone_count;
    const struct store_prediction *prediction;
    size_t prediction_count;
};
/* Remaining openings of the simulated segments, one row every dt_s since touchdown: rows x
 * MR_SEGMENTS. Without rows the simulated zone is not known. */
struct compare_segment_openings {
    const float *remaining_in;
    size_t row_count;
    double dt_s;
};
void compare_find_zones(const struct measured_landing *measured, const struct zones_slack *survey,
                        const struct compare_board_reports *reports,
                        const struct compare_segment_openings *segments,
                        struct compare_zones *zones);

/* All figures of a landing's comparison. The measurement is compared with a simulation of the
 * measured motion, either just computed or the newest one in the campaign. `matrig compare` and the
 * report print this table.
 *
 * Errors are standard errors. Measured: noise, calibration and baseline (common/channels.h), and
 * alignment, which is the change of the simulated movement within the error of the wheel's time.
 * Simulated: the solver's estimate and the spread over an ensemble. Units are inches, feet, and
 * seconds since touchdown; NaN: not known. */

#define COMPARE_MIN_VALID_SHARE 0.5 /* share of the samples that must be valid */

struct compare_channel {
    int64_t number;
    double station_ft;
    bool is_compared;
    char reason_or_remark
        [100];          /* reason why the channel was not compared; otherwise a remark or "" */
    double valid_share; /* share of the samples that are valid */
    struct signal_figures figures;
    struct signal_moment end_measured, end_simulated; /* means over the last 0.2 s */
    double bias_en_score, peak_en_score, end_en_score, arrival_en_score;
};

struct compare_figures {
    int64_t run;
    char model_file[120]; /* name of the model's file; "": not stored */
    /* reason to doubt the measured numbers (measured_format_missing_start); "": none */
    char missing_start_text[MEASURED_MISSING_START_SIZE];
    /* texts of the landing's marks, from measured_quality_text */
    const char *marks;
    double simulation_ms, solver_error_in; /* duration of the simulation, and its error estimate */
    int64_t seed_count;
    size_t surveyed_segment_count; /* number of segments with known slack */
    size_t channel_count;          /* number of fitted transducers */
    struct compare_channel channel[MR_TRANSDUCERS];
    struct compare_zones zones;
    struct compare_timing timing;
};

/* Computes all figures. Simulation rows of channels that were not measured are ignored; a measured
 * channel without such a row is listed as not compared. */
void compare_compute_figures(const struct measured_landing *measured,
                             const struct zones_slack *survey,
                             const struct compare_board_reports *reports,
                             const struct store_simulation_summary *head,
                             const struct store_simulation *rows, size_t count,
                             struct compare_figures *figures);
/* Means over the compared channels, weighted by their number of samples. */
struct compare_channel_means {
    size_t channel_count;
    /* number of samples, and means; NaN: no channel was compared */
    double sample_count, bias_in, rms_in;
    double worst_rms_in, worst_peak_en_score; /* largest value of all channels */
};
struct compare_channel_means compare_compute_means(const struct compare_figures *figures);
/* The complete curves of a compared channel: arrays of measured->samples values, NaN where not
 * compared. The caller frees `storage`. */
struct compare_curves {
    double *storage, *t_s, *measured_in, *measured_error_in, *simulated_in, *simulated_error_in,
        *time_error_s, *alignment_error_in;
};
void compare_fill_curves(const struct measured_landing *measured,
                         const struct compare_timing *clock, const struct measured_channel *channel,
                         const struct store_simulation *row, double solver_error_in,
                         struct compare_curves *curves);

/* Agreement of measured and simulated values: peak, end and arrival of each compared transducer.
 * Two values agree if En, their difference divided by twice their common standard error, is at most
 * 1. */
struct compare_agreement {
    int64_t run;
    const char *model_file;
    /* number of values whose En is known, and number of those with En above 1 */
    size_t judged_value_count, differing_value_count;
    /* The value with the largest En, in inches (an arrival: in seconds). channel NULL: no En is
     * known. */
    const struct compare_channel *channel; /* the channel of that value; points into the figures */
    const char *value_name;                /* "peak", "end", "arrival" */
    bool is_time;
    double measured, simulated, en_score;
};
void compare_compute_agreement(const struct compare_figures *figures,
                               struct compare_agreement *agreement);
/* Writes the agreement as one sentence without newline. */
#define COMPARE_AGREEMENT_SIZE 400
void compare_write_agreement(const struct compare_agreement *agreement, bool si,
                             char out[COMPARE_AGREEMENT_SIZE]);

#endif
