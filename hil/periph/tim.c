#include "hil/periph/tim.h"

#include "hil/core/core.h"
#include "hil/core/nvic.h"
#include "hil/periph/adc.h"
#include "hil/periph/dma.h"
#include "hil/periph/gpio.h"
#include "hil/periph/options.h"
#include "hil/periph/rcc.h"
#include "hil/periph/rules.h"

#define CR1_CEN    1u
#define CR1_UDIS   2u
#define CR1_URS    4u
#define CR1_OPM    8u
#define CR1_ARPE   0x80u
#define SR_UIF     1u
#define SR_TIF     0x40u
#define SR_CC1IF   2u
#define SR_CC1OF   0x200u
#define DIER_CC1DE 0x200u
#define CR1        0x00u
#define CR2        0x04u
#define SMCR       0x08u
#define SR         0x10u
#define EGR        0x14u
#define CCMR1      0x18u
#define CCMR2      0x1cu
#define CCER       0x20u
#define CNT        0x24u
#define PSC        0x28u
#define ARR        0x2cu
#define CCR1       0x34u

static const enum hil_event_slot event_slots[HIL_TIMER_COUNT] = {HIL_EVENT_TIM2, HIL_EVENT_TIM4};
static const unsigned irq_numbers[HIL_TIMER_COUNT] = {HIL_IRQ_TIM2, HIL_IRQ_TIM4};

const struct hil_capture_pin hil_capture_pins[HIL_CAPTURE_CHANNELS] = {
    {0, 15, "PA15"}, {1, 3, "PB3"}, {1, 10, "PB10"}, {1, 11, "PB11"}};

static uint32_t get_counter_mask(unsigned unit)
{
    return unit == HIL_TIM2 ? 0xffffffffu : 0xffffu;
}

static uint64_t get_tick_cycles(const struct hil_tim_device *dev, const struct hil_tim *t)
{
    return (uint64_t)hil_rcc_timer_divider(dev->rcc, HIL_RCC_APB1) * (t->psc_shadow + 1ull);
}

static uint32_t get_count(const struct hil_tim_device *dev, const struct hil_tim *t, uint64_t at)
{
    if (!(t->cr1 & CR1_CEN) || at <= t->base_cycle)
        return t->base_count;
    return t->base_count + (uint32_t)((at - t->base_cycle) / get_tick_cycles(dev, t));
}

static uint32_t get_channel_mode(const struct hil_tim *t, unsigned channel)
{
    return t->ccmr[channel / 2u] >> (8u * (channel % 2u)) & 0xffu;
}

static bool is_output_channel(const struct hil_tim *t, unsigned channel)
{
    return (get_channel_mode(t, channel) & 3u) == 0;
}

static bool is_channel_enabled(const struct hil_tim *t, unsigned channel)
{
    return (t->ccer >> (4u * channel) & 1u) != 0;
}

static bool get_output_level(const struct hil_tim *t, unsigned channel)
{
    bool inverted = (t->ccer >> (4u * channel + 1u) & 1u) != 0;
    return is_output_channel(t, channel) && is_channel_enabled(t, channel) &&
           t->reference_level[channel] != inverted;
}

bool hil_tim4_output(const void *device, unsigned channel, bool *drives)
{
    const struct hil_tim_device *dev = device;
    const struct hil_tim *t = &dev->state[HIL_TIM4];
    *drives = is_output_channel(t, channel) && is_channel_enabled(t, channel);
    return get_output_level(t, channel);
}

static void update_irq(struct hil_tim_device *dev, unsigned unit)
{
    const struct hil_tim *t = &dev->state[unit];
    hil_irq_set_line(dev->core, irq_numbers[unit], (t->sr & t->dier & 0x5fu) != 0);
}

/* Schedules the next change after `at` that the timer makes by itself. */
static void schedule_next_event(struct hil_tim_device *dev, unsigned unit, uint64_t at)
{
    const struct hil_tim *t = &dev->state[unit];
    uint64_t next = HIL_NEVER;
    for (unsigned i = 0; i < HIL_CAPTURE_CHANNELS; i++)
        next = t->capture_cycle[i] < next ? t->capture_cycle[i] : next;
    if (t->cr1 & CR1_CEN) {
        uint64_t tick = get_tick_cycles(dev, t);
        uint32_t count = get_count(dev, t, at);
        uint64_t wrap = count > t->arr_shadow ? (uint64_t)get_counter_mask(unit) + 1u
                                              : (uint64_t)t->arr_shadow + 1u;
        uint64_t ticks = wrap - t->base_count;
        for (unsigned i = 0; i < 4; i++) {
            uint32_t match = t->ccr_shadow[i];
            if (is_output_channel(t, i) && match > count && match < wrap &&
                match - t->base_count < ticks)
                ticks = match - t->base_count;
        }
        if (t->base_cycle + ticks * tick < next)
            next = t->base_cycle + ticks * tick;
    }
    hil_event_set_cycle(dev->core, event_slots[unit], next);
}

/* Returns the reference level of a channel at the present count. `match`: the count equals CCR, at
 * which some modes change the level. */
static bool get_next_reference(const struct hil_tim *t, unsigned channel, uint32_t count,
                               bool match)
{
    bool now = t->reference_level[channel];
    switch (get_channel_mode(t, channel) >> 4 & 7u) {
    case 1: return match ? true : now;
    case 2: return match ? false : now;
    case 3: return match ? !now : now;
    case 4: return false;
    case 5: return true;
    case 6: return count < t->ccr_shadow[channel];
    case 7: return count >= t->ccr_shadow[channel];
    default: return now;
    }
}

/* Triggers converters from the outputs of these timers (RM0090 table 69). */
static void trigger_converters(struct hil_tim_device *dev, unsigned unit, unsigned channel,
                               bool rising, uint64_t at)
{
    static const int8_t extsel[HIL_TIMER_COUNT][4] = {{-1, 3, 4, 5}, {-1, -1, -1, 9}};
    if (extsel[unit][channel] >= 0)
        hil_adc_trigger(dev->adc, (unsigned)extsel[unit][channel], rising, at);
}

struct output_levels {
    bool level[4];
};

static struct output_levels get_output_levels(const struct hil_tim *t)
{
    struct output_levels levels;
#pragma GCC unroll 4
    for (unsigned i = 0; i < 4; i++)
        levels.level[i] = get_output_level(t, i);
    return levels;
}

/* Reports outputs that changed since `before` to pins and converters, all channels at once. */
static void notify_outputs(struct hil_tim_device *dev, unsigned unit, struct output_levels before,
                           uint64_t at)
{
    struct output_levels after = get_output_levels(&dev->state[unit]);
    if (unit == HIL_TIM4 &&
        (after.level[0] != before.level[0] || after.level[1] != before.level[1]))
        hil_gpio_notify_timer(dev->gpio, at);
    for (unsigned i = 0; i < 4; i++) {
        if (after.level[i] != before.level[i])
            trigger_converters(dev, unit, i, after.level[i], at);
    }
}

static void refresh_references(struct hil_tim_device *dev, unsigned unit, uint64_t at)
{
    struct hil_tim *t = &dev->state[unit];
    uint32_t count = get_count(dev, t, at);
    for (unsigned i = 0; i < 4; i++) {
        if (is_output_channel(t, i))
            t->reference_level[i] = get_next_reference(t, i, count, false);
    }
}

static void load_preloads(struct hil_tim *t)
{
    t->psc_shadow = t->psc;
    t->arr_shadow = t->arr;
    for (unsigned i = 0; i < 4; i++) {
        if (is_output_channel(t, i))
            t->ccr_shadow[i] = t->ccr[i];
    }
}

/* TIM4's trigger output starts TIM2 if TIM2 waits for it (trigger mode, ITR3). */
static void trigger_slave_timer(struct hil_tim_device *dev, unsigned unit, uint64_t at)
{
    struct hil_tim *slave = &dev->state[HIL_TIM2];
    if (unit != HIL_TIM4 || (slave->smcr & 0x77u) != 0x36u)
        return;
    slave->sr |= SR_TIF;
    if (!(slave->cr1 & CR1_CEN)) {
        slave->cr1 |= CR1_CEN;
        slave->base_cycle = at;
        schedule_next_event(dev, HIL_TIM2, at);
    }
    update_irq(dev, HIL_TIM2);
}

static void update_event(struct hil_tim_device *dev, unsigned unit, uint64_t at, bool by_software)
{
    struct hil_tim *t = &dev->state[unit];
    t->base_cycle = at;
    t->base_count = 0;
    if (t->cr1 & CR1_UDIS)
        return;
    load_preloads(t);
    if (!(by_software && (t->cr1 & CR1_URS)))
        t->sr |= SR_UIF;
    if ((t->cr2 >> 4 & 7u) == 2u)
        trigger_slave_timer(dev, unit, at);
    if ((t->cr1 & CR1_OPM) && !by_software)
        t->cr1 &= ~CR1_CEN;
}

static void capture_edge(struct hil_tim_device *dev, struct hil_tim *t, unsigned channel,
                         uint64_t at)
{
    /* streams of DMA1 for the capture channels of TIM2, all on request channel 3 (RM0090 table
     * 42) */
    static const uint8_t stream[HIL_CAPTURE_CHANNELS] = {5, 6, 1, 7};
    unsigned every = 1u << (get_channel_mode(t, channel) >> 2 & 3u);
    t->capture_cycle[channel] = HIL_NEVER;
    if (++t->edges_since_capture[channel] < every)
        return;
    t->edges_since_capture[channel] = 0;
    t->ccr[channel] = t->ccr_shadow[channel] = get_count(dev, t, at);
    if (t->sr & SR_CC1IF << channel)
        t->sr |= SR_CC1OF << channel;
    t->sr |= SR_CC1IF << channel;
    if (channel == 0)
        dev->core->state.counters.edges_captured++;
    else if (channel == 1)
        dev->core->state.counters.film_frames_captured++;
    if (t->dier & DIER_CC1DE << channel)
        hil_dma_move_register(dev->dma, 0, stream[channel], 3);
}

static void handle_event(struct hil_tim_device *dev, unsigned unit, uint64_t at)
{
    struct hil_tim *t = &dev->state[unit];
    for (unsigned i = 0; i < HIL_CAPTURE_CHANNELS; i++) {
        if (t->capture_cycle[i] <= at)
            capture_edge(dev, t, i, at);
    }
    /* without clock enable, or before base_cycle, the counter does not run */
    if ((t->cr1 & CR1_CEN) && at >= t->base_cycle) {
        struct output_levels before = get_output_levels(t);
        uint64_t tick = get_tick_cycles(dev, t), ticks = (at - t->base_cycle) / tick;
        bool on_tick = ticks * tick == at - t->base_cycle;
        uint64_t count = t->base_count + ticks;
        if (on_tick && ticks &&
            (count == (uint64_t)t->arr_shadow + 1u || count > get_counter_mask(unit))) {
            update_event(dev, unit, at, false);
            count = 0;
        }
        for (unsigned i = 0; on_tick && i < 4; i++) {
            if (!is_output_channel(t, i))
                continue;
            bool match = t->ccr_shadow[i] == count;
            if (match)
                t->sr |= 2u << i;
            t->reference_level[i] = get_next_reference(t, i, (uint32_t)count, match);
        }
        notify_outputs(dev, unit, before, at);
    }
    update_irq(dev, unit);
    schedule_next_event(dev, unit, at);
}

void hil_tim_freeze_until(struct hil_tim_device *dev, unsigned unit, uint64_t until_cycle)
{
    struct hil_tim *t = &dev->state[unit];
    uint64_t now = hil_now_cycle(dev->core);
    if (!(t->cr1 & CR1_CEN))
        return;
    t->base_count = get_count(dev, t, now);
    t->base_cycle = until_cycle;
    schedule_next_event(dev, unit, now);
}

void hil_tim2_event(void *device, uint64_t at)
{
    handle_event(device, HIL_TIM2, at);
}
void hil_tim4_event(void *device, uint64_t at)
{
    handle_event(device, HIL_TIM4, at);
}

/* Delay of a channel's input filter in timer clocks (CCMR1.ICxF, CR1.CKD). */
static uint32_t get_filter_clocks(const struct hil_tim *t, unsigned channel)
{
    static const uint16_t of_dts[16] = {0,  2,  4,  8,  12,  16,  24,  32,
                                        48, 64, 80, 96, 128, 160, 192, 256};
    uint32_t f = get_channel_mode(t, channel) >> 4;
    uint32_t dts = 1u << (t->cr1 >> 8 & 3u);
    return f < 4 ? of_dts[f] : of_dts[f] * dts;
}

uint64_t hil_tim2_capture_delay(const struct hil_tim_device *dev, unsigned channel)
{
    return (uint64_t)get_filter_clocks(&dev->state[HIL_TIM2], channel) *
           hil_rcc_timer_divider(dev->rcc, HIL_RCC_APB1);
}

void hil_tim2_input_edge(void *device, unsigned channel, bool level, uint64_t at)
{
    struct hil_tim_device *dev = device;
    struct hil_tim *t = &dev->state[HIL_TIM2];
    uint64_t *cycle = &t->capture_cycle[channel];
    uint32_t enables = t->ccer >> (4u * channel);
    if (*cycle != HIL_NEVER && *cycle > at && level != t->capture_level[channel])
        *cycle = HIL_NEVER; /* a pulse shorter than the filter has no effect */
    if ((get_channel_mode(t, channel) & 3u) == 1u && is_channel_enabled(t, channel)) {
        bool falling = (enables & 2u) != 0, both = falling && (enables & 8u);
        if (both || level != falling) {
            *cycle = at + hil_tim2_capture_delay(dev, channel);
            t->capture_level[channel] = level;
        }
    }
    schedule_next_event(dev, HIL_TIM2, at);
}

void hil_tim_reset(void *device, unsigned unit)
{
    struct hil_tim_device *dev = device;
    struct hil_tim *t = &dev->state[unit];
    struct output_levels before = get_output_levels(t);
    *t = (struct hil_tim){.capture_cycle = {HIL_NEVER, HIL_NEVER, HIL_NEVER, HIL_NEVER}};
    t->arr = t->arr_shadow = get_counter_mask(unit);
    hil_event_set_cycle(dev->core, event_slots[unit], HIL_NEVER);
    update_irq(dev, unit);
    notify_outputs(dev, unit, before, hil_now_cycle(dev->core));
}

uint32_t hil_tim_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_tim_device *dev = device;
    struct hil_tim *t = &dev->state[unit];
    if (offset == CNT)
        return get_count(dev, t, hil_now_cycle(dev->core));
    unsigned channel = (offset - CCR1) / 4u;
    if (offset >= CCR1 && !is_output_channel(t, channel)) {
        t->sr &= ~(2u << channel);
        update_irq(dev, unit);
    }
    return t->word[offset / 4u];
}

static void write_cr1(struct hil_tim_device *dev, unsigned unit, uint32_t value)
{
    struct hil_tim *t = &dev->state[unit];
    uint64_t now = hil_now_cycle(dev->core);
    uint32_t count = get_count(dev, t, now);
    bool was_on = (t->cr1 & CR1_CEN) != 0;
    t->cr1 = value;
    if (was_on && !(value & CR1_CEN)) {
        t->base_count = count;
    } else if (!was_on && (value & CR1_CEN)) {
        t->base_cycle = now;
        refresh_references(dev, unit, now);
        if ((t->cr2 >> 4 & 7u) == 1u)
            trigger_slave_timer(dev, unit, now);
    }
}

static void check_channels(struct hil_tim_device *dev, unsigned unit)
{
    const struct hil_tim *t = &dev->state[unit];
    for (unsigned i = 0; i < 4; i++) {
        uint32_t select = get_channel_mode(t, i) & 3u;
        if (select && !(unit == HIL_TIM2 && select == 1))
            hil_bus_refuse(dev->core, "input capture other than TIM2's from their own pins");
        if (!select && (get_channel_mode(t, i) & 0x84u))
            hil_bus_refuse(dev->core, "fast or cleared output compare");
    }
}

static void write_ccr(struct hil_tim_device *dev, unsigned unit, unsigned channel, uint32_t value)
{
    struct hil_tim *t = &dev->state[unit];
    if (!is_output_channel(t, channel))
        return; /* CCR is read-only in capture mode */
    t->ccr[channel] = value & get_counter_mask(unit);
    if (!(get_channel_mode(t, channel) & 8u))
        t->ccr_shadow[channel] = t->ccr[channel];
    refresh_references(dev, unit, hil_now_cycle(dev->core));
}

/* Checks the rule FLOATING for capture inputs, which something must drive or pull. */
static void check_inputs(struct hil_tim_device *dev)
{
    const struct hil_tim *t = &dev->state[HIL_TIM2];
    for (unsigned i = 0; i < HIL_CAPTURE_CHANNELS; i++) {
        const struct hil_capture_pin *pin = &hil_capture_pins[i];
        if (is_output_channel(t, i) || !is_channel_enabled(t, i) ||
            hil_gpio_alternate_function(dev->gpio, pin->port, pin->pin) != 1)
            continue;
        if (hil_gpio_has_defined_level(dev->gpio, pin->port, pin->pin))
            hil_rules_record_pass(dev->rules, HIL_RULE_FLOATING);
        else
            hil_rules_record_violation(
                dev->rules, HIL_RULE_FLOATING, hil_access_timestamp(dev->core).pc,
                "TIM2 captures edges of %s, but nothing drives or pulls it", pin->name);
    }
}

void hil_tim_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_tim_device *dev = device;
    struct hil_tim *t = &dev->state[unit];
    uint64_t now = hil_now_cycle(dev->core);
    struct output_levels before = get_output_levels(t);
    switch (offset) {
    case CR1: write_cr1(dev, unit, value); break;
    case SR: /* flags are cleared by writing 0 */ t->sr &= value; break;
    case EGR:
        if (value & 1u)
            update_event(dev, unit, now, true);
        break;
    case CNT:
        t->base_count = value & get_counter_mask(unit);
        t->base_cycle = now;
        break;
    case PSC: /* PSC is always preloaded */ t->psc = value & 0xffffu; break;
    case ARR:
        t->arr = value & get_counter_mask(unit);
        if (!(t->cr1 & CR1_ARPE))
            t->arr_shadow = t->arr;
        break;
    default:
        if (offset >= CCR1) {
            write_ccr(dev, unit, (offset - CCR1) / 4u, value);
            break;
        }
        t->word[offset / 4u] = value;
        if (offset == CR2 && (value >> 4 & 7u) > 2u)
            hil_bus_refuse(dev->core, "master mode other than reset, enable, update");
        if (offset == SMCR && (value & 7u) && (value & 0xff7fu) != 0x36u)
            hil_bus_refuse(dev->core, "slave mode other than TIM2 triggered by TIM4");
        if (offset == CCMR1 || offset == CCMR2)
            check_channels(dev, unit);
        if (offset >= CCMR1 && offset <= CCER)
            refresh_references(dev, unit, now);
        if (offset == CCER && unit == HIL_TIM2)
            check_inputs(dev);
        break;
    }
    notify_outputs(dev, unit, before, now);
    update_irq(dev, unit);
    schedule_next_event(dev, unit, now);
}

/* ---- tim11 ---- */

#define CCER_CC1E  1u
#define SR11_CC1IF (1u << 1)
#define SR11_CC1OF (1u << 9)
#define OR_HSE_RTC 2u
#define CR_HSERDY  (1u << 17)

void hil_tim11_reset(void *device, unsigned unit)
{
    struct hil_tim11_device *dev = device;
    (void)unit;
    *dev->state = (struct hil_tim11){.arr = 0xffff, .start_ps = HIL_NEVER};
}

/* Time between two captures; HIL_NEVER without a crystal signal. */
static uint64_t get_period_ps(const struct hil_tim11_device *dev)
{
    const struct hil_tim11 *t = dev->state;
    const struct hil_rcc *rcc = dev->rcc->state;
    uint32_t divider = rcc->cfgr >> 16 & 0x1fu;
    if (t->or != OR_HSE_RTC || divider < 2 || !(rcc->cr & CR_HSERDY))
        return HIL_NEVER;
    return HIL_PS_PER_S * divider * (1u << (t->ccmr1 >> 2 & 3u)) / dev->options->hse_hz;
}

static uint32_t get_tim11_count(const struct hil_tim11_device *dev, uint64_t at_ps)
{
    const struct hil_tim11 *t = dev->state;
    uint64_t hz = dev->core->state.clock.hclk_hz / hil_rcc_timer_divider(dev->rcc, HIL_RCC_APB2);
    if (t->start_ps == HIL_NEVER)
        return t->cnt;
    double ticks = (double)(at_ps - t->start_ps) * 1e-12 * (double)hz;
    return (uint32_t)((uint64_t)ticks / (t->psc + 1u)) & 0xffffu;
}

/* Counts the captures up to now. */
static void advance(struct hil_tim11_device *dev)
{
    struct hil_tim11 *t = dev->state;
    uint64_t period = get_period_ps(dev), now = hil_now_ps(dev->core);
    if (t->start_ps == HIL_NEVER || period == HIL_NEVER)
        return;
    uint64_t captures = (now - t->start_ps) / period;
    if (captures == t->capture_count)
        return;
    if ((t->sr & SR11_CC1IF) || captures - t->capture_count > 1)
        t->sr |= SR11_CC1OF;
    t->sr |= SR11_CC1IF;
    t->capture_count = captures;
    t->ccr1 = get_tim11_count(dev, t->start_ps + captures * period);
}

uint32_t hil_tim11_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_tim11_device *dev = device;
    (void)unit;
    advance(dev);
    if (offset == CCR1)
        dev->state->sr &= ~SR11_CC1IF;
    return offset == CNT ? get_tim11_count(dev, hil_now_ps(dev->core))
                         : dev->state->word[offset / 4u];
}

void hil_tim11_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_tim11_device *dev = device;
    struct hil_tim11 *t = dev->state;
    (void)unit;
    advance(dev);
    if (offset == SR) /* flags are cleared by writing 0 */
        t->sr &= value;
    else
        t->word[offset / 4u] = value;
    bool on = (t->cr1 & CR1_CEN) && (t->ccer & CCER_CC1E);
    if (on && t->start_ps == HIL_NEVER) {
        t->start_ps = hil_now_ps(dev->core);
        t->capture_count = 0;
    } else if (!on) {
        t->start_ps = HIL_NEVER;
    }
}
