/* The Cortex-M4F core: Unicorn runs the instructions, this file counts them, keeps virtual time and stops
 * where an exception is due. Everything above single instructions (exceptions, system control space) is
 * our own. */
#ifndef MATRIG_HIL_CPU_H
#define MATRIG_HIL_CPU_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"

struct hil_board;

/* All of the core that software can see. Valid while the core is stopped; see hil_cpu_save. */
struct hil_cpu_registers {
    uint32_t r[13];
    uint32_t msp, psp, lr, pc, xpsr;
    uint32_t control, primask, basepri, faultmask, fpscr;
    uint64_t d[16];
};

struct hil_cpu {
    uint32_t block_instructions; /* of the block that runs, not yet counted into time */
    uint32_t block_address;
    uint32_t block_size;
    bool walking;                /* it is walked through: hil/debug/debug.h, hil/debug/pin_times.h */
    bool asleep;
    bool event;                  /* the event register that WFE waits for */
};

/* Flags of a basic block, found when it is first met. */
enum { HIL_BLOCK_FP = 1, HIL_BLOCK_SEV = 2, HIL_BLOCK_MARKED = 4 /* for the trace */, HIL_BLOCK_WALKED = 8 /* hil/debug/pin_times.h */ };

struct hil_block_info {
    uint32_t address;
    uint16_t size;
    uint8_t instructions;
    uint8_t flags;
    uint32_t profile_block;
};

#define HIL_BLOCK_CACHE 8192u

/* Create the core and map the memories of `board`. Aborts when Unicorn cannot. */
void hil_cpu_create(struct hil_board *board);
void hil_cpu_destroy(struct hil_board *board);
/* Vector table's SP and PC, everything else at its reset value. */
void hil_cpu_reset(struct hil_board *board);
/* Copy the registers out of, and into, the core. */
void hil_cpu_save(const struct hil_board *board, struct hil_cpu_registers *registers);
void hil_cpu_load(struct hil_board *board, const struct hil_cpu_registers *registers);
/* Forget translated code and what is known of its blocks, after memory was written from outside. */
void hil_cpu_forget_code(struct hil_board *board);
/* The same for n bytes at an address. */
void hil_cpu_forget_range(struct hil_board *board, uint32_t address, uint32_t n);
/* What is known of the block at `address` is no longer true: look again when it comes. */
void hil_cpu_inspect_again(struct hil_board *board, uint32_t address);
/* Run instructions until something is due (event, exception, stop). */
void hil_cpu_run(struct hil_board *board);
/* A debugger jumps out of the block that is walked through: what was run of it counts. */
void hil_cpu_leave_block(struct hil_board *board);
/* Make the core look up at the next basic block. Callable from anywhere. */
void hil_cpu_attend(struct hil_board *board);
/* Address that the multiple, double or exclusive transfer at `pc` begins at, if it is one with a general base register
 * (as the registers are now). */
bool hil_cpu_transfer_address(const struct hil_board *board, uint32_t pc, uint32_t *address);
/* Faster stores (hil/core/unicorn_stores.c): of a new board; of the board that runs now (NULL: none); it runs code from RAM. */
struct hil_stores {
    bool code_in_ram;
    struct CPUState *core; /* Unicorn's; NULL: not met yet */
};
void hil_stores_start(struct hil_stores *stores);
void hil_stores_run(struct hil_stores *stores);
void hil_stores_meet_code(struct hil_stores *stores);
/* PC of the instruction in the running block that accesses `address`; the block's start when it cannot be
 * found. */
uint32_t hil_cpu_access_pc(const struct hil_board *board, uint32_t address, bool write);

#endif
