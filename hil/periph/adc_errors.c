#include "hil/periph/adc_errors.h"

#include <math.h>

#include "hil/periph/cells.h"

#define BITS       12u
#define BITS_DRAWN 8u
#define LAST       (HIL_ADC_CODES - 1u)
#define PI         3.14159265358979323846

/* -1 to 1 */
static double draw(uint64_t *random)
{
    return (double)(hil_random(random) >> 11) * 0x1p-52 - 1.0;
}

/* Capacitors of one make are off by a draw that grows with the root of their size. A carry into bit
 * b exchanges it for all below it. The largest jump becomes `jump_lsb`. */
static void draw_carries(float curve_lsb[HIL_ADC_CODES], double jump_lsb, uint64_t *random)
{
    double off[BITS_DRAWN], all = 0.0, most = 0.0;
    for (unsigned b = 0; b < BITS_DRAWN; b++) {
        off[b] = draw(random) / sqrt((double)(1u << b));
        all += off[b];
    }
    for (unsigned code = 0; code < HIL_ADC_CODES; code++) {
        double sum = -all * (double)code / LAST;
        for (unsigned b = 0; b < BITS_DRAWN; b++)
            sum += code >> (BITS - 1u - b) & 1u ? off[b] : 0.0;
        curve_lsb[code] = (float)sum;
        if (code)
            most = fmax(most, fabs(sum - (double)curve_lsb[code - 1u]));
    }
    for (unsigned code = 0; code < HIL_ADC_CODES; code++)
        curve_lsb[code] *= (float)(jump_lsb / most);
}

static double peak_of(const float curve_lsb[HIL_ADC_CODES], const double bow[2], double by)
{
    double peak = 0.0;
    for (unsigned code = 0; code < HIL_ADC_CODES; code += 4u) {
        double x = (double)code / LAST;
        peak = fmax(peak, fabs((double)curve_lsb[code] +
                               by * (bow[0] * sin(PI * x) + bow[1] * sin(2.0 * PI * x))));
    }
    return peak;
}

void hil_adc_draw_inl(float curve_lsb[HIL_ADC_CODES], double peak_lsb, uint64_t *random)
{
    double jump_lsb = HIL_ADC_DNL_LSB * fabs(draw(random));
    const double bow[2] = {draw(random), draw(random)};
    double low = 0.0, high = 2.0 * peak_lsb / fmax(fabs(bow[0]) + fabs(bow[1]), 0.01) + 10.0;
    draw_carries(curve_lsb, jump_lsb, random);
    double carries_lsb = peak_of(curve_lsb, bow, 0.0);
    for (unsigned code = 0; carries_lsb > peak_lsb && code < HIL_ADC_CODES; code++)
        curve_lsb[code] *= (float)(peak_lsb / carries_lsb);
    for (unsigned halvings = 0; halvings < 30u; halvings++) {
        double by = 0.5 * (low + high);
        if (peak_of(curve_lsb, bow, by) > peak_lsb)
            high = by;
        else
            low = by;
    }
    for (unsigned code = 0; code < HIL_ADC_CODES; code++) {
        double x = (double)code / LAST;
        curve_lsb[code] += (float)(low * (bow[0] * sin(PI * x) + bow[1] * sin(2.0 * PI * x)));
    }
}

double hil_adc_real_code(const struct hil_adc_errors *errors, unsigned unit, double ideal_code)
{
    double within = fmin(fmax(ideal_code, 0.0), (double)(HIL_ADC_CODES - 1u));
    return ideal_code + errors->offset_lsb[unit] + errors->gain_lsb[unit] * within / HIL_ADC_CODES +
           (double)errors->inl_lsb[unit][(unsigned)within];
}

double hil_adc_left(const struct hil_adc_errors *errors, int source, double window_s)
{
    double ohm = HIL_ADC_SWITCH_OHM + (source < 0 ? 0.0 : errors->source_ohm[source]);
    double left = exp(-window_s / (ohm * HIL_ADC_SAMPLE_F));
    return left + (source < 0 ? 0.0 : errors->kick_rel[source]);
}
