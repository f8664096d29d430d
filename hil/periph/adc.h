/* ADC1 and ADC3 in independent mode (RM0090 13): regular sequences started by a timer or by
 * software, with DMA.
 *
 * A sequence takes its real time. Each channel is sampled at the end of its own sampling window and
 * its code delivered 12 ADC clocks later; codes are worked out in bulk at the end of the sequence,
 * or earlier when DMA raises a flag inside it or somebody looks. Injected channels, analogue
 * watchdog, continuous and discontinuous mode, temperature sensor are refused.
 *
 * Codes are relative to VDDA (VREF+ is tied to it). A converter is ideal but for its noise unless
 * it is given errors (hil/periph/adc_errors.h). */
#ifndef MATRIG_HIL_ADC_H
#define MATRIG_HIL_ADC_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/words.h"

struct hil_adc_errors;
struct hil_core;
struct hil_dma_device;
struct hil_gpio_device;
struct hil_options;
struct hil_rcc_device;
struct hil_rules_device;

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
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_adc *state; /* of both */
    uint32_t *ccr;         /* the register that they share */
    struct hil_rcc_device *rcc;
    struct hil_dma_device *dma;
    struct hil_gpio_device *gpio;
    struct hil_rules_device *rules;
    struct hil_analogue outside;
    struct hil_recorded_codes record;
    double vdda_v;
    const struct hil_adc_errors *errors; /* NULL: ideal */
};

/* Of both converters: they have one reset line. `unit` is not used. For the bus and the event
 * queue, `device` is a struct hil_adc_device. */
void hil_adc_reset(void *device, unsigned unit);
uint32_t hil_adc_read(void *device, unsigned unit, uint32_t offset);
void hil_adc_write(void *device, unsigned unit, uint32_t offset, uint32_t value);
/* An edge of an external trigger, by its EXTSEL code. */
void hil_adc_trigger(struct hil_adc_device *dev, unsigned extsel, bool rising, uint64_t at);
/* Work out everything that was sampled or finished up to `at`. */
void hil_adc_catch_up(struct hil_adc_device *dev, uint64_t at);
void hil_adc1_event(void *device, uint64_t at);
void hil_adc3_event(void *device, uint64_t at);

#endif
