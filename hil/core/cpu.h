/* The Cortex-M4F core: Unicorn runs the instructions, this file counts them, keeps virtual time and stops
 * where an exception is due. Everything above single instructions (exceptions, system control space) is
 * our own. */
#ifndef MATRIG_HIL_CPU_H
#define MATRIG_HIL_CPU_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/stores.h"

struct hil_core;

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
    bool walking;                /* it is walked through: hil/core/onlooker.h */
    bool asleep;
    bool event;                  /* the event register that WFE waits for */
};

/* Flags of a basic block, found when it is first met. */
enum { HIL_BLOCK_FP = 1, HIL_BLOCK_SEV = 2, HIL_BLOCK_MARKED = 4 /* for the trace */, HIL_BLOCK_WALKED = 8 /* hil_store_watch_calls */ };

struct hil_block_info {
    uint32_t address;
    uint16_t size;
    uint8_t instructions;
    uint8_t flags;
    uint32_t profile_block;
};

#define HIL_BLOCK_CACHE 8192u
#define HIL_REGIONS 7

/* A range of addresses that the bus answers. */
struct hil_region {
    struct hil_core *core;
    uint32_t base;
};

/* What there is between this and Unicorn; derived, or of one return from it: no part of a snapshot. */
struct hil_cpu_engine {
    struct hil_stores stores;
    uint32_t profile_block;    /* number of the block that runs */
    unsigned single;           /* 1, then 2: Unicorn runs one instruction of a block that is walked through */
    /* What the core's hooks leave for the loop. */
    int came_back;
    uint32_t came_back_number;
    uint32_t bad_address, bad_size;
    int bad_type;

    bool runs_to_fp;           /* the core runs up to a floating-point instruction that will fault */
    unsigned split_bytes;      /* of an unaligned store to flash, still to come one by one */
    bool rom_at_zero;          /* as the core's address space is mapped now */
    bool flash_guarded;        /* reads of flash by the core are caught */
    bool looks_at_loads;       /* stuck.h */
    struct hil_block_info blocks[HIL_BLOCK_CACHE];
    struct hil_region regions[HIL_REGIONS];
};

/* Create the core and map its memories. Aborts when Unicorn cannot. */
void hil_cpu_create(struct hil_core *core);
void hil_cpu_destroy(struct hil_core *core);
/* Vector table's SP and PC, everything else at its reset value. */
void hil_cpu_reset(struct hil_core *core);
/* Copy the registers out of, and into, the core. */
void hil_cpu_save(const struct hil_core *core, struct hil_cpu_registers *registers);
void hil_cpu_load(struct hil_core *core, const struct hil_cpu_registers *registers);
/* One register: 0..12, 13 the current SP, 14, 15 PC, 16 xPSR, 17 PRIMASK. */
#define HIL_PRIMASK 17u
uint32_t hil_cpu_register(const struct hil_core *core, unsigned number);
/* Forget translated code and what is known of its blocks, after memory was written from outside. */
void hil_cpu_forget_code(struct hil_core *core);
/* The same for n bytes at an address. */
void hil_cpu_forget_range(struct hil_core *core, uint32_t address, uint32_t n);
/* What is known of the block at `address` is no longer true: look again when it comes. */
void hil_cpu_inspect_again(struct hil_core *core, uint32_t address);
/* Run instructions until something is due (event, exception, stop). */
void hil_cpu_run(struct hil_core *core);
/* A debugger jumps out of the block that is walked through: what was run of it counts. */
void hil_cpu_leave_block(struct hil_core *core);
/* Address that the multiple, double or exclusive transfer at `pc` begins at, if it is one with a general base register
 * (as the registers are now). */
bool hil_cpu_transfer_address(const struct hil_core *core, uint32_t pc, uint32_t *address);
/* PC of the instruction in the running block that accesses `address`; the block's start when it cannot be
 * found. */
uint32_t hil_cpu_access_pc(const struct hil_core *core, uint32_t address, bool write);

#endif
