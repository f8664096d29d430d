/* Scans: TIM4 reverses the excitation and triggers both converters at 8 kHz. DMA stores the codes,
 * and each millisecond becomes a block. RM0090 13.8 (scan, DMA), table 43 (streams), 18.3.15 (timer
 * synchronisation).
 *
 *     TIM4 count   0 ... 2 ........ 2352 ................................ 10290 ... 10500 (125 us)
 *                      excitation   trigger  16 conversions of 124/21 us     next
 *                      reverses     (28 us settling)
 *
 * TIM4's start also starts TIM2, both from 0, so the first trigger of block n is at tick 2352 +
 * 84000 n of TIM2: edges and samples share one clock without software in between. Blocks are 8
 * scans, an even number, so every block begins with the excitation forward (PD12 high, PD13 low).
 *
 * TIM2 alone determines which block has ended. A delayed interrupt therefore cannot give a block a
 * wrong index; blocks not read in time are missing. A debugger that halts the core halts both
 * timers (board.c).
 *
 * Channels that are not fitted are not in the sequences. The converter with the longer sequence
 * signals the end of a block; with equal lengths it is ADC1, because the stream of ADC3 has the
 * lower number and is served first. */
#include "common/block.h"
#include "firmware/f407/drivers.h"
#include "firmware/f407/queue.h"
#include "firmware/health.h"

#define SCAN_TICKS       10500u
#define TRIGGER_TICK     2352u
#define REVERSE_TICK     2u
#define CONVERSION_TICKS 496u /* 124 cycles at 21 MHz */
/* number of scans in the circular buffer: one block is filled while the other is summed */
#define BUFFER_SCANS     (2 * MR_SCANS_PER_BLOCK)
#define ADC1_STREAM      4u
#define ADC3_STREAM      1u
#define BLOCK_QUEUE      16u

/* One row per scan, with one code per input in the sequence. Aligned to words, because two codes
 * are added and compared at a time. */
static _Alignas(4) uint16_t adc1_code[BUFFER_SCANS * MR_ADC1_CHANNELS] DMA_BUFFER;
static _Alignas(4) uint16_t adc3_code[BUFFER_SCANS * MR_TRANSDUCERS] DMA_BUFFER;

static struct mr_scan scan;
static bool is_prepared, are_timers_running;

static struct mr_block block_ring[BLOCK_QUEUE];
static struct queue block_queue;
/* Indices of the block being filled, and of the block at the start of the first half of the
 * buffer. */
static uint32_t next_index, first_index;
/* Ticks from a block's first trigger to the start of its last conversion. */
static uint32_t last_conversion_ticks;

/* Position of the other converter's stream at the end of the last block. A stream that has stopped
 * is at the expected half in every second block, so an unchanged position is an error. */
#define POSITION_UNKNOWN UINT32_MAX
static uint32_t adc1_position = POSITION_UNKNOWN;
static bool is_adc1_stopped;

/* Converter input of each channel. */
static const uint8_t adc_input[MR_CHANNELS] = {
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) [BOARD_##SIGNAL] = input,
#include "firmware/boards/pins.def"
};
enum {
    WRONG_CONVERTER_COUNT = 0
#define CONVERTER_OF(channel) ((channel) < (int)MR_TRANSDUCERS ? 3 : 1)
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) \
    +(CONVERTER_OF(BOARD_##SIGNAL) != (converter))
#include "firmware/boards/pins.def"
};
_Static_assert(WRONG_CONVERTER_COUNT == 0,
               "transducers at ADC3, all others at ADC1: common/block.h");

static void start_stream(unsigned number, uint32_t channel, struct adc_regs *adc, void *memory,
                         uint32_t count, uint32_t interrupts)
{
    struct dma_stream_regs *stream = &DMA2->stream[number];
    dma_stream_stop(DMA2, number);
    if (count == 0)
        return;
    stream->PAR = (uint32_t)(uintptr_t)&adc->DR;
    stream->M0AR = (uint32_t)(uintptr_t)memory;
    stream->NDTR = count;
    dma_stream_start(stream, DMA_CR_CHANNEL(channel) | DMA_CR_PRIORITY(3) | DMA_CR_MSIZE_16 |
                                 DMA_CR_PSIZE_16 | DMA_CR_MINC | DMA_CR_CIRC | interrupts);
}

static void start_converter(struct adc_regs *adc, const uint8_t *channel, unsigned count)
{
    uint32_t sequence[3] = {0};
    adc->CR2 = 0;
    adc->SR = 0;
    if (count == 0)
        return;
    for (unsigned i = 0; i < count; i++)
        sequence[i / 6] |= (uint32_t)adc_input[channel[i]] << (5 * (i % 6));
    adc->SQR3 = sequence[0];
    adc->SQR2 = sequence[1];
    adc->SQR1 = sequence[2] | (count - 1) << 20;
    uint32_t all_112 = 0;
    for (unsigned i = 0; i < 10; i++)
        all_112 |= ADC_SMP_112 << (3 * i);
    adc->SMPR2 = all_112;              /* inputs 0 to 9 */
    adc->SMPR1 = all_112 & 0x7ffffffu; /* inputs 10 to 18 */
    adc->CR1 = ADC_CR1_SCAN | ADC_CR1_OVRIE;
    adc->CR2 = ADC_CR2_ADON | ADC_CR2_DMA | ADC_CR2_DDS | ADC_CR2_EXTSEL_TIM4_CC4 |
               ADC_CR2_EXTEN_RISING;
}

static void start_conversions(void)
{
    /* stop the converters: a scan in progress would store its remaining codes in the new streams */
    ADC1->CR2 = 0;
    ADC3->CR2 = 0;
    const uint32_t tell = DMA_CR_HTIE | DMA_CR_TCIE | DMA_CR_TEIE;
    bool adc3_is_last = scan.transducer_count > scan.adc1_count;
    uint32_t conversions = adc3_is_last ? scan.transducer_count : scan.adc1_count;
    adc1_position = POSITION_UNKNOWN;
    is_adc1_stopped = false;
    first_index = next_index;
    last_conversion_ticks = (MR_SCANS_PER_BLOCK - 1u) * SCAN_TICKS +
                            (conversions - 1u) * CONVERSION_TICKS;
    start_stream(ADC1_STREAM, 0, ADC1, adc1_code, BUFFER_SCANS * scan.adc1_count,
                 adc3_is_last ? 0 : tell);
    start_stream(ADC3_STREAM, 2, ADC3, adc3_code, BUFFER_SCANS * scan.transducer_count,
                 adc3_is_last ? tell : 0);
    start_converter(ADC1, scan.channel + scan.transducer_count, scan.adc1_count);
    start_converter(ADC3, scan.channel, scan.transducer_count);
}

void scan_prepare(void)
{
    ADC_CCR = ADC_CCR_PRESCALER_4;
    is_prepared = true;
}

static void start_timers(void)
{
    irq_enable(IRQ_DMA2_STREAM1, PRIORITY_SCAN);
    irq_enable(IRQ_DMA2_STREAM4, PRIORITY_SCAN);
    irq_enable(IRQ_ADC, PRIORITY_SCAN);

    TIM4->PSC = 0;
    TIM4->ARR = SCAN_TICKS - 1;
    TIM4->CCR[0] = REVERSE_TICK;
    TIM4->CCR[1] = REVERSE_TICK;
    TIM4->CCR[3] = TRIGGER_TICK;
    TIM4->EGR = TIM_EGR_UG;
    /* set the outputs to backward, so that the first reversal makes scan 0 forward */
    TIM4->CCMR1 = TIM_OCM_FORCE_LOW << 4 | TIM_OCM_FORCE_HIGH << 12;
    TIM4->CCMR2 = TIM_OCM_PWM2 << 12;
    TIM4->CCER = 1u << 0 | 1u << 4 | 1u << 12;
    TIM4->CCMR1 = TIM_OCM_TOGGLE << 4 | TIM_OCM_TOGGLE << 12;
    TIM4->CR2 = TIM_CR2_MMS_ENABLE;
    TIM4->SR = 0;
    TIM4->CR1 = TIM_CR1_CEN;
    are_timers_running = true;
}

/* Checks that the excitation pins match the scan in progress. This is called after the last scan of
 * a block: the excitation must be forward if the reversal has occurred, and backward in the last
 * 2.5 us before it. */
static void check_polarity(void)
{
    uint32_t before = TIM4->CNT;
    unsigned pins = (unsigned)pin_read(PIN_EXCITATION_PLUS) |
                    (unsigned)pin_read(PIN_EXCITATION_MINUS) << 1;
    uint32_t after = TIM4->CNT;
    bool reversed_since = before < TRIGGER_TICK;
    if (after < before || before <= REVERSE_TICK)
        return; /* the excitation was reversed between the two readings */
    if (pins != (reversed_since ? 1u : 2u))
        health_count_fault(MR_FAULT_POLARITY, (uint8_t)pins);
}

/* Returns the number of blocks that have ended since the last one handled. A block counts as ended
 * from the start of its last conversion, because the interrupt flag may already be set then. */
static uint32_t count_ended_blocks(void)
{
    int32_t since = (int32_t)(TIM2->CNT - mr_boardtime_block_tick(TRIGGER_TICK, next_index) -
                              last_conversion_ticks);
    return since < 0 ? 0 : (uint32_t)since / MR_TICKS_PER_BLOCK + 1u;
}

/* Handles the interrupt of a full buffer half and builds the block. The other converter has the
 * same trigger and has finished too: if its stream is not at the same half of its buffer, it has
 * lost a scan. (The stream stays there for at least 36 us, until the first code of the next scan.)
 * If the stream has not moved for a block, all blocks are refused until supervision restarts the
 * scans. */
static void end_block(unsigned stream, unsigned other, unsigned other_count)
{
    uint32_t flags = DMA2->ISR[stream / 4] >> dma_flag_shift(stream) & DMA_FLAGS_ALL;
    DMA2->IFCR[stream / 4] = flags << dma_flag_shift(stream);
    if (flags & DMA_FLAG_TEIF)
        health_count_fault(MR_FAULT_SCAN_OVERRUN, 1);
    if (!(flags & (DMA_FLAG_HTIF | DMA_FLAG_TCIF)))
        return;

    uint32_t ended = count_ended_blocks();
    if (ended == 0)
        return; /* ignore this block, which was already counted as missing */
    next_index += ended;
    uint32_t index = next_index - 1u;
    unsigned half = (index - first_index) % 2u ? MR_SCANS_PER_BLOCK : 0;
    if (ended > 1 ||
        (flags & (DMA_FLAG_HTIF | DMA_FLAG_TCIF)) != (half ? DMA_FLAG_TCIF : DMA_FLAG_HTIF)) {
        adc1_position = POSITION_UNKNOWN;
        health_count_fault(MR_FAULT_SCAN_OVERRUN, 1);
        return;
    }
    uint32_t expected = half ? BUFFER_SCANS * other_count : MR_SCANS_PER_BLOCK * other_count;
    uint32_t stands_at = DMA2->stream[other].NDTR;
    is_adc1_stopped |= stands_at == adc1_position;
    adc1_position = stands_at;
    if (other_count && (stands_at != expected || is_adc1_stopped)) {
        health_count_fault(MR_FAULT_SCAN_OVERRUN, 3);
        return;
    }
    check_polarity();
    if (queue_filled(&block_queue) == BLOCK_QUEUE) {
        health_count_fault(MR_FAULT_BLOCK_LATE, 0);
        return;
    }
    struct mr_block *block = &block_ring[block_queue.added % BLOCK_QUEUE];
    uint32_t tick = mr_boardtime_block_tick(TRIGGER_TICK, index);
    uint16_t *transducers = adc3_code + half * scan.transducer_count,
             *others = adc1_code + half * scan.adc1_count;
    if (scan.absent_channels == 0)
        mr_block_from_scans(block, index, tick, (uint16_t(*)[MR_TRANSDUCERS])transducers,
                            (uint16_t(*)[MR_ADC1_CHANNELS])others);
    else
        mr_block_from_fitted_scans(block, &scan, index, tick, transducers, others);
    queue_add(&block_queue, 1);
}

void dma2_stream1_irq(void);
void dma2_stream1_irq(void)
{
    end_block(ADC3_STREAM, ADC1_STREAM, scan.adc1_count);
    irq_end();
}

void dma2_stream4_irq(void);
void dma2_stream4_irq(void)
{
    end_block(ADC1_STREAM, ADC3_STREAM, scan.transducer_count);
    irq_end();
}

void adc_irq(void);
void adc_irq(void)
{
    /* Leave OVR set and disable its interrupt; supervision restarts the scans when there are no
     * more blocks. */
    health_count_fault(MR_FAULT_SCAN_OVERRUN, ADC1->SR & ADC_SR_OVR ? 1 : 3);
    ADC1->CR1 &= ~ADC_CR1_OVRIE;
    ADC3->CR1 &= ~ADC_CR1_OVRIE;
    irq_end();
}

bool scan_is_block_ready(void)
{
    return queue_filled(&block_queue) != 0;
}

unsigned board_blocks_waiting(void)
{
    return queue_filled(&block_queue);
}

bool board_block_get(struct mr_block *block)
{
    if (!scan_is_block_ready())
        return false;
    *block = block_ring[block_queue.removed % BLOCK_QUEUE];
    queue_remove(&block_queue, 1);
    return true;
}

#define TRIGGER_LOW_FROM (MR_SCANS_PER_BLOCK * SCAN_TICKS - TRIGGER_TICK)
#define BEGIN_TICKS      1000u

/* Restarts the scans between the last trigger of a block and the first trigger of the next, so that
 * blocks keep their position on TIM2. The output of TIM4's channel 4 must be low again; otherwise
 * enabling the trigger could count as an edge and shift the polarity by a scan. The start takes 3
 * us, then the converters settle for 3 us (data sheet, tSTAB). The wait is at most one block; it is
 * limited to 200000 polls in case TIM2 has stopped. */
static void restart_scans(const struct mr_scan *with)
{
    for (unsigned polls = 0; polls < 200000; polls++) {
        uint32_t mask = irq_mask();
        /* Time since the first trigger of the block before the next one. The time since the first
         * of all triggers cannot be used, because TIM2 wraps after 51 s, which is not a whole
         * number of blocks. A restart is tried every second, so this difference has not wrapped. */
        uint32_t since = TIM2->CNT - mr_boardtime_block_tick(TRIGGER_TICK, next_index) +
                         MR_TICKS_PER_BLOCK;
        uint32_t in_block = since % MR_TICKS_PER_BLOCK;
        bool now = in_block > TRIGGER_LOW_FROM && in_block < MR_TICKS_PER_BLOCK - BEGIN_TICKS;
        if (now) {
            next_index += since / MR_TICKS_PER_BLOCK;
            scan = *with;
            start_conversions();
        }
        irq_restore(mask);
        if (now) {
            capture_discard_old();
            return;
        }
    }
}

void board_scans_restart(void)
{
    struct mr_scan same = scan;
    if (are_timers_running)
        restart_scans(&same);
}

void board_scans_configure(uint32_t fitted)
{
    struct mr_scan wanted;
    mr_scan_select_channels(&wanted, ~(fitted & BOARD_INPUTS));
    if (!is_prepared)
        return;
    if (are_timers_running) {
        restart_scans(&wanted);
        return;
    }
    scan = wanted;
    start_conversions();
    start_timers();
}
