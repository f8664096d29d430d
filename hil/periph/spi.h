/* SPI2 (RM0090 28) as an 8-bit master with a memory on PB13 SCK, PB14 MISO and PB15 MOSI. Chip
 * select PB12 is driven by software; DMA1 streams 3 (receive) and 4 (send) are used.
 *
 * A byte takes eight periods of PCLK1 / 2^(BR+1). While the three pins are not in SPI2 mode, the
 * memory receives no clock, and SPI2 receives 0xff. In addition to registers.def, I2S and changes
 * of settings during a transfer are refused. */
#ifndef MATRIG_HIL_SPI_H
#define MATRIG_HIL_SPI_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

struct hil_spi {
    /* SR contains only RXNE and OVR; the other bits follow from the state. DR: the received
     * byte. */
    HIL_NAMED_WORDS(word, cr1, cr2, sr, dr);
    /* DR was read, the first step of the sequence that clears OVR */
    bool is_dr_read;
    /* the transmit buffer has a byte; the shift register has a byte */
    bool is_buffer_full, is_shifting;
    uint8_t buffered_byte, shifted_byte;
    uint64_t shift_end_cycle;
    bool is_selected;    /* PB12 was low at the last check */
    bool has_byte_begun; /* a byte has begun since the selection */
    bool is_dr_floating; /* the byte in DR was received while MISO floated */
};

/* The chip connected to the pins. */
struct hil_spi_slave {
    void *context;
    /* Called at the falling edge of chip select, at its rising edge (in_byte: not on a byte
     * boundary), and for each byte exchanged in between. */
    void (*select)(void *context, uint64_t at);
    void (*deselect)(void *context, uint64_t at, bool in_byte);
    uint8_t (*exchange)(void *context, uint8_t in, uint64_t at);
    /* returns true if the chip drove MISO in the last byte */
    bool (*is_driving)(const void *context);
};

struct hil_spi_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_spi *state;
    struct hil_spi_slave slave;
};

/* Period of SCK with the present CR1. */
double hil_spi_clock_period_ns(const struct hil_spi_device *dev);

/* In the functions below, `device` is a struct hil_spi_device. */
void hil_spi_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(spi)
/* Updates the transfer up to `at`. */
void hil_spi_advance(void *device, uint64_t at);
/* Call when a stream of DMA1 was enabled, for which SPI2 may have been waiting. */
void hil_spi_on_dma_enabled(void *device);
/* Call when a pin of port B may have changed. */
void hil_spi_on_pins_changed(void *device, uint64_t at);

#endif
