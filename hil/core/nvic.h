/* Exceptions: pending, active and enabled exceptions, the NVIC, and the priorities of the system
 * handlers (ARMv7-M B1.5, PM0214 4.3).
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

/* Interrupt numbers of the modelled peripherals (RM0090 table 62); those of the DMA streams are in
 * dma.c. */
enum hil_irq {
    HIL_IRQ_FLASH = 4,
    HIL_IRQ_ADC = 18,
    HIL_IRQ_CAN1_TX = 19,
    HIL_IRQ_CAN1_RX0 = 20,
    HIL_IRQ_TIM2 = 28,
    HIL_IRQ_TIM4 = 30,
    HIL_IRQ_USART1 = 37,
    HIL_IRQ_USART6 = 71,
};

void hil_nvic_reset(struct hil_nvic *nvic);
/* Recomputes `next_exception`, `next_group_priority` and `active_group_priority`. Call after any
 * change of the sets or priorities. */
void hil_nvic_update(struct hil_core *core);
/* Sets the level of a peripheral's interrupt line. A line that is high when its handler returns
 * becomes pending again. */
void hil_irq_set_line(struct hil_core *core, unsigned irq, bool level);
/* As hil_irq_set_line, for an exception by its number; the clock security system uses it for
 * NMI. */
void hil_nvic_set_line(struct hil_core *core, unsigned exception, bool level);
bool hil_nvic_is_active(const struct hil_nvic *nvic, unsigned exception);

/* SysTick: 24-bit down counter (ARMv7-M B3.3). The counter is computed when it is read; the only
 * event is the counter reaching 0. */
void hil_systick_create(struct hil_core *core);
void hil_systick_reset(struct hil_core *core);

/* System control block and the rest of the private peripheral bus: CPUID to CPACR, FPU control, DWT
 * cycle counter, debug identification (ARMv7-M B3.2, RM0090 38). */

/* `idcode`: identification of the chip, for DBGMCU. */
void hil_scb_reset(struct hil_scb *scb, uint32_t idcode);
/* Accesses from 0xE0000000 to 0xE00FFFFF, including those to NVIC and SysTick. */
uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size);
void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

/* Stops SysTick and the cycle counter for a number of cycles while a debugger halts the core. */
void hil_scb_hold_counters(struct hil_core *core, uint64_t cycles);

/* --- entry and return, faults, sleep (ARMv7-M B1.5) --- */

/* CFSR bits used (ARMv7-M B3.2.15). */
enum {
    HIL_CFSR_IACCVIOL = 1u << 0,
    HIL_CFSR_IBUSERR = 1u << 8,
    HIL_CFSR_PRECISERR = 1u << 9,
    HIL_CFSR_UNSTKERR = 1u << 11,
    HIL_CFSR_STKERR = 1u << 12,
    HIL_CFSR_BFARVALID = 1u << 15,
    HIL_CFSR_UNDEFINSTR = 1u << 16,
    HIL_CFSR_INVSTATE = 1u << 17,
    HIL_CFSR_INVPC = 1u << 18,
    HIL_CFSR_NOCP = 1u << 19,
    HIL_CFSR_UNALIGNED = 1u << 24,
    HIL_CFSR_DIVBYZERO = 1u << 25,
};

/* Number of the exception to enter now (pending, not masked, and of higher priority than the
 * running code); 0: none. */
unsigned hil_exception_next(struct hil_core *core);
/* True if a sleep by WFI ends now: as hil_exception_next, but ignoring PRIMASK. */
bool hil_exception_can_wake(struct hil_core *core);
/* Enters an exception; the core is stopped before the instruction at `pc`. */
void hil_exception_enter(struct hil_core *core, unsigned exception, uint32_t pc);
/* Reports to the trace that the core changes to a different exception or back to thread mode. */
void hil_exception_trace(struct hil_core *core);
/* Call when the core has branched to EXC_RETURN. */
void hil_exception_return(struct hil_core *core, uint32_t exc_return);
/* Raises a synchronous fault of the instruction at `pc`; it escalates to HardFault and to a halt as
 * the architecture defines. `address`: the accessed address, for BFAR. */
void hil_exception_fault(struct hil_core *core, uint32_t cfsr, uint32_t pc, uint32_t address);
/* Raises SVCall; `pc` is the instruction after the SVC. */
void hil_exception_svc(struct hil_core *core, uint32_t pc);
/* BKPT without a debugger: raises HardFault with DEBUGEVT. */
void hil_exception_bkpt(struct hil_core *core, uint32_t pc);

#endif
