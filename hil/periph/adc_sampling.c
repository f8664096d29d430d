#include "hil/periph/adc_sampling.h"

#include <math.h>

#include "hil/periph/rules.h"

/* The same table: C(ADC) typical, R(ADC) most. */
#define SAMPLE_FARAD 4e-12
#define SWITCH_OHM   6000.0
#define BITS         12

double hil_adc_most_ohm(unsigned sample_clocks, double clock_hz)
{
    return ((double)sample_clocks - 0.5) / (clock_hz * SAMPLE_FARAD * log(exp2(BITS + 2))) -
           SWITCH_OHM;
}

void hil_adc_hold_sampling(struct hil_rules_device *rules, unsigned adc, unsigned input, double ohm,
                           unsigned sample_clocks, double clock_hz)
{
    double most_ohm = hil_adc_most_ohm(sample_clocks, clock_hz);
    if (ohm <= most_ohm)
        hil_rules_kept(rules, HIL_RULE_SAMPLING);
    else
        hil_rules_broken(rules, HIL_RULE_SAMPLING, 0,
                         "input %u of ADC%u has %.0f Ohm, and %u clocks of %.1f MHz take %.0f",
                         input, adc, ohm, sample_clocks, clock_hz * 1e-6, most_ohm);
}
