/* Memory of board.h on SPI2 with a W25Q128: PB12 selects, PB13 SCK, PB14 MISO, PB15 MOSI at 42 MHz
 * / 2; DMA1 stream 3 receives, stream 4 sends. RM0090 28.3.9 (DMA), table 42 (streams); data sheet
 * W25Q128JV rev. F 8.2 (commands), 9.6 (times).
 *
 * Commands and addresses are sent by polling, 0.4 us a byte; data by DMA, 0.1 ms a page. While a
 * page is being programmed, DMA reads the status for 0.2 ms at a time; an interrupt at its end
 * checks the last status. Sectors are erased only while the board is idle, so the main loop polls
 * the status of an erase. */
#include "firmware/f407/drivers.h"
#include "firmware/board.h"

#define RX_STREAM    3u
#define TX_STREAM    4u
#define BYTE_POLLS   200u     /* limit for a byte, which takes 64 cycles */
#define STATUS_BYTES 512u     /* number of status bytes that one DMA transfer reads, in 195 us */
#define TICKS_PER_MS 84000u   /* TIM2 */
#define TRANSFER_MS  5u       /* limit for a transfer: 260 bytes last 0.1 ms */
#define PROGRAM_MS   45u      /* data sheet: 3 ms at most; a failing page takes longer */
#define ERASE_MS     6000u    /* data sheet: 400 ms at most; a failing sector takes longer */
#define POLLS_MAX    8000000u /* limit for any operation, in case TIM2 has stopped */

/* Data sheet 9.6. Times from data sheet 9.6. Before and after an erase, a program or a status
 * command, the chip must be deselected for tSHSL2; otherwise it takes two commands for one. SLEW_NS
 * is the rise time of the line (pins.c). The chip needs tRES1 after the command 0xab (release from
 * power-down) and tRST after a reset. */
#define DESELECT_NS      50u
#define SLEW_NS          10u
#define WAKE_NS          3000u
#define RESET_NS         30000u
/* 168 MHz if the internal oscillator is 4.5 % too fast (STM32F407 data sheet, ACC_HSI) */
#define CORE_MAX_MHZ     176u
#define CYCLES_OF_NS(ns) (((ns)*CORE_MAX_MHZ + 999u) / 1000u)

enum {
    COMMAND_WRITE_ENABLE = 0x06,
    COMMAND_STATUS = 0x05,
    COMMAND_PROGRAM = 0x02,
    COMMAND_READ = 0x03,
    COMMAND_ERASE = 0x20,
    COMMAND_ENABLE_RESET = 0x66,
    COMMAND_RESET = 0x99,
    COMMAND_IDENTITY = 0x9f,
    COMMAND_RELEASE_POWER_DOWN = 0xab
};
#define STATUS_BUSY  1u
#define MANUFACTURER 0xefu
#define CAPACITY     0x18u /* 2^24 bytes */

static volatile enum phase {
    PHASE_ABSENT,
    PHASE_STUCK,
    PHASE_STARTING,
    PHASE_IDLE,
    PHASE_READING,
    PHASE_SENDING,
    PHASE_PROGRAMMING,
    PHASE_ERASING
} phase;
static volatile bool has_failed;
static uint32_t start_tick, polls;
/* DMA target for the bytes received while a page is sent, and for the newest status. */
static volatile uint8_t dma_sink DMA_BUFFER;
static const uint8_t filler = 0xff;

/* Waits at least this many core cycles at any clock rate; one round of the loop has two
 * instructions of at least one cycle. */
static void wait_cycles(uint32_t cycles)
{
    uint32_t rounds = (cycles + 1u) / 2u;
    __asm volatile("dsb\n1:\tsubs %0, #1\n\tbne 1b" : "+l"(rounds) : : "cc", "memory");
}

/* Sets the select line. No other function does, so that the line is high for tSHSL2 before each
 * command. The first clock follows after half a period of SCK or more, 24 ns (tSLCH needs 5 ns).
 * BSY is cleared at least tCHSH (3 ns) after the last clock. */
static __attribute__((noinline)) void set_select(bool on)
{
    if (on)
        wait_cycles(CYCLES_OF_NS(DESELECT_NS + SLEW_NS));
    for (unsigned n = 0; !on && (SPI2->SR & SPI_SR_BSY) && n < BYTE_POLLS;)
        n++;
    pin_write(PIN_MEMORY_SELECT, !on);
}

static uint8_t exchange_byte(uint8_t out)
{
    SPI2->DR = out;
    for (unsigned n = 0; n < BYTE_POLLS; n++) {
        if (SPI2->SR & SPI_SR_RXNE)
            return (uint8_t)SPI2->DR;
    }
    return 0xff;
}

static void send_command(uint8_t command, uint32_t address)
{
    set_select(true);
    exchange_byte(command);
    exchange_byte((uint8_t)(address >> 16));
    exchange_byte((uint8_t)(address >> 8));
    exchange_byte((uint8_t)address);
}

static uint8_t read_status(void)
{
    set_select(true);
    exchange_byte(COMMAND_STATUS);
    uint8_t status = exchange_byte(filler);
    set_select(false);
    return status;
}

static void send_single_command(uint8_t command)
{
    set_select(true);
    exchange_byte(command);
    set_select(false);
}

/* Resets the chip to end an operation that does not end; a busy chip executes no other command. The
 * cells of that operation are then partly changed (data sheet 8.2.36). */
static void reset_chip(void)
{
    send_single_command(COMMAND_ENABLE_RESET);
    send_single_command(COMMAND_RESET);
    wait_cycles(CYCLES_OF_NS(RESET_NS));
}

static void begin_phase(enum phase next)
{
    has_failed = false;
    polls = 0;
    start_tick = TIM2->CNT;
    phase = next;
}

/* Begins a DMA transfer. `in` NULL: received bytes are dropped; `out` NULL: filler bytes are
 * sent. */
static void begin_dma(uint8_t *in, const uint8_t *out, uint32_t count)
{
    struct dma_stream_regs *rx = &DMA1->stream[RX_STREAM], *tx = &DMA1->stream[TX_STREAM];
    DMA1->IFCR[0] = DMA_FLAGS_ALL << dma_flag_shift(RX_STREAM);
    DMA1->IFCR[1] = DMA_FLAGS_ALL << dma_flag_shift(TX_STREAM);
    rx->PAR = (uint32_t)(uintptr_t)&SPI2->DR;
    rx->M0AR = in ? (uint32_t)(uintptr_t)in : (uint32_t)(uintptr_t)&dma_sink;
    rx->NDTR = count;
    dma_stream_start(rx, DMA_CR_CHANNEL(0) | (in ? DMA_CR_MINC : 0) | DMA_CR_TCIE | DMA_CR_TEIE);
    tx->PAR = (uint32_t)(uintptr_t)&SPI2->DR;
    tx->M0AR = out ? (uint32_t)(uintptr_t)out : (uint32_t)(uintptr_t)&filler;
    tx->NDTR = count;
    dma_stream_start(tx, DMA_CR_CHANNEL(0) | (out ? DMA_CR_MINC : 0) | DMA_CR_MEM_TO_PERIPHERAL);
    SPI2->CR2 = SPI_CR2_RXDMAEN | SPI_CR2_TXDMAEN;
}

static bool has_timed_out(uint32_t ms)
{
    return TIM2->CNT - start_tick > ms * TICKS_PER_MS;
}

static void end_program(bool fails)
{
    set_select(false);
    if (fails)
        reset_chip();
    has_failed = fails;
    phase = PHASE_IDLE;
}

void dma1_stream3_irq(void);
void dma1_stream3_irq(void)
{
    uint32_t flags = DMA1->ISR[0] >> dma_flag_shift(RX_STREAM) & DMA_FLAGS_ALL;
    DMA1->IFCR[0] = DMA_FLAGS_ALL << dma_flag_shift(RX_STREAM);
    SPI2->CR2 = 0;
    if (flags & DMA_FLAG_TEIF) {
        /* a bus error of the stream is an error of this driver, not of the chip */
        set_select(false);
        phase = PHASE_ABSENT;
    } else if (phase == PHASE_READING) {
        set_select(false);
        phase = PHASE_IDLE;
    } else if (phase == PHASE_SENDING) {
        set_select(false); /* deselecting starts the programming */
        phase = PHASE_PROGRAMMING;
        set_select(true);
        exchange_byte(COMMAND_STATUS);
        begin_dma(NULL, NULL, STATUS_BYTES);
    } else if (phase == PHASE_PROGRAMMING) {
        if (!(dma_sink & STATUS_BUSY))
            end_program(false);
        else if (has_timed_out(PROGRAM_MS))
            end_program(true);
        else
            begin_dma(NULL, NULL, STATUS_BYTES);
    }
    irq_end();
}

void nor_extend_timeout(uint32_t ticks)
{
    start_tick += ticks;
}

uint32_t nor_read_jedec_id(void)
{
    set_select(true);
    exchange_byte(COMMAND_IDENTITY);
    uint32_t id = (uint32_t)exchange_byte(filler) << 16;
    id |= (uint32_t)exchange_byte(filler) << 8; /* 0x40 or 0x70, depending on the ordering code */
    id |= exchange_byte(filler);
    set_select(false);
    return id;
}

static bool is_expected_chip(void)
{
    uint32_t id = nor_read_jedec_id();
    return id >> 16 == MANUFACTURER && (id & 0xffu) == CAPACITY;
}

static void read_identification(void)
{
    phase = is_expected_chip() ? PHASE_IDLE : PHASE_ABSENT;
}

enum nor_status nor_identify(void)
{
    if (phase == PHASE_ABSENT || phase == PHASE_STUCK)
        return phase == PHASE_ABSENT ? NOR_MISSING : NOR_STUCK;
    if (phase != PHASE_IDLE)
        return NOR_BUSY;
    return is_expected_chip() ? NOR_IDLE : NOR_MISSING;
}

/* Detects the chip. It may still be busy with an operation from before a reset. If there is no
 * chip, all bits read as ones. */
static void detect_chip(void)
{
    uint8_t status = read_status();
    bool late = has_timed_out(ERASE_MS);
    if (status != 0xff && (status & STATUS_BUSY) && late) {
        reset_chip();
        status = read_status();
    }
    if (status == 0xff)
        phase = PHASE_ABSENT;
    else if (!(status & STATUS_BUSY))
        read_identification();
    else if (late)
        phase = PHASE_STUCK;
}

void nor_start(void)
{
    SPI2->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SSI;
    SPI2->CR1 |= SPI_CR1_SPE;
    irq_enable(IRQ_DMA1_STREAM3, PRIORITY_SERIAL);
    send_single_command(COMMAND_RELEASE_POWER_DOWN);
    wait_cycles(CYCLES_OF_NS(WAKE_NS));
    begin_phase(PHASE_STARTING);
    detect_chip();
}

/* Stops a transfer that does not end. The chip is not at fault. */
static void abort_transfer(void)
{
    uint32_t mask = irq_mask();
    dma_stream_stop(DMA1, RX_STREAM);
    dma_stream_stop(DMA1, TX_STREAM);
    SPI2->CR2 = 0;
    set_select(false);
    phase = PHASE_ABSENT;
    irq_restore(mask);
}

enum nor_status nor_poll(void)
{
    polls++;
    switch (phase) {
    case PHASE_ABSENT: return NOR_MISSING;
    case PHASE_STUCK: return NOR_STUCK;
    case PHASE_STARTING: detect_chip(); return NOR_BUSY; /* the next poll reports the result */
    case PHASE_IDLE:
        memory_fence(); /* make the data that DMA has stored visible to the caller */
        return has_failed ? NOR_FAILED : NOR_IDLE;
    case PHASE_ERASING:
        if (!(read_status() & STATUS_BUSY))
            phase = PHASE_IDLE;
        else if (has_timed_out(ERASE_MS) || polls > POLLS_MAX)
            end_program(true);
        return NOR_BUSY; /* the next poll reports the end */
    default:
        /* longer than a page transfer plus programming: abort */
        if (has_timed_out(PROGRAM_MS + TRANSFER_MS) || polls > POLLS_MAX)
            abort_transfer();
        return NOR_BUSY;
    }
}

void nor_begin_read(uint32_t address, uint8_t *bytes, size_t length)
{
    begin_phase(PHASE_READING);
    send_command(COMMAND_READ, address);
    begin_dma(bytes, NULL, (uint32_t)length);
}

void nor_begin_program(uint32_t address, const uint8_t page[NOR_PAGE_BYTES])
{
    send_single_command(COMMAND_WRITE_ENABLE);
    begin_phase(PHASE_SENDING);
    send_command(COMMAND_PROGRAM, address);
    begin_dma(NULL, page, NOR_PAGE_BYTES);
}

void nor_begin_erase(uint32_t address)
{
    send_single_command(COMMAND_WRITE_ENABLE);
    send_command(COMMAND_ERASE, address);
    set_select(false);
    begin_phase(PHASE_ERASING);
}
