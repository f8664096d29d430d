/* Event queue: one fixed slot per source, so that the whole queue is a few words without pointers.
 *
 * A slot holds either an HCLK cycle (peripherals: they count clocks, whatever the clock's rate is) or a
 * physical time in picoseconds (the rig, oscillators, the watchdog's own clock), which is converted again
 * whenever HCLK changes. */
#ifndef MATRIG_HIL_EVENT_H
#define MATRIG_HIL_EVENT_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;

#define HIL_NEVER UINT64_MAX

/* Order is the order of treatment when several are due at the same cycle. */
enum hil_event_slot {
    HIL_EVENT_HSE,
    HIL_EVENT_PLL,
    HIL_EVENT_LSI,
    HIL_EVENT_POWER,     /* the supply is back */
    HIL_EVENT_FAULT,     /* before what happens at the same time */
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

/* Who treats a slot: `at` is the moment it was set to. */
struct hil_event_wire {
    void (*handler)(void *device, uint64_t at);
    void *device;
};

/* An empty queue. */
void hil_event_create(struct hil_core *core);
void hil_event_wire(struct hil_core *core, enum hil_event_slot slot, void (*handler)(void *device, uint64_t at), void *device);
/* Set, move or (HIL_NEVER) clear a slot. A past moment is due at once. */
void hil_event_set_cycle(struct hil_core *core, enum hil_event_slot slot, uint64_t cycle);
void hil_event_set_ps(struct hil_core *core, enum hil_event_slot slot, uint64_t t_ps);
/* Convert the slots that are in picoseconds again, after a change of HCLK. */
void hil_event_rebase(struct hil_core *core);
/* Treat everything due up to the present cycle, in order of time. */
void hil_event_run(struct hil_core *core);

#endif
