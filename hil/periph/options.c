#include "hil/periph/options.h"

#include <stddef.h>

#include "common/emulated.h"
#include "common/image.h"

#define P(letter, pin)      \
    {                       \
        (letter) - 'A', pin \
    }
#define NONE           \
    {                  \
        HIL_NO_PORT, 0 \
    }
/* Levels of the pins at reset: memory not selected, thermometer bus idle, CAN recessive, warning
 * lamp on, shunts off, camera not triggered. */
#define PULLS(warning, shunts)                                                       \
    {                                                                                \
        {P('B', 12), true}, {P('B', 6), true}, {P('B', 7), true}, {P('D', 1), true}, \
            {warning, false}, {shunts, false},                                       \
        {                                                                            \
            P('E', 2), false                                                         \
        }                                                                            \
    }
/* Packages: pinouts of the STM32F405/407 data sheet, figures 13 and 14. */
#define LQFP144                                                           \
    {                                                                     \
        0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0x0003, 0 \
    }
#define LQFP100                                                 \
    {                                                           \
        0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0, 0, 0x0003, 0 \
    }
/* Devices: RM0090 38.6.1. */
#define F407_REVISION_Y 0x100f6413u

/* The rig's inputs and outputs on a board with all 144 pins: transducers, gages, staircase and
 * reference. */
#define WIRED_144                                                                   \
    .channel = {P('F', 3), P('F', 4),  P('F', 5), P('F', 6), P('F', 7), P('F', 8),  \
                P('F', 9), P('F', 10), P('A', 0), P('A', 1), P('A', 2), P('A', 3),  \
                P('A', 4), P('A', 5),  P('A', 6), P('A', 7), P('B', 0), P('B', 1),  \
                P('C', 0), P('C', 1),  P('C', 2), P('C', 3), P('C', 4), P('C', 5)}, \
    .warning = P('E', 0), .shunts = P('E', 1), .pull = PULLS(P('E', 0), P('E', 1)), \
    .lamp = P('E', 3), .jumper = P('E', 8)

static const struct hil_board_type types[] = {
    {
        .number = MR_BOARD_ZG,
        .idcode = F407_REVISION_Y,
        .flash_kib = 1024,
        .supply_v = 3.3,
        .bonded = LQFP144,
        WIRED_144,
        .serial_out = P('A', 9),
        .serial_in = P('A', 10),
        .usart = 1,
        .serial_function = 7,
        .is_rom_on_serial = true,
        .sensor_select = NONE,
    },
    /* Parts on the board: ST's own project of the board (STM32_open_pin_data,
     * boards/C47_Discovery_STM32F407G-DISC1); its VDD is 3 V (UM1472 4.3). */
    {
        .number = MR_BOARD_DISCOVERY,
        .idcode = F407_REVISION_Y,
        .flash_kib = 1024,
        .supply_v = 3.0,
        .bonded = LQFP100,
        .channel = {P('A', 1), P('A', 2), P('A', 3), P('C', 1), P('C', 2),
                    NONE,      NONE,      NONE, /* gages */
                    P('A', 4), P('A', 5), P('A', 6), P('A', 7), P('B', 0),
                    P('B', 1), NONE,      NONE,      NONE,      NONE,
                    NONE,      NONE,      NONE,      NONE, /* staircase, reference */
                    P('C', 4), P('C', 5)},
        .warning = P('E', 4),
        .shunts = P('E', 5),
        .pull = PULLS(P('E', 4), P('E', 5)),
        .lamp = P('E', 6),
        .jumper = P('E', 8),
        .serial_out = P('C', 6),
        .serial_in = P('C', 7),
        .usart = 6,
        .serial_function = 8,
        .sensor_select = P('E', 3), /* SDO of the LIS302DL */
        .sensor_out = P('A', 6),
    },
    /* The ST-LINK supplies the clock; OSC_OUT is unused (UM1974 6.7; STM32_open_pin_data,
     * boards/A45_Nucleo_NUCLEO-F446ZE). */
    {
        .number = MR_BOARD_NUCLEO446,
        .idcode = 0x10006421u, /* RM0390 33.6.1, revision A */
        .flash_kib = 512,
        .has_no_ccm = true,
        .clock_bypass = true,
        .supply_v = 3.3,
        .bonded = LQFP144,
        WIRED_144,
        .serial_out = P('G', 14),
        .serial_in = P('G', 9),
        .usart = 6,
        .serial_function = 8,
        .sensor_select = NONE,
    },
};
#define TYPES (sizeof types / sizeof types[0])

const struct hil_board_type *hil_board_type_by_number(unsigned number)
{
    for (unsigned i = 0; i < TYPES; i++) {
        if (types[i].number == number)
            return &types[i];
    }
    return NULL;
}

const struct hil_board_type *hil_board_type_by_name(const char *name)
{
    int number = mr_board_by_name(name);
    return number < 0 ? NULL : hil_board_type_by_number((unsigned)number);
}

const char *hil_board_type_name(const struct hil_board_type *type)
{
    return mr_board_by_number(type->number)->name;
}

int hil_board_type_channel(const struct hil_board_type *type, unsigned port, unsigned pin)
{
    for (unsigned i = 0; i < HIL_BOARD_CHANNELS; i++) {
        if (hil_same_pin(type->channel[i], port, pin))
            return (int)i;
    }
    return -1;
}

bool hil_board_type_has(const struct hil_board_type *type, unsigned port, unsigned pin)
{
    return port < HIL_BOARD_PORTS && (type->bonded[port] >> pin & 1u) != 0;
}

void hil_options_default(struct hil_options *options)
{
    *options = (struct hil_options){
        .type = hil_board_type_by_number(MR_BOARD_ZG),
        .seed = 1,
        .hse_hz = 8000000,
        .lsi_hz = 32000,
        .host_baud = 2000000,
        .can_bus = HIL_CAN_CONNECTED,
        .adc_noise = true,
        .cpi = 1.0,
        .temperature_c = 20.0,
        .uid = {0x00310042u, MR_EMULATED_LOT << 8 | 0x0fu, 0x20343635u},
    };
}
