/* Inside of the emulated board: all state in one struct without pointers, and what the parts call of each
 * other.
 *
 * `struct hil_state` plus the memories plus the core's registers are the whole machine: a snapshot is a
 * copy of them. What a board is connected to (callbacks, rig, trace) is in `struct hil_board` and not part
 * of a snapshot. */
#ifndef MATRIG_HIL_MACHINE_H
#define MATRIG_HIL_MACHINE_H

#include "hil/periph/adc.h"
#include "hil/board/board.h"
#include "hil/core/bootrom.h"
#include "hil/core/bus.h"
#include "hil/rig/camera.h"
#include "hil/periph/can.h"
#include "hil/core/clock.h"
#include "hil/rig/codes.h"
#include "hil/core/cpu.h"
#include "hil/periph/dma.h"
#include "hil/core/event.h"
#include "hil/core/exception.h"
#include "hil/rig/faults.h"
#include "hil/periph/flash.h"
#include "hil/periph/gpio.h"
#include "hil/periph/i2c.h"
#include "hil/periph/iwdg.h"
#include "hil/core/nvic.h"
#include "hil/debug/pin_times.h"
#include "hil/periph/rcc.h"
#include "hil/core/registers.h"
#include "hil/rig/replay.h"
#include "hil/rig/rig.h"
#include "hil/core/scb.h"
#include "hil/rig/script.h"
#include "hil/periph/spi.h"
#include "hil/core/stuck.h"
#include "hil/core/systick.h"
#include "hil/periph/tim.h"
#include "hil/chips/tmp112.h"
#include "hil/periph/usart.h"
#include "hil/chips/w25q.h"

#define HIL_FLASH_BASE 0x08000000u
#define HIL_FLASH_SIZE 0x00100000u
#define HIL_SRAM_BASE 0x20000000u /* SRAM1 112 KiB and SRAM2 16 KiB, contiguous */
#define HIL_SRAM_SIZE 0x00020000u
#define HIL_CCM_BASE 0x10000000u
#define HIL_CCM_SIZE 0x00010000u
#define HIL_REGIONS 7
#define HIL_PERIPHERALS_MAX 64u
#define HIL_REGISTER_WORDS 256u /* a kilobyte */

struct hil_memory {
    uint8_t flash[HIL_FLASH_SIZE];
    uint8_t sram[HIL_SRAM_SIZE];
    uint8_t ccm[HIL_CCM_SIZE];
    uint8_t nor[HIL_NOR_SIZE]; /* inverted, see hil/chips/w25q.c; last, and mostly never touched */
};

struct hil_state {
    struct hil_clock clock;
    struct hil_events events;
    struct hil_counters counters;
    struct hil_cpu cpu;
    struct hil_nvic nvic;
    struct hil_scb scb;
    struct hil_systick systick;
    struct hil_rcc rcc;
    struct hil_flash flash;
    struct hil_gpio gpio;
    struct hil_tim tim[HIL_TIMERS];
    struct hil_dma dma[2];
    struct hil_adc adc[2];
    uint32_t adc_ccr;
    struct hil_usart usart;
    struct hil_spi spi;
    struct hil_w25q w25q;
    struct hil_i2c i2c;
    struct hil_tmp112 tmp112;
    struct hil_can can;
    struct hil_iwdg iwdg;
    struct hil_rig rig;
    struct hil_camera camera;
    struct hil_script script;
    struct hil_replay_state replay;
    struct hil_faults faults;
    struct hil_nor_faults nor_faults;
    struct hil_stuck stuck;
    bool held_in_reset; /* no supply, or too little */
};

struct hil_region {
    struct hil_board *board;
    uint32_t base;
};

struct uc_struct;
struct hil_debug;
struct hil_vcd;
struct hil_profile;

struct hil_board {
    struct hil_state state;
    struct hil_memory *memory; /* page-aligned: the core runs directly on it */
    struct uc_struct *uc;
    struct hil_options options;
    struct hil_callbacks callbacks, pin_callbacks;
    const struct hil_run *run; /* may be NULL */
    const struct hil_replay *replay; /* instead of a run; may be NULL */

    /* Of the present run_until; nothing of it outlives the call. */
    uint64_t limit_cycle;      /* the block hook looks up from here on; at most the next event */
    bool target_reached;
    bool reset_request;
    bool power_lost;           /* the reset requested is the return of the supply */
    uint64_t hold_ps;          /* and lasts until then */
    uint32_t reset_flags;      /* RCC_CSR flags of the reset requested */
    bool stopped;
    enum mr_status stop_status;
    char reason[256];

    struct hil_debug *debug;   /* hil/debug/debug.h; NULL: no debugger */
    struct hil_vcd *vcd;       /* hil/debug/vcd.h; NULL: no trace */
    struct hil_profile *profile; /* hil/debug/profile.h; NULL: nobody counts */
    struct hil_pin_times *pin_times; /* hil/debug/pin_times.h; NULL: nobody watches */
    uint32_t profile_block;    /* number of the block that runs */
    unsigned single;           /* 1, then 2: Unicorn runs one instruction of a block that is walked through */

    struct hil_access access;
    struct hil_stores stores;

    /* What the core's hooks leave for the loop. */
    int came_back;
    uint32_t came_back_number;
    uint32_t bad_address, bad_size;
    int bad_type;

    bool runs_to_fp;           /* the core runs up to a floating-point instruction that will fault */
    unsigned split_bytes;      /* of an unaligned store to flash, still to come one by one */
    bool rom_at_zero;          /* as the core's address space is mapped now */
    bool flash_guarded;        /* reads of flash by the core are caught */
    bool looks_at_loads;       /* hil/core/stuck.h */

    /* Derived from code, run file and replay; rebuilt when needed. */
    struct hil_settling settling[HIL_SETTLINGS];
    const struct mr_block *codes_block; /* whose codes these are; NULL: of none */
    struct hil_codes codes;
    struct hil_block_info blocks[HIL_BLOCK_CACHE];
    struct hil_region regions[HIL_REGIONS];
    uint8_t peripheral_of[512]; /* index by kilobyte from 0x40000000 */
    const struct hil_register_set *registers_of[HIL_PERIPHERALS_MAX]; /* NULL: without a table */
    const struct hil_register *register_at[HIL_PERIPHERALS_MAX][HIL_REGISTER_WORDS]; /* by word of a peripheral; NULL: not yet looked for, or none */
};

/* Stop the run, with a message. The first stop wins. */
__attribute__((format(printf, 3, 4))) void hil_board_stop(struct hil_board *board, enum mr_status status,
                                                           const char *format, ...);
/* One line to the trace, if there is one. */
__attribute__((format(printf, 2, 3))) void hil_trace_line(struct hil_board *board, const char *format, ...);
#define hil_trace(board, ...)                       \
    do {                                            \
        if ((board)->options.trace)                 \
            hil_trace_line((board), __VA_ARGS__);   \
    } while (0)

/* Power on with the memories as they are. MR_OK, or why the firmware cannot start. */
enum mr_status hil_board_restart(struct hil_board *board);
/* Reset the chip at the next chance; `flags` are added to RCC_CSR. */
void hil_board_request_reset(struct hil_board *board, uint32_t flags);

void hil_board_power_event(struct hil_board *board, uint64_t at);

/* Host address of n bytes of the board's memory, or NULL when they are not in one memory (or would write
 * flash). */
static inline uint8_t *hil_board_memory(const struct hil_board *board, uint32_t address, uint32_t n,
                                        bool write)
{
    struct hil_memory *memory = board->memory;
    if (address - HIL_SRAM_BASE < HIL_SRAM_SIZE && n <= HIL_SRAM_SIZE - (address - HIL_SRAM_BASE))
        return memory->sram + (address - HIL_SRAM_BASE);
    if (address - HIL_CCM_BASE < HIL_CCM_SIZE && n <= HIL_CCM_SIZE - (address - HIL_CCM_BASE))
        return memory->ccm + (address - HIL_CCM_BASE);
    if (write)
        return NULL;
    if (address - HIL_FLASH_BASE < HIL_FLASH_SIZE && n <= HIL_FLASH_SIZE - (address - HIL_FLASH_BASE))
        return memory->flash + (address - HIL_FLASH_BASE);
    if (address - HIL_ROM_BASE < HIL_ROM_SIZE && n <= HIL_ROM_SIZE - (address - HIL_ROM_BASE))
        return (uint8_t *)(uintptr_t)hil_bootrom_image + (address - HIL_ROM_BASE);
    if (board->state.flash.boot_rom) {
        if (address < HIL_ROM_SIZE && n <= HIL_ROM_SIZE - address)
            return (uint8_t *)(uintptr_t)hil_bootrom_image + address;
    } else if (address < HIL_FLASH_SIZE && n <= HIL_FLASH_SIZE - address) {
        return memory->flash + address;
    }
    return NULL;
}

static inline uint64_t hil_now(const struct hil_board *board) { return board->state.clock.now_cycle; }

#endif
