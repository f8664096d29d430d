/* The camera: its trigger on PE2, its frame pulses on PB3, which TIM2 channel 2 captures at 84 MHz
 * and DMA1 stream 6 stores. RM0090 18.3.5, table 42. What is shorter than 3 us is noise: the input
 * filter passes it over, and delays what it passes. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define CAPTURES     32u /* at 200 a second 160 ms */
#define STREAM       6u
#define FILTER_TICKS 256u
#define STOP_POLLS   1000u

static volatile uint32_t captured_tick[CAPTURES] DMA_BUFFER;
static unsigned taken; /* index of the oldest capture not taken */

static void stop(struct dma_stream_regs *stream)
{
    TIM2->DIER &= ~TIM_DIER_CC2DE;
    TIM2->CCER &= ~TIM_CCER_CC2E;
    stream->CR = 0;
    for (unsigned polls = 0; (stream->CR & DMA_CR_EN) && polls < STOP_POLLS; polls++) {
    }
    DMA1->IFCR[STREAM / 4] = DMA_FLAGS_ALL << dma_flag_shift(STREAM);
}

void board_frames_capture(bool on)
{
    struct dma_stream_regs *stream = &DMA1->stream[STREAM];
    stop(stream);
    taken = 0;
    if (!on)
        return;
    stream->PAR = (uint32_t)(uintptr_t)&TIM2->CCR[1];
    stream->M0AR = (uint32_t)(uintptr_t)captured_tick;
    stream->NDTR = CAPTURES;
    stream->CR = DMA_CR_CHANNEL(3) | DMA_CR_PRIORITY(1) | DMA_CR_MSIZE_32 | DMA_CR_PSIZE_32 |
                 DMA_CR_MINC | DMA_CR_CIRC | DMA_CR_EN;
    TIM2->CCMR1 = (TIM2->CCMR1 & 0xffu) | TIM_CCMR1_CC2_TI2 | TIM_CCMR1_IC2F_256;
    (void)TIM2->CCR[1]; /* an old capture is none of these */
    TIM2->DIER |= TIM_DIER_CC2DE;
    TIM2->CCER |= TIM_CCER_CC2E; /* rising */
}

size_t board_frames_take(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    size_t count = 0;
    unsigned head = (CAPTURES - DMA1->stream[STREAM].NDTR) % CAPTURES;
    if (TIM2->SR & TIM_SR_CC2OF) {
        TIM2->SR = ~TIM_SR_CC2OF;
        health_count(MR_FAULT_EDGE_OVERRUN, 2);
    }
    while (taken != head && count < capacity &&
           (int32_t)(captured_tick[taken] - FILTER_TICKS - until_tick) <= 0) {
        ticks[count++] = captured_tick[taken] - FILTER_TICKS;
        taken = (taken + 1) % CAPTURES;
    }
    return count;
}

uint32_t board_camera(bool high)
{
    pin_write(PIN_CAMERA_TRIGGER, high);
    return TIM2->CNT;
}
