/* The microcontroller: the peripherals of an STM32F407 around the core, where each is on the bus,
 * and how the chip joins them: clocks and reset lines, requests of DMA, triggers, alternate
 * functions of pins.
 *
 * Whoever builds a board sets the core's, the options' and the state's places, and connects what is
 * outside: the wires of CAN and USART, the slaves of SPI and I2C, the analogue source, the flash's
 * calls. */
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

/* Without pointers: a copy is a snapshot. */
struct hil_mcu_state {
    struct hil_rcc rcc;
    struct hil_flash flash;
    struct hil_gpio gpio;
    struct hil_tim tim[HIL_TIMERS];
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
    struct hil_pin pin[6]; /* alternate functions */
    struct hil_pin line_in;
};

/* Join the parts. `mcu` is zero and outlived by the others. Its pin listeners are called after the
 * earlier ones. */
void hil_mcu_create(struct hil_mcu *mcu, struct hil_core *core, struct hil_options *options,
                    struct hil_mcu_state *state);
/* What a reset line of the chip reaches, the core apart. `csr_flags` are the flags that RCC_CSR
 * will show. */
void hil_mcu_reset(struct hil_mcu *mcu, uint32_t csr_flags);

#endif
