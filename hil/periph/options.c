#include "hil/periph/options.h"

#include <stddef.h>

#include "common/emulated.h"
#include "common/image.h"

#define PIN(letter, pin)    \
    {                       \
        (letter) - 'A', pin \
    }
#define NO_PIN         \
    {                  \
        HIL_NO_PORT, 0 \
    }
/* Levels of the pins at reset: memory not selected, thermometer bus idle, CAN recessive, warning
 * lamp on, shunts off, camera not triggered. */
#define PIN_PULLS(warning, shunts)                                                           \
    {                                                                                        \
        {PIN('B', 12), true}, {PIN('B', 6), true}, {PIN('B', 7), true}, {PIN('D', 1), true}, \
            {warning, false}, {shunts, false},                                               \
        {                                                                                    \
            PIN('E', 2), false                                                               \
        }                                                                                    \
    }
/* Packages: pinouts of the STM32F405/407 data sheet, figures 13 and 14. */
#define LQFP144_PINS                                                      \
    {                                                                     \
        0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0x0003, 0 \
    }
#define LQFP100_PINS                                            \
    {                                                           \
        0xffff, 0xffff, 0xffff, 0xffff, 0xffff, 0, 0, 0x0003, 0 \
    }
/* Devices: RM0090 38.6.1. */
#define F407_REVISION_Y_IDCODE 0x100f6413u

/* The rig's inputs and outputs on a board with all 144 pins: transducers, gages, staircase and
 * reference. */
#define LQFP144_WIRING                                                                   \
    .channel_pin =                                                                       \
        {PIN('F', 3), PIN('F', 4),  PIN('F', 5), PIN('F', 6), PIN('F', 7), PIN('F', 8),  \
         PIN('F', 9), PIN('F', 10), PIN('A', 0), PIN('A', 1), PIN('A', 2), PIN('A', 3),  \
         PIN('A', 4), PIN('A', 5),  PIN('A', 6), PIN('A', 7), PIN('B', 0), PIN('B', 1),  \
         PIN('C', 0), PIN('C', 1),  PIN('C', 2), PIN('C', 3), PIN('C', 4), PIN('C', 5)}, \
    .warning_pin = PIN('E', 0), .shunt_pin = PIN('E', 1),                                \
    .pulls = PIN_PULLS(PIN('E', 0), PIN('E', 1)), .lamp_sense_pin = PIN('E', 3),         \
    .jumper_pin = PIN('E', 8)

static const struct hil_board_type board_types[] = {
    {
        .number = MR_BOARD_ZG,
        .idcode = F407_REVISION_Y_IDCODE,
        .flash_kib = 1024,
        .supply_v = 3.3,
        .bonded_pins = LQFP144_PINS,
        LQFP144_WIRING,
        .serial_out_pin = PIN('A', 9),
        .serial_in_pin = PIN('A', 10),
        .usart = 1,
        .serial_alternate_function = 7,
        .is_rom_on_serial = true,
        .sensor_select_pin = NO_PIN,
    },
    /* Parts on the board, from ST's own project of the board (STM32_open_pin_data,
     * boards/C47_Discovery_STM32F407G-DISC1); its VDD is 3 V (UM1472 4.3). */
    {
        .number = MR_BOARD_DISCOVERY,
        .idcode = F407_REVISION_Y_IDCODE,
        .flash_kib = 1024,
        .supply_v = 3.0,
        .bonded_pins = LQFP100_PINS,
        .channel_pin = {PIN('A', 1), PIN('A', 2), PIN('A', 3), PIN('C', 1), PIN('C', 2),
                        NO_PIN,      NO_PIN,      NO_PIN, /* gages */
                        PIN('A', 4), PIN('A', 5), PIN('A', 6), PIN('A', 7), PIN('B', 0),
                        PIN('B', 1), NO_PIN,      NO_PIN,      NO_PIN,      NO_PIN,
                        NO_PIN,      NO_PIN,      NO_PIN,      NO_PIN, /* staircase, reference */
                        PIN('C', 4), PIN('C', 5)},
        .warning_pin = PIN('E', 4),
        .shunt_pin = PIN('E', 5),
        .pulls = PIN_PULLS(PIN('E', 4), PIN('E', 5)),
        .lamp_sense_pin = PIN('E', 6),
        .jumper_pin = PIN('E', 8),
        .serial_out_pin = PIN('C', 6),
        .serial_in_pin = PIN('C', 7),
        .usart = 6,
        .serial_alternate_function = 8,
        .sensor_select_pin = PIN('E', 3), /* SDO of the LIS302DL */
        .sensor_out_pin = PIN('A', 6),
    },
    /* The ST-LINK supplies the clock; OSC_OUT is unused (UM1974 6.7; STM32_open_pin_data,
     * boards/A45_Nucleo_NUCLEO-F446ZE). */
    {
        .number = MR_BOARD_NUCLEO446,
        .idcode = 0x10006421u, /* RM0390 33.6.1, revision A */
        .flash_kib = 512,
        .has_no_ccm = true,
        .has_clock_bypass = true,
        .supply_v = 3.3,
        .bonded_pins = LQFP144_PINS,
        LQFP144_WIRING,
        .serial_out_pin = PIN('G', 14),
        .serial_in_pin = PIN('G', 9),
        .usart = 6,
        .serial_alternate_function = 8,
        .sensor_select_pin = NO_PIN,
    },
};
#define TYPE_COUNT (sizeof board_types / sizeof board_types[0])

const struct hil_board_type *hil_board_type_by_number(unsigned number)
{
    for (unsigned i = 0; i < TYPE_COUNT; i++) {
        if (board_types[i].number == number)
            return &board_types[i];
    }
    return NULL;
}

const struct hil_board_type *hil_board_type_by_name(const char *name)
{
    int number = mr_board_number_by_name(name);
    return number < 0 ? NULL : hil_board_type_by_number((unsigned)number);
}

const char *hil_board_type_name(const struct hil_board_type *type)
{
    return mr_board_by_number(type->number)->name;
}

int hil_board_type_find_channel(const struct hil_board_type *type, unsigned port, unsigned pin)
{
    for (unsigned i = 0; i < HIL_BOARD_CHANNELS; i++) {
        if (hil_is_same_pin(type->channel_pin[i], port, pin))
            return (int)i;
    }
    return -1;
}

bool hil_board_type_has_pin(const struct hil_board_type *type, unsigned port, unsigned pin)
{
    return port < HIL_BOARD_PORTS && (type->bonded_pins[port] >> pin & 1u) != 0;
}

void hil_options_default(struct hil_options *options)
{
    *options = (struct hil_options){
        .type = hil_board_type_by_number(MR_BOARD_ZG),
        .noise_seed = 1,
        .hse_hz = 8000000,
        .lsi_hz = 32000,
        .host_baud = 2000000,
        .can_bus = HIL_CAN_CONNECTED,
        .has_adc_noise = true,
        .cycles_per_instruction = 1.0,
        .temperature_c = 20.0,
        .uid = {0x00310042u, MR_EMULATED_LOT << 8 | 0x0fu, 0x20343635u},
    };
}
