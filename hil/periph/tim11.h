/* TIM11 (RM0090 19.5) as far as it measures the crystal: channel 1 captures the HSE, divided for
 * the RTC (TIM11_OR). Anything else is refused. */
#ifndef MATRIG_HIL_TIM11_H
#define MATRIG_HIL_TIM11_H

#include <stdint.h>

#include "hil/core/words.h"

struct hil_core;
struct hil_options;
struct hil_rcc_device;

struct hil_tim11 {
    HIL_WORDS(word, cr1, at_04, smcr, dier, sr, egr, ccmr1, at_1c, ccer, cnt, psc, arr, at_30, ccr1,
              at_38[6], or);
    uint64_t began_ps; /* counter and capture are on since then; HIL_NEVER: they are not */
    uint64_t captures; /* since then */
};

struct hil_tim11_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_rcc_device *rcc;
    struct hil_tim11 *state;
};

/* `device` is a struct hil_tim11_device, `unit` is not used. */
void hil_tim11_reset(void *device, unsigned unit);
uint32_t hil_tim11_read(void *device, unsigned unit, uint32_t offset);
void hil_tim11_write(void *device, unsigned unit, uint32_t offset, uint32_t value);

#endif
