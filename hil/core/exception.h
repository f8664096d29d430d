/* Exception entry and return, faults, sleep (ARMv7-M B1.5). */
#ifndef MATRIG_HIL_EXCEPTION_H
#define MATRIG_HIL_EXCEPTION_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;

/* CFSR bits used (ARMv7-M B3.2.15). */
enum {
    HIL_CFSR_IACCVIOL = 1u << 0,
    HIL_CFSR_IBUSERR = 1u << 8,
    HIL_CFSR_PRECISERR = 1u << 9,
    HIL_CFSR_STKERR = 1u << 12,
    HIL_CFSR_BFARVALID = 1u << 15,
    HIL_CFSR_UNDEFINSTR = 1u << 16,
    HIL_CFSR_INVSTATE = 1u << 17,
    HIL_CFSR_INVPC = 1u << 18,
    HIL_CFSR_NOCP = 1u << 19,
    HIL_CFSR_UNALIGNED = 1u << 24,
};

/* Number of the exception to take now, 0 for none: pending, of higher priority than what runs, not
 * masked. */
unsigned hil_exception_due(struct hil_core *core);
/* True when WFI ends: as hil_exception_due, but PRIMASK does not count. */
bool hil_exception_wakes(struct hil_core *core);
/* Take it; the core is stopped before instruction `pc`. */
void hil_exception_enter(struct hil_core *core, unsigned exception, uint32_t pc);
/* Tell the trace that the core goes to another exception, or back to the thread. */
void hil_exception_seen(struct hil_core *core);
/* The core branched to EXC_RETURN. */
void hil_exception_return(struct hil_core *core, uint32_t exc_return);
/* A synchronous fault of the instruction at `pc`: escalates to HardFault, and to a halt, as the
 * architecture says. `address`: what it accessed, for BFAR. */
void hil_exception_fault(struct hil_core *core, uint32_t cfsr, uint32_t pc, uint32_t address);
/* SVC: pc is the instruction after it. */
void hil_exception_svc(struct hil_core *core, uint32_t pc);
/* BKPT without debugger: HardFault with DEBUGEVT. */
void hil_exception_bkpt(struct hil_core *core, uint32_t pc);

#endif
