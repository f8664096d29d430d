/* The state of the processor, part by part; what the parts do is in their own headers. No pointers:
 * a copy is a snapshot. */
#ifndef MATRIG_HIL_STATE_H
#define MATRIG_HIL_STATE_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/clock.h"
#include "hil/core/counters.h"
#include "hil/core/memory.h"
#include "hil/core/peripheral.h"

/* --- events: hil/core/event.h --- */

/* Order is the order of treatment when several are due at the same cycle. */
enum hil_event_slot {
    HIL_EVENT_HSE,
    HIL_EVENT_PLL,
    HIL_EVENT_LSI,
    HIL_EVENT_POWER, /* the supply is back */
    HIL_EVENT_FAULT, /* before what happens at the same time */
    HIL_EVENT_LATE,
    HIL_EVENT_FLASH_CUT, /* before the end of what it cuts */
    HIL_EVENT_FLASH,
    HIL_EVENT_NOR_CUT,
    HIL_EVENT_NOR,
    HIL_EVENT_RIG,
    HIL_EVENT_CAMERA,
    HIL_EVENT_SCRIPT,
    HIL_EVENT_REPLAY,
    HIL_EVENT_ADC1, /* before the timers: a scan that ends when the next trigger comes has ended */
    HIL_EVENT_ADC3,
    HIL_EVENT_TIM4, /* before TIM2, which it triggers */
    HIL_EVENT_TIM2,
    HIL_EVENT_SPI,
    HIL_EVENT_I2C,
    HIL_EVENT_DMA_MEMORY,
    HIL_EVENT_CAN,
    HIL_EVENT_CAN_OTHER, /* the other node has waited */
    HIL_EVENT_USART_TX,
    HIL_EVENT_USART_RX,
    HIL_EVENT_SYSTICK,
    HIL_EVENT_IWDG,
    HIL_EVENT_TARGET, /* end of the current run_until: last */
    HIL_EVENT_COUNT
};

struct hil_events {
    uint64_t at_cycle[HIL_EVENT_COUNT];
    uint64_t at_ps[HIL_EVENT_COUNT]; /* HIL_NEVER: the slot is in cycles */
    uint64_t next_cycle;             /* earliest of at_cycle */
    unsigned next_slot;              /* the first of the slots that are due then */
};

/* --- exceptions: hil/core/nvic.h, scb.h, systick.h --- */

#define HIL_INTERRUPTS      82u /* STM32F40x */
#define HIL_EXCEPTIONS      (16u + HIL_INTERRUPTS)
#define HIL_EXCEPTION_WORDS ((HIL_EXCEPTIONS + 31u) / 32u)

struct hil_nvic {
    uint32_t enabled[HIL_EXCEPTION_WORDS];
    uint32_t pending[HIL_EXCEPTION_WORDS];
    uint32_t active[HIL_EXCEPTION_WORDS];
    uint32_t line[HIL_EXCEPTION_WORDS]; /* level a peripheral holds */
    int16_t priority[HIL_EXCEPTIONS];   /* -3..-1 fixed, else 0..240 in steps of 16 */
    uint16_t best;                      /* pending exception of highest priority, 0: none */
    int16_t best_group;                 /* its group priority */
    int16_t active_group;               /* group priority of what runs; 256: thread */
    uint8_t prigroup;                   /* AIRCR.PRIGROUP */
};

struct hil_scb {
    /* 0xE000ED00 to 0xE000EF47 */
    HIL_WORDS(word, cpuid, icsr, vtor, aircr, scr, ccr, shpr[3], shcsr, cfsr, hfsr, dfsr, mmfar,
              bfar, afsr, ids[18], cpacr, mpu[25], dhcsr, dcrsr, dcrdr, demcr, at_e00[64], stir,
              at_f04[12], fpccr, fpcar, fpdscr, mvfr[2]);
    /* CYCCNT = cycles + offset while enabled, offset alone while not */
    uint32_t dwt_ctrl, dwt_offset;
    HIL_WORDS(dbgmcu, idcode, cr, apb1_fz, apb2_fz); /* from 0xE0042000 on */
};

struct hil_systick {
    uint32_t ctrl; /* ENABLE, TICKINT, CLKSOURCE, COUNTFLAG (bit 16) */
    uint32_t load;
    uint32_t value;      /* while stopped */
    uint64_t zero_cycle; /* while running: when the counter next becomes 0 */
};

/* --- the core itself --- */

struct hil_cpu {
    uint32_t block_instructions; /* of the block that runs, not yet counted into time */
    uint32_t block_address;
    uint32_t block_size;
    bool walking; /* it is walked through: hil/core/core.h */
    bool asleep;
    bool event; /* the event register that WFE waits for */
};

#define HIL_STUCK_MAX 8u

struct hil_stuck {
    uint32_t count;
    struct {
        uint32_t address; /* of its byte */
        uint8_t mask;
        bool level;
    } bit[HIL_STUCK_MAX];
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
    struct hil_stuck stuck;
};

#endif
