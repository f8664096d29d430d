/* DMA1 and DMA2 (RM0090 10), direct mode between a peripheral and memory.
 *
 * Peripherals that have data or room call hil_dma_write_items or hil_dma_read_items with the number
 * of items moved at that time; the half-transfer and transfer-complete flags are set then. A
 * peripheral that moves several items in one event must not skip a flag: hil_dma_items_until_flag
 * returns the number of items up to the next flag. DMA has no access to CCM; an attempt is a
 * transfer error. */
#ifndef MATRIG_HIL_DMA_H
#define MATRIG_HIL_DMA_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

struct hil_dma_stream {
    HIL_NAMED_WORDS(word, cr, ndtr, par, m0ar, m1ar, fcr);
    uint32_t reload_count; /* NDTR at the time the stream was enabled */
};

struct hil_dma {
    uint32_t isr[2]; /* LISR, HISR */
    struct hil_dma_stream stream[8];
    /* a stream waits for a read of flash, which blocks the memory port and therefore all streams of
     * the controller */
    bool is_waiting_for_flash;
};

struct hil_dma_request {
    unsigned controller; /* 0: DMA1, 1: DMA2 */
    unsigned stream;
    unsigned channel;
    uint32_t peripheral_address; /* address that PAR must contain */
    bool is_from_memory;
};

/* A peripheral connected to a controller. `advance`: update the transfers of the peripheral up to
 * this cycle; `on_enabled`: a stream was enabled, for which the peripheral may have been waiting.
 * Both may be NULL. */
struct hil_dma_client {
    void *context;
    void (*advance)(void *context, uint64_t at);
    void (*on_enabled)(void *context);
};

#define HIL_DMA_CLIENTS_MAX 2u

struct hil_dma_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_dma *state; /* both controllers */
    /* clients of each controller, in the order of their `advance` calls */
    struct hil_dma_client client[2][HIL_DMA_CLIENTS_MAX];
};

/* Functions that the bus calls; `device` is a struct hil_dma_device. */
void hil_dma_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(dma)

/* Call when flash can be read again; `device` is a struct hil_dma_device. */
void hil_dma_on_flash_ready(void *device);

/* Number of items that the stream can move now, up to and including the item that raises a flag or
 * ends the transfer. Returns 0 if the stream does not serve this request (it is off, or has a
 * different channel or direction). A wrong PAR stops the run. */
uint32_t hil_dma_items_until_flag(struct hil_dma_device *dev,
                                  const struct hil_dma_request *request);
/* Move n items, 1 <= n <= hil_dma_items_until_flag. Values are in the low bits of 16-bit words; a
 * stream of bytes uses the low byte. hil_dma_read_items returns false if the memory is not
 * accessible: transfer error, and nothing is moved. */
void hil_dma_write_items(struct hil_dma_device *dev, const struct hil_dma_request *request,
                         const uint16_t *values, uint32_t n);
bool hil_dma_read_items(struct hil_dma_device *dev, const struct hil_dma_request *request,
                        uint8_t *values, uint32_t n);
/* Moves one item from a 32-bit peripheral register (capture), which is read through the bus with
 * its side effects. */
void hil_dma_move_register(struct hil_dma_device *dev, unsigned controller, unsigned stream,
                           unsigned channel);

#endif
