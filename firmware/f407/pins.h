/* Pins by signal, from firmware/boards/pins.def. */
#ifndef MATRIG_FIRMWARE_F407_PINS_H
#define MATRIG_FIRMWARE_F407_PINS_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/f407/facts.h"
#include "firmware/f407/regs.h"

enum pin_signal {
#define PIN(port, pin, SIGNAL) PIN_##SIGNAL,
#include "firmware/boards/pins.def"
    PIN_COUNT
};

struct pin_location {
    struct gpio_regs *port;
    uint8_t pin;
};

/* Compiles to a constant if `signal` is constant. */
static inline struct pin_location pin_location(enum pin_signal signal)
{
    static const struct pin_location places[PIN_COUNT] = {
#define PIN(port, pin, SIGNAL) [PIN_##SIGNAL] = {GPIO##port, pin},
#include "firmware/boards/pins.def"
    };
    return places[signal];
}

static inline void pin_write(enum pin_signal signal, bool high)
{
    struct pin_location place = pin_location(signal);
    place.port->BSRR = 1u << (high ? place.pin : place.pin + 16u);
}

static inline bool pin_read(enum pin_signal signal)
{
    struct pin_location place = pin_location(signal);
    return place.port->IDR >> place.pin & 1u;
}

/* Sets the clocks of ports and peripherals, and the functions, pulls and initial levels of all
 * pins. */
void pins_configure(void);
/* Mode of the thermometer's two pins: inputs (unused), I2C1, or open-drain outputs to clock a stuck
 * bus. */
enum pins_i2c_mode { PINS_I2C_NONE, PINS_I2C_BUS, PINS_I2C_CLOCKED };
void pins_set_i2c_mode(enum pins_i2c_mode bus_mode);

#endif
