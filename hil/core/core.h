/* The processor with its memories, its bus, its interrupt controller and its clock: all that every
 * peripheral knows.
 *
 * `struct hil_core_state` holds no pointers: with the memories and the core's registers (cpu.h) it
 * is the whole of the processor, and a copy of it is a snapshot. What the core is connected to is
 * beside it.
 *
 * Arrows point down: peripherals, chips, rig and board include this; nothing of hil/core/ includes
 * them. The core reports to them over wires that they connect and by the calls below. */
#ifndef MATRIG_HIL_CORE_H
#define MATRIG_HIL_CORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unicorn/unicorn.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/core/translator.h"

/* The access in progress, for refusals. */
struct hil_access {
    uint32_t address;
    unsigned size;
    bool write;
};

/* A peripheral as the bus knows it; it has a kilobyte of addresses. `device` is handed to each
 * call, with `unit`. The bus refuses by registers.def before it calls: `read` and `write` see
 * registers of that table alone, and no value that the table refuses. */
struct hil_peripheral {
    uint32_t base;
    unsigned unit; /* of several alike behind one device */
    uint32_t (*read)(void *device, unsigned unit, uint32_t offset);
    void (*write)(void *device, unsigned unit, uint32_t offset, uint32_t value);
    bool narrow; /* byte and halfword writes are modelled */
    /* What a narrow write leaves in the rest of the word: the register's own bits. NULL: nothing,
     * where a written 0 means nothing or the register is no wider. */
    uint32_t (*rest)(void *device, unsigned unit, uint32_t offset);
    void *device;
    const uint32_t *clocks; /* its clock is on while one of these bits is; NULL: always */
    uint32_t clock_mask;
};

/* Memory of the chip that no store changes, from 0x1fff7000: unique id, option bytes and the
 * like. */
struct hil_system_memory {
    uint32_t (*read)(void *device, uint32_t address); /* the word at `address` & ~3 */
    void *device;
};

/* Clocks that were switched on a moment ago. */
struct hil_fresh_clocks {
    const uint32_t *clocks; /* NULL: none; else as in struct hil_peripheral */
    uint32_t mask;
    void (*accessed)(void *who); /* the first access to one that has such a clock */
    void *who;
};

#define HIL_PERIPHERALS_MAX 64u
#define HIL_REGISTER_WORDS  256u /* a kilobyte */
#define HIL_BUS_PAGES       512u /* kilobytes from 0x40000000 */

struct hil_bus {
    struct hil_access access;
    struct hil_system_memory system_memory;
    struct hil_fresh_clocks fresh;
    unsigned count;
    struct hil_peripheral peripheral[HIL_PERIPHERALS_MAX];
    uint8_t peripheral_of[HIL_BUS_PAGES];
    /* of each */
    const struct hil_register_set *registers_of[HIL_PERIPHERALS_MAX];
    /* by word of a peripheral; NULL: not yet looked for, or none */
    const struct hil_register *register_at[HIL_PERIPHERALS_MAX][HIL_REGISTER_WORDS];
};

#define HIL_NO_PERIPHERAL 0xffu

/* The peripheral at an address; NULL: none. */
static inline const struct hil_peripheral *hil_peripheral_at(const struct hil_bus *bus,
                                                             uint32_t address)
{
    uint32_t page = (address - 0x40000000u) >> 10;
    uint8_t i = page < HIL_BUS_PAGES ? bus->peripheral_of[page] : HIL_NO_PERIPHERAL;
    return i == HIL_NO_PERIPHERAL ? NULL : &bus->peripheral[i];
}

/* Who looks on while the core runs: a debugger, a trace, a profile. The core calls them, and
 * knows none of them by name; what they are is in hil/debug/. An onlooker whose calls are NULL is
 * not there.
 *
 * Nothing here changes what a board does: a debugger holds virtual time, the others only look. */
struct hil_debugger_calls {
    bool (*holds)(const void *who);
    /* was a watchpoint hit? Then hold, at the block's end */
    bool (*holds_hit)(void *who);
    /* the firmware's own instruction */
    void (*hold_bkpt)(void *who);
    /* must this block be walked through? */
    bool (*wants)(const void *who, uint32_t address, uint32_t size);
    /* of an instruction of such a block */
    bool (*stops_before)(void *who, uint32_t pc);
};

struct hil_tracer_calls {
    /* something may have changed at this cycle */
    void (*sample)(void *who, uint64_t at);
    void (*exception)(void *who); /* the core goes to another exception */
};

struct hil_profiler_calls {
    /* so many of that block have run */
    void (*count)(void *who, uint32_t address, uint32_t size, uint32_t instructions);
};

struct hil_onlookers {
    const struct hil_debugger_calls *debugger;
    const struct hil_tracer_calls *tracer;
    const struct hil_profiler_calls *profiler;
    void *debugger_who, *tracer_who, *profiler_who;
};

/* Who treats a slot: `at` is the moment it was set to. */
struct hil_event_wire {
    void (*handler)(void *device, uint64_t at);
    void *device;
};

struct hil_whatif;

/* Flags of a basic block, found when it is first met. */
enum { HIL_BLOCK_FP = 1, HIL_BLOCK_SEV = 2, HIL_BLOCK_DIVISION = 4 };

struct hil_block_info {
    uint32_t address;
    uint16_t size;
    uint8_t instructions;
    uint8_t flags;
};

#define HIL_BLOCK_CACHE 8192u
#define HIL_REGIONS     7

/* A range of addresses that the bus answers. */
struct hil_region {
    struct hil_core *core;
    uint32_t base;
};

/* What there is between this and Unicorn; derived, or of one return from it: no part of a
 * snapshot. */
struct hil_cpu_engine {
    struct hil_translator translator;
    struct hil_whatif *whatif; /* NULL: not needed yet */
    /* 1, then 2: Unicorn runs one instruction of a block that is walked through */
    unsigned single;
    /* What the core's hooks leave for the loop. */
    int came_back;
    uint32_t came_back_number;
    uint32_t bad_address, bad_size;
    struct hil_place bad_place; /* the instruction */
    bool left_inside;     /* the run was stopped by an access: the core stands at its instruction */
    unsigned split_bytes; /* of an unaligned store to flash, still to come one by one */
    bool rom_at_zero;     /* as the core's address space is mapped now */
    bool flash_guarded;   /* reads of flash by the core are caught */
    bool looks_at_loads;  /* stuck cells: cpu.h */
    struct hil_block_info blocks[HIL_BLOCK_CACHE];
    struct hil_region regions[HIL_REGIONS];
};

/* ---- must ---- */

/* A call of Unicorn that must not fail. */

static inline void uc_check(uc_err err, const char *what)
{
    if (err == UC_ERR_OK)
        return;
    fprintf(stderr, "matrig-board: the CPU emulator failed: %s: %s\n", what, uc_strerror(err));
    abort();
}

/* Zeroes; without memory there is no board. */
static inline void *hil_allocate(size_t size)
{
    void *bytes = calloc(1, size);
    if (!bytes)
        abort();
    return bytes;
}

#define HIL_CYCLE_PARTS 256u

/* A reset of the chip that was asked for, and not yet made. */
struct hil_reset {
    bool asked;
    bool power_lost;  /* it is the return of the supply */
    uint32_t flags;   /* of RCC_CSR */
    uint64_t hold_ps; /* and lasts until then */
};

struct hil_core {
    struct hil_core_state state;
    struct hil_memory *memory; /* page-aligned: the core runs directly on it */
    struct uc_struct *uc;
    FILE *trace;          /* NULL, or the file for exceptions and unusual events */
    bool watch_alignment; /* hil_options.watch_alignment */
    uint32_t cycle_parts; /* of a cycle, HIL_CYCLE_PARTS, for each instruction: hil_options.cpi */

    /* Of the present run; nothing of it outlives the run. */
    uint64_t limit_cycle; /* the block hook looks up from here on; at most the next event */
    bool target_reached;
    struct hil_reset reset;
    bool stopped;
    enum mr_status stop_status;
    char reason[512];

    struct hil_bus bus;
    struct hil_event_wire handler[HIL_EVENT_COUNT];
    struct hil_bank_calls bank;
    bool no_ccm; /* the chip has none */
    struct hil_onlookers onlookers;
    struct hil_cpu_engine engine;
};

/* Physical time of a cycle, rounded down; and the first cycle that is not before a time. */
uint64_t hil_clock_ps(const struct hil_clock *clock, uint64_t cycle);
uint64_t hil_clock_cycle(const struct hil_clock *clock, uint64_t t_ps);
/* HCLK of a clock that starts. */
void hil_clock_start(struct hil_clock *clock, uint32_t hclk_hz);
/* HCLK becomes hclk_hz at the present cycle. Parts that wait for a physical time must be notified:
 * hil_hclk_change does both. */
void hil_clock_turn(struct hil_clock *clock, uint32_t hclk_hz);

/* Stop the run, with a message. The first stop wins. */
__attribute__((format(printf, 3, 4))) void hil_core_stop(struct hil_core *core,
                                                         enum mr_status status, const char *format,
                                                         ...);
/* Reset the chip at the next chance; `flags` are added to RCC_CSR. */
void hil_core_request_reset(struct hil_core *core, uint32_t flags);
/* Make the core look up at the next basic block. Callable from anywhere. */
static inline void hil_core_attend(struct hil_core *core)
{
    core->limit_cycle = 0;
}

/* One line to the trace, if there is one. */
__attribute__((format(printf, 2, 3))) void hil_core_trace_line(struct hil_core *core,
                                                               const char *format, ...);
#define hil_trace(core, ...)                          \
    do {                                              \
        if ((core)->trace)                            \
            hil_core_trace_line((core), __VA_ARGS__); \
    } while (0)

static inline uint64_t hil_now(const struct hil_core *core)
{
    return core->state.clock.now_cycle;
}
static inline uint64_t hil_now_ps(const struct hil_core *core)
{
    return hil_clock_ps(&core->state.clock, core->state.clock.now_cycle);
}

/* Where n bytes are in flash, SRAM or CCM; NULL: not in one of them. */
static inline uint8_t *hil_memory_place(struct hil_memory *memory, uint32_t address, uint32_t n)
{
    if (address - HIL_SRAM_BASE < HIL_SRAM_SIZE && n <= HIL_SRAM_SIZE - (address - HIL_SRAM_BASE))
        return memory->sram + (address - HIL_SRAM_BASE);
    if (address - HIL_CCM_BASE < HIL_CCM_SIZE && n <= HIL_CCM_SIZE - (address - HIL_CCM_BASE))
        return memory->ccm + (address - HIL_CCM_BASE);
    if (address - HIL_FLASH_BASE < HIL_FLASH_SIZE &&
        n <= HIL_FLASH_SIZE - (address - HIL_FLASH_BASE))
        return memory->flash + (address - HIL_FLASH_BASE);
    return NULL;
}

/* Host address of n bytes of the chip's memory, or NULL when they are not in one memory (or would
 * write flash). */
static inline uint8_t *hil_memory_at(const struct hil_core *core, uint32_t address, uint32_t n,
                                     bool write)
{
    uint8_t *place = hil_memory_place(core->memory, address, n);
    if (place)
        return write && address - HIL_FLASH_BASE < HIL_FLASH_SIZE ? NULL : place;
    if (write)
        return NULL;
    if (address - HIL_ROM_BASE < HIL_ROM_SIZE && n <= HIL_ROM_SIZE - (address - HIL_ROM_BASE))
        return (uint8_t *)(uintptr_t)hil_bootrom_image + (address - HIL_ROM_BASE);
    if (core->state.bank.boot_rom) {
        if (address < HIL_ROM_SIZE && n <= HIL_ROM_SIZE - address)
            return (uint8_t *)(uintptr_t)hil_bootrom_image + address;
    } else if (address < HIL_FLASH_SIZE && n <= HIL_FLASH_SIZE - address) {
        return core->memory->flash + address;
    }
    return NULL;
}

/* Is this address one that cannot be read before the operation of flash in progress ends? */
static inline bool hil_memory_stalls(const struct hil_core *core, uint32_t address)
{
    const struct hil_bank *bank = &core->state.bank;
    return bank->busy && (address - HIL_FLASH_BASE < HIL_FLASH_SIZE ||
                          (address < HIL_FLASH_SIZE && !bank->boot_rom));
}

/* Bytes of flash, SRAM, CCM and ROM. MR_UNKNOWN when the range is not in one memory. */
enum mr_status hil_memory_peek(const struct hil_core *core, uint32_t address, void *out, size_t n);

/* One register: 0..12, 13 the current SP, 14, 15 PC, 16 xPSR, 17 PRIMASK. */
#define HIL_PRIMASK 17u
uint32_t hil_cpu_register(const struct hil_core *core, unsigned number);

/* Which registers and bits the emulated board models, in one table (registers.def): the bus refuses
 * by it, a reset takes its values, a test pokes every register of every peripheral and compares.
 *
 * A write that changes a reserved bit, a bit that is not modelled or a read-only register ends the
 * run with a message. Silicon ignores such writes; a program that makes them is wrong or relies on
 * something that is not here. */

struct hil_register {
    uint16_t offset; /* of the first */
    uint8_t count;   /* so many alike, */
    uint8_t stride;  /* so many bytes apart */
    char access;     /* 'b' both, 'r' read-only, 'w' write-only */
    bool loose;      /* reserved bits may be written with anything: flags cleared by 0, keys */
    const char *name;
    uint32_t reset;
    uint32_t plain;   /* bits that read back as written */
    uint32_t action;  /* bits whose writing does something or clears a flag */
    uint32_t status;  /* bits that hardware sets; what is written there does not matter */
    uint32_t partly;  /* bits of which some values, or in some states, are modelled: see `what` */
    uint32_t refused; /* bits that hardware has and the board does not model */
    const char *what; /* about partly and refused */
};

struct hil_register_set {
    const char *peripheral;
    uint32_t base;
    const struct hil_register *all; /* the one behind the last has no name */
};

/* The table of a peripheral by its base address; NULL: it has none. */
const struct hil_register_set *hil_registers_of(uint32_t base);
const struct hil_register_set *hil_registers_all(size_t *count);
/* NULL: not modelled. */
const struct hil_register *hil_register_at(const struct hil_register_set *set, uint32_t offset);
/* Why hardware would ignore this write, as text in static storage; NULL: the write is allowed. */
const char *hil_register_objection(const struct hil_register *r, uint32_t value);
/* What `count` registers from `offset` on are after a reset; where there is none: 0. */
void hil_registers_reset(uint32_t base, uint32_t offset, uint32_t *word, size_t count);

/* The access in progress: which instruction of the running block makes it, when, and its refusal.
 *
 * Everything else of the emulator happens at the start of a basic block. Here an access has the
 * time of its own instruction: the start of its block plus one cycle (hil_options.cpi) for every
 * instruction before it. On hardware an instruction takes one cycle or more (an IT instruction or a
 * NOP can take none), so the time between two accesses is a lower bound of the real one. */

/* Must the multiple, double or exclusive transfer at `pc` fault for its address, as the registers
 * are now? One with a general base register. */
bool hil_transfer_is_unaligned(const struct hil_core *core, uint32_t pc);
/* Does a condition code hold with these flags? */
bool hil_condition_holds(uint32_t xpsr, unsigned condition);
/* How many instructions begin from `from` to before `to`. */
unsigned hil_instructions_between(const struct hil_core *core, uint32_t from, uint32_t to);

/* PC of the instruction that makes the bus access in progress; for accesses from outside the core,
 * its present PC. */
uint32_t hil_access_pc(const struct hil_core *core);

/* Of the access in progress, from a peripheral that is read or written. Zero when no instruction of
 * the firmware makes it: a debugger, DMA or the boot ROM does. */
struct hil_moment hil_stamp(const struct hil_core *core);
/* Of what happens without the core, at a cycle. */
struct hil_moment hil_stamp_at(const struct hil_core *core, uint64_t cycle);

/* Refusals: an access that is not modelled ends the run with a message. */

/* Called by a peripheral that is asked for something it does not model, with what it is: "TIM4:
 * centre-aligned mode". Returns 0, so that a read can return it; the run stops. */
uint32_t hil_bus_refuse(struct hil_core *core, const char *what);
/* The same for a register that is not modelled. */
uint32_t hil_bus_no_register(struct hil_core *core);
/* The run stops at the access in progress: `why`, the access, and `what` (NULL: nothing to add). */
void hil_bus_stop(struct hil_core *core, const char *why, const char *what);

/* Event queue: one fixed slot per source, so that the whole queue is a few words without pointers.
 *
 * A slot holds either an HCLK cycle (peripherals: they count clocks, whatever the clock's rate is)
 * or a physical time in picoseconds (the rig, oscillators, the watchdog's own clock), which is
 * converted again whenever HCLK changes. */

/* An empty queue, and no peripheral on the bus. */
void hil_core_create(struct hil_core *core);
void hil_event_wire(struct hil_core *core, enum hil_event_slot slot,
                    void (*handler)(void *device, uint64_t at), void *device);
/* Set, move or (HIL_NEVER) clear a slot. A past moment is due at once. */
void hil_event_set_cycle(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle);
void hil_event_set_ps(struct hil_core *core, enum hil_event_slot slot, uint64_t t_ps);
/* Treat everything due up to the present cycle, in order of time. */
void hil_event_run(struct hil_core *core);

/* HCLK becomes hclk_hz now. */
void hil_hclk_change(struct hil_core *core, uint32_t hclk_hz);
/* No clock: physical time goes to the next event that is in physical time, while cycles stand
 * still. */
void hil_hclk_stand_still(struct hil_core *core);

#endif
