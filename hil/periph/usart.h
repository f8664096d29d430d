/* USART1 (RM0090 30) with 8N1, 8E1 and 8O1 and DMA in both directions. The other end of the line is
 * a function call.
 *
 * Bytes are sent back to back at the programmed rate. If the rates of the two ends differ by more
 * than 3 %, or the parities differ, each byte is received as 0 with a framing error, and the sent
 * bytes are counted. Bytes sent while PA9 is not in USART1_TX mode are lost. Received bytes are
 * spaced at the rate of the other end, and their bits appear on PA10. */
#ifndef MATRIG_HIL_USART_H
#define MATRIG_HIL_USART_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/wire.h"

#define HIL_USART_QUEUE_LENGTH  4096u
#define HIL_USART_DMA_BYTES_MAX 32u /* maximum bytes that one event sends with DMA */

struct hil_usart {
    /* DR: the received byte; bit 8 is the parity bit */
    HIL_NAMED_WORDS(word, sr, dr, brr, cr1, cr2, cr3);
    bool is_sr_read; /* SR was read, the first step of the sequences that clear TC, IDLE and ORE */
    /* sending */
    /* DR contains a byte to be sent; the shift register contains one */
    bool is_dr_full, is_shifting;
    uint8_t buffered_byte, shifted_byte;
    uint64_t shift_end_cycle;
    uint8_t output[HIL_USART_DMA_BYTES_MAX + 2];
    uint32_t output_count;
    /* receiving */
    /* time at which the receiver was switched on; frames that began earlier are not received */
    uint64_t receiver_enabled_ps;
    uint32_t input_queue_head, input_queue_count;
    bool is_delay_over;      /* the delay of the next byte is over */
    bool is_idle_event_next; /* the next event is the idle line after the last byte */
    uint8_t input_queue[HIL_USART_QUEUE_LENGTH];
};

struct hil_usart_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_usart *state;
    struct hil_line_calls line_calls;
};

/* Queues bytes from the other end; they arrive at its rate, directly after the bytes queued before.
 * MR_OK; MR_FULL: more than HIL_USART_QUEUE_LENGTH bytes are waiting, and the rest is dropped. */
enum mr_status hil_usart_inject(struct hil_usart_device *dev, const uint8_t *bytes, size_t n);
/* Number of bytes that hil_usart_inject accepts now. */
size_t hil_usart_free_space(const struct hil_usart_device *dev);

/* In the functions below, `device` is a struct hil_usart_device. */
void hil_usart_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(usart)
void hil_usart_rx_event(void *device, uint64_t at);
/* Updates transmission up to `at`. */
void hil_usart_advance(void *device, uint64_t at);
/* Returns the present level of the line into PA10. */
bool hil_usart_line_in(const void *device, unsigned channel, bool *drives);
/* Call when a stream of DMA2 was enabled, for which USART1 may have been waiting. */
void hil_usart_on_dma_enabled(void *device);

#endif
