/* What there is between the core and Unicorn: blocks met so far, the state of a return, the ranges
 * that the bus answers. */
#ifndef MATRIG_HIL_ENGINE_H
#define MATRIG_HIL_ENGINE_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unicorn/unicorn.h>

#include "hil/core/stores.h"

struct hil_core;
struct hil_whatif;

/* Flags of a basic block, found when it is first met. */
enum {
    HIL_BLOCK_FP = 1,
    HIL_BLOCK_SEV = 2,
    HIL_BLOCK_MARKED = 4 /* for the trace */
};

struct hil_block_info {
    uint32_t address;
    uint16_t size;
    uint8_t instructions;
    uint8_t flags;
    uint32_t profile_block;
};

#define HIL_BLOCK_CACHE 8192u
#define HIL_REGIONS     7

/* A range of addresses that the bus answers. */
struct hil_region {
    struct hil_core *core;
    uint32_t base;
};

/* The last access that was stamped (stamp.h), of one run of a block. */
struct hil_stamped {
    uint32_t block;
    uint64_t cycle;
    uint32_t address;
    bool write;
    uint32_t pc;
    uint64_t issue; /* of the core's accesses, which */
    unsigned before;
};

/* What there is between this and Unicorn; derived, or of one return from it: no part of a
 * snapshot. */
struct hil_cpu_engine {
    struct hil_stores stores;
    struct hil_stamped stamped;
    struct hil_whatif *whatif; /* NULL: not needed yet */
    uint32_t profile_block;    /* number of the block that runs */
    /* 1, then 2: Unicorn runs one instruction of a block that is walked through */
    unsigned single;
    /* What the core's hooks leave for the loop. */
    int came_back;
    uint32_t came_back_number;
    uint32_t bad_address, bad_size;

    /* the core runs up to a floating-point instruction that will fault */
    bool runs_to_fp;
    unsigned split_bytes; /* of an unaligned store to flash, still to come one by one */
    bool rom_at_zero;     /* as the core's address space is mapped now */
    bool flash_guarded;   /* reads of flash by the core are caught */
    bool looks_at_loads;  /* stuck.h */
    struct hil_block_info blocks[HIL_BLOCK_CACHE];
    struct hil_region regions[HIL_REGIONS];
};

/* ---- must ---- */

/* A call of Unicorn that must not fail. */

static inline void hil_must(uc_err err, const char *what)
{
    if (err == UC_ERR_OK)
        return;
    fprintf(stderr, "matrig-board: the CPU emulator failed: %s: %s\n", what, uc_strerror(err));
    abort();
}

#endif
