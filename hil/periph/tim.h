/* TIM2 (32 bits, edge capture) and TIM4 (scan trigger and excitation), RM0090 18. Modelled:
 * counting up, output compare with all eight modes, capture on TIM2's channels from their
 * own pins with filter and prescaler, trigger mode from a different timer. All other functions are
 * refused.
 *
 * The counter is computed when it is read; compare matches, updates and captures are events. The
 * delay of the input filter is modelled. Trigger and synchronisation delays of one or two timer
 * clocks are not. */
#ifndef MATRIG_HIL_TIM_H
#define MATRIG_HIL_TIM_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

#define HIL_TIMER_COUNT      2u
#define HIL_CAPTURE_CHANNELS 4u
enum { HIL_TIM2, HIL_TIM4 };

/* Pins of TIM2's capture channels; alternate function 1. */
struct hil_capture_pin {
    unsigned port, pin;
    const char *name;
};
extern const struct hil_capture_pin hil_capture_pins[HIL_CAPTURE_CHANNELS];

struct hil_tim {
    /* registers as last written */
    HIL_NAMED_WORDS(word, cr1, cr2, smcr, dier, sr, egr, ccmr[2], ccer, cnt, psc, arr, rcr, ccr[4]);
    /* values in use; registers with preload take effect at the next update */
    uint32_t psc_shadow, arr_shadow, ccr_shadow[4];
    /* cycle at which the counter was base_count; the counter runs from here while CEN is set */
    uint64_t base_cycle;
    uint32_t base_count;
    bool reference_level[4]; /* OCxREF */
    /* cycle at which an edge will pass the filter; HIL_NEVER: none */
    uint64_t capture_cycle[HIL_CAPTURE_CHANNELS];
    bool capture_level[HIL_CAPTURE_CHANNELS];
    /* number of edges since the last capture, for the prescaler */
    uint8_t edges_since_capture[HIL_CAPTURE_CHANNELS];
};

struct hil_tim_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_tim *state; /* all timers */
    struct hil_adc_device *adc;
};

/* Functions that bus and event queue call; `device` is a struct hil_tim_device. */
void hil_tim_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(tim)
void hil_tim2_event(void *device, uint64_t at);
void hil_tim4_event(void *device, uint64_t at);

/* Function that the pins call: level of TIM4's output on channel 0..3; *drives is false while the
 * channel is off. */
bool hil_tim4_output(const void *device, unsigned channel, bool *drives);
/* Call when TI1 to TI4 of TIM2 (channel 0 to 3) changed to `level`. */
void hil_tim2_input_edge(void *device, unsigned channel, bool level, uint64_t at);
/* Stops a timer until until_cycle, because the core is halted (DBGMCU). */
void hil_tim_freeze_until(struct hil_tim_device *dev, unsigned unit, uint64_t until_cycle);
/* HCLK cycles from an edge of an input to its capture, with the present settings of the input. */
uint64_t hil_tim2_capture_delay(const struct hil_tim_device *dev, unsigned channel);

/* ---- tim11 ---- */

/* TIM11 (RM0090 19.5), only for measuring the crystal: channel 1 captures the HSE divided for the
 * RTC (TIM11_OR). All other functions are refused. */

struct hil_tim11 {
    HIL_NAMED_WORDS(word, cr1, reserved_04, smcr, dier, sr, egr, ccmr1, reserved_1c, ccer, cnt, psc,
                    arr, reserved_30, ccr1, reserved_38[6], or);
    uint64_t start_ps;      /* time at which counter and capture were switched on; HIL_NEVER: off */
    uint64_t capture_count; /* captures since start_ps */
};

struct hil_tim11_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_tim11 *state;
};

/* Functions that the bus calls; `device` is a struct hil_tim11_device, `unit` is not used. */
void hil_tim11_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(tim11)

#endif
