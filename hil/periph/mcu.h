/* The microcontroller: the peripherals of an STM32F407, their addresses on the bus, and their
 * connections within the chip (clocks and reset lines, DMA requests, triggers, alternate functions
 * of pins).
 *
 * The code that builds a board provides core, options and state, and connects the outside parts:
 * the wires of CAN and USART, the slaves of SPI and I2C, the source of analogue signals and the
 * calls of the flash. */
#ifndef MATRIG_HIL_MCU_H
#define MATRIG_HIL_MCU_H

#include <stdint.h>

#include "hil/periph/adc.h"
#include "hil/periph/can.h"
#include "hil/periph/dma.h"
#include "hil/periph/flash.h"
#include "hil/periph/gpio.h"
#include "hil/periph/i2c.h"
#include "hil/periph/rcc.h"
#include "hil/periph/rules.h"
#include "hil/periph/spi.h"
#include "hil/periph/tim.h"
#include "hil/periph/usart.h"

/* Contains no pointers: a copy is a snapshot. */
struct hil_mcu_state {
    struct hil_rcc rcc;
    struct hil_flash flash;
    struct hil_gpio gpio;
    struct hil_tim tim[HIL_TIMER_COUNT];
    struct hil_dma dma[2];
    struct hil_adc adc[2];
    uint32_t adc_ccr;
    struct hil_usart usart;
    struct hil_spi spi;
    struct hil_i2c i2c;
    struct hil_can can;
    struct hil_iwdg iwdg;
    struct hil_tim11 tim11;
    struct hil_rules rules;
};

struct hil_mcu {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_rcc_device rcc;
    struct hil_flash_device flash;
    struct hil_gpio_device gpio;
    struct hil_tim_device tim;
    struct hil_dma_device dma;
    struct hil_adc_device adc;
    struct hil_usart_device usart;
    struct hil_spi_device spi;
    struct hil_i2c_device i2c;
    struct hil_can_device can;
    struct hil_iwdg_device iwdg;
    struct hil_tim11_device tim11;
    struct hil_rules_device rules;
    struct hil_pin pin[4 + HIL_CAPTURE_CHANNELS]; /* alternate functions */
    struct hil_pin serial_in_pin;
};

/* Connects the peripherals of the microcontroller. `mcu` must be zeroed; the other arguments must
 * outlive it. Pin listeners are called in the order in which they were added. */
void hil_mcu_create(struct hil_mcu *mcu, struct hil_core *core, struct hil_options *options,
                    struct hil_mcu_state *state);
/* Resets everything on the chip except the core. `csr_flags`: reset flags for RCC_CSR. */
void hil_mcu_reset(struct hil_mcu *mcu, uint32_t csr_flags);

#endif
