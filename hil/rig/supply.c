#include "hil/rig/supply.h"

#include "hil/chips/tmp112.h"
#include "hil/chips/w25q.h"
#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/periph/flash.h"
#include "hil/periph/rcc.h"

#define CSR_BROWN_OUT (1u << 25)
#define POWER_DOWN_V  1.68

void hil_supply_cut(struct hil_supply_device *dev)
{
    struct hil_core *core = dev->core;
    core->state.counters.power_cuts++;
    hil_trace(core, "power cut");
    hil_flash_power_lost(dev->flash);
    hil_w25q_power_lost(dev->nor);
    hil_tmp112_power(dev->thermometer);
    core->reset.power_lost = core->reset.asked = true;
    core->reset.flags = HIL_CSR_POWER_ON;
    hil_core_attend(core);
}

void hil_supply_off(struct hil_supply_device *dev, uint64_t duration_ps)
{
    hil_supply_cut(dev);
    dev->core->reset.hold_ps = hil_now_ps(dev->core) + duration_ps;
}

/* Volts at which the chip goes into reset: DS8626, embedded reset and power control block, typical,
 * falling. */
static double brown_out_volts(const struct hil_supply_device *dev)
{
    static const double level[4] = {2.83, 2.50, 2.19, POWER_DOWN_V}; /* OPTCR.BOR_LEV; 3: off */
    return level[dev->flash->state->options >> 2 & 3u];
}

void hil_supply_dip(struct hil_supply_device *dev, double volts, uint64_t duration_ps)
{
    /* RM0090 table 10: HCLK for each wait state, by supply. */
    double hz_by_wait_state = volts >= 2.7 ? 30e6
                            : volts >= 2.4 ? 24e6
                            : volts >= 2.1 ? 22e6
                                           : 20e6;
    if (volts < POWER_DOWN_V) {
        hil_supply_off(dev, duration_ps);
    } else if (volts < brown_out_volts(dev)) {
        hil_core_request_reset(dev->core, CSR_BROWN_OUT);
        dev->core->reset.hold_ps = hil_now_ps(dev->core) + duration_ps;
    } else if (volts < 1.8 || dev->core->state.clock.hclk_hz >
                                  hz_by_wait_state * ((dev->rcc->state->flash_acr & 7u) + 1u)) {
        hil_core_stop(dev->core, MR_HALTED,
                      "supply of %.2f V: silicon could not run at HCLK %u Hz with %u wait states, "
                      "and the option bytes "
                      "let it try (brown-out reset below %.2f V)",
                      volts, (unsigned)dev->core->state.clock.hclk_hz,
                      (unsigned)(dev->rcc->state->flash_acr & 7u), brown_out_volts(dev));
    }
}

static void on_return(void *device, uint64_t at)
{
    struct hil_supply_device *dev = device;
    (void)at;
    dev->state->held_in_reset = false;
    hil_w25q_power_back(dev->nor);
    hil_trace(dev->core, "reset released");
}

void hil_supply_hold(struct hil_supply_device *dev)
{
    struct hil_reset *reset = &dev->core->reset;
    dev->state->held_in_reset = reset->hold_ps > hil_now_ps(dev->core);
    if (dev->state->held_in_reset)
        hil_event_set_ps(dev->core, HIL_EVENT_POWER, reset->hold_ps);
    reset->hold_ps = 0;
}

void hil_supply_create(struct hil_supply_device *dev)
{
    hil_event_wire(dev->core, HIL_EVENT_POWER, on_return, dev);
}
