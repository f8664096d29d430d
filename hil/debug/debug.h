/* Debugger access to the core: breakpoints, steps, watchpoints, registers, memory. Virtual time
 * stands still while the debugger holds the board, so the board behaves the same with and without a
 * debugger.
 *
 * A basic block that contains a breakpoint is executed instruction by instruction, but still as one
 * block: it is counted once, interrupted only at its end, and its accesses have the time of its
 * start. A break therefore changes nothing.
 *
 * A watchpoint holds the board after the instruction that made the access (`hit_pc`); the rest of
 * the block is executed instruction by instruction. It detects accesses by the core, not by DMA. A
 * step runs the handlers of interrupts that occur during the step. */
#ifndef MATRIG_HIL_DEBUG_H
#define MATRIG_HIL_DEBUG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/board/board.h"

#define HIL_BREAKPOINTS_MAX 64u
#define HIL_WATCHPOINTS_MAX 8u

enum hil_hold_reason {
    HIL_HOLD_NONE, /* the board runs */
    HIL_HOLD_REQUESTED,
    HIL_HOLD_BREAKPOINT,
    HIL_HOLD_STEP,
    HIL_HOLD_WATCHPOINT,
    HIL_HOLD_BKPT, /* a BKPT instruction in the firmware */
};

/* numbers as in gdb */
enum hil_watch_kind { HIL_WATCH_WRITE = 2, HIL_WATCH_READ = 3, HIL_WATCH_ACCESS = 4 };

struct hil_watchpoint {
    enum hil_watch_kind kind;
    uint32_t address, size; /* size 0: this entry is free */
    size_t unicorn_hook;
};

struct hil_debug {
    struct hil_board *board; /* board to which the debugger is attached */
    enum hil_hold_reason hold_reason;
    uint32_t breakpoint[HIL_BREAKPOINTS_MAX];
    unsigned breakpoint_count;
    struct hil_watchpoint watchpoints[HIL_WATCHPOINTS_MAX];
    enum hil_watch_kind hit_kind; /* watchpoint that was hit (HIL_HOLD_WATCHPOINT) */
    uint32_t hit_address, hit_pc;
    bool is_watchpoint_hit;

    bool is_stepping, has_stepped; /* a step was requested; its instruction has been executed */
    unsigned step_depth;           /* active exceptions at the start of the step */
    /* execution continues with the instruction at resume_pc, without breaking there again */
    bool is_resuming;
    uint32_t resume_pc;
};

/* hil_debug_attach and hil_debug_detach attach and detach a debugger. `debug` belongs to the caller
 * and must stay valid until detaching. Attaching holds the board at once. Detaching removes all
 * breakpoints and watchpoints and lets the board run. */
void hil_debug_attach(struct hil_board *board, struct hil_debug *debug);
void hil_debug_detach(struct hil_board *board);
void hil_debug_hold(struct hil_board *board, enum hil_hold_reason reason);
bool hil_debug_is_holding(const struct hil_board *board);

/* Let the board run, or execute one instruction. */
void hil_debug_run(struct hil_board *board);
void hil_debug_step(struct hil_board *board);

/* Lets time advance to until_ps while the board is held. The core and the peripherals that DBGMCU
 * stops do not run; everything else runs, and its interrupts become pending. Ends early if a reset
 * is requested. */
void hil_debug_advance(struct hil_board *board, uint64_t until_ps);

/* Set or remove a breakpoint or watchpoint. MR_OK, also if it is already set or removed; MR_FULL:
 * more than HIL_BREAKPOINTS_MAX or HIL_WATCHPOINTS_MAX. */
enum mr_status hil_debug_set_breakpoint(struct hil_board *board, uint32_t address, bool set);
enum mr_status hil_debug_set_watchpoint(struct hil_board *board, enum hil_watch_kind kind,
                                        uint32_t address, uint32_t size, bool set);

/* Registers, numbered as in the target description in gdb.c. Values have 32 bits, or 64 for
 * D0..D15. */
enum hil_debug_register {
    HIL_REG_PC = 15,
    HIL_REG_XPSR = 16,
    HIL_REG_MSP = 17,
    HIL_REG_PSP,
    HIL_REG_PRIMASK,
    HIL_REG_BASEPRI,
    HIL_REG_FAULTMASK,
    HIL_REG_CONTROL,
    HIL_REG_D0,
    HIL_REG_FPSCR = HIL_REG_D0 + 16,
    HIL_REG_COUNT
};
uint64_t hil_debug_read_register(const struct hil_board *board, unsigned number);
void hil_debug_write_register(struct hil_board *board, unsigned number, uint64_t value);

/* Access to memory and peripherals. Reading a register has no side effect; writing one has its
 * normal effects. Flash is programmed as a debug probe does it. MR_UNKNOWN: no memory at this
 * address, or not modelled; nothing is changed. */
enum mr_status hil_debug_read(struct hil_board *board, uint32_t address, uint8_t *out, size_t n);
enum mr_status hil_debug_write(struct hil_board *board, uint32_t address, uint8_t *bytes, size_t n);

#endif
