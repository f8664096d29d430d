/* Switch edges and pulses from outside: TIM2 captures the time of each at 84 MHz, and DMA1 stores
 * it. Edges: channel 1, stream 5. Pulses: frames of the camera (PB3) on channel 2, the brake (PB10)
 * on channel 3, the wheel (PB11) on channel 4. Edges shorter than 95 ns and pulses shorter than 3
 * us are noise: the input filter removes them, and delays the rest. The one-shot of the edges is 17
 * us long; the cables of the pulses are not part of the board. The camera's trigger is PE2. RM0090
 * 18.3.5, table 42. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define EDGE_CAPTURES      64u
#define PULSE_CAPTURES     32u /* size of a pulse buffer: 160 ms of pulses at 200 per second */
#define EDGE_STREAM        5u
#define EDGE_FILTER_TICKS  8u
#define PULSE_FILTER_TICKS 256u
/* Ticks can be compared only within 25 s. Captures are processed with the next block; without
 * blocks, the scans are restarted each second. */
#define AGE_MAX_TICKS      (10u * 84000000u)
#define DETAIL_TOO_OLD     1u /* details of the fault */
#define DETAIL_PULSES      2u

static volatile uint32_t edge_tick[EDGE_CAPTURES] DMA_BUFFER,
    pulse_tick[BOARD_PULSE_INPUT_COUNT][PULSE_CAPTURES] DMA_BUFFER;
/* index of the oldest capture that has not been processed */
static unsigned next_edge_capture, next_pulse_capture[BOARD_PULSE_INPUT_COUNT];
static const uint8_t pulse_stream[BOARD_PULSE_INPUT_COUNT] = {
    [BOARD_FRAME_PULSES] = 6, [BOARD_BRAKE_PULSES] = 1, [BOARD_WHEEL_PULSES] = 7};

static uint32_t get_pulse_channel(enum board_pulse_input input)
{
    return 1u + input;
}

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
    start_stream(EDGE_STREAM, 0, edge_tick, EDGE_CAPTURES, DMA_CR_PRIORITY(2));
    TIM2->PSC = 0;
    TIM2->EGR = TIM_EGR_UG;
    TIM2->CNT = 0;
    TIM2->CCMR1 = TIM_CCMR1_CC1_TI1 | TIM_CCMR1_IC1F_8;
    TIM2->CCER = 1u; /* rising edges */
    TIM2->DIER = TIM_DIER_CC1DE;
    TIM2->SMCR = TIM_SMCR_TS_ITR3 | TIM_SMCR_SMS_TRIGGER; /* start TIM2 together with TIM4 */
}

/* Removes the captures up to a tick and returns them, oldest first, with the filter delay
 * subtracted. */
static size_t get_captures(unsigned stream, const volatile uint32_t *captured, unsigned size,
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

/* Drops captures that are too old to be ordered: an old capture would look like a future one and
 * would block all later ones. */
static void discard_old_captures(unsigned stream, const volatile uint32_t *captured, unsigned size,
                                 unsigned *taken, uint8_t detail)
{
    unsigned head = (size - DMA1->stream[stream].NDTR) % size;
    while (*taken != head && TIM2->CNT - captured[*taken] > AGE_MAX_TICKS) {
        *taken = (*taken + 1) % size;
        health_count_fault(MR_FAULT_EDGE_OVERRUN, detail);
    }
}

void capture_discard_old(void)
{
    discard_old_captures(EDGE_STREAM, edge_tick, EDGE_CAPTURES, &next_edge_capture, DETAIL_TOO_OLD);
    for (unsigned i = 0; i < BOARD_PULSE_INPUT_COUNT; i++) {
        if (TIM2->DIER & TIM_DIER_CC1DE << get_pulse_channel((enum board_pulse_input)i))
            discard_old_captures(pulse_stream[i], pulse_tick[i], PULSE_CAPTURES,
                                 &next_pulse_capture[i], DETAIL_PULSES);
    }
}

size_t board_edges_get(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    if (TIM2->SR & TIM_SR_CC1OF) {
        TIM2->SR = ~TIM_SR_CC1OF;
        health_count_fault(MR_FAULT_EDGE_OVERRUN, 0);
    }
    return get_captures(EDGE_STREAM, edge_tick, EDGE_CAPTURES, &next_edge_capture, until_tick,
                        EDGE_FILTER_TICKS, ticks, capacity);
}

void board_pulses_enable(enum board_pulse_input input, bool on)
{
    uint32_t channel = get_pulse_channel(input), shift = channel % 2 * 8;
    volatile uint32_t *mode = channel < 2 ? &TIM2->CCMR1 : &TIM2->CCMR2;
    TIM2->DIER &= ~(TIM_DIER_CC1DE << channel);
    TIM2->CCER &= ~(TIM_CCER_CC1E << 4 * channel);
    dma_stream_stop(DMA1, pulse_stream[input]);
    next_pulse_capture[input] = 0;
    if (!on)
        return;
    start_stream(pulse_stream[input], channel, pulse_tick[input], PULSE_CAPTURES,
                 DMA_CR_PRIORITY(1));
    *mode = (*mode & ~(0xffu << shift)) | (TIM_CCMR1_CC1_TI1 | TIM_CCMR1_IC1F_256) << shift;
    (void)TIM2->CCR[channel]; /* read the register to discard an old capture */
    TIM2->DIER |= TIM_DIER_CC1DE << channel;
    TIM2->CCER |= TIM_CCER_CC1E << 4 * channel; /* rising edges */
}

size_t board_pulses_get(enum board_pulse_input input, uint32_t until_tick, uint32_t *ticks,
                        size_t capacity)
{
    uint32_t overrun = TIM_SR_CC1OF << get_pulse_channel(input);
    if (TIM2->SR & overrun) {
        TIM2->SR = ~overrun;
        health_count_fault(MR_FAULT_EDGE_OVERRUN, DETAIL_PULSES);
    }
    return get_captures(pulse_stream[input], pulse_tick[input], PULSE_CAPTURES,
                        &next_pulse_capture[input], until_tick, PULSE_FILTER_TICKS, ticks,
                        capacity);
}

uint32_t board_set_camera_trigger(bool high)
{
    pin_write(PIN_CAMERA_TRIGGER, high);
    return TIM2->CNT;
}
