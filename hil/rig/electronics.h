/* The electronics between the sensors and the pins: of the ideal board, or of one that is drawn.
 *
 * The ideal board is the circuits' nominal values and nothing else; every test that asks for no
 * other has it. A drawn board has the spread of the reference circuits' parts (hil/circuits, of
 * which figures.def is made): a standard deviation or a typical value is drawn as a normal
 * deviation, a tolerance and a most evenly within, the INL's peak from typical to most, rarely near
 * the most. One seed, one board; the seed of the converters' noise is another. */
#ifndef MATRIG_HIL_ELECTRONICS_H
#define MATRIG_HIL_ELECTRONICS_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/periph/adc.h"
#include "hil/rig/runfile.h"

struct hil_options;

#define HIL_PULSE_PS         20000000ull /* of the one-shot: 20 us */
#define HIL_STAIRCASE_ZERO_V 0.050       /* at 3.3 V */

/* Nominal step of a switch, position 1..24, in codes. */
unsigned hil_step_codes(unsigned position);

/* Of all boards, by the names of hil/circuits/figures.def. */
struct hil_figures {
#define FIGURE(name, value, unit, block, text) double name;
#include "hil/circuits/figures.def"
};

struct hil_electronics {
    double vdda_v;
    double reference;       /* times 2.500 V, at 20 degrees */
    double reference_read;  /* of that, what its own channel gets */
    double reference_drift; /* relative, a degree */
    double warmer_k;        /* than 20 degrees, at power on */
    double warmer_k_per_s;
    double transducer_gain[HIL_RUN_TRANSDUCERS];
    double transducer_zero_in[HIL_RUN_TRANSDUCERS];
    double transducer_mid_v[HIL_RUN_TRANSDUCERS]; /* added */
    double transducer_gain_k; /* by which the cells' gain rises, relative, a degree */
    double transducer_tau_s;
    double gage_gain[HIL_RUN_GAGES];
    double gage_natural_lb[HIL_RUN_GAGES]; /* its zero before the balance trim */
    double gage_zero_lb[HIL_RUN_GAGES];    /* and after it, at 20 degrees */
    double gage_drift_lb_k[HIL_RUN_GAGES];
    double gage_shunt[HIL_RUN_GAGES]; /* times HIL_RIG_SHUNT_LB */
    double gage_lag_s;                /* of the filter against aliases */
    double staircase_zero;            /* times its nominal 0.050 V */
    double step_codes[HIL_RUN_SWITCHES];
    double staircase_tau_s;
    uint64_t pulse_ps; /* of the one-shot */
    /* from a pin that changes to the lamp's read-back, and to the shunts' contacts */
    bool lamp_told; /* its current, once it is hot, is above the read-back's threshold */
    uint64_t lamp_sense_ps, relay_operate_ps, relay_release_ps, relay_bounce_ps;
    bool drawn; /* else nothing of `adc` holds but what the converters see of each source */
    struct hil_adc_errors adc;
};

/* Values of figures.def. */
void hil_figures_reference(struct hil_figures *figures);

/* The electronics of the board in the options: ideal, or drawn from `figures` (NULL: the reference
 * design's). */
void hil_electronics_make(struct hil_electronics *electronics, const struct hil_options *options,
                          const struct hil_figures *figures);

/* The unique identifier of the chip on the board that this seed draws: its place on the wafer, the
 * wafer and its lot (RM0090 39.1), which marks it as emulated (common/emulated.h). */
void hil_electronics_identity(uint64_t seed, uint32_t uid[3]);

/* Zero of a bridge whose balance trim reaches `range_lb` either way and is set to `left_lb`. */
double hil_electronics_trimmed(double natural_lb, double range_lb, double left_lb);

#endif
