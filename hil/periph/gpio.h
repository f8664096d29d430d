/* GPIO ports A to I (RM0090 8): mode, output, input, alternate functions, and the resulting level
 * of a pin.
 *
 * The level of a pin is determined by the first of these that applies: ODR and OTYPER in output
 * mode; the peripheral in alternate mode; an outside driver; an outside resistor; the internal
 * pull-up or pull-down. Without any of these, the pin floats. It reads as low here, and a decision
 * that depends on it violates a rule (rules.def, FLOATING). */
#ifndef MATRIG_HIL_GPIO_H
#define MATRIG_HIL_GPIO_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

#define HIL_GPIO_PORTS 9u
#define HIL_GPIO_BSRR  0x18u

struct hil_gpio_port {
    HIL_NAMED_WORDS(word, moder, otyper, ospeedr, pupdr, idr, odr, bsrr, lckr, afr[2]);
    uint16_t externally_driven_pins; /* pins connected to an outside driver */
    uint16_t external_levels;        /* levels of the outside drivers */
};

struct hil_gpio {
    struct hil_gpio_port port[HIL_GPIO_PORTS];
};

enum hil_pin_mode { HIL_PIN_INPUT, HIL_PIN_OUTPUT, HIL_PIN_ALTERNATE, HIL_PIN_ANALOGUE };

/* A peripheral on a pin (alternate function `function`) or an outside part on it. `channel` is
 * passed to its calls. */
struct hil_pin {
    void *context;
    int alternate_function;
    unsigned channel;
    /* returns the level that the part drives; NULL: the part only reads the pin */
    bool (*level)(const void *context, unsigned channel, bool *drives);
    /* called when an outside driver has changed the level; NULL: not needed */
    void (*edge)(void *context, unsigned channel, bool level, uint64_t at);
};

/* Called when a pin may have changed. */
struct hil_pin_listener {
    void *context;
    void (*on_change)(void *context, uint64_t at);
};

#define HIL_PIN_LISTENERS_MAX 8u

struct hil_gpio_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_gpio *state;
    const struct hil_pin *alternate_pins[HIL_GPIO_PORTS][16]; /* peripherals by pin; NULL: none */
    /* outside parts by pin; NULL: unconnected, or driven by hil_gpio_drive */
    const struct hil_pin *external_pins[HIL_GPIO_PORTS][16];
    /* listeners for ports B, D and E, called in this order */
    struct hil_pin_listener listener[HIL_PIN_LISTENERS_MAX];
    unsigned listener_count;
    struct hil_pin_listener timer_listener; /* listener for the pins that TIM4 can drive */
    /* pins with an outside resistor */
    uint16_t pull_up_pins[HIL_GPIO_PORTS], pull_down_pins[HIL_GPIO_PORTS];
    /* called when the core reads IDR while these pins float; NULL: no listener */
    void (*on_floating_read)(void *context, unsigned port, uint32_t value, uint32_t pins);
    /* called when the core has stored to a port; NULL: no listener */
    void (*on_store)(void *context, unsigned port);
    void *store_context, *floating_context;
};

/* Adds a listener; aborts if there are more than HIL_PIN_LISTENERS_MAX. */
void hil_gpio_add_listener(struct hil_gpio_device *dev, void (*changed)(void *context, uint64_t at),
                           void *context);
/* Level function of a peripheral whose pin is always high, because its edges are not modelled. */
bool hil_gpio_level_always_high(const void *context, unsigned channel, bool *drives);

/* A function that the bus calls; `device` is a struct hil_gpio_device, `unit` a port. */
void hil_gpio_reset_port(void *device, unsigned unit);
enum hil_pin_mode hil_gpio_mode(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
/* Alternate function number of a pin in alternate mode, -1 in any other. */
int hil_gpio_alternate_function(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
bool hil_gpio_level(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
/* True if a driver, a peripheral, or an internal or outside resistor holds the pin's level. */
bool hil_gpio_has_defined_level(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
/* Connects an outside pull-up or pull-down resistor to a pin. */
void hil_gpio_add_pull(struct hil_gpio_device *dev, unsigned port, unsigned pin, bool up);
/* Sets the level of an outside driver on a pin. */
void hil_gpio_drive(struct hil_gpio_device *dev, unsigned port, unsigned pin, bool level,
                    uint64_t at);
/* Call when a cause of pin levels (ODR, mode, output of a timer) changed at cycle `at`: notifies
 * the listeners. */
void hil_gpio_notify_listeners(struct hil_gpio_device *dev, uint64_t at);
/* As hil_gpio_notify_listeners, for the pins that TIM4 can drive. */
void hil_gpio_notify_timer(struct hil_gpio_device *dev, uint64_t at);

HIL_DECLARE_BUS_CALLS(gpio)
/* Bits of a register that a narrow write does not change (hil_peripheral.unchanged_bits). */
uint32_t hil_gpio_unchanged_bits(void *device, unsigned unit, uint32_t offset);

#endif
