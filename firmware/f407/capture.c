/* Switch edges: TIM2 channel 1 captures each at 84 MHz, DMA1 stream 5 stores it. RM0090 18.3.5,
 * table 42. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define CAPTURES 64u
#define STREAM   5u

static volatile uint32_t captured_tick[CAPTURES] DMA_BUFFER;
static unsigned taken; /* index of the oldest capture not taken */

bool capture_start(void)
{
    if (!answers(&TIM2->ARR, 0xffffffffu)) {
        health_count(MR_FAULT_TIMER_MISSING, 2);
        return false;
    }
    struct dma_stream_regs *stream = &DMA1->stream[STREAM];
    stream->PAR = (uint32_t)(uintptr_t)&TIM2->CCR[0];
    stream->M0AR = (uint32_t)(uintptr_t)captured_tick;
    stream->NDTR = CAPTURES;
    stream->CR = DMA_CR_CHANNEL(3) | DMA_CR_PRIORITY(2) | DMA_CR_MSIZE_32 | DMA_CR_PSIZE_32 |
                 DMA_CR_MINC | DMA_CR_CIRC | DMA_CR_EN;

    TIM2->PSC = 0;
    TIM2->EGR = TIM_EGR_UG;
    TIM2->CNT = 0;
    /* channel 1 captures TI1, every edge, no filter: the one-shot ahead of it is clean */
    TIM2->CCMR1 = 1u;
    TIM2->CCER = 1u; /* rising */
    TIM2->DIER = TIM_DIER_CC1DE;
    TIM2->SMCR = TIM_SMCR_TS_ITR3 | TIM_SMCR_SMS_TRIGGER; /* TIM4's start starts it */
    return true;
}

size_t board_edges_take(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    size_t count = 0;
    unsigned head = (CAPTURES - DMA1->stream[STREAM].NDTR) % CAPTURES;
    if (TIM2->SR & TIM_SR_CC1OF) {
        TIM2->SR = ~TIM_SR_CC1OF;
        health_count(MR_FAULT_EDGE_OVERRUN, 0);
    }
    while (taken != head && count < capacity && (int32_t)(captured_tick[taken] - until_tick) <= 0) {
        ticks[count++] = captured_tick[taken];
        taken = (taken + 1) % CAPTURES;
    }
    return count;
}
