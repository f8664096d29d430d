/* Options of a board: oscillators, identity, the other ends of its links, fitted parts. */
#ifndef MATRIG_HIL_OPTIONS_H
#define MATRIG_HIL_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/splitmix.h"
#include "hil/periph/canbits.h"
#include "hil/periph/wire.h"

/* The boards that can be emulated: chip, package, supply, and wiring of the pins. The data are
 * taken from data sheets and manuals, independently of firmware/boards/, so that tests detect an
 * error in either. */

#define HIL_BOARD_CHANNELS   24u /* 8 transducers, 14 gages, staircase and reference */
#define HIL_BOARD_PORTS      9u
#define HIL_BOARD_PULL_COUNT 7u

struct hil_pin_location {
    uint8_t port, pin; /* port 0 = A; HIL_NO_PORT: not present */
};
#define HIL_NO_PORT 0xffu

/* A resistor outside the chip that defines the level of a pin before the firmware configures it. */
struct hil_pull {
    struct hil_pin_location location;
    bool is_up;
};

struct hil_board_type {
    unsigned number; /* number as in the header of the image (common/boards.def) */
    uint32_t idcode; /* DBGMCU_IDCODE */
    uint32_t flash_kib;
    bool has_no_ccm;
    bool has_clock_bypass; /* true: OSC_IN is connected to a clock; false: to a crystal */
    double supply_v;       /* VDDA */
    /* bit masks of the pins of each port that are connected in the package */
    uint16_t bonded_pins[HIL_BOARD_PORTS];
    struct hil_pin_location channel_pin[HIL_BOARD_CHANNELS];
    struct hil_pin_location warning_pin, shunt_pin, lamp_sense_pin, jumper_pin;
    struct hil_pull pulls[HIL_BOARD_PULL_COUNT];
    struct hil_pin_location serial_out_pin, serial_in_pin;
    uint8_t usart,
        serial_alternate_function; /* USART of the serial link, and its alternate function */
    bool is_rom_on_serial;         /* the boot ROM uses the pins of the serial link */
    /* a sensor on the board holds the pin of a channel (sensor_out_pin) at 0 V while its select
     * line is low */
    struct hil_pin_location sensor_select_pin, sensor_out_pin;
};

/* Board type with this number or name (common/boards.def); NULL: not modelled. Static storage. */
const struct hil_board_type *hil_board_type_by_number(unsigned number);
const struct hil_board_type *hil_board_type_by_name(const char *name);
const char *hil_board_type_name(const struct hil_board_type *type);

/* Channel on a pin, or -1. */
int hil_board_type_find_channel(const struct hil_board_type *type, unsigned port, unsigned pin);
bool hil_board_type_has_pin(const struct hil_board_type *type, unsigned port, unsigned pin);

static inline bool hil_is_same_pin(struct hil_pin_location place, unsigned port, unsigned pin)
{
    return place.port == port && place.pin == pin;
}

/* ---- options ---- */

/* How long operations of flash and NOR take, within the range of the data sheet. */
enum hil_cell_times {
    HIL_TIMES_RANDOM, /* random: mostly near typical, occasionally up to the maximum */
    HIL_TIMES_TYPICAL,
    HIL_TIMES_MAXIMUM,
};

struct hil_circuit_figures;
/* What happens when the firmware violates a timing or electrical rule (hil/periph/rules.h). */
enum hil_rules_mode { HIL_RULES_STOP, HIL_RULES_COUNT, HIL_RULES_OFF };

struct hil_options {
    const struct hil_board_type *type; /* type of the board */
    uint64_t noise_seed;               /* seed of the converter noise */
    uint32_t hse_hz;                   /* crystal frequency; 0: the crystal never starts */
    int32_t hsi_error_ppm;             /* error of the internal 16 MHz oscillator */
    uint32_t lsi_hz;                   /* clock of the watchdog, 17000 to 47000 */
    uint32_t host_baud;                /* baud rate of the other end of the serial link */
    /* parity of the other end; not used if host_parity_follows_board is set */
    enum hil_parity host_parity;
    bool host_parity_follows_board;
    enum hil_can_bus can_bus;
    uint32_t can_id_base; /* CAN base of the board, used for CAN commands in the run file */
    /* frame rate of the film camera, 1/s; 0: no camera (hil/rig/rig.h) */
    double camera_hz;
    uint64_t camera_delay_ps; /* delay from the trigger to the first frame */
    /* jitter of each frame, uniformly distributed within +- this value */
    uint64_t camera_jitter_ps;
    bool has_adc_noise; /* false: codes are exact, for tests */
    /* supply of converters and staircase, 2.7 to 3.6 V; 0: nominal supply of the board */
    double vdda_v;
    /* electronics have random tolerances, from tolerance_seed (hil/rig/electronics.h) */
    bool has_random_tolerances;
    uint64_t tolerance_seed;
    const struct hil_circuit_figures
        *figures;            /* figures of the tolerances; NULL: those of hil/circuits */
    uint32_t uid[3];         /* unique device identifier */
    bool is_jumper_fitted;   /* the maintenance jumper is fitted */
    bool has_no_rig;         /* no rig is connected: all lines to it are open */
    bool has_clocks_left_on; /* start with clocks left on: hil_rcc_leave_clocks_on */
    bool is_boot0_high;      /* level of the BOOT0 pin at reset: high starts the boot ROM */
    double temperature_c;    /* mat temperature at power on; NaN: no thermometer is fitted */
    double temperature_c_per_h;
    enum hil_cell_times cell_times; /* duration of flash and NOR operations */
    enum hil_rules_mode rules_mode;
    /* bit mask (enum hil_rule): violations of these rules are counted and do not stop the run */
    uint32_t counted_rules;
    double cycles_per_instruction; /* virtual cycles per instruction, at least 1 */
    /* fault on multiple and double transfers that are not aligned to words; two to three times
     * slower, because every instruction is checked */
    bool is_alignment_checked;
    FILE *trace; /* NULL, or the file for exceptions and unusual events */
    /* NULL, or the file for injected faults, one line each (hil/rig/faults.h) */
    FILE *fault_log;
};

/* Sets the defaults: board zg, 8 MHz crystal, exact HSI, 32 kHz LSI, 2 Mbaud, CAN bus connected,
 * noise on, seed 1, nominal supply of the board, ideal electronics. */
void hil_options_default(struct hil_options *options);

#endif
