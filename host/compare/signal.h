/* Two series of the same quantity, sample by sample: how far apart, how alike, and whether their
 * errors explain it. Pure.
 *
 * Values in inches (or any one unit), times in seconds since touchdown; d = measured - simulated;
 * u: standard errors.
 *
 *     bias         mean of d
 *     rms          root mean square of d
 *     chi          root mean square of d / sqrt(u_m^2 + u_s^2): 1 when the errors explain all of it
 *     inside       share of samples with |d| <= 2 sqrt(u_m^2 + u_s^2)
 *     peak         extreme, by size, of the mean over SIGNAL_WINDOW samples; its time: when that
 *                  first comes within SIGNAL_NEAR of it, or five standard deviations of the noise
 *                  if that is more, and how long until it last is: on a plateau noise says where
 *                  the most is
 *     arrival      first time at which that mean crosses SIGNAL_ARRIVAL of its own peak, between
 *                  two samples by a straight line. Error: noise and error of the value over the
 *                  slope there; alignment; spacing of the samples / sqrt(12). Not known when the
 *                  threshold is below five standard deviations of the noise
 *     correlation  Pearson's. None of a flat series: one whose standard deviation is within twice
 *                  that of the noise
 *     En           |difference| / (2 sqrt(u_m^2 + u_s^2)): up to 1 the two agree (ISO 13528,
 *                  coverage factor 2)
 *
 * NaN: a sample that is missing; in a result: not known. */
#ifndef MATRIG_HOST_COMPARE_SIGNAL_H
#define MATRIG_HOST_COMPARE_SIGNAL_H

#include <stdbool.h>
#include <stddef.h>

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
    double lasts_s; /* of a peak */
};

struct signal_figures {
    size_t compared; /* samples that both have */
    double bias, bias_error;
    double rms, chi, inside;
    struct signal_moment peak_measured, peak_simulated;
    struct signal_moment arrival_measured, arrival_simulated; /* value: the threshold */
    double correlation;
    bool flat_measured, flat_simulated;
};

void signal_compare(const struct signal *signal, struct signal_figures *figures);

/* En of two values; NaN when either is not known; INFINITY when they differ without any error. */
double signal_en(double measured, double measured_error, double simulated, double simulated_error);

#endif
