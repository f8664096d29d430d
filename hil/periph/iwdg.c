#include "hil/periph/iwdg.h"

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/access.h"
#include "hil/core/state.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"

#define KR                0x00u
#define PR                0x04u
#define SR                0x0cu
#define KEY_RELOAD        0xaaaau
#define KEY_UNLOCK        0x5555u
#define KEY_START         0xccccu
#define CSR_IWDGRSTF      (1u << 29)
#define UPDATE_LSI_CYCLES 5u

void hil_iwdg_reset(struct hil_iwdg_device *dev)
{
    *dev->state = (struct hil_iwdg){.rlr = 0xfff};
    hil_event_set_ps(dev->core, HIL_EVENT_IWDG, HIL_NEVER);
}

static uint64_t lsi_ps(const struct hil_iwdg_device *dev, uint64_t lsi_cycles)
{
    return lsi_cycles * HIL_SECOND_PS / dev->options->lsi_hz;
}

static void reload(struct hil_iwdg_device *dev)
{
    struct hil_iwdg *w = dev->state;
    /* Divider 4 * 2^PR, at most 256; reset when the counter passes 0. */
    uint64_t divider = 4u << (w->pr > 6 ? 6 : w->pr);
    uint64_t timeout_ps = lsi_ps(dev, divider * (w->rlr + 1u));
    if (w->running)
        hil_event_set_ps(dev->core, HIL_EVENT_IWDG, hil_now_ps(dev->core) + timeout_ps);
}

uint32_t hil_iwdg_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_iwdg_device *dev = device;
    struct hil_iwdg *w = dev->state;
    uint64_t now = hil_now_ps(dev->core);
    (void)unit;
    if (offset == SR)
        return (uint32_t)(now < w->until_ps[0]) | (uint32_t)(now < w->until_ps[1]) << 1;
    return w->word[offset / 4u];
}

static bool may_change(struct hil_iwdg_device *dev, bool updating)
{
    if (!dev->state->unlocked)
        hil_bus_refuse(dev->core, "the register is locked: silicon ignores the write");
    else if (updating)
        hil_bus_refuse(dev->core,
                       "a value is still on its way (PVU, RVU): silicon ignores the write");
    return dev->state->unlocked && !updating;
}

static void key_write(struct hil_iwdg_device *dev, uint32_t key)
{
    struct hil_iwdg *w = dev->state;
    w->unlocked = key == KEY_UNLOCK;
    if (key == KEY_START && !w->running) {
        w->running = true;
        hil_rcc_watchdog_starts(dev->rcc);
    }
    if (key == KEY_START || key == KEY_RELOAD)
        reload(dev);
}

void hil_iwdg_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_iwdg_device *dev = device;
    struct hil_iwdg *w = dev->state;
    uint64_t now = hil_now_ps(dev->core);
    (void)unit;
    if (offset == KR) {
        key_write(dev, value & 0xffffu);
        return;
    }
    uint64_t *until_ps = &w->until_ps[(offset - PR) / 4u];
    if (may_change(dev, now < *until_ps)) {
        w->word[offset / 4u] = value;
        *until_ps = now + lsi_ps(dev, UPDATE_LSI_CYCLES);
    }
}

void hil_iwdg_event(void *device, uint64_t at)
{
    struct hil_iwdg_device *dev = device;
    (void)at;
    dev->core->state.counters.watchdog_resets++;
    hil_trace(dev->core, "watchdog expired");
    hil_core_request_reset(dev->core, CSR_IWDGRSTF);
}
