/* The state of the processor, part by part; the header of each part declares its functions. The
 * state contains no pointers: a copy is a snapshot. */
#ifndef MATRIG_HIL_STATE_H
#define MATRIG_HIL_STATE_H

#include <stdbool.h>
#include <stdint.h>

/* ---- call-backs ---- */

/* A call-back from one part to another: the receiver and its function. The sender does not know the
 * receiver, so a peripheral is independent of its board. */

struct hil_callback {
    void (*function)(void *context); /* NULL: not connected */
    void *context;
};

static inline void hil_callback_invoke(const struct hil_callback *wire)
{
    if (wire->function)
        wire->function(wire->context);
}

/* ---- registers by name and by offset ---- */

/* Registers of a peripheral by name and by offset: word[offset / 4] is the register named at that
 * position. Positions without a register, and registers without storage, need a name too; their
 * words stay 0. */

#define HIL_NAMED_WORDS(word, ...)                                    \
    union {                                                           \
        struct {                                                      \
            uint32_t __VA_ARGS__;                                     \
        };                                                            \
        uint32_t word[sizeof(struct { uint32_t __VA_ARGS__; }) / 4u]; \
    }

/* --- time: hil/core/core.h --- */

/* Units of physical time, in picoseconds. */
#define HIL_PS_PER_S  1000000000000ull
#define HIL_PS_PER_MS 1000000000ull
#define HIL_PS_PER_US 1000000ull
#define HIL_PS_PER_NS 1000ull
#define HIL_NEVER     UINT64_MAX /* a cycle or physical time that is never reached */

struct hil_clock {
    uint64_t now_cycle;    /* start of the running basic block */
    uint64_t anchor_cycle; /* cycle of the last change of HCLK */
    uint64_t anchor_ps;
    uint32_t hclk_hz;
    /* HCLK for which the ratio was computed: a cycle takes ratio_ps / ratio_cycles picoseconds
     * (reduced fraction) */
    uint32_t ratio_hclk_hz;
    uint64_t ratio_ps, ratio_cycles;
    bool is_stopped; /* there is no clock: the cycle count does not advance */
};

/* --- memories and their addresses (RM0090 2.3) --- */

#define HIL_FLASH_BASE 0x08000000u
#define HIL_FLASH_SIZE 0x00100000u
#define HIL_SRAM_BASE  0x20000000u /* SRAM1 112 KiB and SRAM2 16 KiB, contiguous */
#define HIL_SRAM_SIZE  0x00020000u
#define HIL_CCM_BASE   0x10000000u
#define HIL_CCM_SIZE   0x00010000u

struct hil_memory {
    uint8_t flash[HIL_FLASH_SIZE];
    uint8_t sram[HIL_SRAM_SIZE];
    uint8_t ccm[HIL_CCM_SIZE];
};

/* State of the flash bank that the core needs to know. The model of the flash interface updates
 * it. */
struct hil_bank {
    bool is_busy;    /* an operation is in progress, and the bank cannot be read until it ends */
    bool is_erasing; /* the operation is an erase of a sector, of the bank or of option bytes */
    bool is_boot_rom_mapped; /* address 0 is mapped to system memory instead of flash */
    /* Bit mask of sectors that were erased while the data cache may still contain their old
     * content. */
    uint16_t stale_sectors;
};

/* Calls of the flash interface. `load` is called for reads during an operation; it stalls the bus
 * until the operation has ended, so virtual time jumps. */
struct hil_bank_calls {
    void *context;
    /* stores 1, 2, 4 or 8 bytes */
    void (*store)(void *context, uint32_t address, unsigned size, uint64_t value);
    void (*load)(void *context, uint32_t address);
};

/* System memory: the program in hil/rom/bootrom.c, which implements AN3155 on USART1. */
#define HIL_ROM_BASE    0x1fff0000u
#define HIL_ROM_SIZE    0x00007000u
#define HIL_ROM_VERSION 0x31u /* version of the protocol, also at 0x1FFF77DE (AN2606) */

/* HIL_ROM_SIZE bytes, page-aligned. */
extern const uint8_t hil_bootrom_image[];

/* Counts since a board was created. They survive resets of the chip. */
struct hil_counters {
    uint64_t instructions;
    uint64_t asleep_cycles; /* HCLK cycles spent in WFI or WFE */
    uint64_t exceptions;    /* entered exceptions, including tail-chained ones */
    uint64_t tail_chains;
    uint64_t fault_exceptions; /* entries of MemManage, BusFault, UsageFault and HardFault */
    uint64_t resets;           /* all resets except power on */
    uint64_t watchdog_resets;
    uint64_t can_frames_out;
    uint64_t can_frames_in;
    uint64_t can_frames_filtered; /* received frames that no filter accepted */
    uint64_t can_errors;          /* frames that were destroyed or not acknowledged */
    /* number of times that the firmware filled a mailbox again before it cleared RQCP */
    uint64_t can_mailboxes_refilled;
    uint64_t can_frames_in_dropped; /* frames injected while the queue of the other node was full */
    uint64_t serial_bytes_out;
    uint64_t serial_bytes_in;
    /* bytes garbled because rate or parity differ from those of the other end */
    uint64_t serial_bytes_garbled;
    uint64_t serial_bytes_in_dropped; /* bytes injected while the queue was full */
    uint64_t adc_scans[2];            /* completed sequences of ADC1 and ADC3 */
    uint64_t adc_triggers_ignored;    /* triggers during a running sequence */
    uint64_t adc_overruns;
    uint64_t switches_opened;
    uint64_t edges_captured;       /* captures by TIM2 channel 1 */
    uint64_t film_frames_captured; /* captures by TIM2 channel 2 */
    uint64_t film_frames_sent;     /* pulses sent by the camera */
    /* time with PD12 high and PD13 low; equal to excitation_minus_ps if there is no direct
     * component */
    uint64_t excitation_plus_ps;
    uint64_t excitation_minus_ps;
    uint64_t faults_injected;    /* injected faults, as reported by hil/rig/faults.h */
    uint64_t flash_errors;       /* stores and operations that set an error flag, and wrong keys */
    uint64_t flash_stall_cycles; /* HCLK cycles for which the core waited for flash */
    uint64_t power_cuts;
    uint32_t last_fault_pc;
};

/* --- events: hil/core/core.h --- */

/* Events that are due at the same cycle are handled in this order. */
enum hil_event_slot {
    HIL_EVENT_HSE,
    HIL_EVENT_PLL,
    HIL_EVENT_LSI,
    HIL_EVENT_POWER, /* the supply has returned */
    HIL_EVENT_FAULT, /* handled before other events at the same cycle */
    HIL_EVENT_DELAYED_OUTPUT,
    HIL_EVENT_FLASH,
    HIL_EVENT_NOR,
    HIL_EVENT_RIG,
    HIL_EVENT_CAMERA,
    HIL_EVENT_SCRIPT,
    HIL_EVENT_REPLAY,
    HIL_EVENT_ADC1, /* before the timers, so that a scan ends before a trigger at the same cycle */
    HIL_EVENT_ADC3,
    HIL_EVENT_TIM4, /* before TIM2: TIM4 triggers TIM2 */
    HIL_EVENT_TIM2,
    HIL_EVENT_SPI,
    HIL_EVENT_I2C,
    HIL_EVENT_CAN,
    HIL_EVENT_CAN_OTHER_NODE, /* a fault no longer delays the frame of the other node */
    HIL_EVENT_USART_TX,
    HIL_EVENT_USART_RX,
    HIL_EVENT_SYSTICK,
    HIL_EVENT_IWDG,
    HIL_EVENT_RUN_END, /* end of the present run_until; must be the last slot */
    HIL_EVENT_COUNT
};
/* number of interleaved chains in the search for the next event; the number of slots is a multiple
 * of it */
#define HIL_EVENT_SEARCH_CHAINS 4u
#define HIL_EVENT_SLOTS                                                           \
    ((HIL_EVENT_COUNT + HIL_EVENT_SEARCH_CHAINS - 1u) / HIL_EVENT_SEARCH_CHAINS * \
     HIL_EVENT_SEARCH_CHAINS)

struct hil_events {
    uint64_t due_cycle[HIL_EVENT_SLOTS];
    uint64_t due_ps[HIL_EVENT_SLOTS]; /* HIL_NEVER: the slot is set in cycles */
    uint64_t next_cycle;              /* earliest time in due_cycle */
    unsigned next_slot;               /* first slot that is due at next_cycle */
};

/* --- exceptions: hil/core/nvic.h --- */

#define HIL_INTERRUPTS      82u /* STM32F40x */
#define HIL_EXCEPTIONS      (16u + HIL_INTERRUPTS)
#define HIL_EXCEPTION_WORDS ((HIL_EXCEPTIONS + 31u) / 32u)

struct hil_nvic {
    uint32_t enabled[HIL_EXCEPTION_WORDS];
    uint32_t pending[HIL_EXCEPTION_WORDS];
    uint32_t active[HIL_EXCEPTION_WORDS];
    uint32_t line_levels[HIL_EXCEPTION_WORDS]; /* levels of the interrupt lines */
    /* fixed priorities are -3..-1; others are 0..240 in steps of 16 */
    int16_t priority[HIL_EXCEPTIONS];
    uint16_t next_exception;       /* pending exception of the highest priority; 0: none */
    int16_t next_group_priority;   /* group priority of `next_exception` */
    int16_t active_group_priority; /* group priority of the running exception; 256: thread */
    uint8_t prigroup;              /* AIRCR.PRIGROUP */
};

struct hil_scb {
    /* 0xE000ED00 to 0xE000EF47 */
    HIL_NAMED_WORDS(word, cpuid, icsr, vtor, aircr, scr, ccr, shpr[3], shcsr, cfsr, hfsr, dfsr,
                    mmfar, bfar, afsr, ids[18], cpacr, mpu[25], dhcsr, dcrsr, dcrdr, demcr,
                    reserved_e00[64], stir, reserved_f04[12], fpccr, fpcar, fpdscr, mvfr[2]);
    /* CYCCNT is cycles + offset while enabled, otherwise offset */
    uint32_t dwt_ctrl, dwt_offset;
    HIL_NAMED_WORDS(dbgmcu, idcode, cr, apb1_fz, apb2_fz); /* from 0xE0042000 on */
};

struct hil_systick {
    uint32_t ctrl; /* bits ENABLE, TICKINT, CLKSOURCE, and COUNTFLAG (bit 16) */
    uint32_t load;
    uint32_t value;      /* value of the stopped counter */
    uint64_t zero_cycle; /* for the running counter: cycle at which it next becomes 0 */
};

/* --- the core itself --- */

struct hil_cpu {
    /* number of instructions of the running block that were executed but not yet added to
     * now_cycle */
    uint32_t block_instruction_count;
    uint32_t block_address;
    uint32_t block_size;
    /* part of a cycle that is not yet added to now_cycle, in 1/HIL_PARTS_PER_CYCLE cycles */
    uint32_t uncounted_cycle_parts;
    bool is_stepping; /* the block is executed instruction by instruction */
    bool is_asleep;
    bool is_event_register_set; /* the event register, for which WFE waits, is set */
};

#define HIL_STUCK_BITS_MAX 8u

struct hil_stuck_bits {
    uint32_t count;
    struct {
        uint32_t address; /* address of the byte */
        uint8_t mask;
        bool level;
    } bit[HIL_STUCK_BITS_MAX];
};

struct hil_core_state {
    struct hil_clock clock;
    struct hil_events events;
    struct hil_counters counters;
    struct hil_cpu cpu;
    struct hil_nvic nvic;
    struct hil_scb scb;
    struct hil_systick systick;
    struct hil_bank bank;
    struct hil_stuck_bits stuck_bits;
};

/* A time, and the instruction that caused an event at this time. */
struct hil_timestamp {
    uint64_t ps;    /* time since power on */
    uint32_t pc;    /* instruction that caused the event; 0: caused by hardware */
    double slew_ns; /* slew of the edge: time until its level is reached */
};

#endif
