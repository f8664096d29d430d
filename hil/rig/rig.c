#include "hil/rig/rig.h"

#include <math.h>

#include "hil/core/core.h"
#include "hil/core/event.h"

#define PORT_D              3u
#define PORT_E              4u
#define STAIRCASE_ZERO_V    0.050
#define STAIRCASE_TAU_S     20e-6
#define GAGE_ZERO_V         0.400
#define GAGE_V_PER_LB       0.005
#define REFERENCE_V         2.500
#define TRANSDUCER_MID_V    1.65
#define TRANSDUCER_ZERO_V   0.050
#define TRANSDUCER_V_PER_IN 0.5
#define TRANSDUCER_TAU_S    4e-6
#define CHANNEL_STAIRCASE   22u
#define CHANNEL_REFERENCE   23u
#define SETTLED_TAUS        40.0 /* exp(-40) of full scale is 1e-14 codes */

unsigned hil_rig_step_codes(unsigned position)
{
    return 64u + 8u * (7u * (position - 1u) % 24u);
}

static void schedule(struct hil_rig_device *dev)
{
    const struct hil_rig *rig = dev->state;
    uint64_t next = rig->pulse_end_ps;
    if (dev->run && rig->opened < rig->order_count) {
        uint64_t opens = dev->run->switch_open_ps[rig->order[rig->opened]];
        if (opens < next)
            next = opens;
    }
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        if (rig->contact[i].bounces && rig->contact[i].next_ps < next)
            next = rig->contact[i].next_ps;
    }
    hil_event_set_ps(dev->core, HIL_EVENT_RIG, next);
}

void hil_rig_start(struct hil_rig_device *dev)
{
    struct hil_rig *rig = dev->state;
    *rig = (struct hil_rig){.pulse_end_ps = HIL_NEVER};
    for (unsigned i = 0; dev->run && i < HIL_RUN_SWITCHES; i++) {
        uint64_t t_ps = dev->run->switch_open_ps[i];
        rig->contact[i].next_ps = HIL_NEVER;
        if (t_ps == HIL_RUN_NEVER)
            continue;
        unsigned place = rig->order_count++;
        for (; place && dev->run->switch_open_ps[rig->order[place - 1]] > t_ps; place--)
            rig->order[place] = rig->order[place - 1];
        rig->order[place] = (uint8_t)i;
    }
    schedule(dev);
}

/* Where the staircase's part of a contact stands, 0 to 1. */
static double contact_level(const struct hil_contact *contact, double t_s)
{
    double taus = (t_s - (double)contact->since_ps * 1e-12) / STAIRCASE_TAU_S;
    double target = contact->open;
    if (taus > SETTLED_TAUS)
        return target;
    return taus > 0.0 ? target + (contact->level - target) * exp(-taus) : contact->level;
}

static void move_contact(struct hil_rig_device *dev, unsigned i, bool open, uint64_t t_ps,
                         uint64_t at)
{
    struct hil_rig *rig = dev->state;
    struct hil_contact *contact = &rig->contact[i];
    hil_adc_catch_up(dev->adc, at); /* what was sampled before saw the old state */
    contact->level = contact->moved ? contact_level(contact, (double)t_ps * 1e-12) : 0.0;
    contact->moved = true;
    contact->open = open;
    contact->since_ps = t_ps;
    hil_trace(dev->core, "switch %u %s", i + 1u, open ? "opens" : "closes");
    if (!open)
        return;
    rig->pulse_end_ps = t_ps + HIL_RIG_PULSE_PS;
    dev->core->state.counters.switches_opened++;
    hil_gpio_drive(dev->gpio, 0, 15, true, at);
}

static void bounce(struct hil_rig_device *dev, unsigned i, uint64_t at)
{
    struct hil_contact *contact = &dev->state->contact[i];
    uint64_t t_ps = contact->next_ps;
    bool opens = !contact->open;
    move_contact(dev, i, opens, t_ps, at);
    if (opens)
        contact->bounces--;
    contact->next_ps = contact->bounces ? t_ps + contact->period_ps / 2u : HIL_NEVER;
}

static void on_event(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    struct hil_rig *rig = dev->state;
    uint64_t now_ps = hil_clock_ps(&dev->core->state.clock, at);
    if (rig->pulse_end_ps <= now_ps) {
        rig->pulse_end_ps = HIL_NEVER;
        hil_gpio_drive(dev->gpio, 0, 15, false, at);
    }
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        while (rig->contact[i].bounces && rig->contact[i].next_ps <= now_ps)
            bounce(dev, i, at);
    }
    while (dev->run && rig->opened < rig->order_count &&
           dev->run->switch_open_ps[rig->order[rig->opened]] <= now_ps) {
        unsigned i = rig->order[rig->opened++];
        struct hil_contact *contact = &rig->contact[i];
        uint64_t opens = dev->run->switch_open_ps[i];
        if (contact->skipped)
            continue;
        move_contact(dev, i, true, opens, at);
        contact->next_ps = contact->bounces ? opens + contact->period_ps / 2u : HIL_NEVER;
    }
    schedule(dev);
}

bool hil_rig_lamp_draws(const struct hil_rig_device *dev)
{
    enum hil_lamp lamp = (enum hil_lamp)dev->state->lamp;
    return lamp == HIL_LAMP_SHORTED || (lamp == HIL_LAMP_GOOD && !hil_gpio_level(dev->gpio, 4, 0));
}

void hil_rig_skip(struct hil_rig_device *dev, unsigned position)
{
    dev->state->contact[position].skipped = true;
}

void hil_rig_bounce(struct hil_rig_device *dev, unsigned position, uint32_t times,
                    uint64_t period_ps)
{
    struct hil_contact *contact = &dev->state->contact[position];
    contact->bounces = (uint8_t)times;
    contact->period_ps = period_ps;
    contact->next_ps = HIL_NEVER;
}

/* What is left of a step after `taus`. The converters look after the same few times in every scan:
 * those are remembered. */
static double rest_after(struct hil_rig_device *dev, uint64_t cycles, double taus)
{
    struct hil_settling *known = &dev->settling[cycles / HIL_SETTLING_CYCLES % HIL_SETTLINGS];
    if (known->rest <= 0.0 || known->taus != taus)
        *known = (struct hil_settling){taus, exp(-taus)};
    return known->rest;
}

/* Amplitude of the excitation at the transducers, -1 to 1. */
static double amplitude(struct hil_rig_device *dev, uint64_t at)
{
    const struct hil_rig *rig = dev->state;
    double taus = (double)(at - rig->since_cycle) / dev->core->state.clock.hclk_hz /
                  TRANSDUCER_TAU_S;
    if (at < rig->since_cycle || taus > SETTLED_TAUS)
        return rig->excitation;
    return rig->excitation +
           (rig->from - rig->excitation) * rest_after(dev, at - rig->since_cycle, taus);
}

void hil_rig_count_excitation(struct hil_rig_device *dev, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    uint64_t now_ps = hil_clock_ps(&dev->core->state.clock, at);
    if (now_ps <= rig->since_ps)
        return;
    if (rig->excitation > 0)
        dev->core->state.counters.excitation_plus_ps += now_ps - rig->since_ps;
    else if (rig->excitation < 0)
        dev->core->state.counters.excitation_minus_ps += now_ps - rig->since_ps;
    rig->since_ps = now_ps;
}

void hil_rig_excitation(struct hil_rig_device *dev, bool pd12, bool pd13, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    int8_t wanted = (int8_t)(pd12 - pd13);
    if (wanted == rig->excitation)
        return;
    hil_adc_catch_up(dev->adc, at); /* what was sampled before saw the old polarity */
    hil_rig_count_excitation(dev, at);
    rig->from = amplitude(dev, at);
    rig->excitation = wanted;
    rig->since_cycle = at;
    rig->since_ps = hil_clock_ps(&dev->core->state.clock, at);
}

static void switch_shunts(struct hil_rig_device *dev, bool on, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    if (on == rig->shunted)
        return;
    hil_adc_catch_up(dev->adc, at);
    rig->shunted = on;
    hil_trace(dev->core, "shunts %s", on ? "on" : "off");
}

void hil_rig_drift(struct hil_rig_device *dev, unsigned gage, double gain, double offset_lb)
{
    hil_adc_catch_up(dev->adc, hil_now(dev->core));
    dev->state->gain_drift[gage] = gain - 1.0;
    dev->state->offset_lb[gage] = offset_lb;
}

static double gage_volts(const struct hil_rig *rig, unsigned gage, double tension_lb)
{
    double lb = (1.0 + rig->gain_drift[gage]) *
                    (tension_lb + (rig->shunted ? HIL_RIG_SHUNT_LB : 0.0)) +
                rig->offset_lb[gage];
    return GAGE_ZERO_V + GAGE_V_PER_LB * lb;
}

static double staircase_volts(const struct hil_rig_device *dev, double t_s)
{
    const struct hil_rig *rig = dev->state;
    double codes = 0.0;
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        if (rig->contact[i].moved)
            codes += hil_rig_step_codes(i + 1u) * contact_level(&rig->contact[i], t_s);
    }
    return STAIRCASE_ZERO_V + codes * HIL_VREF_V / 4096.0;
}

/* Number of the strain gage on a pin, 1..14, or 0. */
static unsigned gage_on(unsigned port, unsigned pin)
{
    if (port == 0 && pin < 8)
        return pin + 1;
    if (port == 1 && pin < 2)
        return pin + 9;
    return port == 2 && pin < 4 ? pin + 11 : 0;
}

int hil_rig_channel(unsigned port, unsigned pin)
{
    unsigned gage = gage_on(port, pin);
    if (gage)
        return (int)(HIL_RUN_TRANSDUCERS + gage - 1u);
    if (port == 5 && pin >= 3 && pin <= 10)
        return (int)pin - 3;
    return port == 2 && (pin == 4 || pin == 5) ? (int)pin + 18 : -1;
}

/* What a channel's sensor is exposed to: inches, pounds; volts of staircase and reference. */
static double quantity(const struct hil_rig_device *dev, unsigned channel, double t_s)
{
    if (channel == CHANNEL_STAIRCASE)
        return staircase_volts(dev, t_s);
    if (channel == CHANNEL_REFERENCE)
        return REFERENCE_V;
    return dev->run ? hil_run_truth(dev->run, channel, t_s) : 0.0;
}

/* Nothing moves where there is no run: the time of each conversion costs more than the rest of
 * it. */
static double quantity_at(const struct hil_rig_device *dev, unsigned channel, uint64_t at)
{
    if (dev->run)
        return quantity(dev, channel, (double)hil_clock_ps(&dev->core->state.clock, at) * 1e-12);
    return channel == CHANNEL_STAIRCASE ? STAIRCASE_ZERO_V
         : channel == CHANNEL_REFERENCE ? REFERENCE_V
                                        : 0.0;
}

void hil_rig_fail(struct hil_rig_device *dev, unsigned channel, enum hil_channel_fault fault)
{
    hil_adc_catch_up(dev->adc, hil_now(dev->core));
    dev->state->channel_fault[channel] = (uint8_t)fault;
    dev->state->held[channel] = quantity(dev, channel, (double)hil_now_ps(dev->core) * 1e-12);
}

double hil_rig_channel_volts(void *device, int channel, uint64_t at)
{
    struct hil_rig_device *dev = device;
    if (channel < 0)
        return 0.0;
    enum hil_channel_fault fault = (enum hil_channel_fault)dev->state->channel_fault[channel];
    if (fault > HIL_CHANNEL_STUCK)
        return fault == HIL_CHANNEL_HIGH ? HIL_VREF_V : 0.0;
    double value = fault == HIL_CHANNEL_STUCK ? dev->state->held[channel]
                                              : quantity_at(dev, (unsigned)channel, at);
    if (channel < (int)HIL_RUN_TRANSDUCERS)
        return TRANSDUCER_MID_V +
               amplitude(dev, at) * (TRANSDUCER_ZERO_V + TRANSDUCER_V_PER_IN * value);
    return channel < (int)HIL_RUN_COLUMNS
             ? gage_volts(dev->state, (unsigned)channel - HIL_RUN_TRANSDUCERS, value)
             : value;
}

/* --- what it is connected to --- */

static void look_at_excitation(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    hil_rig_excitation(dev, hil_gpio_level(dev->gpio, PORT_D, 12),
                       hil_gpio_level(dev->gpio, PORT_D, 13), at);
}

static void look_at_shunts(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    switch_shunts(dev, hil_gpio_level(dev->gpio, PORT_E, 1), at);
}

/* PE3 is low while the lamp draws current. */
static bool lamp_sense(const void *device, unsigned channel, bool *drives)
{
    (void)channel;
    *drives = true;
    return !hil_rig_lamp_draws(device);
}

void hil_rig_create(struct hil_rig_device *dev)
{
    struct hil_gpio_device *gpio = dev->gpio;
    dev->state->pulse_end_ps = HIL_NEVER;
    dev->lamp = (struct hil_pin){.who = dev, .function = -1, .level = lamp_sense};
    gpio->outside[PORT_E][3] = &dev->lamp;
    gpio->timer_listener = (struct hil_pin_listener){dev, look_at_excitation};
    hil_gpio_listen(gpio, look_at_excitation, dev);
    hil_gpio_listen(gpio, look_at_shunts, dev);
    dev->adc->outside = (struct hil_analogue){dev, hil_rig_channel, hil_rig_channel_volts};
    hil_event_wire(dev->core, HIL_EVENT_RIG, on_event, dev);
}
