#include "hil/core/event.h"

#include "hil/board/machine.h"
#include "hil/debug/vcd.h"

typedef void (*event_handler)(struct hil_board *board, uint64_t at);

static void target_event(struct hil_board *board, uint64_t at)
{
    (void)at;
    board->target_reached = true;
}

static const event_handler handlers[HIL_EVENT_COUNT] = {
    [HIL_EVENT_HSE] = hil_rcc_hse_event,
    [HIL_EVENT_PLL] = hil_rcc_pll_event,
    [HIL_EVENT_LSI] = hil_rcc_lsi_event,
    [HIL_EVENT_POWER] = hil_board_power_event,
    [HIL_EVENT_FAULT] = hil_faults_event,
    [HIL_EVENT_LATE] = hil_faults_late_event,
    [HIL_EVENT_FLASH_CUT] = hil_flash_cut_event,
    [HIL_EVENT_FLASH] = hil_flash_event,
    [HIL_EVENT_NOR_CUT] = hil_w25q_cut_event,
    [HIL_EVENT_NOR] = hil_w25q_event,
    [HIL_EVENT_RIG] = hil_rig_event,
    [HIL_EVENT_CAMERA] = hil_camera_event,
    [HIL_EVENT_SCRIPT] = hil_script_event,
    [HIL_EVENT_REPLAY] = hil_replay_event,
    [HIL_EVENT_ADC1] = hil_adc1_event,
    [HIL_EVENT_ADC3] = hil_adc3_event,
    [HIL_EVENT_TIM4] = hil_tim4_event,
    [HIL_EVENT_TIM2] = hil_tim2_event,
    [HIL_EVENT_SPI] = hil_spi_event,
    [HIL_EVENT_I2C] = hil_i2c_event,
    [HIL_EVENT_DMA_MEMORY] = hil_dma_memory_event,
    [HIL_EVENT_CAN] = hil_can_event,
    [HIL_EVENT_CAN_OTHER] = hil_can_other_event,
    [HIL_EVENT_USART_TX] = hil_usart_tx_event,
    [HIL_EVENT_USART_RX] = hil_usart_rx_event,
    [HIL_EVENT_SYSTICK] = hil_systick_event,
    [HIL_EVENT_IWDG] = hil_iwdg_event,
    [HIL_EVENT_TARGET] = target_event,
};

void hil_event_init(struct hil_events *events)
{
    for (unsigned i = 0; i < HIL_EVENT_COUNT; i++) {
        events->at_cycle[i] = HIL_NEVER;
        events->at_ps[i] = HIL_NEVER;
    }
    events->next_cycle = HIL_NEVER;
}

/* Least of the times with their slots below them, so that of those at the same time the first slot wins; in chains that do not wait
 * for one another. */
#define SLOT_BITS 5u
#define CHAINS 4u
_Static_assert(HIL_EVENT_COUNT % CHAINS == 0 && HIL_EVENT_COUNT <= 1u << SLOT_BITS, "slots in whole steps");

static void find_next(struct hil_board *board)
{
    struct hil_events *events = &board->state.events;
    uint64_t least[CHAINS] = {HIL_NEVER, HIL_NEVER, HIL_NEVER, HIL_NEVER};
#pragma GCC unroll 28
    for (unsigned i = 0; i < HIL_EVENT_COUNT; i++) {
        uint64_t key = events->at_cycle[i] << SLOT_BITS | i; /* cycles of a hundred years take 59 bits */
        least[i % CHAINS] = key < least[i % CHAINS] ? key : least[i % CHAINS];
    }
    least[0] = least[1] < least[0] ? least[1] : least[0];
    least[2] = least[3] < least[2] ? least[3] : least[2];
    unsigned slot = (unsigned)((least[2] < least[0] ? least[2] : least[0]) & ((1u << SLOT_BITS) - 1u));
    uint64_t next = events->at_cycle[slot];
    events->next_cycle = next;
    events->next_slot = slot;
    if (next < board->limit_cycle)
        board->limit_cycle = next;
}

static void set(struct hil_board *board, enum hil_event_slot slot, uint64_t cycle, uint64_t t_ps)
{
    struct hil_events *events = &board->state.events;
    uint64_t before = events->at_cycle[slot];
    events->at_cycle[slot] = cycle;
    events->at_ps[slot] = t_ps;
    if (before == events->next_cycle && cycle > before) { /* it may have been the earliest */
        find_next(board);
    } else if (cycle < events->next_cycle || (cycle == events->next_cycle && slot < events->next_slot)) {
        events->next_cycle = cycle;
        events->next_slot = slot;
    }
    if (events->next_cycle < board->limit_cycle)
        board->limit_cycle = events->next_cycle;
}

void hil_event_set_cycle(struct hil_board *board, enum hil_event_slot slot, uint64_t cycle)
{
    set(board, slot, cycle, HIL_NEVER);
}

void hil_event_set_ps(struct hil_board *board, enum hil_event_slot slot, uint64_t t_ps)
{
    set(board, slot, hil_clock_cycle(&board->state.clock, t_ps), t_ps);
}

void hil_event_rebase(struct hil_board *board)
{
    struct hil_events *events = &board->state.events;
    for (unsigned i = 0; i < HIL_EVENT_COUNT; i++) {
        if (events->at_ps[i] != HIL_NEVER)
            events->at_cycle[i] = hil_clock_cycle(&board->state.clock, events->at_ps[i]);
    }
    find_next(board);
}

void hil_event_run(struct hil_board *board)
{
    struct hil_events *events = &board->state.events;
    while (events->next_cycle <= board->state.clock.now_cycle && !board->target_reached) {
        unsigned slot = events->next_slot;
        uint64_t at = events->at_cycle[slot];
        events->at_cycle[slot] = HIL_NEVER;
        events->at_ps[slot] = HIL_NEVER;
        events->next_cycle = HIL_NEVER; /* until the handler has set what it sets */
        handlers[slot](board, at);
        if (board->vcd && slot != HIL_EVENT_TARGET) /* where a run is cut changes nothing, and shows nowhere */
            hil_vcd_sample(board, at);
        find_next(board);
    }
}
