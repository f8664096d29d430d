#include "hil/periph/gpio.h"

#include <stdlib.h>

#include "hil/core/core.h"
#include "hil/periph/options.h"

#define FIRST_PORT 0x40020000u
#define MODER      0x00u
#define IDR        0x10u
#define PORT_B     1u
#define PORT_D     3u
#define PORT_E     4u

void hil_gpio_add_listener(struct hil_gpio_device *dev, void (*changed)(void *context, uint64_t at),
                           void *context)
{
    if (dev->listener_count == HIL_PIN_LISTENERS_MAX)
        abort();
    dev->listener[dev->listener_count++] = (struct hil_pin_listener){context, changed};
}

bool hil_gpio_level_always_high(const void *context, unsigned channel, bool *drives)
{
    (void)context;
    (void)channel;
    *drives = true;
    return true;
}

void hil_gpio_reset_port(void *device, unsigned port)
{
    struct hil_gpio_device *dev = device;
    struct hil_gpio_port *p = &dev->state->port[port];
    uint16_t driven = p->externally_driven_pins, outside = p->external_levels;
    *p = (struct hil_gpio_port){.externally_driven_pins = driven, .external_levels = outside};
    hil_registers_reset(FIRST_PORT + 0x400u * port, 0, p->word, sizeof p->word / 4u);
    hil_gpio_notify_listeners(dev, hil_now_cycle(dev->core));
}

enum hil_pin_mode hil_gpio_mode(const struct hil_gpio_device *dev, unsigned port, unsigned pin)
{
    return (enum hil_pin_mode)(dev->state->port[port].moder >> (2u * pin) & 3u);
}

int hil_gpio_alternate_function(const struct hil_gpio_device *dev, unsigned port, unsigned pin)
{
    if (hil_gpio_mode(dev, port, pin) != HIL_PIN_ALTERNATE)
        return -1;
    return (int)(dev->state->port[port].afr[pin / 8u] >> (4u * (pin % 8u)) & 15u);
}

/* The peripheral that the pin's alternate function selects, or NULL. */
static const struct hil_pin *find_pin_user(const struct hil_gpio_device *dev, unsigned port,
                                           unsigned pin)
{
    const struct hil_pin *user = dev->alternate_pins[port][pin];
    return user && hil_gpio_alternate_function(dev, port, pin) == user->alternate_function ? user
                                                                                           : NULL;
}

/* Returns the level of a pin. *held is true if something drives or pulls the pin. */
static bool find_pin_level(const struct hil_gpio_device *dev, unsigned port, unsigned pin,
                           bool *held)
{
    const struct hil_gpio_port *p = &dev->state->port[port];
    enum hil_pin_mode mode = hil_gpio_mode(dev, port, pin);
    unsigned pull = p->pupdr >> (2u * pin) & 3u;
    *held = true;
    if (mode == HIL_PIN_OUTPUT) {
        bool high = (p->odr >> pin & 1u) != 0;
        if (!high || !(p->otyper >> pin & 1u))
            return high;
    } else if (mode == HIL_PIN_ALTERNATE) {
        const struct hil_pin *user = find_pin_user(dev, port, pin);
        bool drives = false;
        bool level = user && user->level && user->level(user->context, user->channel, &drives);
        if (drives)
            return level;
    }
    if (p->externally_driven_pins >> pin & 1u)
        return (p->external_levels >> pin & 1u) != 0;
    const struct hil_pin *outside = dev->external_pins[port][pin];
    if (outside) {
        bool drives, high = outside->level(outside->context, outside->channel, &drives);
        if (drives)
            return high;
    }
    if ((dev->pull_up_pins[port] | dev->pull_down_pins[port]) >> pin & 1u)
        return dev->pull_up_pins[port] >> pin & 1u;
    *held = pull != 0;
    return pull == 1u;
}

bool hil_gpio_level(const struct hil_gpio_device *dev, unsigned port, unsigned pin)
{
    bool held;
    return find_pin_level(dev, port, pin, &held);
}

bool hil_gpio_has_defined_level(const struct hil_gpio_device *dev, unsigned port, unsigned pin)
{
    bool held;
    (void)find_pin_level(dev, port, pin, &held);
    return held;
}

void hil_gpio_add_pull(struct hil_gpio_device *dev, unsigned port, unsigned pin, bool up)
{
    uint16_t *pulled = up ? dev->pull_up_pins : dev->pull_down_pins;
    pulled[port] |= (uint16_t)(1u << pin);
}

void hil_gpio_notify_timer(struct hil_gpio_device *dev, uint64_t at)
{
    if (dev->timer_listener.on_change)
        dev->timer_listener.on_change(dev->timer_listener.context, at);
}

void hil_gpio_notify_listeners(struct hil_gpio_device *dev, uint64_t at)
{
    for (unsigned i = 0; i < dev->listener_count; i++)
        dev->listener[i].on_change(dev->listener[i].context, at);
}

void hil_gpio_drive(struct hil_gpio_device *dev, unsigned port, unsigned pin, bool level,
                    uint64_t at)
{
    struct hil_gpio_port *p = &dev->state->port[port];
    uint16_t bit = (uint16_t)(1u << pin);
    bool before = hil_gpio_level(dev, port, pin);
    p->externally_driven_pins |= bit;
    p->external_levels = (uint16_t)(level ? p->external_levels | bit : p->external_levels & ~bit);
    bool after = hil_gpio_level(dev, port, pin);
    /* without the alternate function, the peripheral does not receive edges of the pin */
    const struct hil_pin *user = after != before ? find_pin_user(dev, port, pin) : NULL;
    if (user && user->edge)
        user->edge(user->context, user->channel, after, at);
}

uint32_t hil_gpio_unchanged_bits(void *device, unsigned unit, uint32_t offset)
{
    return offset == HIL_GPIO_BSRR ? 0 : hil_gpio_read(device, unit, offset);
}

uint32_t hil_gpio_read(void *device, unsigned unit, uint32_t offset)
{
    struct hil_gpio_device *dev = device;
    uint32_t value = 0, floating = 0;
    if (offset != IDR)
        return dev->state->port[unit].word[offset / 4u];
    for (unsigned pin = 0; pin < 16; pin++) {
        bool held;
        if (hil_gpio_mode(dev, unit, pin) == HIL_PIN_ANALOGUE)
            continue;
        value |= (uint32_t)find_pin_level(dev, unit, pin, &held) << pin;
        floating |= (uint32_t)!held << pin;
    }
    if (floating && dev->on_floating_read)
        dev->on_floating_read(dev->floating_context, unit, value, floating);
    return value;
}

/* Stops the run if a pin in use is missing from the package. The chip would drive it, but it is not
 * connected. */
static bool check_pins(struct hil_gpio_device *dev, unsigned port, uint32_t moder)
{
    for (unsigned pin = 0; pin < 16; pin++) {
        if ((moder >> (2u * pin) & 3u) == HIL_PIN_INPUT ||
            hil_board_type_has_pin(dev->options->type, port, pin))
            continue;
        hil_core_stop(dev->core, MR_HALTED,
                      "P%c%u is used, but this package does not have that pin", 'A' + port, pin);
        return false;
    }
    return true;
}

void hil_gpio_write(void *device, unsigned unit, uint32_t offset, uint32_t value)
{
    struct hil_gpio_device *dev = device;
    struct hil_gpio_port *p = &dev->state->port[unit];
    if (offset == MODER && !check_pins(dev, unit, value))
        return;
    if (offset == HIL_GPIO_BSRR) /* if a bit is both set and reset, set has priority */
        p->odr = ((p->odr & ~(value >> 16)) | value) & 0xffffu;
    else
        p->word[offset / 4u] = value;
    if (dev->on_store)
        dev->on_store(dev->store_context, unit);
    if (unit == PORT_D || unit == PORT_B || unit == PORT_E)
        hil_gpio_notify_listeners(dev, hil_now_cycle(dev->core));
}
