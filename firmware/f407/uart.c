/* The serial link, USART1 or USART6 at 2 Mbaud, 8N1: 84 MHz / 16 / 2 Mbaud = 2.625. DMA2 stream 7
 * sends from a ring, stream 2 receives into one. RM0090 30.3.4 (baud rate), 30.3.13 (DMA). Where
 * the DMA does not answer, output is polled and input is lost. */
#include <string.h>

#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define TX_RING        8192u
#define RX_RING        1024u
#define UART           (BOARD_SERIAL == 6 ? USART6 : USART1)
/* RM0090 table 43 */
#define TX_STREAM      7u
#define RX_STREAM      2u
#define REQUEST        (BOARD_SERIAL == 6 ? 5u : 4u)
#define BRR_2M         (2u << 4 | 10u) /* 2 + 10/16 */
#define BRR_2M_RAW     (1u << 4)       /* 16 MHz / 8 / 2 Mbaud = 1, eight samples a bit */
/* A byte takes 840 cycles. Few enough that a dead transmitter does not outlast the watchdog,
 * message by message. */
#define POLLS_PER_BYTE 1000u
#define PCLK2_HZ       84000000u
#define RAW_HZ         16000000u

static uint8_t tx_ring[TX_RING] DMA_BUFFER, rx_ring[RX_RING] DMA_BUFFER;
static volatile uint32_t tx_put, tx_got; /* bytes ever queued and ever sent */
static volatile uint32_t tx_chunk;       /* bytes the DMA is sending */
static uint32_t rx_got;
static bool by_dma;
static uint32_t polls_per_byte = POLLS_PER_BYTE;

void uart_start(bool dma_works, bool raw_clock)
{
    by_dma = dma_works;
    UART->BRR = raw_clock ? BRR_2M_RAW : BRR_2M;
    UART->CR3 = by_dma ? USART_CR3_DMAT | USART_CR3_DMAR : 0;
    UART->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | (raw_clock ? USART_CR1_OVER8 : 0);
    if (!by_dma) {
        health_count(MR_FAULT_SERIAL_POLLED, 0);
        return;
    }
    struct dma_stream_regs *rx = &DMA2->stream[RX_STREAM];
    rx->PAR = (uint32_t)(uintptr_t)&UART->DR;
    rx->M0AR = (uint32_t)(uintptr_t)rx_ring;
    rx->NDTR = RX_RING;
    rx->CR = DMA_CR_CHANNEL(REQUEST) | DMA_CR_MINC | DMA_CR_CIRC | DMA_CR_EN;
    DMA2->stream[TX_STREAM].PAR = (uint32_t)(uintptr_t)&UART->DR;
    irq_enable(IRQ_DMA2_STREAM7, PRIORITY_SERIAL);
}

/* Gives the DMA the next stretch of the ring. Interrupts masked, or inside its own. */
static void send_next(void)
{
    uint32_t waiting = tx_put - tx_got;
    uint32_t at = tx_got % TX_RING;
    struct dma_stream_regs *tx = &DMA2->stream[TX_STREAM];
    tx_chunk = waiting < TX_RING - at ? waiting : TX_RING - at;
    if (!tx_chunk)
        return;
    DMA2->IFCR[TX_STREAM / 4] = DMA_FLAGS_ALL << dma_flag_shift(TX_STREAM);
    tx->M0AR = (uint32_t)(uintptr_t)&tx_ring[at];
    tx->NDTR = tx_chunk;
    tx->CR = DMA_CR_CHANNEL(REQUEST) | DMA_CR_MINC | DMA_CR_MEM_TO_PERIPHERAL | DMA_CR_TCIE |
             DMA_CR_TEIE | DMA_CR_EN;
}

void dma2_stream7_irq(void);
void dma2_stream7_irq(void)
{
    DMA2->IFCR[TX_STREAM / 4] = DMA_FLAGS_ALL << dma_flag_shift(TX_STREAM);
    tx_got += tx_chunk;
    send_next();
}

static bool send_polled(const uint8_t *bytes, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        unsigned polls = 0;
        while (!(UART->SR & USART_SR_TXE)) {
            if (++polls == polls_per_byte)
                return false;
        }
        UART->DR = bytes[i];
    }
    return true;
}

bool board_serial_send(const uint8_t *bytes, size_t length)
{
    if (!by_dma)
        return send_polled(bytes, length);
    if (length > TX_RING - (tx_put - tx_got))
        return false;
    uint32_t at = tx_put % TX_RING;
    size_t to_end = TX_RING - at;
    size_t first = length < to_end ? length : to_end;
    memcpy(&tx_ring[at], bytes, first);
    memcpy(tx_ring, bytes + first, length - first);
    uint32_t mask = irq_mask();
    tx_put += length;
    if (!tx_chunk)
        send_next();
    irq_restore(mask);
    return true;
}

size_t board_serial_receive(uint8_t *bytes, size_t capacity)
{
    size_t count = 0;
    if (!by_dma)
        return 0;
    uint32_t head = (RX_RING - DMA2->stream[RX_STREAM].NDTR) % RX_RING;
    while (rx_got != head && count < capacity) {
        bytes[count++] = rx_ring[rx_got];
        rx_got = (rx_got + 1) % RX_RING;
    }
    return count;
}

/* RM0090 30.3.4: of 16 samples a bit the register is clock over baud; of 8 its fraction has three
 * bits of four. */
void uart_rate(uint32_t baud)
{
    bool eight = (UART->CR1 & USART_CR1_OVER8) != 0;
    uint32_t divider = ((eight ? RAW_HZ : PCLK2_HZ) + baud / 2u) / baud;
    UART->BRR = eight ? divider >> 3 << 4 | (divider & 7u) : divider;
    polls_per_byte = POLLS_PER_BYTE * (2000000u / baud + 1u);
}

bool uart_sent(void)
{
    return tx_put == tx_got;
}
