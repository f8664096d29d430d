/* ADC1 and ADC3 in independent mode (RM0090 13): regular sequences started by a timer or by
 * software, with DMA.
 *
 * A sequence takes its real time. Each channel is sampled at the end of its sampling window, and
 * its code is delivered 12 ADC clocks later. All codes are computed together at the end of the
 * sequence, or earlier when DMA raises a flag within the sequence or a register is read.
 *
 * Codes are relative to VDDA (VREF+ is tied to it). A converter is ideal except for its noise,
 * unless errors are set (struct hil_adc_errors). */
#ifndef MATRIG_HIL_ADC_H
#define MATRIG_HIL_ADC_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

struct hil_adc_errors;

#define HIL_NOMINAL_VDDA_V 3.3 /* supply voltage to which codes in the configuration refer */

enum { HIL_ADC1, HIL_ADC3 };

struct hil_adc {
    HIL_NAMED_WORDS(word, sr, cr1, cr2, smpr[2], jofr[4], htr, ltr, sqr[3], jsqr, jdr[4], dr);
    /* the last code has not been read; with DMA or EOCS the next conversion is an overrun */
    bool is_dr_full;
    bool has_dma_ended; /* DDS is 0 and the DMA transfer has ended */
    bool is_sequence_running;
    uint64_t start_cycle;     /* start of the first sampling window */
    uint32_t clock_cycles;    /* HCLK cycles per ADC clock in this sequence */
    bool is_sequence_planned; /* the planned sequence matches the registers */
    /* HCLK for which `remaining_share` was computed (together with `clock_cycles`) */
    uint32_t planned_hclk_hz;
    uint8_t sequence_length, sampled_count, delivered_count;
    uint8_t channel[16];
    int8_t source[16]; /* source on the pin of channel[k], from hil_analogue.source */
    uint16_t conversion_end_clock[16]; /* ADC clocks from start to the end of conversion k */
    uint16_t code[16];
    /* share of the step from the previous conversion that remains in conversion k
     * (hil_adc_remaining_share) */
    double remaining_share[16];
    double sample_capacitor_v; /* voltage of the sample capacitor; used only with errors */
    uint64_t random_state;
    uint16_t trigger_levels; /* levels of the external triggers, by EXTSEL */
    /* time at which the converter was switched on; used until the first conversion */
    struct hil_timestamp switch_on_time;
};

/* The circuit connected to the analogue pins. */
struct hil_analogue {
    void *context;
    /* number of the source on a pin; -1: not connected */
    int (*source)(const void *context, unsigned port, unsigned pin);
    /* voltage, not clipped; 0 V if not connected */
    double (*volts)(void *context, int source, uint64_t at);
    /* source resistance seen by the converter; NULL: unknown */
    double (*source_ohm)(const void *context, int source);
};

/* Recorded codes that replace voltages. */
struct hil_recorded_codes {
    void *context;
    /* returns the code of a pin sampled at a cycle; function NULL: no record */
    uint16_t (*code)(void *context, unsigned port, unsigned pin, uint64_t at);
};

struct hil_adc_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_adc *state; /* states of both converters */
    uint32_t *ccr;         /* register shared by both converters */
    struct hil_analogue analogue;
    struct hil_recorded_codes recorded;
    double vdda_v;
    const struct hil_adc_errors *errors; /* NULL: ideal */
};

/* Resets both converters, which share one reset line; `unit` is not used. In all functions with a
 * parameter `device`, it is a struct hil_adc_device. */
void hil_adc_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(adc)
/* Call at an edge of an external trigger, identified by its EXTSEL code. */
void hil_adc_trigger(struct hil_adc_device *dev, unsigned extsel, bool rising, uint64_t at);
/* Computes all samples and conversions up to `at`. */
void hil_adc_advance(void *device, uint64_t at);
void hil_adc1_event(void *device, uint64_t at);
void hil_adc3_event(void *device, uint64_t at);

/* ---- errors of a real converter ---- */

/* Errors of a real converter: offset, gain, integral nonlinearity, noise, and the residual charge
 * of the previous channel in the sample capacitor.
 *
 * Each conversion contains a fraction of the step from the previously sampled voltage. The fraction
 * has two parts: the charge that the pin's capacitor has not replaced (`kickback_share`), and the
 * incomplete settling within the sampling window, exp(-t / ((RADC + source) CADC)). RADC = 6 kOhm
 * and CADC = 7 pF are the maxima of DS8626 table 67. Units are LSB of 4096 codes; sources are
 * numbered as by
 * hil_analogue.source. */

#define HIL_ADC_SOURCES         24u
#define HIL_ADC_CODES           4096u
/* rms noise of the ideal board, to which `noise_ratio` refers */
#define HIL_ADC_NOISE_LSB       2.0
#define HIL_ADC_SWITCH_MAX_OHM  6e3   /* RADC */
#define HIL_ADC_CAPACITOR_MAX_F 7e-12 /* CADC */

struct hil_adc_errors {
    double offset_lsb[2]; /* offset of ADC1 and ADC3 */
    double gain_lsb[2];   /* error at full scale */
    float inl_lsb[2][HIL_ADC_CODES];
    double noise_ratio[HIL_ADC_SOURCES]; /* noise as a multiple of HIL_ADC_NOISE_LSB */
    double kickback_share[HIL_ADC_SOURCES];
    double source_ohm[HIL_ADC_SOURCES];
};

/* Draws the nonlinearity of a capacitive converter: steps where the upper bits carry, up to
 * HIL_ADC_DNL_MAX_LSB (DS8626 table 68: ED is typically 1, at most 2), plus a smooth bow that sets
 * the peak of the curve to `peak_lsb`. The ends of the curve are 0, because EL is relative to the
 * line through them. */
#define HIL_ADC_DNL_MAX_LSB 2.0
void hil_adc_draw_inl(float curve_lsb[HIL_ADC_CODES], double peak_lsb, uint64_t *random);

/* Returns the code of a real converter for which an ideal one would give `ideal_code`, not rounded
 * and not limited to the range; `unit`: 0 ADC1, 1 ADC3. */
double hil_adc_code_with_errors(const struct hil_adc_errors *errors, unsigned unit,
                                double ideal_code);

/* Share of the step from the previous channel that remains after `window_s`; `source` -1: a pin
 * without a source. */
double hil_adc_remaining_share(const struct hil_adc_errors *errors, int source, double window_s);

/* ---- sampling time ---- */

/* Sampling time required for a source resistance: STM32F407 data sheet, 12-bit ADC characteristics,
 * equation 1, for an error below a quarter of an LSB. */

/* Maximum source resistance for a sampling window of `sample_clocks` ADC clocks. Negative: the
 * window is too short even for 0 Ohm. */
double hil_adc_max_source_ohm(unsigned sample_clocks, double clock_hz);

#endif
