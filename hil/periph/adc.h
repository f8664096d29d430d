/* ADC1 and ADC3 in independent mode (RM0090 13): regular sequences started by a timer or by
 * software, with DMA.
 *
 * A sequence takes its real time. Each channel is sampled at the end of its own sampling window and
 * its code delivered 12 ADC clocks later; codes are worked out in bulk at the end of the sequence,
 * or earlier when DMA raises a flag inside it or a register is read.
 *
 * Codes are relative to VDDA (VREF+ is tied to it). A converter is ideal apart from its noise
 * unless it is given errors (hil/periph/adc.h). */
#ifndef MATRIG_HIL_ADC_H
#define MATRIG_HIL_ADC_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

struct hil_adc_errors;

#define HIL_NOMINAL_VDDA_V 3.3 /* what the codes of the configuration stand for */

enum { HIL_ADC1, HIL_ADC3 };

struct hil_adc {
    HIL_WORDS(word, sr, cr1, cr2, smpr[2], jofr[4], htr, ltr, sqr[3], jsqr, jdr[4], dr);
    /* converted and not read: the next conversion overruns when DMA or EOCS ask for each */
    bool dr_full;
    bool dma_ended; /* DDS is 0 and the DMA has come to its end */
    bool running;
    uint64_t start_cycle;     /* first sampling window opens */
    uint32_t clock_cycles;    /* HCLK cycles of an ADC clock, for this sequence */
    bool planned;             /* length, channels and end_clock are those of the registers */
    uint32_t planned_hclk_hz; /* and with `clock_cycles` what `left` was worked out for */
    uint8_t length, sampled, delivered;
    uint8_t channel[16];
    int8_t source[16];      /* what is outside on the pin of channel[k]: hil_analogue.source */
    uint16_t end_clock[16]; /* ADC clocks from start to the end of conversion k */
    uint16_t code[16];
    double left[16];        /* of a step from the conversion before: hil_adc_left */
    double held_v;          /* in the sample capacitor; only where there are errors */
    uint64_t noise;         /* of the generator */
    uint16_t triggers_high; /* levels of the external triggers, by EXTSEL */
    struct hil_moment on;   /* since when, before its first conversion */
};

/* What is outside on the analogue pins. */
struct hil_analogue {
    void *who;
    /* number of what is on a pin; -1: nothing */
    int (*source)(const void *who, unsigned port, unsigned pin);
    double (*volts)(void *who, int source, uint64_t at); /* not clipped; nothing: 0 V */
    /* its resistance as the converter sees it; NULL: not known */
    double (*source_ohm)(const void *who, int source);
};

/* A record in place of volts: the code of a pin sampled at a cycle. */
struct hil_recorded_codes {
    void *who;
    uint16_t (*code)(void *who, unsigned port, unsigned pin, uint64_t at); /* NULL: no record */
};

struct hil_adc_device {
    HIL_NEIGHBOURS;
    struct hil_adc *state; /* of both */
    uint32_t *ccr;         /* the register that they share */
    struct hil_analogue outside;
    struct hil_recorded_codes record;
    double vdda_v;
    const struct hil_adc_errors *errors; /* NULL: ideal */
};

/* Of both converters: they have one reset line. `unit` is not used. For the bus and the event
 * queue, `device` is a struct hil_adc_device. */
void hil_adc_reset(void *device, unsigned unit);
HIL_ON_BUS(adc)
/* An edge of an external trigger, by its EXTSEL code. */
void hil_adc_trigger(struct hil_adc_device *dev, unsigned extsel, bool rising, uint64_t at);
/* Work out everything that was sampled or finished up to `at`. */
void hil_adc_catch_up(void *device, uint64_t at);
void hil_adc1_event(void *device, uint64_t at);
void hil_adc3_event(void *device, uint64_t at);

/* ---- adc_errors ---- */

/* What a real converter adds to a code: offset, gain, integral nonlinearity, noise, and what is
 * left in its sample capacitor of the channel before.
 *
 * A conversion takes over a fraction of the step from the voltage sampled before: the charge that
 * the pin's own capacitor has not made good (`kick_rel`), and what the sampling window was too
 * short for, exp(-t / ((RADC + source) CADC)), with RADC 6 kOhm at most and CADC 7 pF at most
 * (DS8626 table 67). Units are LSB of 4096 codes; sources are numbered as hil_analogue.source does.
 * */

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

/* ---- adc_sampling ---- */

/* How long a converter must sample a source of some resistance: STM32F407 data sheet, 12-bit ADC
 * characteristics, equation 1, for an error below a quarter of an LSB. */

/* The most that a window of so many ADC clocks takes; below 0: not even 0 Ohm. */
double hil_adc_most_ohm(unsigned sample_clocks, double clock_hz);

#endif
