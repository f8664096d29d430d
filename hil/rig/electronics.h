/* The electronics between sensors and pins: either ideal, or with random tolerances (a "drawn"
 * board).
 *
 * The ideal board has the exact nominal values of the circuits and is the default of all tests. A
 * drawn board has the tolerances of the parts in the reference circuits (hil/circuits, the source
 * of figures.def). Figures given as a standard deviation or a typical value are drawn from a normal
 * distribution, figures given as a tolerance or a maximum from a uniform one. The peak of the INL
 * is between typical and maximum, rarely near the maximum. Each seed gives one board; the noise of
 * the converters has a different seed. */
#ifndef MATRIG_HIL_ELECTRONICS_H
#define MATRIG_HIL_ELECTRONICS_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/periph/adc.h"
#include "hil/rig/runfile.h"

struct hil_options;

#define HIL_ONE_SHOT_PULSE_PS 20000000ull /* pulse of the one-shot, 20 us */
#define HIL_STAIRCASE_ZERO_V  0.050       /* level without open switches, at 3.3 V */

/* Nominal step of a switch, position 1..24, in codes. */
unsigned hil_switch_step_codes(unsigned position);

/* Figures of all boards, with the names of hil/circuits/figures.def. */
struct hil_circuit_figures {
#define FIGURE(name, value, unit, block, text) double name;
#include "hil/circuits/figures.def"
};

struct hil_electronics {
    double vdda_v;
    double reference_ratio;         /* ratio to 2.500 V, at 20 C */
    double reference_reading_ratio; /* reading of the reference channel / reference */
    double reference_drift_per_k;   /* relative drift per C */
    double temperature_rise_k;      /* temperature at power on, above 20 C */
    double temperature_rise_k_per_s;
    double transducer_gain[HIL_RUN_TRANSDUCERS];
    double transducer_zero_in[HIL_RUN_TRANSDUCERS];
    double transducer_mid_v[HIL_RUN_TRANSDUCERS]; /* offset from the nominal mid voltage */
    double transducer_gain_per_k;                 /* rise of the transducer gain, relative, per C */
    double transducer_tau_s;
    double gage_gain[HIL_RUN_GAGES];
    double gage_untrimmed_lb[HIL_RUN_GAGES]; /* zero before the balance trim */
    double gage_zero_lb[HIL_RUN_GAGES];      /* zero after the balance trim, at 20 C */
    double gage_drift_lb_k[HIL_RUN_GAGES];
    double gage_shunt_ratio[HIL_RUN_GAGES]; /* ratio to HIL_RIG_SHUNT_LB */
    double gage_tau_s;                      /* time constant of the anti-aliasing filter */
    double staircase_zero_ratio;            /* ratio to the nominal 0.050 V */
    double step_codes[HIL_RUN_SWITCHES];
    double staircase_tau_s;
    uint64_t one_shot_pulse_ps; /* pulse of the one-shot */
    /* the current of the lamp, once hot, is above the threshold of the read-back */
    bool is_lamp_detected;
    /* delays from a pin change to the lamp's read-back and to the contacts of the shunt relay */
    uint64_t lamp_sense_ps, relay_operate_ps, relay_release_ps, relay_bounce_ps;
    bool has_drawn_tolerances; /* false: only the source resistances in `adc_errors` are valid */
    struct hil_adc_errors adc_errors;
};

/* Sets the values of figures.def. */
void hil_circuit_figures_set_reference(struct hil_circuit_figures *figures);

/* Sets the electronics for the options: ideal, or drawn from `figures` (NULL: those of the
 * reference design). */
void hil_electronics_set_up(struct hil_electronics *electronics, const struct hil_options *options,
                            const struct hil_circuit_figures *figures);

/* Unique identifier of the chip on the board with this seed: position on the wafer, wafer and lot
 * (RM0090 39.1). The lot marks the chip as emulated (common/emulated.h). */
void hil_electronics_chip_uid(uint64_t seed, uint32_t uid[3]);

/* Returns the zero of a bridge after the balance trim, which has a range of +-`range_lb`: what
 * remains is `residual_lb` plus any offset beyond the range. */
double hil_electronics_trimmed_zero_lb(double untrimmed_lb, double range_lb, double residual_lb);

#endif
