/* The boards that can be emulated: chip, package, supply, and what is wired to which pin. Read out
 * of data sheets and manuals apart from firmware/boards/, so that a wrong belief has two
 * authors. */
#ifndef MATRIG_HIL_BOARD_TYPE_H
#define MATRIG_HIL_BOARD_TYPE_H

#include <stdbool.h>
#include <stdint.h>

#define HIL_BOARD_CHANNELS 24u /* 8 transducers, 14 gages, staircase, reference */
#define HIL_BOARD_PORTS    9u
#define HIL_BOARD_PULLS    7u

struct hil_pin_place {
    uint8_t port, pin; /* port 0 = A; HIL_NO_PORT: it is not there */
};
#define HIL_NO_PORT 0xffu

/* A resistor outside the chip, so that nothing starts while its pin still floats. */
struct hil_pull {
    struct hil_pin_place at;
    bool up;
};

struct hil_board_type {
    unsigned number; /* as the image's header has it (common/boards.def) */
    uint32_t idcode; /* DBGMCU_IDCODE */
    uint32_t flash_kib;
    bool no_ccm;                      /* the chip has none */
    bool clock_bypass;                /* OSC_IN gets a clock; else there is a crystal */
    double supply_v;                  /* VDDA */
    uint16_t bonded[HIL_BOARD_PORTS]; /* pins of each port that the package has */
    struct hil_pin_place channel[HIL_BOARD_CHANNELS];
    struct hil_pin_place warning, shunts, lamp;
    struct hil_pull pull[HIL_BOARD_PULLS];
    struct hil_pin_place serial_out, serial_in;
    uint8_t usart, serial_function; /* which is the serial link, and its alternate function */
    bool rom_hears;                 /* the boot ROM listens at the serial link */
    /* a sensor of the board's own holds a channel's pin at 0 V while its select is low */
    struct hil_pin_place sensor_select, sensor_out;
};

/* The type with this number or name (common/boards.def); NULL: it is not modelled. Static
 * storage. */
const struct hil_board_type *hil_board_type_of(unsigned number);
const struct hil_board_type *hil_board_type_named(const char *name);
const char *hil_board_type_name(const struct hil_board_type *type);

/* Channel that is on a pin, or -1. */
int hil_board_type_channel(const struct hil_board_type *type, unsigned port, unsigned pin);
bool hil_board_type_has(const struct hil_board_type *type, unsigned port, unsigned pin);

static inline bool hil_same_pin(struct hil_pin_place place, unsigned port, unsigned pin)
{
    return place.port == port && place.pin == pin;
}

#endif
