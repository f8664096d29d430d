/* ADC1 and ADC3 in independent mode (RM0090 13): regular sequences started by a timer or by software, with
 * DMA.
 *
 * A sequence takes its real time. Each channel is sampled at the end of its own sampling window and its
 * code delivered 12 ADC clocks later; codes are worked out in bulk at the end of the sequence, or earlier
 * when DMA raises a flag inside it or somebody looks. Injected channels, analogue watchdog, continuous and
 * discontinuous mode, temperature sensor are refused. */
#ifndef MATRIG_HIL_ADC_H
#define MATRIG_HIL_ADC_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

enum { HIL_ADC1, HIL_ADC3 };

struct hil_adc {
    uint32_t sr, cr1, cr2, smpr[2], sqr[3], jsqr, htr, ltr;
    uint16_t dr;
    /* converted and not read: the next conversion overruns when DMA or EOCS ask for each */
    bool dr_full;
    bool dma_ended;        /* DDS is 0 and the DMA has come to its end */
    bool running;
    uint64_t start_cycle;  /* first sampling window opens */
    uint32_t clock_cycles; /* HCLK cycles of an ADC clock, for this sequence */
    bool planned;           /* length, channels and end_clock are those of the registers */
    uint8_t length, sampled, delivered;
    uint8_t channel[16];
    int8_t rig_channel[16]; /* of the rig, on the pin of channel[k] */
    uint16_t end_clock[16]; /* ADC clocks from start to the end of conversion k */
    uint16_t code[16];
    uint64_t noise;         /* of the generator */
};

void hil_adc_reset(struct hil_board *board);
uint32_t hil_adc_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_adc_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
/* An edge of an external trigger, by its EXTSEL code. */
void hil_adc_trigger(struct hil_board *board, unsigned extsel, bool rising, uint64_t at);
/* Work out everything that was sampled or finished up to `at`. */
void hil_adc_catch_up(struct hil_board *board, uint64_t at);
void hil_adc1_event(struct hil_board *board, uint64_t at);
void hil_adc3_event(struct hil_board *board, uint64_t at);

#endif
