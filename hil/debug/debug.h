/* What a debugger does to the core: breakpoints, steps, watchpoints, registers, memory. Virtual
 * time stands still while it holds the board, and nothing here moves it: the board does the same
 * with and without.
 *
 * A basic block with a breakpoint in it is walked through instruction by instruction, as one block:
 * counted once, interrupted only at its end, its accesses at the time of its start. So breaking in
 * it changes nothing.
 *
 * A watchpoint holds behind the instruction that made the access, `watch_pc`: its block is walked
 * through from there. It sees the core's accesses, not DMA's. A step goes over
 * interrupts that come meanwhile: their handlers run. */
#ifndef MATRIG_HIL_DEBUG_H
#define MATRIG_HIL_DEBUG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/board/board.h"

#define HIL_BREAKPOINTS 64u
#define HIL_WATCHPOINTS 8u

enum hil_hold {
    HIL_HOLD_NONE, /* it runs */
    HIL_HOLD_ASKED,
    HIL_HOLD_BREAKPOINT,
    HIL_HOLD_STEP,
    HIL_HOLD_WATCHPOINT,
    HIL_HOLD_BKPT, /* the firmware's own instruction */
};

/* as gdb numbers them */
enum hil_watch { HIL_WATCH_WRITE = 2, HIL_WATCH_READ = 3, HIL_WATCH_ACCESS = 4 };

struct hil_watchpoint {
    enum hil_watch kind;
    uint32_t address, size; /* size 0: free */
    size_t hook;
};

struct hil_debug {
    struct hil_board *board; /* that it is attached to */
    enum hil_hold hold;
    uint32_t breakpoint[HIL_BREAKPOINTS];
    unsigned breakpoints;
    struct hil_watchpoint watch[HIL_WATCHPOINTS];
    enum hil_watch watch_kind; /* what hit: HIL_HOLD_WATCHPOINT */
    uint32_t watch_address, watch_pc;
    bool watch_hit;

    bool stepping, stepped; /* a step was asked for; its instruction has run */
    unsigned step_depth;    /* exceptions active when it began */
    /* the instruction at fresh_pc goes on from where it was held */
    bool fresh;
    uint32_t fresh_pc;
};

/* Attach and detach a debugger; `debug` is the caller's, and outlives the attachment. The board is
 * held at once. Detaching removes all break- and watchpoints and lets it run. */
void hil_debug_attach(struct hil_board *board, struct hil_debug *debug);
void hil_debug_detach(struct hil_board *board);
void hil_debug_hold(struct hil_board *board, enum hil_hold why);
bool hil_debug_holds(const struct hil_board *board);

/* Let it go on: run, or step an instruction. */
void hil_debug_run(struct hil_board *board);
void hil_debug_step(struct hil_board *board);

/* Let time go on while it is held, until then: what DBGMCU stops stands still, and what is part of
 * the core; all else runs, and its interrupts wait. Ends early with a reset that is asked for. */
void hil_debug_pass(struct hil_board *board, uint64_t until_ps);

/* MR_FULL: no more than the constants above; setting what is set, or removing what is not, is
 * MR_OK. */
enum mr_status hil_debug_break(struct hil_board *board, uint32_t address, bool set);
enum mr_status hil_debug_watch(struct hil_board *board, enum hil_watch kind, uint32_t address,
                               uint32_t size, bool set);

/* Registers by the numbers of the target description in gdb.c. Values of 32 bits, or 64 for
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

/* Memory and peripherals. Reading a register has no side effect here; writing one has its own.
 * Flash is written as a probe would. MR_UNKNOWN: nothing there, or not modelled; then nothing has
 * changed. */
enum mr_status hil_debug_read(struct hil_board *board, uint32_t address, uint8_t *out, size_t n);
enum mr_status hil_debug_write(struct hil_board *board, uint32_t address, uint8_t *bytes, size_t n);

#endif
