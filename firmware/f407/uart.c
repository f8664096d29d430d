/* The serial link, USART1 or USART6 at 2 Mbaud, 8N1: 84 MHz / 16 / 2 Mbaud = 2.625. DMA2 stream 7
 * sends from a ring, stream 2 receives into one. RM0090 30.3.4 (baud rate), 30.3.13 (DMA). */
#include <string.h>

#include "firmware/f407/drivers.h"
#include "firmware/f407/queue.h"

#define TX_RING_BYTES    8192u
#define RX_RING_BYTES    1024u
#define UART             (BOARD_SERIAL == 6 ? USART6 : USART1)
/* RM0090 table 43 */
#define TX_STREAM        7u
#define RX_STREAM        2u
#define UART_DMA_CHANNEL (BOARD_SERIAL == 6 ? 5u : 4u)
#define BRR_2M           (2u << 4 | 10u) /* divider 2 + 10/16 = 2.625 */
#define PCLK2_HZ         84000000u

static uint8_t tx_ring[TX_RING_BYTES] DMA_BUFFER, rx_ring[RX_RING_BYTES] DMA_BUFFER;
static struct queue tx_queue;
static volatile uint32_t tx_dma_bytes; /* number of bytes that DMA is sending */
static uint32_t rx_read_count;

void uart_start(void)
{
    UART->BRR = BRR_2M;
    UART->CR3 = USART_CR3_DMAT | USART_CR3_DMAR;
    UART->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    struct dma_stream_regs *rx = &DMA2->stream[RX_STREAM];
    rx->PAR = (uint32_t)(uintptr_t)&UART->DR;
    rx->M0AR = (uint32_t)(uintptr_t)rx_ring;
    rx->NDTR = RX_RING_BYTES;
    dma_stream_start(rx, DMA_CR_CHANNEL(UART_DMA_CHANNEL) | DMA_CR_MINC | DMA_CR_CIRC);
    DMA2->stream[TX_STREAM].PAR = (uint32_t)(uintptr_t)&UART->DR;
    irq_enable(IRQ_DMA2_STREAM7, PRIORITY_SERIAL);
}

/* Starts DMA for the next contiguous part of the ring. Call with interrupts masked, or from the DMA
 * interrupt. */
static void send_next(void)
{
    uint32_t waiting = queue_filled(&tx_queue);
    uint32_t at = tx_queue.removed % TX_RING_BYTES;
    struct dma_stream_regs *tx = &DMA2->stream[TX_STREAM];
    tx_dma_bytes = waiting < TX_RING_BYTES - at ? waiting : TX_RING_BYTES - at;
    if (!tx_dma_bytes)
        return;
    DMA2->IFCR[TX_STREAM / 4] = DMA_FLAGS_ALL << dma_flag_shift(TX_STREAM);
    tx->M0AR = (uint32_t)(uintptr_t)&tx_ring[at];
    tx->NDTR = tx_dma_bytes;
    dma_stream_start(tx, DMA_CR_CHANNEL(UART_DMA_CHANNEL) | DMA_CR_MINC | DMA_CR_MEM_TO_PERIPHERAL |
                             DMA_CR_TCIE | DMA_CR_TEIE);
}

void dma2_stream7_irq(void);
void dma2_stream7_irq(void)
{
    DMA2->IFCR[TX_STREAM / 4] = DMA_FLAGS_ALL << dma_flag_shift(TX_STREAM);
    queue_remove(&tx_queue, tx_dma_bytes);
    send_next();
    irq_end();
}

bool board_serial_send(const uint8_t *bytes, size_t length)
{
    if (length > TX_RING_BYTES - queue_filled(&tx_queue))
        return false;
    uint32_t at = tx_queue.added % TX_RING_BYTES;
    size_t to_end = TX_RING_BYTES - at;
    size_t first = length < to_end ? length : to_end;
    memcpy(&tx_ring[at], bytes, first);
    memcpy(tx_ring, bytes + first, length - first);
    uint32_t mask = irq_mask();
    queue_add(&tx_queue, (uint32_t)length);
    if (!tx_dma_bytes)
        send_next();
    irq_restore(mask);
    return true;
}

size_t board_serial_receive(uint8_t *bytes, size_t capacity)
{
    size_t count = 0;
    uint32_t head = (RX_RING_BYTES - DMA2->stream[RX_STREAM].NDTR) % RX_RING_BYTES;
    memory_fence();
    while (rx_read_count != head && count < capacity) {
        bytes[count++] = rx_ring[rx_read_count];
        rx_read_count = (rx_read_count + 1) % RX_RING_BYTES;
    }
    return count;
}

void uart_set_rate(uint32_t baud)
{
    UART->BRR = (PCLK2_HZ + baud / 2u) / baud;
}

bool uart_is_sent(void)
{
    return queue_filled(&tx_queue) == 0;
}
