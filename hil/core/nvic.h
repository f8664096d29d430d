/* Which exception is pending, active and allowed: NVIC and the system handlers' priorities (ARMv7-M
 * B1.5, PM0214 4.3).
 *
 * Exception numbers: 1..15 system, 16 + n interrupt n. Priorities keep the upper four bits, as on
 * the STM32F4. */
#ifndef MATRIG_HIL_NVIC_H
#define MATRIG_HIL_NVIC_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"

struct hil_core;

enum hil_exception {
    HIL_EXC_NONE = 0,
    HIL_EXC_RESET = 1,
    HIL_EXC_NMI = 2,
    HIL_EXC_HARD_FAULT = 3,
    HIL_EXC_MEM_MANAGE = 4,
    HIL_EXC_BUS_FAULT = 5,
    HIL_EXC_USAGE_FAULT = 6,
    HIL_EXC_SVCALL = 11,
    HIL_EXC_DEBUG_MONITOR = 12,
    HIL_EXC_PENDSV = 14,
    HIL_EXC_SYSTICK = 15,
};

/* Interrupt numbers of the peripherals modelled (RM0090 table 62); of the streams of DMA: dma.c. */
enum hil_irq {
    HIL_IRQ_FLASH = 4,
    HIL_IRQ_RCC = 5,
    HIL_IRQ_ADC = 18,
    HIL_IRQ_CAN1_TX = 19,
    HIL_IRQ_CAN1_RX0 = 20,
    HIL_IRQ_CAN1_RX1 = 21,
    HIL_IRQ_CAN1_SCE = 22,
    HIL_IRQ_TIM2 = 28,
    HIL_IRQ_TIM4 = 30,
    HIL_IRQ_I2C1_EV = 31,
    HIL_IRQ_I2C1_ER = 32,
    HIL_IRQ_SPI2 = 36,
    HIL_IRQ_USART1 = 37,
    HIL_IRQ_USART6 = 71,
};

void hil_nvic_reset(struct hil_nvic *nvic);
/* Recompute what is best and what runs; to be called after any change of the sets or priorities. */
void hil_nvic_update(struct hil_core *core);
/* A peripheral drives its interrupt line; a line that is high when its handler returns pends
 * again. */
void hil_irq_line(struct hil_core *core, unsigned irq, bool level);
/* The same for an exception by its number (clock security holds NMI). */
void hil_nvic_line(struct hil_core *core, unsigned exception, bool level);
/* Mark taken / finished. */
void hil_nvic_activate(struct hil_core *core, unsigned exception);
void hil_nvic_deactivate(struct hil_core *core, unsigned exception);
bool hil_nvic_is_active(const struct hil_nvic *nvic, unsigned exception);
/* Group priority of a priority value under PRIGROUP. */
int hil_nvic_group(const struct hil_nvic *nvic, int priority);

/* SysTick: 24-bit down counter (ARMv7-M B3.3). The counter is computed when somebody looks; only
 * its zero is an event. */
void hil_systick_create(struct hil_core *core);
void hil_systick_reset(struct hil_core *core);

/* System control block and the rest of the private peripheral bus: CPUID to CPACR, FPU control, DWT
 * cycle counter, debug identification (ARMv7-M B3.2, RM0090 38). */
/* `idcode`: of the chip, for DBGMCU. */
void hil_scb_reset(struct hil_scb *scb, uint32_t idcode);
/* Anything from 0xE0000000 to 0xE00FFFFF; hands on to NVIC and SysTick. */
uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size);
void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

#endif
