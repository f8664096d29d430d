/* How long a converter must sample a source of some resistance: STM32F407 data sheet, 12-bit ADC
 * characteristics, equation 1, for an error below a quarter of an LSB. */
#ifndef MATRIG_HIL_ADC_SAMPLING_H
#define MATRIG_HIL_ADC_SAMPLING_H

struct hil_rules_device;

/* The most that a window of so many ADC clocks takes; below 0: not even 0 Ohm. */
double hil_adc_most_ohm(unsigned sample_clocks, double clock_hz);
/* Hold the rule (rules.def, SAMPLING) for an input of ADC1 (1) or ADC3 (3) with a source of so many
 * Ohm. */
void hil_adc_hold_sampling(struct hil_rules_device *rules, unsigned adc, unsigned input, double ohm,
                           unsigned sample_clocks, double clock_hz);

#endif
