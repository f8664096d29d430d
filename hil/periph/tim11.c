#include "hil/periph/tim11.h"

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/time.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"

#define SR         0x10u
#define CNT        0x24u
#define CCR1       0x34u
#define CR1_CEN    1u
#define CCER_CC1E  1u
#define SR_CC1IF   (1u << 1)
#define SR_CC1OF   (1u << 9)
#define OR_HSE_RTC 2u
#define CR_HSERDY  (1u << 17)

void hil_tim11_reset(void *device, unsigned unit)
{
    struct hil_tim11_device *dev = device;
    (void)unit;
    *dev->state = (struct hil_tim11){.arr = 0xffff, .began_ps = HIL_NEVER};
}

/* Between two captures; HIL_NEVER: nothing comes. */
static uint64_t period_ps(const struct hil_tim11_device *dev)
{
    const struct hil_tim11 *t = dev->state;
    const struct hil_rcc *rcc = dev->rcc->state;
    uint32_t divider = rcc->cfgr >> 16 & 0x1fu;
    if (t->or != OR_HSE_RTC || divider < 2 || !(rcc->cr & CR_HSERDY))
        return HIL_NEVER;
    return HIL_SECOND_PS * divider * (1u << (t->ccmr1 >> 2 & 3u)) / dev->options->hse_hz;
}

static uint32_t count_at(const struct hil_tim11_device *dev, uint64_t at_ps)
{
    const struct hil_tim11 *t = dev->state;
    uint64_t hz = dev->core->state.clock.hclk_hz / hil_rcc_apb2_timer_divider(dev->rcc);
    if (t->began_ps == HIL_NEVER)
        return t->cnt;
    double ticks = (double)(at_ps - t->began_ps) * 1e-12 * (double)hz;
    return (uint32_t)((uint64_t)ticks / (t->psc + 1u)) & 0xffffu;
}

/* What was captured up to now. */
static void catch_up(struct hil_tim11_device *dev)
{
    struct hil_tim11 *t = dev->state;
    uint64_t period = period_ps(dev), now = hil_now_ps(dev->core);
    if (t->began_ps == HIL_NEVER || period == HIL_NEVER)
        return;
    uint64_t captures = (now - t->began_ps) / period;
    if (captures == t->captures)
        return;
    if ((t->sr & SR_CC1IF) || captures - t->captures > 1)
        t->sr |= SR_CC1OF;
    t->sr |= SR_CC1IF;
    t->captures = captures;
    t->ccr1 = count_at(dev, t->began_ps + captures * period);
}

uint32_t hil_tim11_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_tim11_device *dev = device;
    (void)unit;
    catch_up(dev);
    if (offset == CCR1)
        dev->state->sr &= ~SR_CC1IF;
    return offset == CNT ? count_at(dev, hil_now_ps(dev->core)) : dev->state->word[offset / 4u];
}

void hil_tim11_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_tim11_device *dev = device;
    struct hil_tim11 *t = dev->state;
    (void)unit;
    catch_up(dev);
    if (offset == SR) /* zeroes clear */
        t->sr &= value;
    else
        t->word[offset / 4u] = value;
    bool on = (t->cr1 & CR1_CEN) && (t->ccer & CCER_CC1E);
    if (on && t->began_ps == HIL_NEVER) {
        t->began_ps = hil_now_ps(dev->core);
        t->captures = 0;
    } else if (!on) {
        t->began_ps = HIL_NEVER;
    }
}
