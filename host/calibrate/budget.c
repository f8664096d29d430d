#include "host/calibrate/budget.h"

#include <math.h>

#include "common/block.h"
#include "common/channels.h"

#define PER_MILLION       1e-6
#define INTEGRATION_STEPS 400 /* number of integration steps over a rectangular distribution */

/* values of the reference circuits that this file uses */
static const struct circuit_values {
#define FIGURE(name, value, unit, block, text) double name;
#include "hil/circuits/figures.def"
} circuit = {
#define FIGURE(name, value, unit, block, text) .name = value,
#include "hil/circuits/figures.def"
};

static const struct uncertainty_source {
    const char *name, *text, *distribution, *transducer_unit, *gage_unit;
} sources[BUDGET_SOURCE_COUNT] = {
    [BUDGET_NOISE] = {"noise", "converter and amplifier: noise", "normal (type A)", "codes",
                      "codes"},
    [BUDGET_ROUNDING] = {"rounding", "converter: rounding to codes", "rectangular", "codes",
                         "codes"},
    [BUDGET_GAIN] = {"gain", "gain: sensor, amplifier, excitation", "normal", "1", "1"},
    [BUDGET_ZERO] = {"zero", "zero", "normal", "in", "lb"},
    [BUDGET_DRIFT] = {"drift", "zero drift: sensor, amplifier", "normal", "in per h", "lb per h"},
    [BUDGET_LINEARITY] = {"linearity", "calibration: residual at the reading", "normal", "in",
                          "lb"},
    [BUDGET_REFERENCE] = {"reference", "reference", "normal", "1", "1"},
    [BUDGET_CERTIFICATE] = {"certificate", "certificate of the sensor", "normal", "in", "lb"},
    [BUDGET_BASELINE] = {"baseline", "calibration: residual at the start", "normal", "in", "lb"},
    [BUDGET_POSITION] = {"position", "position: station of the sensor", "normal", "ft", "ft"},
    [BUDGET_TEMPERATURE] = {"temperature", "temperature: change since calibration", "rectangular",
                            "K", "K"},
};

const char *budget_source_name(enum budget_source source)
{
    return sources[source].name;
}

const char *budget_source_label(enum budget_source source)
{
    return sources[source].text;
}

const char *budget_distribution(enum budget_source source)
{
    return sources[source].distribution;
}

const char *budget_input_unit(enum budget_source source, bool transducer)
{
    return transducer ? sources[source].transducer_unit : sources[source].gage_unit;
}

double budget_default_noise_codes(void)
{
    return circuit.adc_noise_lsb / sqrt((double)MR_SCANS_PER_BLOCK);
}

/* Returns the stated error if `source` is its only source. A gain of 0 has no rounding error. */
static double compute_single_source_error(const struct budget_case *of, enum budget_source source)
{
    struct mr_channel_config channel = {.low = of->channel->low, .high = of->channel->high};
    struct mr_error_conditions reading = of->reading;
    float step = of->channel->unit_per_code;
    reading.noise = reading.reference_error = 0.0f;
    switch (source) {
    case BUDGET_NOISE: reading.noise = of->reading.noise; break;
    case BUDGET_ROUNDING:
        if (!(fabsf(of->reading.noise) < MR_QUANTISATION_NOISE_CODES * fabsf(step)))
            return 0.0; /* with noise, averaging removes the rounding error */
        channel.unit_per_code = step;
        break;
    case BUDGET_GAIN: channel.gain_error = of->channel->gain_error; break;
    case BUDGET_ZERO: channel.zero_error = of->channel->zero_error; break;
    case BUDGET_DRIFT: channel.drift_error_per_h = of->channel->drift_error_per_h; break;
    case BUDGET_LINEARITY: channel.linearity_error = of->channel->linearity_error; break;
    default: /* without a baseline, an error of the reference also changes the zero */
        reading.reference_error = of->reading.reference_error;
        if (!(reading.baseline_blocks > 0.0f))
            reading.value += of->channel->zero_code * step;
        break;
    }
    return (double)mr_reading_error(&channel, &reading);
}

static double get_input_uncertainty(const struct budget_case *of, enum budget_source source)
{
    const struct mr_channel_config *channel = of->channel;
    switch (source) {
    case BUDGET_NOISE: return fabs((double)(of->reading.noise / channel->unit_per_code));
    case BUDGET_ROUNDING: return 0.5;
    case BUDGET_GAIN: return (double)channel->gain_error;
    case BUDGET_ZERO: return (double)channel->zero_error;
    case BUDGET_DRIFT: return (double)channel->drift_error_per_h;
    case BUDGET_LINEARITY:
    case BUDGET_BASELINE: return (double)channel->linearity_error;
    case BUDGET_REFERENCE: return (double)of->reading.reference_error;
    case BUDGET_CERTIFICATE:
        return isnan(of->certificate_expanded_uncertainty) ? 0.0
                                                           : of->certificate_expanded_uncertainty;
    case BUDGET_POSITION: return of->station_error_ft;
    default: return of->temperature_half_range_k;
    }
}

static double get_divisor(const struct budget_case *of, enum budget_source source)
{
    if (source == BUDGET_CERTIFICATE)
        return isnan(of->certificate_expanded_uncertainty) ? 1.0 : of->certificate_coverage_factor;
    return source == BUDGET_ROUNDING || source == BUDGET_TEMPERATURE ? sqrt(3.0) : 1.0;
}

/* Returns the drift in in or lb per kelvin, beyond the part that the stated error includes. */
static double compute_drift_per_kelvin(const struct budget_case *of, const struct budget *budget,
                                       double kelvin)
{
    const struct mr_channel_config *channel = of->channel;
    if (channel->kind == MR_KIND_DISPLACEMENT)
        return channel->calibrated_day
                 ? circuit.transducer_cell_ppm_k * PER_MILLION * fabs((double)of->reading.value)
                 : 0.0;
    double drift = circuit.gage_drift_lb_k * kelvin,
           had = hypot(budget->row[BUDGET_DRIFT].contribution,
                       budget->row[BUDGET_ZERO].contribution);
    return kelvin > 0.0 && drift > had ? sqrt(drift * drift - had * had) / kelvin : 0.0;
}

static double get_sensitivity(const struct budget_case *of, const struct budget *budget,
                              enum budget_source source)
{
    bool movement = of->reading.baseline_blocks > 0.0f;
    switch (source) {
    case BUDGET_CERTIFICATE: return 1.0;
    case BUDGET_BASELINE:
        return movement && of->channel->points < 2 ? budget->row[BUDGET_LINEARITY].sensitivity
                                                   : 0.0;
    case BUDGET_POSITION:
        return of->channel->kind == MR_KIND_DISPLACEMENT ? of->slope_max_in_ft : 0.0;
    default: return compute_drift_per_kelvin(of, budget, budget->row[source].standard_uncertainty);
    }
}

/* Returns the probability of an error within `k` standard uncertainties. `wide`: half width of the
 * rectangular part, `narrow`: standard deviation of the normal part, both in standard
 * uncertainties. */
static double compute_coverage_probability(double k, double wide, double narrow)
{
    double sum = 0.0;
    for (int i = 0; i < INTEGRATION_STEPS; i++) {
        double off = wide * (2.0 * (i + 0.5) / INTEGRATION_STEPS - 1.0);
        sum += 0.5 *
               (erf((k - off) / (narrow * sqrt(2.0))) + erf((k + off) / (narrow * sqrt(2.0))));
    }
    return sum / INTEGRATION_STEPS;
}

static double find_coverage_factor(const struct budget *budget, bool rectangular)
{
    double share = 0.0, low = 0.0, high = 5.0;
    if (rectangular && budget->combined_uncertainty > 0.0)
        share = budget->row[BUDGET_TEMPERATURE].contribution / budget->combined_uncertainty;
    double wide = sqrt(3.0) * share, narrow = sqrt(fmax(1.0 - share * share, 1e-4));
    for (int i = 0; i < 40; i++) {
        double middle = 0.5 * (low + high);
        *(compute_coverage_probability(middle, wide, narrow) < BUDGET_COVERAGE_PROBABILITY
              ? &low
              : &high) = middle;
    }
    return 0.5 * (low + high);
}

void budget_compute(const struct budget_case *of, struct budget *budget)
{
    double variance = 0.0;
    for (enum budget_source s = 0; s < BUDGET_SOURCE_COUNT; s++) {
        struct budget_row *row = &budget->row[s];
        row->input = get_input_uncertainty(of, s);
        row->divisor = get_divisor(of, s);
        row->standard_uncertainty = row->input / row->divisor;
        if (s < BUDGET_STATED_COUNT) {
            row->contribution = compute_single_source_error(of, s);
            row->sensitivity = row->standard_uncertainty > 0.0
                                 ? row->contribution / row->standard_uncertainty
                                 : 0.0;
        } else {
            row->sensitivity = get_sensitivity(of, budget, s);
            row->contribution = row->sensitivity * row->standard_uncertainty;
        }
        variance += row->contribution * row->contribution;
        if (s == BUDGET_STATED_COUNT - 1)
            budget->stated_error = sqrt(variance);
    }
    budget->combined_uncertainty = sqrt(variance);
    budget->coverage_factor = find_coverage_factor(budget,
                                                   of->channel->kind == MR_KIND_DISPLACEMENT);
    budget->expanded_uncertainty = budget->coverage_factor * budget->combined_uncertainty;
}
