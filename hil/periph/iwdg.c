#include "hil/periph/iwdg.h"

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/refuse.h"
#include "hil/core/time.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"

#define KEY_RELOAD 0xaaaau
#define KEY_UNLOCK 0x5555u
#define KEY_START 0xccccu
#define CSR_IWDGRSTF (1u << 29)
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
    switch (offset) {
    case 0x00: /* KR reads as 0 */
        return 0;
    case 0x04:
        return w->pr;
    case 0x08:
        return w->rlr;
    case 0x0c:
        return (uint32_t)(now < w->pr_until_ps) | (uint32_t)(now < w->rlr_until_ps) << 1;
    default:
        return hil_bus_no_register(dev->core);
    }
}

static bool may_change(struct hil_iwdg_device *dev, bool updating)
{
    if (!dev->state->unlocked)
        hil_bus_refuse(dev->core, "the register is locked: silicon ignores the write");
    else if (updating)
        hil_bus_refuse(dev->core, "a value is still on its way (PVU, RVU): silicon ignores the write");
    return dev->state->unlocked && !updating;
}

void hil_iwdg_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_iwdg_device *dev = device;
    struct hil_iwdg *w = dev->state;
    uint64_t now = hil_now_ps(dev->core);
    (void)unit;
    switch (offset) {
    case 0x00:
        value &= 0xffffu;
        w->unlocked = value == KEY_UNLOCK;
        if (value == KEY_START) {
            if (!w->running) {
                w->running = true;
                hil_rcc_watchdog_starts(dev->rcc);
            }
            reload(dev);
        } else if (value == KEY_RELOAD) {
            reload(dev);
        }
        break;
    case 0x04:
        if (may_change(dev, now < w->pr_until_ps)) {
            w->pr = value & 7u;
            w->pr_until_ps = now + lsi_ps(dev, UPDATE_LSI_CYCLES);
        }
        break;
    case 0x08:
        if (may_change(dev, now < w->rlr_until_ps)) {
            w->rlr = value & 0xfffu;
            w->rlr_until_ps = now + lsi_ps(dev, UPDATE_LSI_CYCLES);
        }
        break;
    default:
        hil_bus_no_register(dev->core);
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
