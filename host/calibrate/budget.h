/* The uncertainty budget of a reading, in the manner of the GUM (JCGM 100:2008): each contribution
 * with its distribution, divisor, standard uncertainty u(x), sensitivity c and what c u(x) it
 * brings to the reading; their root sum square; and the expanded uncertainty, that times a coverage
 * factor.
 *
 * It has two parts. The first is the stated error of a reading, which stands beside every reading:
 * each of its contributions is mr_reading_error (common/channels.h) with all others taken away, so
 * that the part adds up to it. It is the repeatability of the channel against its calibration. The
 * second is the uncertainty of the calibration itself and of the place of use, which the stated
 * error leaves out: certificate, baseline, position, temperature (docs/explanation/errors.md, "What
 * a calibration leaves out").
 *
 * Contributions are taken as independent (GUM 5.1.2), degrees of freedom as infinite, the sum as
 * normal, except for the cell's temperature, which may dominate: the coverage factor is that of a
 * rectangular and a normal distribution together, 1.96 where there is nothing of the former. The
 * uncertainty of the known values of `matrig calibrate` belongs into one place: --known, which
 * brings it into the stated gain and zero, or the certificate.
 *
 * Pure. In or lb. */
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
    BUDGET_STATED, /* those before it are the stated error's */
    BUDGET_CERTIFICATE = BUDGET_STATED,
    BUDGET_BASELINE,
    BUDGET_POSITION,
    BUDGET_TEMPERATURE,
    BUDGET_SOURCES
};

#define BUDGET_HELD 0.95

struct budget_case {
    const struct mr_channel_config *channel;
    struct mr_error_case reading;
    double certificate; /* expanded uncertainty at the reading; NaN: no certificate */
    double certificate_factor;
    double station_error_ft; /* standard */
    double steepest_in_ft;   /* movement along the mat */
    double kelvin;           /* half width */
};

struct budget_row {
    double input;        /* what is known of the source, in input_unit */
    double divisor;      /* of its distribution */
    double standard;     /* u(x): input over divisor */
    double sensitivity;  /* c: in or lb, a input_unit */
    double contribution; /* c u(x), in or lb */
};

struct budget {
    struct budget_row row[BUDGET_SOURCES];
    double stated;   /* root sum square of the stated error's rows: mr_reading_error */
    double combined; /* of all */
    double factor;   /* so many of it hold with BUDGET_HELD */
    double expanded;
};

void budget_make(const struct budget_case *of, struct budget *budget);

/* Static storage. */
const char *budget_source_name(enum budget_source source); /* "noise": of programs */
const char *budget_source_text(enum budget_source source); /* for people */
const char *budget_distribution(enum budget_source source);
/* "codes", "1" (relative), "ft", ...; of a transducer, else of a gage. */
const char *budget_input_unit(enum budget_source source, bool transducer);

/* Standard deviation of a block's mean, codes, by the circuits' converter: of a channel of which
 * none was measured. */
double budget_noise_codes(void);

#endif
