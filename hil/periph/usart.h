/* USART1 (RM0090 30), 8N1, 8E1 and 8O1, with DMA both ways; the line's other end is a function call.
 *
 * Bytes leave back to back at the programmed rate. Where the rates differ by
 * more than 3 %, or the parity, each byte is heard as hil/periph/serial_line.h says, and what leaves is counted;
 * what leaves while PA9 is not USART1_TX is lost. Bytes that arrive are spaced at the other end's rate, and
 * PA10 shows their bits. */
#ifndef MATRIG_HIL_USART_H
#define MATRIG_HIL_USART_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

#define HIL_USART_QUEUE 4096u
#define HIL_USART_GROUP 32u /* bytes that one event may send under DMA */

struct hil_usart {
    uint32_t sr, brr, cr1, cr2, cr3;
    bool sr_was_read; /* half of the sequences that clear TC, IDLE, ORE */
    /* sending */
    bool holding, shifting;   /* a byte in DR; in the shift register */
    uint8_t held, shifted;
    uint64_t shift_end_cycle;
    uint8_t out[HIL_USART_GROUP + 2];
    uint32_t out_count;
    /* receiving */
    uint16_t received;        /* the parity bit is bit 8 */
    uint64_t listens_since_ps; /* a frame that began before is not seen */
    uint32_t queue_head, queue_count;
    bool delayed;             /* the next byte has had its delay */
    bool idle_follows;        /* the next event is the idle line after the last byte */
    uint8_t queue[HIL_USART_QUEUE];
};

void hil_usart_reset(struct hil_board *board);
uint32_t hil_usart_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_usart_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
void hil_usart_tx_event(struct hil_board *board, uint64_t at);
void hil_usart_rx_event(struct hil_board *board, uint64_t at);
/* Bring what has been sent up to `at`. */
void hil_usart_catch_up(struct hil_board *board, uint64_t at);
/* Level of the line into PA10 now. */
bool hil_usart_line_in(const struct hil_board *board);
/* A stream of DMA2 was enabled: it may be the one that waited. */
void hil_usart_dma_enabled(struct hil_board *board);

#endif
