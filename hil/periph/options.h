/* What is chosen when a board is made: its oscillators and identity, the other ends of its links,
 * what is fitted to it. */
#ifndef MATRIG_HIL_OPTIONS_H
#define MATRIG_HIL_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/splitmix.h"
#include "hil/periph/canbits.h"
#include "hil/periph/wire.h"

/* The boards that can be emulated: chip, package, supply, and what is wired to which pin. Taken
 * from data sheets and manuals independently of firmware/boards/, so that an error must be made
 * twice to go unnoticed. */

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
    struct hil_pin_place warning, shunts, lamp, jumper;
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

/* ---- options ---- */

/* Where in the range of its data sheet the duration of a flash or NOR operation lies. */
enum hil_cell_times {
    HIL_TIMES_SPREAD, /* drawn: mostly near typical, at times up to the maximum */
    HIL_TIMES_TYPICAL,
    HIL_TIMES_MAXIMUM,
};

struct hil_figures;
/* What a broken rule of time or electricity does (hil/periph/rules.h). */
enum hil_rules_mode { HIL_RULES_STOP, HIL_RULES_COUNT, HIL_RULES_OFF };

struct hil_options {
    const struct hil_board_type *type; /* which board it is */
    uint64_t seed;                     /* of converter noise */
    uint32_t hse_hz;                   /* crystal; 0: it never starts */
    int32_t hsi_error_ppm;             /* of the internal 16 MHz oscillator */
    uint32_t lsi_hz;                   /* 17000..47000, watchdog clock */
    uint32_t host_baud;                /* rate of the serial line's other end */
    enum hil_parity host_parity; /* and its parity; not used where it follows the board's own */
    bool host_parity_follows;
    enum hil_can_bus can_bus;
    uint32_t can_base; /* of the board's identifiers, to which CAN commands of its run file go */
    /* frames a second of the film camera; 0: there is none (hil/rig/rig.h) */
    double camera_hz;
    uint64_t camera_delay_ps;  /* from its trigger to the first frame */
    uint64_t camera_jitter_ps; /* of each frame, either way, evenly distributed */
    bool adc_noise;            /* false: codes are exact, for tests */
    double vdda_v;    /* supply of converters and staircase, 2.7 to 3.6 V; 0: as the board has it */
    bool board_drawn; /* electronics are drawn by board_seed (hil/rig/electronics.h) */
    uint64_t board_seed;
    const struct hil_figures *figures; /* from which; NULL: of hil/circuits */
    uint32_t uid[3];                   /* unique device identifier */
    bool jumper;                       /* the maintenance jumper is fitted */
    bool bare;            /* nothing is plugged in where the rig is: its lines are open */
    bool left_on;         /* see hil_rcc_leave_on */
    bool boot0;           /* level of the BOOT0 pin at reset: high starts the boot ROM */
    double temperature_c; /* of the mat at power on; NaN: no thermometer is fitted */
    double temperature_c_per_h;
    enum hil_cell_times cell_times; /* how long flash and NOR operations take */
    enum hil_rules_mode rules;
    uint32_t rules_counted; /* bits by enum hil_rule: these only count */
    double cpi;             /* virtual cycles for each instruction, at least 1 */
    /* fault on multiple and double transfers that are not aligned to words; two to three times
     * slower, since every instruction is looked at */
    bool watch_alignment;
    FILE *trace; /* NULL, or the file for exceptions and unusual events */
    /* NULL, or the file for injected faults, one line each (hil/rig/faults.h) */
    FILE *log;
};

/* Defaults: the board zg, 8 MHz crystal, exact HSI, 32 kHz LSI, 2 Mbaud, bus connected, noise on,
 * seed 1, the board's own supply, ideal electronics. */
void hil_options_default(struct hil_options *options);

#endif
