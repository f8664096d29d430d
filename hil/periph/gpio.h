/* GPIO ports A to I (RM0090 8): mode, output, input, alternate functions, and the resulting level
 * of a pin.
 *
 * A pin's level: in output mode by ODR and OTYPER; in alternate mode by the peripheral; otherwise
 * by the outside connection; otherwise by a resistor outside, then by the internal pull. A pin held
 * by none of these floats: it reads as low here, and a decision that depends on it breaks a rule
 * (rules.def, FLOATING). */
#ifndef MATRIG_HIL_GPIO_H
#define MATRIG_HIL_GPIO_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

#define HIL_GPIO_PORTS 9u
#define HIL_GPIO_BSRR  0x18u

struct hil_gpio_port {
    HIL_WORDS(word, moder, otyper, ospeedr, pupdr, idr, odr, bsrr, lckr, afr[2]);
    uint16_t driven;  /* pins connected to a driver outside */
    uint16_t outside; /* its level */
};

struct hil_gpio {
    struct hil_gpio_port port[HIL_GPIO_PORTS];
};

enum hil_pin_mode { HIL_PIN_INPUT, HIL_PIN_OUTPUT, HIL_PIN_ALTERNATE, HIL_PIN_ANALOGUE };

/* A peripheral on a pin as its alternate function `function`, or what is outside on it. `channel`
 * is handed to its calls. */
struct hil_pin {
    void *who;
    int function;
    unsigned channel;
    bool (*level)(const void *who, unsigned channel, bool *drives); /* NULL: it only listens */
    /* a driver outside changed the level; NULL: it does not look */
    void (*edge)(void *who, unsigned channel, bool level, uint64_t at);
};

/* Told that a pin may have changed. */
struct hil_pin_listener {
    void *who;
    void (*changed)(void *who, uint64_t at);
};

#define HIL_PIN_LISTENERS 8u

struct hil_gpio_device {
    HIL_NEIGHBOURS;
    struct hil_gpio *state;
    const struct hil_pin *alternate[HIL_GPIO_PORTS][16]; /* NULL: no peripheral */
    /* NULL: unconnected, or driven by hil_gpio_drive */
    const struct hil_pin *outside[HIL_GPIO_PORTS][16];
    /* of ports B, D and E; called in this order */
    struct hil_pin_listener listener[HIL_PIN_LISTENERS];
    unsigned listeners;
    struct hil_pin_listener timer_listener; /* of the pins that TIM4 can drive */
    uint16_t pulled_up[HIL_GPIO_PORTS], pulled_down[HIL_GPIO_PORTS]; /* by resistors outside */
    /* The core reads IDR while these pins float; NULL: no listener. */
    void (*floats)(void *who, unsigned port, uint32_t value, uint32_t pins);
    /* the core has stored to a port; NULL: no listener */
    void (*stored)(void *who, unsigned port);
    void *stored_who, *floats_who;
};

/* Up to HIL_PIN_LISTENERS; aborts beyond. */
void hil_gpio_listen(struct hil_gpio_device *dev, void (*changed)(void *who, uint64_t at),
                     void *who);
/* For a peripheral whose pin rests high and whose edges are not modelled. */
bool hil_gpio_rests_high(const void *who, unsigned channel, bool *drives);

/* For the bus; `device` is a struct hil_gpio_device, `unit` a port. */
void hil_gpio_reset_port(void *device, unsigned unit);
enum hil_pin_mode hil_gpio_mode(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
/* Alternate function number of a pin in alternate mode, -1 in any other. */
int hil_gpio_alternate(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
bool hil_gpio_level(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
/* Does anything hold its level: a driver, a peripheral, a resistor inside or outside? */
bool hil_gpio_is_held(const struct hil_gpio_device *dev, unsigned port, unsigned pin);
/* A resistor outside pulls it. */
void hil_gpio_pull(struct hil_gpio_device *dev, unsigned port, unsigned pin, bool up);
/* A driver outside changes its level. */
void hil_gpio_drive(struct hil_gpio_device *dev, unsigned port, unsigned pin, bool level,
                    uint64_t at);
/* Something that pins depend on changed at cycle `at` (ODR, mode, a timer's output): notify the
 * listeners. */
void hil_gpio_changed(struct hil_gpio_device *dev, uint64_t at);
/* The same of the pins that TIM4 can drive. */
void hil_gpio_timer_changed(struct hil_gpio_device *dev, uint64_t at);

HIL_ON_BUS(gpio)
/* What a narrow write leaves in the rest of a register (hil_peripheral.rest). */
uint32_t hil_gpio_rest(void *device, unsigned unit, uint32_t offset);

#endif
