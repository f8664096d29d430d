/* TIM2 (32 bits, edge capture) and TIM4 (scan trigger and excitation), RM0090 18: counting up,
 * output compare with all eight modes, capture of TIM2's channels 1 and 2 from their own pins with
 * filter and prescaler, trigger mode from another timer. The rest is refused.
 *
 * The counter is computed when it is read; compare matches, updates and captures are events.
 * Trigger and synchronisation delays of one or two timer clocks are not modelled; the input
 * filter's is. */
#ifndef MATRIG_HIL_TIM_H
#define MATRIG_HIL_TIM_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

#define HIL_TIMERS   2u
#define HIL_CAPTURES 2u
enum { HIL_TIM2, HIL_TIM4 };

struct hil_tim {
    /* as written */
    HIL_WORDS(word, cr1, cr2, smcr, dier, sr, egr, ccmr[2], ccer, cnt, psc, arr, rcr, ccr[4]);
    uint32_t psc_now, arr_now, ccr_now[4]; /* in use (preload) */
    /* the counter was base_count here; runs from here while CEN */
    uint64_t base_cycle;
    uint32_t base_count;
    bool reference[4]; /* OCxREF */
    /* Of channels 1 and 2: */
    uint64_t capture_cycle[HIL_CAPTURES]; /* HIL_NEVER, or when the filter lets an edge through */
    bool capture_level[HIL_CAPTURES];
    uint8_t capture_skipped[HIL_CAPTURES]; /* edges since the last capture, for the prescaler */
};

struct hil_tim_device {
    HIL_NEIGHBOURS;
    struct hil_tim *state; /* of all */
    struct hil_adc_device *adc;
};

/* For the bus and the event queue; `device` is a struct hil_tim_device. */
void hil_tim_reset(void *device, unsigned unit);
HIL_ON_BUS(tim)
void hil_tim2_event(void *device, uint64_t at);
void hil_tim4_event(void *device, uint64_t at);

/* For the pins. Level of TIM4's output on channel 0..3; *drives false while the channel is off. */
bool hil_tim4_output(const void *device, unsigned channel, bool *drives);
/* TI1 or TI2 of TIM2 (channel 0 or 1) changed to `level`. */
void hil_tim2_input_edge(void *device, unsigned channel, bool level, uint64_t at);
/* A halted core stops it (DBGMCU) until then. */
void hil_tim_hold(struct hil_tim_device *dev, unsigned unit, uint64_t until_cycle);
/* HCLK cycles from an edge of TI1 or TI2 to its capture, as the input is set up now. */
uint64_t hil_tim2_capture_delay(const struct hil_tim_device *dev, unsigned channel);

/* ---- tim11 ---- */

/* TIM11 (RM0090 19.5) as far as it measures the crystal: channel 1 captures the HSE, divided for
 * the RTC (TIM11_OR). Anything else is refused. */

struct hil_tim11 {
    HIL_WORDS(word, cr1, at_04, smcr, dier, sr, egr, ccmr1, at_1c, ccer, cnt, psc, arr, at_30, ccr1,
              at_38[6], or);
    uint64_t began_ps; /* counter and capture are on since then; HIL_NEVER: they are not */
    uint64_t captures; /* since then */
};

struct hil_tim11_device {
    HIL_NEIGHBOURS;
    struct hil_tim11 *state;
};

/* `device` is a struct hil_tim11_device, `unit` is not used. */
void hil_tim11_reset(void *device, unsigned unit);
HIL_ON_BUS(tim11)

#endif
