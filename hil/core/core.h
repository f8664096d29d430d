/* The processor with its memories, bus, interrupt controller and clock: the part of the emulator
 * that every peripheral uses.
 *
 * `struct hil_core_state` contains no pointers. With the memories and the core's registers (cpu.h)
 * it is the complete state of the processor, and a copy of it is a snapshot. Pointers to other
 * parts are kept outside of it.
 *
 * Dependencies: peripherals, chips, rig and board include this header; nothing in hil/core/
 * includes theirs. The core reports to them through call-backs that they connect. */
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

/* The bus access in progress, for messages about a refused access. */
struct hil_access {
    uint32_t address;
    unsigned size;
    bool is_write;
};

/* A peripheral on the bus, with a kilobyte of addresses. `device` and `unit` are passed to each
 * call. The bus checks accesses against registers.def before a call, so `read` and `write` receive
 * only registers of that table and no refused value. */
struct hil_peripheral {
    uint32_t base;
    unsigned unit; /* number among identical peripherals of one device */
    uint32_t (*read)(void *device, unsigned unit, uint32_t offset);
    void (*write)(void *device, unsigned unit, uint32_t offset, uint32_t value);
    bool allows_narrow_writes; /* true if byte and halfword writes are modelled */
    /* Returns the bits of the register that a narrow write does not change. NULL: not needed,
     * because writing 0 has no effect or the register is as narrow as the write. */
    uint32_t (*unchanged_bits)(void *device, unsigned unit, uint32_t offset);
    void *device;
    /* the clock is on while a bit of clock_mask is set in this word; NULL: the clock is always
     * on */
    const uint32_t *clock_enables;
    uint32_t clock_mask;
};

/* Read-only memory of the chip from 0x1fff7000: unique identifier, option bytes and others. */
struct hil_system_memory {
    uint32_t (*read)(void *device, uint32_t address); /* returns the word at `address` & ~3 */
    void *device;
};

/* Clocks that have just been switched on. */
struct hil_new_clocks {
    const uint32_t *clock_enables; /* NULL: none; otherwise as in struct hil_peripheral */
    uint32_t clock_mask;
    /* called at the first access to a peripheral whose clock has just been switched on */
    void (*on_first_access)(void *context);
    void *context;
};

#define HIL_PERIPHERALS_MAX 64u
#define HIL_REGISTER_WORDS  256u /* words in a kilobyte */
#define HIL_BUS_PAGES       512u /* number of kilobytes from 0x40000000 */

struct hil_bus {
    struct hil_access access;
    struct hil_system_memory system_memory;
    struct hil_new_clocks new_clocks;
    unsigned peripheral_count;
    struct hil_peripheral peripheral[HIL_PERIPHERALS_MAX];
    uint8_t page_peripheral[HIL_BUS_PAGES];
    /* table of the registers of each peripheral */
    const struct hil_register_set *peripheral_registers[HIL_PERIPHERALS_MAX];
    /* registers by peripheral and word; NULL: not looked up yet, or no such register */
    const struct hil_register *register_at[HIL_PERIPHERALS_MAX][HIL_REGISTER_WORDS];
};

#define HIL_NO_PERIPHERAL 0xffu

/* Peripheral at an address; NULL: none. */
static inline const struct hil_peripheral *hil_peripheral_at(const struct hil_bus *bus,
                                                             uint32_t address)
{
    uint32_t page = (address - 0x40000000u) >> 10;
    uint8_t i = page < HIL_BUS_PAGES ? bus->page_peripheral[page] : HIL_NO_PERIPHERAL;
    return i == HIL_NO_PERIPHERAL ? NULL : &bus->peripheral[i];
}

/* Observers while the core runs: debugger, trace and profiler (hil/debug/). The core knows them
 * only by these calls. An observer whose calls are NULL is not attached.
 *
 * Observers do not change the behaviour of a board; a debugger stops virtual time while it holds
 * the board. */
struct hil_debugger_calls {
    bool (*is_holding)(const void *context);
    /* returns true if a watchpoint was hit; the board is then held at the end of the block */
    bool (*has_hit_watchpoint)(void *context);
    /* called when the firmware has executed BKPT */
    void (*handle_bkpt)(void *context);
    /* returns true if the block must be executed instruction by instruction */
    bool (*must_step_block)(const void *context, uint32_t address, uint32_t size);
    /* returns true if the board must stop before this instruction */
    bool (*must_stop_before)(void *context, uint32_t pc);
};

struct hil_tracer_calls {
    /* called when signals may have changed at this cycle */
    void (*sample_signals)(void *context, uint64_t at);
    /* called when the core changes to a different exception */
    void (*on_exception_change)(void *context);
};

struct hil_profiler_calls {
    /* called when this number of instructions of the block has been executed */
    void (*count_instructions)(void *context, uint32_t address, uint32_t size,
                               uint32_t instructions);
};

struct hil_observers {
    const struct hil_debugger_calls *debugger;
    const struct hil_tracer_calls *tracer;
    const struct hil_profiler_calls *profiler;
    void *debugger_context, *tracer_context, *profiler_context;
};

/* Handler of an event slot; `at` is the time that was set. */
struct hil_event_handler {
    void (*handler)(void *device, uint64_t at);
    void *device;
};

struct hil_whatif;

/* Flags of a basic block, determined when the block is first executed. */
enum { HIL_BLOCK_HAS_FP = 1, HIL_BLOCK_HAS_SEV = 2, HIL_BLOCK_HAS_DIVISION = 4 };

struct hil_block_info {
    uint32_t address;
    uint16_t size;
    uint8_t instruction_count;
    uint8_t flags;
};

#define HIL_BLOCK_CACHE_SIZE 8192u
#define HIL_REGION_COUNT     7

/* A range of addresses for accesses through the bus. */
struct hil_region {
    struct hil_core *core;
    uint32_t base;
};

/* Interface state between the core and Unicorn. It is not part of a snapshot, because its members
 * can be recomputed or are used only until the next call of Unicorn. */
struct hil_cpu_engine {
    struct hil_translator translator;
    struct hil_whatif *whatif; /* NULL: not needed yet */
    /* 0: off; 1: Unicorn is about to execute a single instruction; 2: it is executing it */
    unsigned single_step_state;
    /* Results of the core's hooks for the main loop. */
    int return_reason;
    uint32_t return_interrupt;
    uint32_t bad_address, bad_size;
    /* instruction that made the access that Unicorn rejected */
    struct hil_instruction bad_instruction;
    bool has_left_block; /* the run was stopped by an access, and the core is at that instruction */
    /* number of bytes of an unaligned store to flash that Unicorn will still report one by one */
    unsigned split_store_bytes_left;
    bool is_rom_at_zero;              /* present mapping of the core's address space */
    bool are_flash_reads_intercepted; /* reads of flash by the core call a hook */
    bool is_checking_loads;           /* loads are checked for stuck cells (cpu.h) */
    struct hil_block_info blocks[HIL_BLOCK_CACHE_SIZE];
    struct hil_region regions[HIL_REGION_COUNT];
};

/* ---- failures that abort the program ---- */

/* Checks a call of Unicorn that must not fail; aborts otherwise. */

static inline void uc_check(uc_err err, const char *what)
{
    if (err == UC_ERR_OK)
        return;
    fprintf(stderr, "matrig-board: the CPU emulator failed at %s: %s\n", what, uc_strerror(err));
    abort();
}

/* Allocates zeroed memory; aborts on failure. */
static inline void *hil_allocate(size_t size)
{
    void *bytes = calloc(1, size);
    if (!bytes)
        abort();
    return bytes;
}

#define HIL_PARTS_PER_CYCLE 256u

/* A requested reset of the chip that has not been executed yet. */
struct hil_reset {
    bool is_requested;
    bool has_lost_power; /* the reset ends a period without supply */
    uint32_t csr_flags;  /* flags for RCC_CSR */
    uint64_t end_ps;     /* time at which the reset ends */
};

struct hil_core {
    struct hil_core_state state;
    struct hil_memory *memory; /* page-aligned; the core runs directly on this memory */
    struct uc_struct *uc;
    FILE *trace;               /* NULL, or the file for exceptions and unusual events */
    bool is_alignment_checked; /* hil_options.is_alignment_checked */
    /* length of an instruction in 1/HIL_PARTS_PER_CYCLE cycles, from hil_options.cpi */
    uint32_t instruction_cycle_parts;

    /* The members from here to `failure_reason` are used only during a run. */
    /* the block hook returns to the main loop at the first block that begins at or after this
     * cycle; not later than the next event */
    uint64_t next_check_cycle;
    bool has_reached_target;
    struct hil_reset reset;
    bool is_stopped;
    enum mr_status stop_status;
    char failure_reason[512];

    struct hil_bus bus;
    struct hil_event_handler event_handler[HIL_EVENT_COUNT];
    struct hil_bank_calls bank_calls;
    bool has_no_ccm;
    struct hil_observers observers;
    struct hil_cpu_engine engine;
};

/* Returns the physical time of a cycle, rounded down; the second function returns the first cycle
 * at or after a physical time. */
uint64_t hil_clock_ps_at_cycle(const struct hil_clock *clock, uint64_t cycle);
uint64_t hil_clock_cycle_at_ps(const struct hil_clock *clock, uint64_t t_ps);
/* Starts a clock with the given HCLK. */
void hil_clock_start(struct hil_clock *clock, uint32_t hclk_hz);
/* Changes HCLK to hclk_hz at the present cycle. Parts that wait for a physical time must also be
 * notified; use hil_core_set_hclk for both. */
void hil_clock_set_hclk(struct hil_clock *clock, uint32_t hclk_hz);

/* Stops the run with a message. Only the first stop counts. */
__attribute__((format(printf, 3, 4))) void hil_core_stop(struct hil_core *core,
                                                         enum mr_status status, const char *format,
                                                         ...);
/* Resets the chip as soon as possible; `flags` are added to RCC_CSR. */
void hil_core_request_reset(struct hil_core *core, uint32_t flags);
/* Makes the core check for events at the next basic block. Any part may call it. */
static inline void hil_core_request_check(struct hil_core *core)
{
    core->next_check_cycle = 0;
}

/* Writes one line to the trace, if there is one. */
__attribute__((format(printf, 2, 3))) void hil_core_trace_line(struct hil_core *core,
                                                               const char *format, ...);
#define hil_trace(core, ...)                          \
    do {                                              \
        if ((core)->trace)                            \
            hil_core_trace_line((core), __VA_ARGS__); \
    } while (0)

static inline uint64_t hil_now_cycle(const struct hil_core *core)
{
    return core->state.clock.now_cycle;
}
static inline uint64_t hil_now_ps(const struct hil_core *core)
{
    return hil_clock_ps_at_cycle(&core->state.clock, core->state.clock.now_cycle);
}

/* Host address of n bytes in flash, SRAM or CCM; NULL: the bytes are not within one of these
 * memories. */
static inline uint8_t *hil_memory_host_address(struct hil_memory *memory, uint32_t address,
                                               uint32_t n)
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

/* Host address of n bytes of the chip's memory. NULL: the bytes are not within one memory, or
 * `write` is set and they are in flash or ROM. */
static inline uint8_t *hil_memory_at(const struct hil_core *core, uint32_t address, uint32_t n,
                                     bool write)
{
    uint8_t *place = hil_memory_host_address(core->memory, address, n);
    if (place)
        return write && address - HIL_FLASH_BASE < HIL_FLASH_SIZE ? NULL : place;
    if (write)
        return NULL;
    if (address - HIL_ROM_BASE < HIL_ROM_SIZE && n <= HIL_ROM_SIZE - (address - HIL_ROM_BASE))
        return (uint8_t *)(uintptr_t)hil_bootrom_image + (address - HIL_ROM_BASE);
    if (core->state.bank.is_boot_rom_mapped) {
        if (address < HIL_ROM_SIZE && n <= HIL_ROM_SIZE - address)
            return (uint8_t *)(uintptr_t)hil_bootrom_image + address;
    } else if (address < HIL_FLASH_SIZE && n <= HIL_FLASH_SIZE - address) {
        return core->memory->flash + address;
    }
    return NULL;
}

/* True if this address cannot be read before the flash operation in progress ends. */
static inline bool hil_memory_is_stalled(const struct hil_core *core, uint32_t address)
{
    const struct hil_bank *bank = &core->state.bank;
    return bank->is_busy && (address - HIL_FLASH_BASE < HIL_FLASH_SIZE ||
                             (address < HIL_FLASH_SIZE && !bank->is_boot_rom_mapped));
}

/* Reads bytes of flash, SRAM, CCM or ROM. MR_UNKNOWN: the range is not within one memory. */
enum mr_status hil_memory_peek(const struct hil_core *core, uint32_t address, void *out, size_t n);

/* Value of a register: 0..12, 13 the current SP, 14 LR, 15 PC, 16 xPSR, 17 PRIMASK. */
#define HIL_REGISTER_PRIMASK 17u
uint32_t hil_cpu_register(const struct hil_core *core, unsigned number);

/* The registers and bits that the emulated board models are in one table (registers.def). The bus
 * checks accesses against it, a reset uses its values, and a test checks every register of every
 * peripheral against it.
 *
 * A write that changes a reserved bit, a bit that is not modelled or a read-only register stops the
 * run with a message. Hardware ignores such writes, but a program that makes them is wrong or
 * relies on a function that is not modelled. */

struct hil_register {
    uint16_t offset; /* offset of the first register */
    uint8_t count;   /* number of such registers in a row, at distance `stride` */
    uint8_t stride;  /* distance between these registers in bytes */
    char access;     /* 'b' both, 'r' read-only, 'w' write-only */
    /* writes may contain any value in reserved bits: in registers whose flags are cleared by
     * writing 0, and for keys */
    bool allows_reserved;
    const char *name;
    uint32_t reset;
    uint32_t plain_bits;  /* bits that read back as written */
    uint32_t action_bits; /* bits that start an action or clear a flag when written */
    uint32_t status;      /* bits that hardware sets; written values are ignored */
    /* bits that are modelled only for some values or states; see `explanation` */
    uint32_t conditional_bits;
    uint32_t unmodelled_bits; /* bits that exist in hardware but are not modelled */
    const char *explanation;  /* explanation of `conditional_bits` and `unmodelled_bits` */
};

struct hil_register_set {
    const char *peripheral;
    uint32_t base;
    const struct hil_register *registers; /* an entry without a name ends the list */
};

/* Table of a peripheral by its base address; NULL: none. */
const struct hil_register_set *hil_registers_by_base(uint32_t base);
const struct hil_register_set *hil_registers_all(size_t *count);
/* Register of a set at an offset; NULL: not modelled. */
const struct hil_register *hil_register_at(const struct hil_register_set *set, uint32_t offset);
/* Reason why this write is refused, as text in static storage; NULL: the write is allowed. */
const char *hil_register_refusal(const struct hil_register *r, uint32_t value);
/* Sets `count` words from `offset` on to the reset values of their registers; 0 where there is no
 * register. */
void hil_registers_reset(uint32_t base, uint32_t offset, uint32_t *word, size_t count);

/* Functions about the bus access in progress: the instruction of the running block that makes it,
 * its time, and how to refuse it.
 *
 * All other parts of the emulator use the time at the start of a basic block. The time of an access
 * is that of its instruction: the start of the block plus one cycle (hil_options.cpi) for every
 * instruction before it. On hardware an instruction takes one cycle or more (an IT instruction or a
 * NOP can take none), so the time between two accesses is a lower bound of the real time. */

/* True if the multiple, double or exclusive transfer at `pc` must fault because of its address,
 * with the present registers. Only for transfers with a general base register. */
bool hil_is_transfer_unaligned(const struct hil_core *core, uint32_t pc);
/* True if the condition code is met with these flags. */
bool hil_is_condition_met(uint32_t xpsr, unsigned condition);
/* Number of instructions that begin at or after `from` and before `to`. */
unsigned hil_count_instructions(const struct hil_core *core, uint32_t from, uint32_t to);

/* PC of the instruction that makes the bus access in progress. For accesses from outside the core:
 * the present PC. */
uint32_t hil_access_pc(const struct hil_core *core);

/* Time and PC of the access in progress, for the peripheral that is being read or written. Zero if
 * the access is not made by an instruction of the firmware but by a debugger, DMA or the boot
 * ROM. */
struct hil_timestamp hil_access_timestamp(const struct hil_core *core);
/* Returns the time stamp of an event in hardware at a cycle; its PC is 0. */
struct hil_timestamp hil_timestamp_at_cycle(const struct hil_core *core, uint64_t cycle);

/* Refusals: functions that stop the run because an access is not modelled. */

/* Stops the run because the firmware uses a function that the emulated peripheral lacks; `what`
 * describes it: "TIM4: centre-aligned mode". Returns 0, which a read can return. */
uint32_t hil_bus_refuse(struct hil_core *core, const char *what);
/* As hil_bus_refuse, for a register that is not modelled. */
uint32_t hil_bus_refuse_register(struct hil_core *core);
/* Stops the run at the access in progress. The message consists of `reason`, the access, and
 * `detail` (may be NULL). */
void hil_bus_stop(struct hil_core *core, const char *reason, const char *detail);

/* Event queue: one fixed slot per source, so that the queue consists of a few words without
 * pointers.
 *
 * A slot holds either an HCLK cycle (for peripherals, which count clocks at any rate) or a physical
 * time in picoseconds (for the rig, oscillators and the watchdog's clock), which is converted again
 * when HCLK changes. */

/* Initialises the core with an empty queue and no peripherals on the bus. */
void hil_core_create(struct hil_core *core);
void hil_event_connect(struct hil_core *core, enum hil_event_slot slot,
                       void (*handler)(void *device, uint64_t at), void *device);
/* Set, move or (with HIL_NEVER) clear a slot. A time in the past is due at once. */
void hil_event_set_cycle(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle);
void hil_event_set_ps(struct hil_core *core, enum hil_event_slot slot, uint64_t t_ps);
/* Handles all events due up to the present cycle, in order of time. */
void hil_event_handle_due(struct hil_core *core);

/* Changes HCLK to hclk_hz now. */
void hil_core_set_hclk(struct hil_core *core, uint32_t hclk_hz);
/* Used while there is no clock: advances physical time to the next event that has a physical time;
 * the cycle count does not change. */
void hil_core_skip_to_event(struct hil_core *core);

#endif
