/* The uncertainty budget of a reading, following the GUM (JCGM 100:2008). It lists each source with
 * its distribution, divisor, standard uncertainty u(x), sensitivity c and contribution c u(x) to
 * the reading. The combined uncertainty is the root sum square of the contributions, and the
 * expanded uncertainty is the combined uncertainty times a coverage factor.
 *
 * It has two parts. The first part is the stated error, which is printed with every reading. Each
 * of its contributions is mr_reading_error (common/channels.h) with all other sources removed, so
 * that the contributions add up to the stated error. It is the repeatability of the channel
 * relative to its calibration. The second part is the uncertainty of the calibration itself and of
 * the conditions of use, which the stated error leaves out: certificate, baseline, position,
 * temperature (docs/explanation/errors.md).
 *
 * Contributions are assumed independent (GUM 5.1.2), degrees of freedom infinite, and the sum
 * normal, except for the cell's temperature, which may dominate. The coverage factor is that of a
 * rectangular and a normal distribution combined; it is 1.96 without a rectangular contribution.
 * The uncertainty of the known values of `matrig calibrate` must be entered only once: with
 * --known, which includes it in the stated gain and zero, or in the certificate.
 *
 * Pure functions. Values are in in or lb. */
#ifndef MATRIG_HOST_CALIBRATE_BUDGET_H
#define MATRIG_HOST_CALIBRATE_BUDGET_H

#include <stdbool.h>

#include "common/channels.h"

enum budget_source {
    BUDGET_NOISE,
    BUDGET_ROUNDING,
    BUDGET_GAIN,
    BUDGET_ZERO,
    BUDGET_DRIFT,
    BUDGET_LINEARITY,
    BUDGET_REFERENCE,
    BUDGET_STATED_COUNT, /* the sources before this entry are part of the stated error */
    BUDGET_CERTIFICATE = BUDGET_STATED_COUNT,
    BUDGET_BASELINE,
    BUDGET_POSITION,
    BUDGET_TEMPERATURE,
    BUDGET_SOURCE_COUNT
};

#define BUDGET_COVERAGE_PROBABILITY 0.95

struct budget_case {
    const struct mr_channel_config *channel;
    struct mr_error_conditions reading;
    double certificate_expanded_uncertainty; /* at the reading; NaN: no certificate */
    double certificate_coverage_factor;
    double station_error_ft;         /* standard uncertainty of the station, ft */
    double slope_max_in_ft;          /* largest change of movement per distance along the mat */
    double temperature_half_range_k; /* half width of the temperature range, K */
};

struct budget_row {
    double input;                /* uncertainty of the source, in input_unit */
    double divisor;              /* divisor that belongs to the source's distribution */
    double standard_uncertainty; /* u(x): input divided by divisor */
    double sensitivity;          /* sensitivity coefficient c, in or lb per input_unit */
    /* contribution to the reading's standard error: c u(x), in inches or pounds */
    double contribution;
};

struct budget {
    struct budget_row row[BUDGET_SOURCE_COUNT];
    double stated_error; /* root sum square of the rows of the stated error: mr_reading_error */
    double combined_uncertainty; /* root sum square of all rows */
    double coverage_factor;
    double expanded_uncertainty;
};

void budget_compute(const struct budget_case *of, struct budget *budget);

/* The texts of these functions have static storage. */
const char *budget_source_name(enum budget_source source);  /* word for programs: "noise" */
const char *budget_source_label(enum budget_source source); /* name for people */
const char *budget_distribution(enum budget_source source);
/* Returns the unit of the input of a source for a transducer or else a gage: "codes", "1"
 * (relative), "ft", ... */
const char *budget_input_unit(enum budget_source source, bool transducer);

/* Returns the standard deviation of a block's mean in codes, computed from the data sheet of the
 * circuit's converter, for a channel whose noise was not measured. */
double budget_default_noise_codes(void);

#endif
