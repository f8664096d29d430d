/* Independent watchdog (RM0090 21), clocked by the LSI, which is anywhere from 17 to 47 kHz. */
#ifndef MATRIG_HIL_IWDG_H
#define MATRIG_HIL_IWDG_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"

struct hil_core;
struct hil_options;
struct hil_rcc_device;

struct hil_iwdg {
    HIL_WORDS(word, kr, pr, rlr);
    bool unlocked, running;
    /* SR.PVU and SR.RVU: a value written to PR or RLR takes up to five LSI cycles to arrive */
    uint64_t until_ps[2];
};

struct hil_iwdg_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_iwdg *state;
    struct hil_rcc_device *rcc;
};

void hil_iwdg_reset(struct hil_iwdg_device *dev);
/* For the bus and the event queue; `device` is a struct hil_iwdg_device. */
uint32_t hil_iwdg_read(void *device, unsigned unit, uint32_t offset);
void hil_iwdg_write(void *device, unsigned unit, uint32_t offset, uint32_t value);
void hil_iwdg_event(void *device, uint64_t at);

#endif
