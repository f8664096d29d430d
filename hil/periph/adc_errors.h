/* What a real converter adds to a code: offset, gain, integral nonlinearity, noise, and what is
 * left in its sample capacitor of the channel before.
 *
 * A conversion takes over a fraction of the step from the voltage sampled before: the charge that
 * the pin's own capacitor has not made good (`kick_rel`), and what the sampling window was too
 * short for, exp(-t / ((RADC + source) CADC)), with RADC 6 kOhm at most and CADC 7 pF at most
 * (DS8626 table 67). Units are LSB of 4096 codes; sources are numbered as hil_analogue.source does.
 * */
#ifndef MATRIG_HIL_ADC_ERRORS_H
#define MATRIG_HIL_ADC_ERRORS_H

#include <stdint.h>

#define HIL_ADC_SOURCES    24u
#define HIL_ADC_CODES      4096u
#define HIL_ADC_NOISE_LSB  2.0   /* rms of the noise that is scaled: that of the ideal board */
#define HIL_ADC_SWITCH_OHM 6e3   /* RADC */
#define HIL_ADC_SAMPLE_F   7e-12 /* CADC */

struct hil_adc_errors {
    double offset_lsb[2]; /* of ADC1, ADC3 */
    double gain_lsb[2];   /* at full scale */
    float inl_lsb[2][HIL_ADC_CODES];
    double noise[HIL_ADC_SOURCES]; /* times HIL_ADC_NOISE_LSB */
    double kick_rel[HIL_ADC_SOURCES];
    double source_ohm[HIL_ADC_SOURCES];
};

/* A curve of a converter that weighs its bits with capacitors: jumps where its upper bits carry,
 * the largest up to HIL_ADC_DNL_LSB (DS8626 table 68: ED is 1 typically, 2 at most), on a smooth
 * bow that makes the curve's largest value `peak_lsb`. Its ends are 0: EL is against the line
 * through them. */
#define HIL_ADC_DNL_LSB 2.0
void hil_adc_draw_inl(float curve_lsb[HIL_ADC_CODES], double peak_lsb, uint64_t *random);

/* The code, not rounded and not clipped, where an ideal converter has `ideal_code`; `unit`: 0 ADC1,
 * 1 ADC3. */
double hil_adc_real_code(const struct hil_adc_errors *errors, unsigned unit, double ideal_code);

/* What is left of a step from the channel before after `window_s`; `source` -1: a bare pin. */
double hil_adc_left(const struct hil_adc_errors *errors, int source, double window_s);

#endif
