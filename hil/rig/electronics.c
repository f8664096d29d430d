#include "hil/rig/electronics.h"

#include <math.h>

#include "common/emulated.h"
#include "hil/core/state.h"
#include "hil/periph/adc.h"
#include "hil/periph/options.h"

#define ROOM_C               20.0
#define SECONDS_PER_HOUR     3600.0
#define TWO_PI               6.28318530717958647693
#define CODE_COUNT           4096.0
/* Largest errors of the sensors, from the data sheets in firmware/config.c. */
#define CELL_GAIN_REL        0.005 /* electrolytic transducer, 0.5 % */
#define CELL_ZERO_IN         0.010 /* the zero is set by hand */
#define GAGE_FACTOR_REL      0.005
#define MID_V                1.65 /* nominal values of hil/rig/rig.h */
#define GAGE_V_PER_LB        0.005
#define SHUNT_LB             40.0
#define STAIRCASE_ZERO_CODES (HIL_STAIRCASE_ZERO_V * CODE_COUNT / HIL_NOMINAL_VDDA_V)
_Static_assert(HIL_RUN_COLUMNS + 2u <= HIL_ADC_SOURCES, "each channel has a source");

unsigned hil_switch_step_codes(unsigned position)
{
    return 64u + 8u * (7u * (position - 1u) % 24u);
}

void hil_circuit_figures_set_reference(struct hil_circuit_figures *figures)
{
#define FIGURE(name, value, unit, block, text) .name = value,
    *figures = (struct hil_circuit_figures){
#include "hil/circuits/figures.def"
    };
}

/* Returns a number that is uniform between -most and most. */
static double draw_uniform(uint64_t *random, double most)
{
    return most * (2.0 * mr_splitmix64_uniform(random) - 1.0);
}

/* Draws from a normal distribution (Box and Muller); the second value is not used. */
static double draw_normal(uint64_t *random, double sd)
{
    double u = 1.0 - mr_splitmix64_uniform(random), v = mr_splitmix64_uniform(random);
    return sd * sqrt(-2.0 * log(u)) * cos(TWO_PI * v);
}

static uint64_t convert_us_to_ps(double us)
{
    return (uint64_t)(us * (double)HIL_PS_PER_US);
}

double hil_electronics_trimmed_zero_lb(double untrimmed_lb, double range_lb, double residual_lb)
{
    double beyond = fabs(untrimmed_lb) - range_lb;
    return residual_lb + (beyond > 0.0 ? copysign(beyond, untrimmed_lb) : 0.0);
}

static void make_ideal(struct hil_electronics *e, const struct hil_options *options)
{
    bool known = !isnan(options->temperature_c);
    *e = (struct hil_electronics){
        .vdda_v = options->vdda_v > 0.0 ? options->vdda_v : options->type->supply_v,
        .reference_ratio = 1.0,
        .reference_reading_ratio = 1.0,
        .temperature_rise_k = known ? options->temperature_c - ROOM_C : 0.0,
        .temperature_rise_k_per_s = known ? options->temperature_c_per_h / SECONDS_PER_HOUR : 0.0,
        .transducer_tau_s = 4e-6,
        .staircase_zero_ratio = 1.0,
        .staircase_tau_s = 20e-6,
        .one_shot_pulse_ps = HIL_ONE_SHOT_PULSE_PS,
        .is_lamp_detected = true,
    };
    for (unsigned i = 0; i < HIL_RUN_TRANSDUCERS; i++)
        e->transducer_gain[i] = 1.0;
    for (unsigned i = 0; i < HIL_RUN_GAGES; i++)
        e->gage_gain[i] = e->gage_shunt_ratio[i] = 1.0;
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        e->step_codes[i] = hil_switch_step_codes(i + 1u);
}

static void draw_transducer_tolerances(struct hil_electronics *e,
                                       const struct hil_circuit_figures *f, uint64_t *random)
{
    /* this factor is common to all transducers of a board */
    double drive = 1.0 + draw_normal(random, f->transducer_excitation_sd_rel);
    double mid_v = f->transducer_mid_v - MID_V + draw_normal(random, f->transducer_mid_supply_sd_v);
    e->transducer_tau_s = f->transducer_settle_us * 1e-6;
    e->transducer_gain_per_k = f->transducer_cell_ppm_k * 1e-6;
    for (unsigned i = 0; i < HIL_RUN_TRANSDUCERS; i++) {
        e->transducer_gain[i] = drive * (1.0 + draw_normal(random, f->transducer_gain_sd_rel)) *
                                (1.0 + draw_uniform(random, CELL_GAIN_REL));
        e->transducer_zero_in[i] = draw_uniform(random, CELL_ZERO_IN);
        e->transducer_mid_v[i] = mid_v + draw_normal(random, f->transducer_mid_sd_v);
    }
}

static void draw_gage_tolerances(struct hil_electronics *e, const struct hil_circuit_figures *f,
                                 uint64_t *random)
{
    double excitation = (1.0 + draw_normal(random, f->gage_excitation_sd_rel)) * f->gage_v_per_lb /
                        GAGE_V_PER_LB;
    e->gage_tau_s = 1.0 / (TWO_PI * f->gage_corner_hz);
    for (unsigned i = 0; i < HIL_RUN_GAGES; i++) {
        e->gage_gain[i] = excitation * (1.0 + draw_normal(random, f->gage_gain_sd_rel)) *
                          (1.0 + draw_uniform(random, GAGE_FACTOR_REL));
        e->gage_untrimmed_lb[i] = draw_normal(random, f->gage_zero_sd_lb);
        e->gage_zero_lb[i] =
            hil_electronics_trimmed_zero_lb(e->gage_untrimmed_lb[i], f->gage_trim_range_lb,
                                            draw_normal(random, f->gage_trim_residual_lb));
        e->gage_drift_lb_k[i] = draw_normal(random, f->gage_drift_lb_k);
        e->gage_shunt_ratio[i] = f->gage_shunt_lb / SHUNT_LB +
                                 draw_normal(random, f->gage_shunt_error_rel);
    }
}

static void draw_sensor_tolerances(struct hil_electronics *e, const struct hil_circuit_figures *f,
                                   uint64_t *random)
{
    e->reference_ratio = 1.0 + draw_uniform(random, f->reference_error_rel);
    e->reference_reading_ratio = 1.0 + draw_normal(random, f->reference_read_sd_rel);
    e->reference_drift_per_k = draw_uniform(random, f->reference_drift_ppm_k * 1e-6);
    draw_transducer_tolerances(e, f, random);
    draw_gage_tolerances(e, f, random);
}

/* Resistors connect each switch, the supply (for the zero) and ground to one node. The contribution
 * of each is its conductance divided by the sum of all conductances, whichever switches are
 * open. */
static void draw_staircase_tolerances(struct hil_electronics *e,
                                      const struct hil_circuit_figures *f, uint64_t *random)
{
    double part[HIL_RUN_SWITCHES], rest = CODE_COUNT - STAIRCASE_ZERO_CODES, all = 0.0;
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        rest -= e->step_codes[i];
        part[i] = e->step_codes[i] * (1.0 + draw_uniform(random, f->staircase_resistor_tol_rel));
        all += part[i];
    }
    double zero = STAIRCASE_ZERO_CODES *
                  (1.0 + draw_uniform(random, f->staircase_resistor_tol_rel));
    all += zero + rest * (1.0 + draw_uniform(random, f->staircase_resistor_tol_rel));
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        e->step_codes[i] = part[i] * CODE_COUNT / all;
    e->staircase_zero_ratio = zero * CODE_COUNT / all / STAIRCASE_ZERO_CODES;
    e->staircase_tau_s = f->staircase_settle_us * 1e-6;
}

static void draw_output_tolerances(struct hil_electronics *e, const struct hil_circuit_figures *f,
                                   uint64_t *random)
{
    double width_us = f->one_shot_min_us +
                      mr_splitmix64_uniform(random) * (f->one_shot_max_us - f->one_shot_min_us);
    e->one_shot_pulse_ps = convert_us_to_ps(width_us);
    e->lamp_sense_ps = convert_us_to_ps(fmax(f->lamp_sense_us, f->lamp_clear_us));
    double threshold_a = f->lamp_sense_threshold_a +
                         draw_normal(random, f->lamp_sense_threshold_sd_a);
    e->is_lamp_detected = fmin(f->lamp_cold_a, f->lamp_hot_a) > threshold_a;
    /* between half the maximum and the maximum, because relays differ */
    e->relay_operate_ps =
        convert_us_to_ps(1e3 * f->relay_operate_ms * (0.5 + 0.5 * mr_splitmix64_uniform(random)));
    e->relay_release_ps =
        convert_us_to_ps(1e3 * f->relay_release_ms * (0.5 + 0.5 * mr_splitmix64_uniform(random)));
    e->relay_bounce_ps = convert_us_to_ps(1e3 * f->relay_bounce_ms * mr_splitmix64_uniform(random));
}

static void draw_converter_errors(struct hil_adc_errors *adc, const struct hil_circuit_figures *f,
                                  uint64_t *random)
{
    for (unsigned unit = 0; unit < 2; unit++) {
        double u = mr_splitmix64_uniform(random);
        double peak = f->adc_inl_typical_lsb +
                      (f->adc_inl_max_lsb - f->adc_inl_typical_lsb) * u * u * u;
        hil_adc_draw_inl(adc->inl_lsb[unit], peak, random);
        adc->offset_lsb[unit] = draw_normal(random, f->adc_offset_lsb);
        adc->gain_lsb[unit] = draw_normal(random, f->adc_gain_lsb);
    }
}

/* Properties of each channel at the converter, in converter order. */
static void set_channel_sources(struct hil_adc_errors *adc, const struct hil_circuit_figures *f)
{
    const struct {
        unsigned count;
        double noise_lsb, kickback_share, ohm;
    } kinds[] = {
        {HIL_RUN_TRANSDUCERS, hypot(f->adc_noise_lsb, f->transducer_noise_lsb),
         f->transducer_kick_rel, f->transducer_source_ohm},
        {HIL_RUN_GAGES, hypot(f->adc_noise_lsb, f->gage_noise_lsb), f->gage_kick_rel,
         f->gage_source_ohm},
        {1, f->adc_noise_lsb, f->staircase_kick_rel, f->staircase_source_ohm},
        {1, f->adc_noise_lsb, f->reference_kick_rel, f->reference_source_ohm},
    };
    for (unsigned kind = 0, channel = 0; kind < sizeof kinds / sizeof kinds[0]; kind++) {
        for (unsigned i = 0; i < kinds[kind].count; i++, channel++) {
            adc->noise_ratio[channel] = kinds[kind].noise_lsb / HIL_ADC_NOISE_LSB;
            adc->kickback_share[channel] = kinds[kind].kickback_share;
            adc->source_ohm[channel] = kinds[kind].ohm;
        }
    }
}

void hil_electronics_set_up(struct hil_electronics *electronics, const struct hil_options *options,
                            const struct hil_circuit_figures *figures)
{
    struct hil_circuit_figures reference;
    uint64_t random = options->tolerance_seed * 0x9e6c63d0876a9a99ull + 0x5851f42d4c957f2dull;
    hil_circuit_figures_set_reference(&reference);
    const struct hil_circuit_figures *f = figures ? figures : &reference;
    make_ideal(electronics, options);
    set_channel_sources(&electronics->adc_errors, f);
    if (!options->has_random_tolerances)
        return;
    electronics->has_drawn_tolerances = true;
    draw_sensor_tolerances(electronics, f, &random);
    draw_staircase_tolerances(electronics, f, &random);
    draw_output_tolerances(electronics, f, &random);
    draw_converter_errors(&electronics->adc_errors, f, &random);
}

void hil_electronics_chip_uid(uint64_t seed, uint32_t uid[3])
{
    uint64_t random = seed * 0xd1342543de82ef95ull + 0x2545f4914f6cdd1dull;
    uint8_t lot[4];
    uint64_t place = mr_splitmix64(&random);
    for (unsigned i = 0; i < 4; i++)
        lot[i] = (uint8_t)('0' + mr_splitmix64(&random) % 10u);
    uid[0] = (uint32_t)(place & 0xffu) | (uint32_t)(place >> 8 & 0xffu) << 16;
    uid[1] = (uint32_t)(1u + (place >> 16) % 25u) | MR_EMULATED_LOT << 8;
    uid[2] = (uint32_t)lot[0] | (uint32_t)lot[1] << 8 | (uint32_t)lot[2] << 16 |
             (uint32_t)lot[3] << 24;
}
