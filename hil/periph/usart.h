/* USART1 (RM0090 30), 8N1, 8E1 and 8O1, with DMA both ways; the line's other end is a function
 * call.
 *
 * Bytes leave back to back at the programmed rate. Where the rates differ by more than 3 %, or the
 * parity, each byte arrives as 0 with a framing error, and what leaves is counted; what
 * leaves while PA9 is not USART1_TX is lost. Bytes that arrive are spaced at the other end's rate,
 * and PA10 shows their bits. */
#ifndef MATRIG_HIL_USART_H
#define MATRIG_HIL_USART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/wire.h"

#define HIL_USART_QUEUE 4096u
#define HIL_USART_GROUP 32u /* bytes that one event may send under DMA */

struct hil_usart {
    /* DR: what was received; the parity bit is bit 8 */
    HIL_WORDS(word, sr, dr, brr, cr1, cr2, cr3);
    bool sr_was_read; /* half of the sequences that clear TC, IDLE, ORE */
    /* sending */
    bool holding, shifting; /* a byte in DR; in the shift register */
    uint8_t held, shifted;
    uint64_t shift_end_cycle;
    uint8_t out[HIL_USART_GROUP + 2];
    uint32_t out_count;
    /* receiving */
    uint64_t listens_since_ps; /* a frame that began before is not seen */
    uint32_t queue_head, queue_count;
    bool delayed;      /* the next byte has had its delay */
    bool idle_follows; /* the next event is the idle line after the last byte */
    uint8_t queue[HIL_USART_QUEUE];
};

struct hil_usart_device {
    HIL_NEIGHBOURS;
    struct hil_usart *state;
    struct hil_wire wire;
};

/* Bytes from the other end, back to back at its rate after those given before. MR_FULL: room for
 * HIL_USART_QUEUE, rest dropped. */
enum mr_status hil_usart_inject(struct hil_usart_device *dev, const uint8_t *bytes, size_t n);
/* Bytes that hil_usart_inject takes now. */
size_t hil_usart_room(const struct hil_usart_device *dev);

/* For the bus, the event queue, DMA and the pins; `device` is a struct hil_usart_device. */
void hil_usart_reset(void *device, unsigned unit);
HIL_ON_BUS(usart)
void hil_usart_rx_event(void *device, uint64_t at);
/* Bring what has been sent up to `at`. */
void hil_usart_catch_up(void *device, uint64_t at);
/* Level of the line into PA10 now. */
bool hil_usart_line_in(const void *device, unsigned channel, bool *drives);
/* A stream of DMA2 was enabled: it may be the one that waited. */
void hil_usart_dma_enabled(void *device);

#endif
