#include "hil/rig/rig.h"

#include <math.h>
#include <string.h>

#include "common/canbase.h"
#include "common/framing.h"
#include "hil/core/core.h"
#include "hil/periph/can.h"
#include "hil/periph/gpio.h"
#include "hil/periph/options.h"
#include "hil/periph/tim.h"
#include "hil/periph/usart.h"
#include "hil/rig/electronics.h"

#define PORT_D              3u
#define GAGE_ZERO_V         0.400
#define GAGE_V_PER_LB       0.005
#define REFERENCE_V         2.500
#define TRANSDUCER_MID_V    1.65
#define TRANSDUCER_ZERO_V   0.050
#define TRANSDUCER_V_PER_IN 0.5
#define CHANNEL_STAIRCASE   22u
#define CHANNEL_REFERENCE   23u
/* A step counts as settled after this many time constants: exp(-40) of full scale is 1e-14
 * codes. */
#define SETTLED_AFTER_TAUS  40.0
#define RELAY_BOUNCES       2u /* number of times that a closing contact opens again */

/* Time of the next change of the input with train i. */
static uint64_t get_next_pulse_edge_ps(const struct hil_rig_device *dev, unsigned i)
{
    return hil_pulse_train_next_edge(&dev->run->pulse_train[i], &dev->state->pulse_train[i],
                                     HIL_TRAIN_PULSE_PS);
}

static void schedule(struct hil_rig_device *dev)
{
    const struct hil_rig *rig = dev->state;
    uint64_t next = rig->one_shot_end_ps;
    if (dev->run && rig->opened_count < rig->opening_count) {
        uint64_t opens = dev->run->switch_open_ps[rig->opening_order[rig->opened_count]];
        if (opens < next)
            next = opens;
    }
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        if (rig->contact[i].remaining_bounces && rig->contact[i].next_move_ps < next)
            next = rig->contact[i].next_move_ps;
    }
    if (rig->next_shunt_move_ps < next)
        next = rig->next_shunt_move_ps;
    for (unsigned i = 0; dev->run && i < HIL_RUN_TRAINS; i++) {
        if (get_next_pulse_edge_ps(dev, i) < next)
            next = get_next_pulse_edge_ps(dev, i);
    }
    hil_event_set_ps(dev->core, HIL_EVENT_RIG, next);
}

void hil_rig_start(struct hil_rig_device *dev)
{
    struct hil_rig *rig = dev->state;
    *rig = (struct hil_rig){.one_shot_end_ps = HIL_NEVER, .next_shunt_move_ps = HIL_NEVER};
    for (unsigned i = 0; dev->run && i < HIL_RUN_SWITCHES; i++) {
        uint64_t t_ps = dev->run->switch_open_ps[i];
        rig->contact[i].next_move_ps = HIL_NEVER;
        if (t_ps == HIL_RUN_NEVER)
            continue;
        unsigned place = rig->opening_count++;
        for (; place && dev->run->switch_open_ps[rig->opening_order[place - 1]] > t_ps; place--)
            rig->opening_order[place] = rig->opening_order[place - 1];
        rig->opening_order[place] = (uint8_t)i;
    }
    schedule(dev);
}

/* Contribution of a contact to the staircase voltage, 0 to 1. */
static double compute_contact_level(const struct hil_contact *contact, double t_s, double tau_s)
{
    double taus = (t_s - (double)contact->moved_ps * 1e-12) / tau_s;
    double target = contact->is_open;
    if (taus > SETTLED_AFTER_TAUS)
        return target;
    return taus > 0.0 ? target + (contact->start_level - target) * exp(-taus)
                      : contact->start_level;
}

static void move_contact(struct hil_rig_device *dev, unsigned i, bool open, uint64_t t_ps,
                         uint64_t at)
{
    struct hil_rig *rig = dev->state;
    struct hil_contact *contact = &rig->contact[i];
    hil_adc_advance(dev->adc, at); /* compute earlier samples first, with the old state */
    double tau_s = dev->electronics->staircase_tau_s;
    contact->start_level = contact->has_moved
                             ? compute_contact_level(contact, (double)t_ps * 1e-12, tau_s)
                             : 0.0;
    contact->has_moved = true;
    contact->is_open = open;
    contact->moved_ps = t_ps;
    hil_trace(dev->core, "switch %u %s", i + 1u, open ? "opens" : "closes");
    if (!open)
        return;
    rig->one_shot_end_ps = t_ps + dev->electronics->one_shot_pulse_ps;
    dev->core->state.counters.switches_opened++;
    hil_gpio_drive(dev->gpio, 0, 15, true, at);
}

static void continue_bounce(struct hil_rig_device *dev, unsigned i, uint64_t at)
{
    struct hil_contact *contact = &dev->state->contact[i];
    uint64_t t_ps = contact->next_move_ps;
    bool opens = !contact->is_open;
    move_contact(dev, i, opens, t_ps, at);
    if (opens)
        contact->remaining_bounces--;
    contact->next_move_ps = contact->remaining_bounces ? t_ps + contact->bounce_period_ps / 2u
                                                       : HIL_NEVER;
}

static void toggle_train_pin(struct hil_rig_device *dev, unsigned i, uint64_t at)
{
    const struct hil_capture_pin *pin = &hil_capture_pins[HIL_RUN_FIRST_CAPTURE_CHANNEL + i];
    struct hil_pulse_train_state *state = &dev->state->pulse_train[i];
    hil_pulse_train_pass_edge(state);
    hil_gpio_drive(dev->gpio, pin->port, pin->pin, state->is_high, at);
}

static void connect_shunts(struct hil_rig_device *dev, bool on, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    if (on == rig->are_shunts_on)
        return;
    hil_adc_advance(dev->adc, at);
    rig->are_shunts_on = on;
    hil_trace(dev->core, "shunts %s", on ? "on" : "off");
}

/* Moves the relay's contacts: first after its delay, then for each bounce. */
static void move_relay_contact(struct hil_rig_device *dev, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    uint64_t apart_ps = dev->electronics->relay_bounce_ps / (2u * RELAY_BOUNCES);
    rig->remaining_shunt_moves--;
    connect_shunts(dev, rig->is_shunt_requested != rig->remaining_shunt_moves % 2u, at);
    rig->next_shunt_move_ps = rig->remaining_shunt_moves ? rig->next_shunt_move_ps + apart_ps
                                                         : HIL_NEVER;
}

static void on_event(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    struct hil_rig *rig = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    if (rig->one_shot_end_ps <= now_ps) {
        rig->one_shot_end_ps = HIL_NEVER;
        hil_gpio_drive(dev->gpio, 0, 15, false, at);
    }
    while (rig->next_shunt_move_ps <= now_ps)
        move_relay_contact(dev, at);
    for (unsigned i = 0; dev->run && i < HIL_RUN_TRAINS; i++) {
        if (get_next_pulse_edge_ps(dev, i) <= now_ps)
            toggle_train_pin(dev, i, at);
    }
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        while (rig->contact[i].remaining_bounces && rig->contact[i].next_move_ps <= now_ps)
            continue_bounce(dev, i, at);
    }
    while (dev->run && rig->opened_count < rig->opening_count &&
           dev->run->switch_open_ps[rig->opening_order[rig->opened_count]] <= now_ps) {
        unsigned i = rig->opening_order[rig->opened_count++];
        struct hil_contact *contact = &rig->contact[i];
        uint64_t opens = dev->run->switch_open_ps[i];
        if (contact->is_skipped)
            continue;
        move_contact(dev, i, true, opens, at);
        contact->next_move_ps = contact->remaining_bounces ? opens + contact->bounce_period_ps / 2u
                                                           : HIL_NEVER;
    }
    schedule(dev);
}

static bool is_pin_high(const struct hil_rig_device *dev, struct hil_pin_location place)
{
    return hil_gpio_level(dev->gpio, place.port, place.pin);
}

bool hil_rig_has_lamp_current(const struct hil_rig_device *dev)
{
    enum hil_lamp_fault lamp = (enum hil_lamp_fault)dev->state->lamp_fault;
    return lamp == HIL_LAMP_SHORTED ||
           (lamp == HIL_LAMP_GOOD && !is_pin_high(dev, dev->type->warning_pin));
}

void hil_rig_skip_switch(struct hil_rig_device *dev, unsigned position)
{
    dev->state->contact[position].is_skipped = true;
}

void hil_rig_bounce_switch(struct hil_rig_device *dev, unsigned position, uint32_t times,
                           uint64_t period_ps)
{
    struct hil_contact *contact = &dev->state->contact[position];
    contact->remaining_bounces = (uint8_t)times;
    contact->bounce_period_ps = period_ps;
    contact->next_move_ps = HIL_NEVER;
}

/* Remaining part of a step after `taus` time constants. Results are cached, because every scan uses
 * the same few times. */
static double compute_remaining_share(struct hil_rig_device *dev, uint64_t cycles, double taus)
{
    struct hil_settling *known =
        &dev->settling[cycles / HIL_SETTLING_CYCLES % HIL_SETTLING_CACHE_SIZE];
    if (known->remaining_share <= 0.0 || known->taus != taus)
        *known = (struct hil_settling){taus, exp(-taus)};
    return known->remaining_share;
}

/* Amplitude of the excitation at the transducers, -1 to 1. */
static double compute_excitation_amplitude(struct hil_rig_device *dev, uint64_t at)
{
    const struct hil_rig *rig = dev->state;
    double taus = (double)(at - rig->excitation_changed_cycle) / dev->core->state.clock.hclk_hz /
                  dev->electronics->transducer_tau_s;
    if (at < rig->excitation_changed_cycle || taus > SETTLED_AFTER_TAUS)
        return rig->excitation;
    return rig->excitation +
           (rig->excitation_start_amplitude - rig->excitation) *
               compute_remaining_share(dev, at - rig->excitation_changed_cycle, taus);
}

void hil_rig_count_excitation(struct hil_rig_device *dev, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    if (now_ps <= rig->excitation_changed_ps)
        return;
    if (rig->excitation > 0)
        dev->core->state.counters.excitation_plus_ps += now_ps - rig->excitation_changed_ps;
    else if (rig->excitation < 0)
        dev->core->state.counters.excitation_minus_ps += now_ps - rig->excitation_changed_ps;
    rig->excitation_changed_ps = now_ps;
}

void hil_rig_set_excitation(struct hil_rig_device *dev, bool pd12, bool pd13, uint64_t at)
{
    struct hil_rig *rig = dev->state;
    int8_t wanted = (int8_t)(pd12 - pd13);
    if (wanted == rig->excitation)
        return;
    hil_adc_advance(dev->adc, at); /* compute earlier samples first, with the old polarity */
    hil_rig_count_excitation(dev, at);
    rig->excitation_start_amplitude = compute_excitation_amplitude(dev, at);
    rig->excitation = wanted;
    rig->excitation_changed_cycle = at;
    rig->excitation_changed_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
}

/* Handles a new level of PE1. */
static void start_shunt_relay(struct hil_rig_device *dev, bool on, uint64_t at)
{
    const struct hil_electronics *e = dev->electronics;
    struct hil_rig *rig = dev->state;
    if (on == rig->is_shunt_requested)
        return;
    rig->is_shunt_requested = on;
    rig->next_shunt_move_ps = HIL_NEVER;
    uint64_t delay_ps = on ? e->relay_operate_ps : e->relay_release_ps;
    if (delay_ps) {
        rig->remaining_shunt_moves = on && e->relay_bounce_ps ? 2u * RELAY_BOUNCES + 1u : 1u;
        rig->next_shunt_move_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at) + delay_ps;
        schedule(dev);
    } else {
        connect_shunts(dev, on, at);
    }
}

void hil_rig_set_gage_drift(struct hil_rig_device *dev, unsigned gage, double gain,
                            double offset_lb)
{
    hil_adc_advance(dev->adc, hil_now_cycle(dev->core));
    dev->state->gain_drift[gage] = gain - 1.0;
    dev->state->offset_drift_lb[gage] = offset_lb;
}

/* Temperature above the one at which the electronics were adjusted, in K. */
static double get_temperature_rise_k(const struct hil_rig_device *dev, uint64_t at)
{
    const struct hil_electronics *e = dev->electronics;
    if (e->temperature_rise_k_per_s == 0.0)
        return e->temperature_rise_k;
    double t_s = (double)hil_clock_ps_at_cycle(&dev->core->state.clock, at) * 1e-12;
    return e->temperature_rise_k + e->temperature_rise_k_per_s * t_s;
}

static double compute_gage_volts(const struct hil_rig_device *dev, unsigned gage, double tension_lb,
                                 double warmer)
{
    const struct hil_electronics *e = dev->electronics;
    const struct hil_rig *rig = dev->state;
    double shunt_lb = rig->are_shunts_on ? HIL_RIG_SHUNT_LB * e->gage_shunt_ratio[gage] : 0.0;
    double lb = (1.0 + rig->gain_drift[gage]) * (tension_lb + shunt_lb) * e->gage_gain[gage] +
                rig->offset_drift_lb[gage] + e->gage_zero_lb[gage] +
                e->gage_drift_lb_k[gage] * warmer;
    return GAGE_ZERO_V + GAGE_V_PER_LB * lb;
}

/* VDDA supplies the staircase, so its voltage is proportional to VDDA and its steps are constant in
 * codes. */
static double compute_staircase_volts(const struct hil_rig_device *dev, double t_s)
{
    const struct hil_electronics *e = dev->electronics;
    const struct hil_rig *rig = dev->state;
    double codes = 0.0;
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++) {
        if (rig->contact[i].has_moved)
            codes += e->step_codes[i] *
                     compute_contact_level(&rig->contact[i], t_s, e->staircase_tau_s);
    }
    return (HIL_STAIRCASE_ZERO_V * e->staircase_zero_ratio + codes * HIL_NOMINAL_VDDA_V / 4096.0) *
           (e->vdda_v / HIL_NOMINAL_VDDA_V);
}

/* Returns the reference voltage as a fraction of its nominal value. `warmer`: temperature rise,
 * K. */
static double get_reference_ratio(const struct hil_rig_device *dev, double warmer)
{
    return dev->electronics->reference_ratio *
           (1.0 + dev->electronics->reference_drift_per_k * warmer);
}

int hil_rig_find_channel(const void *device, unsigned port, unsigned pin)
{
    const struct hil_rig_device *dev = device;
    return hil_board_type_find_channel(dev->type, port, pin);
}

static bool is_gage_channel(unsigned channel)
{
    return channel >= HIL_RUN_TRANSDUCERS && channel < HIL_RUN_COLUMNS;
}

/* Returns the input of a channel's sensor in inches or pounds; for the staircase its voltage. */
static double get_sensor_input(const struct hil_rig_device *dev, unsigned channel, double t_s)
{
    if (channel == CHANNEL_STAIRCASE)
        return compute_staircase_volts(dev, t_s);
    if (channel == CHANNEL_REFERENCE || !dev->run)
        return 0.0;
    return hil_run_get_true_value(
        dev->run, channel, is_gage_channel(channel) ? t_s - dev->electronics->gage_tau_s : t_s);
}

/* As get_sensor_input, at a time. Without a run nothing moves, so the time need not be computed,
 * which would take longer than all the rest. */
static double get_sensor_input_at(const struct hil_rig_device *dev, unsigned channel, uint64_t at)
{
    double t_s = dev->run ? (double)hil_clock_ps_at_cycle(&dev->core->state.clock, at) * 1e-12
                          : 0.0;
    return get_sensor_input(dev, channel, t_s);
}

void hil_rig_set_channel_fault(struct hil_rig_device *dev, unsigned channel,
                               enum hil_channel_fault fault)
{
    hil_adc_advance(dev->adc, hil_now_cycle(dev->core));
    dev->state->channel_fault[channel] = (uint8_t)fault;
    dev->state->stuck_value[channel] = get_sensor_input(dev, channel,
                                                        (double)hil_now_ps(dev->core) * 1e-12);
}

/* True if an on-board sensor chip is selected and drives this channel's pin. */
static bool is_grounded_by_sensor(const struct hil_rig_device *dev, unsigned channel)
{
    const struct hil_board_type *type = dev->type;
    return type->sensor_select_pin.port != HIL_NO_PORT &&
           hil_is_same_pin(type->sensor_out_pin, type->channel_pin[channel].port,
                           type->channel_pin[channel].pin) &&
           !is_pin_high(dev, type->sensor_select_pin);
}

double hil_rig_channel_volts(void *device, int channel, uint64_t at)
{
    struct hil_rig_device *dev = device;
    if (channel < 0 || is_grounded_by_sensor(dev, (unsigned)channel))
        return 0.0;
    enum hil_channel_fault fault = (enum hil_channel_fault)dev->state->channel_fault[channel];
    if (fault > HIL_CHANNEL_STUCK)
        return fault == HIL_CHANNEL_HIGH ? dev->electronics->vdda_v : 0.0;
    double value = fault == HIL_CHANNEL_STUCK ? dev->state->stuck_value[channel]
                                              : get_sensor_input_at(dev, (unsigned)channel, at);
    if (channel == (int)CHANNEL_STAIRCASE)
        return value;
    const struct hil_electronics *e = dev->electronics;
    double warmer = get_temperature_rise_k(dev, at),
           volts = REFERENCE_V * e->reference_reading_ratio;
    if (channel < (int)HIL_RUN_TRANSDUCERS)
        volts = TRANSDUCER_MID_V + e->transducer_mid_v[channel] +
                compute_excitation_amplitude(dev, at) *
                    (TRANSDUCER_ZERO_V +
                     TRANSDUCER_V_PER_IN * (value + e->transducer_zero_in[channel])) *
                    (e->transducer_gain[channel] + e->transducer_gain_per_k * warmer);
    else if (is_gage_channel((unsigned)channel))
        volts = compute_gage_volts(dev, (unsigned)channel - HIL_RUN_TRANSDUCERS, value, warmer);
    return volts * get_reference_ratio(dev, warmer);
}

/* --- connections --- */

static void update_excitation(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    hil_rig_set_excitation(dev, hil_gpio_level(dev->gpio, PORT_D, 12),
                           hil_gpio_level(dev->gpio, PORT_D, 13), at);
}

static void update_shunts(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    start_shunt_relay(dev, is_pin_high(dev, dev->type->shunt_pin), at);
}

static void update_lamp(void *device, uint64_t at)
{
    struct hil_rig_device *dev = device;
    if (!dev->electronics->lamp_sense_ps)
        return;
    bool on = hil_rig_has_lamp_current(dev);
    if (on == dev->state->is_lamp_on)
        return;
    dev->state->is_lamp_on = on;
    dev->state->lamp_changed_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
}

void hil_rig_set_lamp_fault(struct hil_rig_device *dev, enum hil_lamp_fault lamp)
{
    dev->state->lamp_fault = (uint8_t)lamp;
    update_lamp(dev, hil_now_cycle(dev->core));
}

/* Returns the level of the lamp's read-back: low while the lamp draws more current than the
 * threshold of the amplifier, after a delay. */
static bool get_lamp_sense(const void *device, unsigned channel, bool *drives)
{
    const struct hil_rig_device *dev = device;
    const struct hil_electronics *e = dev->electronics;
    bool on = hil_rig_has_lamp_current(dev);
    (void)channel;
    *drives = !dev->has_no_rig;
    if (on == dev->state->is_lamp_on &&
        hil_now_ps(dev->core) < dev->state->lamp_changed_ps + e->lamp_sense_ps)
        on = !on; /* the delay has not passed yet, so the old level applies */
    return !(on && e->is_lamp_detected);
}

/* Source resistance of a channel at the converter. */
static double get_source_ohm(const void *device, int channel)
{
    const struct hil_rig_device *dev = device;
    return dev->electronics->adc_errors.source_ohm[channel];
}

void hil_rig_create(struct hil_rig_device *dev)
{
    struct hil_gpio_device *gpio = dev->gpio;
    dev->state->one_shot_end_ps = HIL_NEVER;
    dev->state->next_shunt_move_ps = HIL_NEVER;
    dev->lamp_sense_pin =
        (struct hil_pin){.context = dev, .alternate_function = -1, .level = get_lamp_sense};
    gpio->external_pins[dev->type->lamp_sense_pin.port][dev->type->lamp_sense_pin.pin] =
        &dev->lamp_sense_pin;
    gpio->timer_listener = (struct hil_pin_listener){dev, update_excitation};
    hil_gpio_add_listener(gpio, update_excitation, dev);
    hil_gpio_add_listener(gpio, update_shunts, dev);
    hil_gpio_add_listener(gpio, update_lamp, dev);
    dev->adc->analogue = (struct hil_analogue){.context = dev,
                                               .source = hil_rig_find_channel,
                                               .volts = hil_rig_channel_volts,
                                               .source_ohm = get_source_ohm};
    hil_event_connect(dev->core, HIL_EVENT_RIG, on_event, dev);
}

/* ---- scripted commands ---- */

enum mr_status hil_command_send(struct hil_can_device *can, struct hil_usart_device *usart,
                                uint16_t *sequence, const struct mr_command *message, bool serial)
{
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    size_t length = mr_command_put(message, payload);
    if (serial) {
        uint8_t bytes[MR_FRAME_BYTES_MAX];
        return hil_usart_inject(
            usart, bytes, mr_frame_encode((*sequence)++, MR_ID_COMMAND, payload, length, bytes));
    }
    struct hil_can_frame frame = {
        .id = mr_can_id_to_bus(MR_ID_COMMAND, (uint16_t)can->options->can_id_base),
        .length = (uint8_t)length};
    memcpy(frame.data, payload, length);
    return hil_can_inject(can, &frame);
}

static void schedule_script(struct hil_command_script_device *dev)
{
    const struct hil_command_script *script = dev->state;
    bool more = dev->rig->run && script->next_command < dev->rig->run->command_count;
    hil_event_set_ps(dev->core, HIL_EVENT_SCRIPT,
                     more ? dev->rig->run->commands[script->next_command].t_ps : HIL_NEVER);
}

void hil_command_script_start(struct hil_command_script_device *dev)
{
    *dev->state = (struct hil_command_script){0};
    schedule_script(dev);
}

static void apply_command(struct hil_command_script_device *dev,
                          const struct hil_run_command *command)
{
    if (hil_command_send(dev->can, dev->usart, &dev->state->sequence, &command->message,
                         command->is_sent_by_serial) != MR_OK)
        hil_core_stop(
            dev->core, MR_FULL,
            "scripted command %u of the run file: too many commands are waiting for the %s",
            (unsigned)command->message.tag, command->is_sent_by_serial ? "serial line" : "CAN bus");
}

static void on_command(void *device, uint64_t at)
{
    struct hil_command_script_device *dev = device;
    struct hil_command_script *script = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    while (dev->rig->run && script->next_command < dev->rig->run->command_count &&
           dev->rig->run->commands[script->next_command].t_ps <= now_ps)
        apply_command(dev, &dev->rig->run->commands[script->next_command++]);
    schedule_script(dev);
}

void hil_command_script_create(struct hil_command_script_device *dev)
{
    hil_event_connect(dev->core, HIL_EVENT_SCRIPT, on_command, dev);
}

/* ---- the film camera ---- */

#define PORT_B             1u
#define CAMERA_FRAME_PIN   3u
#define PORT_E             4u
#define CAMERA_TRIGGER_PIN 2u

static void plan_next_frame(struct hil_camera_device *dev)
{
    struct hil_camera *camera = dev->state;
    const struct hil_options *options = dev->options;
    double even_ps = (double)camera->next_frame * 1e12 / options->camera_hz;
    double drawn = (double)(mr_splitmix64(&camera->random_state) >> 11) * 0x1p-52 -
                   1.0; /* -1 to 1 */
    double jitter_ps = drawn * (double)options->camera_jitter_ps;
    double since_ps = (double)options->camera_delay_ps + even_ps + jitter_ps;
    camera->next_frame_ps = camera->trigger_ps + (since_ps > 0.0 ? (uint64_t)(since_ps + 0.5) : 0u);
}

static void schedule_camera(struct hil_camera_device *dev)
{
    const struct hil_camera *camera = dev->state;
    uint64_t next = camera->is_running ? camera->next_frame_ps : HIL_NEVER;
    if (camera->is_pulse_high && camera->pulse_end_ps < next)
        next = camera->pulse_end_ps;
    hil_event_set_ps(dev->core, HIL_EVENT_CAMERA, next);
}

static void update_trigger(void *device, uint64_t at)
{
    struct hil_camera_device *dev = device;
    struct hil_camera *camera = dev->state;
    bool level = hil_gpio_level(dev->gpio, PORT_E, CAMERA_TRIGGER_PIN);
    bool rises = level && !camera->is_trigger_high;
    camera->is_trigger_high = level;
    if (!rises || camera->is_running || !(dev->options->camera_hz > 0.0))
        return;
    *camera = (struct hil_camera){.is_trigger_high = true,
                                  .is_running = true,
                                  .frames_to_skip = camera->frames_to_skip,
                                  .trigger_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at),
                                  .random_state = dev->options->noise_seed};
    hil_trace(dev->core, "the camera starts");
    plan_next_frame(dev);
    schedule_camera(dev);
}

static void on_camera(void *device, uint64_t at)
{
    struct hil_camera_device *dev = device;
    struct hil_camera *camera = dev->state;
    uint64_t now_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    if (camera->is_pulse_high && camera->pulse_end_ps <= now_ps) {
        camera->is_pulse_high = false;
        hil_gpio_drive(dev->gpio, PORT_B, CAMERA_FRAME_PIN, false, at);
    }
    if (camera->is_running && camera->next_frame_ps <= now_ps) {
        if (camera->frames_to_skip) {
            camera->frames_to_skip--;
        } else {
            camera->is_pulse_high = true;
            camera->pulse_end_ps = camera->next_frame_ps + HIL_TRAIN_PULSE_PS;
            dev->core->state.counters.film_frames_sent++;
            hil_gpio_drive(dev->gpio, PORT_B, CAMERA_FRAME_PIN, true, at);
        }
        camera->next_frame++;
        plan_next_frame(dev);
    }
    schedule_camera(dev);
}

void hil_camera_skip_frames(struct hil_camera_device *dev, uint32_t frames)
{
    dev->state->frames_to_skip = frames;
}

void hil_camera_create(struct hil_camera_device *dev)
{
    hil_gpio_add_listener(dev->gpio, update_trigger, dev);
    hil_event_connect(dev->core, HIL_EVENT_CAMERA, on_camera, dev);
}
