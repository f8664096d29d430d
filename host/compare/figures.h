/* A landing's comparison as figures, from what was measured and a simulation that was aligned with
 * it: a fresh one, or the newest one that the campaign keeps. The table of `matrig compare` and of
 * the report.
 *
 * Errors are standard errors. Measured: noise, calibration and baseline (common/measure.h) and
 * alignment, how far the simulated movement changes within the error of the wheel's time (align.h).
 * Simulated: the solver's own estimate and the spread over an ensemble. Inches, feet, seconds since
 * touchdown; NaN: not known. */
#ifndef MATRIG_HOST_COMPARE_FIGURES_H
#define MATRIG_HOST_COMPARE_FIGURES_H

#include "host/compare/align.h"
#include "host/compare/signal.h"
#include "host/compare/zones.h"

#define COMPARE_LEAST_VALID 0.5 /* share of the samples */

struct compare_channel {
    int64_t number;
    double station_ft;
    bool compared;
    char why[100]; /* not compared: why; else what is to be known of it, or empty */
    double valid;  /* share of the samples */
    struct signal_figures f;
    struct signal_moment end_measured, end_simulated; /* mean of the last 0.2 s */
    /* at arrival: how far the wheel was from the station, positive: before it */
    double ahead_measured_ft, ahead_simulated_ft;
    double bias_en, peak_en, end_en, arrival_en;
    double alignment_in; /* largest part of the measured error that is the alignment's */
};

struct compare_figures {
    int64_t run;
    char against[120]; /* file; empty: not kept */
    /* why the measured numbers are doubtful (host/analyse/doubts.h); "": they are not */
    char doubt[DOUBTS_TEXT];
    double run_ms, error_in; /* of the simulation, and its own estimate */
    int64_t seeds, edges;
    double offset_s, scatter_s;
    size_t surveyed; /* segments whose slack was known */
    size_t channels; /* fitted */
    struct compare_channel channel[MR_TRANSDUCERS];
    struct compare_zones zones;
};

/* Rows of channels that measured lacks are left out; a channel that is measured without a row is
 * there, not compared. MR_FULL. */
enum mr_status compare_figures(const struct measured *measured, const struct zones_closure *survey,
                               const struct compare_said *said,
                               const struct store_simulation_head *head,
                               const struct store_simulation *rows, size_t count,
                               struct compare_figures *figures, struct error *error);
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
enum mr_status compare_curves(const struct measured *measured, const struct compare_clock *clock,
                              const struct measured_channel *channel,
                              const struct store_simulation *row, double solver_error_in,
                              struct compare_curves *series, struct error *error);

#endif
