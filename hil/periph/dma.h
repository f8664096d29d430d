/* DMA1 and DMA2 (RM0090 10), direct mode between a peripheral and memory.
 *
 * Peripherals that have data or room call hil_dma_write_items / hil_dma_read_items with as many
 * items as moved at that moment; half-transfer and transfer-complete flags rise then. A peripheral
 * that moves several items in one event must not step over a flag: hil_dma_until_flag returns the
 * number of items to the next. CCM is out of reach: transfer error. */
#ifndef MATRIG_HIL_DMA_H
#define MATRIG_HIL_DMA_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

struct hil_dma_stream {
    HIL_WORDS(word, cr, ndtr, par, m0ar, m1ar, fcr);
    uint32_t reload; /* NDTR when it was enabled */
};

struct hil_dma {
    uint32_t isr[2]; /* LISR, HISR */
    struct hil_dma_stream stream[8];
    bool waits_for_flash; /* a read of flash holds its memory port, and so all its streams */
};

struct hil_dma_request {
    unsigned controller; /* 0: DMA1, 1: DMA2 */
    unsigned stream;
    unsigned channel;
    uint32_t peripheral; /* address that PAR must hold */
    bool from_memory;
};

/* A peripheral behind a controller. `catch_up`: bring what it has moved up to this cycle;
 * `enabled`: a stream was enabled, it may be the one that waited. NULL: it has no use for it. */
struct hil_dma_client {
    void *who;
    void (*catch_up)(void *who, uint64_t at);
    void (*enabled)(void *who);
};

#define HIL_DMA_CLIENTS 2u

struct hil_dma_device {
    HIL_NEIGHBOURS;
    struct hil_dma *state; /* of both */
    /* of each controller, in the order in which they catch up */
    struct hil_dma_client client[2][HIL_DMA_CLIENTS];
};

/* For the bus; `device` is a struct hil_dma_device. */
void hil_dma_reset(void *device, unsigned unit);
HIL_ON_BUS(dma)

/* Flash can be read again; `device` is a struct hil_dma_device. */
void hil_dma_flash_ready(void *device);

/* Items the stream would move now without stopping or raising a flag before the last of them; 0
 * while it does not serve this request (off, other channel or direction). A wrong PAR stops the
 * run. */
uint32_t hil_dma_until_flag(struct hil_dma_device *dev, const struct hil_dma_request *request);
/* Move n items, 1 <= n <= hil_dma_until_flag. Values are in the low bits of 16-bit words; a stream
 * of bytes takes the low byte. Reading returns false when the memory is out of reach: transfer
 * error, nothing moved. */
void hil_dma_write_items(struct hil_dma_device *dev, const struct hil_dma_request *request,
                         const uint16_t *values, uint32_t n);
bool hil_dma_read_items(struct hil_dma_device *dev, const struct hil_dma_request *request,
                        uint8_t *values, uint32_t n);
/* One item of a 32-bit peripheral register (capture), read through the bus with its side
 * effects. */
void hil_dma_request(struct hil_dma_device *dev, unsigned controller, unsigned stream,
                     unsigned channel);

#endif
