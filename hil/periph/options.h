/* What is chosen when a board is made: its oscillators and identity, the other ends of its links,
 * what is fitted to it. */
#ifndef MATRIG_HIL_OPTIONS_H
#define MATRIG_HIL_OPTIONS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "hil/periph/can_frame.h"
#include "hil/periph/cells.h"
#include "hil/periph/wire.h"

struct hil_board_type;
struct hil_figures;
/* What a broken rule of time or electricity does (hil/periph/rules.h). */
enum hil_rules_mode { HIL_RULES_STOP, HIL_RULES_COUNT, HIL_RULES_OFF };

struct hil_options {
    const struct hil_board_type *type; /* which board it is (hil/periph/board_type.h) */
    uint64_t seed;                     /* of converter noise */
    uint32_t hse_hz;                   /* crystal; 0: it never starts */
    int32_t hsi_error_ppm;             /* of the internal 16 MHz oscillator */
    uint32_t lsi_hz;                   /* 17000..47000, watchdog clock */
    uint32_t host_baud;                /* rate of the serial line's other end */
    enum hil_parity host_parity; /* and its parity; not used where it follows the board's own */
    bool host_parity_follows;
    enum hil_can_bus can_bus;
    uint32_t can_base; /* of the board's identifiers, to which CAN commands of its run file go */
    /* frames a second of the film camera; 0: there is none (hil/rig/camera.h) */
    double camera_hz;
    uint64_t camera_delay_ps;  /* from its trigger to the first frame */
    uint64_t camera_jitter_ps; /* of each frame, either way, evenly distributed */
    bool adc_noise;            /* false: codes are exact, for tests */
    double vdda_v;    /* supply of converters and staircase, 2.7 to 3.6 V; 0: as the board has it */
    bool board_drawn; /* electronics are drawn by board_seed (hil/rig/electronics.h) */
    uint64_t board_seed;
    const struct hil_figures *figures; /* from which; NULL: of hil/circuits */
    uint32_t uid[3];                   /* unique device identifier */
    bool bare;            /* nothing is plugged in where the rig is: its lines are open */
    bool left_on;         /* see hil_rcc_leave_on */
    bool boot0;           /* level of the BOOT0 pin at reset: high starts the boot ROM */
    double temperature_c; /* of the mat at power on; NaN: no thermometer is fitted */
    double temperature_c_per_h;
    enum hil_cell_times cell_times; /* how long flash and NOR operations take */
    enum hil_rules_mode rules;
    uint32_t rules_counted; /* bits by enum hil_rule: these only count */
    /* fault on multiple and double transfers that are not aligned to words; two to three times
     * slower, since every instruction is looked at */
    bool watch_alignment;
    FILE *trace; /* NULL, or where exceptions and unusual events are told */
    /* NULL, or where injected faults are told, a line each (hil/rig/faults.h) */
    FILE *log;
};

/* Defaults: the board zg, 8 MHz crystal, exact HSI, 32 kHz LSI, 2 Mbaud, bus connected, noise on,
 * seed 1, the board's own supply, ideal electronics. */
void hil_options_default(struct hil_options *options);

#endif
