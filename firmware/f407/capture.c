/* Switch edges and the camera's frame pulses: TIM2 captures each at 84 MHz, DMA1 stores the
 * capture. Edges: channel 1, stream 5. Pulses, on PB3: channel 2, stream 6. Edges shorter than 95
 * ns and pulses shorter than 3 us are noise: the input filter removes them, and delays the rest.
 * The one-shot of the edges is 17 us long; the camera's cable is not part of the board. The
 * camera's trigger is PE2. RM0090 18.3.5, table 42. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define EDGES              64u
#define FRAMES             32u /* 160 ms at 200 a second */
#define EDGE_STREAM        5u
#define FRAME_STREAM       6u
#define EDGE_FILTER_TICKS  8u
#define FRAME_FILTER_TICKS 256u
/* Ticks can be compared within 25 s. Captures are taken with the next block; without blocks the
 * scans are restarted each second. */
#define OLD_TICKS          (10u * 84000000u)
#define TOO_OLD            1u /* details of the fault */
#define PULSES             2u

static volatile uint32_t edge_tick[EDGES] DMA_BUFFER, frame_tick[FRAMES] DMA_BUFFER;
static unsigned edge_taken, frame_taken; /* index of the oldest capture not yet taken */

static void start_stream(unsigned number, unsigned channel, volatile uint32_t *ticks, uint32_t size,
                         uint32_t priority)
{
    struct dma_stream_regs *stream = &DMA1->stream[number];
    stream->PAR = (uint32_t)(uintptr_t)&TIM2->CCR[channel];
    stream->M0AR = (uint32_t)(uintptr_t)ticks;
    stream->NDTR = size;
    dma_stream_start(stream, DMA_CR_CHANNEL(3) | priority | DMA_CR_MSIZE_32 | DMA_CR_PSIZE_32 |
                                 DMA_CR_MINC | DMA_CR_CIRC);
}

void capture_start(void)
{
    TIM2->ARR = 0xffffffffu;
    start_stream(EDGE_STREAM, 0, edge_tick, EDGES, DMA_CR_PRIORITY(2));
    TIM2->PSC = 0;
    TIM2->EGR = TIM_EGR_UG;
    TIM2->CNT = 0;
    TIM2->CCMR1 = TIM_CCMR1_CC1_TI1 | TIM_CCMR1_IC1F_8;
    TIM2->CCER = 1u; /* rising edges */
    TIM2->DIER = TIM_DIER_CC1DE;
    TIM2->SMCR = TIM_SMCR_TS_ITR3 | TIM_SMCR_SMS_TRIGGER; /* TIM4's start starts it */
}

/* Takes captures up to a tick, oldest first, with the filter delay subtracted. */
static size_t take(unsigned stream, const volatile uint32_t *captured, unsigned size,
                   unsigned *taken, uint32_t until_tick, uint32_t delay, uint32_t *ticks,
                   size_t capacity)
{
    size_t count = 0;
    unsigned head = (size - DMA1->stream[stream].NDTR) % size;
    while (*taken != head && count < capacity &&
           (int32_t)(captured[*taken] - delay - until_tick) <= 0) {
        ticks[count++] = captured[*taken] - delay;
        *taken = (*taken + 1) % size;
    }
    return count;
}

/* Drops captures that are too old to order: an old one would look like a future one and block all
 * after it. */
static void drop_old(unsigned stream, const volatile uint32_t *captured, unsigned size,
                     unsigned *taken, uint8_t detail)
{
    unsigned head = (size - DMA1->stream[stream].NDTR) % size;
    while (*taken != head && TIM2->CNT - captured[*taken] > OLD_TICKS) {
        *taken = (*taken + 1) % size;
        health_count(MR_FAULT_EDGE_OVERRUN, detail);
    }
}

void capture_drop_old(void)
{
    drop_old(EDGE_STREAM, edge_tick, EDGES, &edge_taken, TOO_OLD);
    if (TIM2->DIER & TIM_DIER_CC2DE)
        drop_old(FRAME_STREAM, frame_tick, FRAMES, &frame_taken, PULSES);
}

size_t board_edges_take(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    if (TIM2->SR & TIM_SR_CC1OF) {
        TIM2->SR = ~TIM_SR_CC1OF;
        health_count(MR_FAULT_EDGE_OVERRUN, 0);
    }
    return take(EDGE_STREAM, edge_tick, EDGES, &edge_taken, until_tick, EDGE_FILTER_TICKS, ticks,
                capacity);
}

void board_frames_capture(bool on)
{
    TIM2->DIER &= ~TIM_DIER_CC2DE;
    TIM2->CCER &= ~TIM_CCER_CC2E;
    dma_stream_stop(DMA1, FRAME_STREAM);
    frame_taken = 0;
    if (!on)
        return;
    start_stream(FRAME_STREAM, 1, frame_tick, FRAMES, DMA_CR_PRIORITY(1));
    TIM2->CCMR1 = (TIM2->CCMR1 & 0xffu) | TIM_CCMR1_CC2_TI2 | TIM_CCMR1_IC2F_256;
    (void)TIM2->CCR[1]; /* discards an old capture */
    TIM2->DIER |= TIM_DIER_CC2DE;
    TIM2->CCER |= TIM_CCER_CC2E; /* rising edges */
}

size_t board_frames_take(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    if (TIM2->SR & TIM_SR_CC2OF) {
        TIM2->SR = ~TIM_SR_CC2OF;
        health_count(MR_FAULT_EDGE_OVERRUN, PULSES);
    }
    return take(FRAME_STREAM, frame_tick, FRAMES, &frame_taken, until_tick, FRAME_FILTER_TICKS,
                ticks, capacity);
}

uint32_t board_camera(bool high)
{
    pin_write(PIN_CAMERA_TRIGGER, high);
    return TIM2->CNT;
}
