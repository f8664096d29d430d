/* SPI2 (RM0090 28) as an 8-bit master with a memory on PB13 SCK, PB14 MISO, PB15 MOSI, chip select
 * PB12 driven by software, DMA1 streams 3 (receive) and 4 (send).
 *
 * A byte takes eight periods of PCLK1 / 2^(BR+1). While the three pins are not SPI2's, the memory
 * sees no clock and 0xff is received. Refused beside registers.def: I2S, a change of settings in
 * mid transfer. */
#ifndef MATRIG_HIL_SPI_H
#define MATRIG_HIL_SPI_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

struct hil_spi {
    /* Of SR only RXNE, OVR; the rest follows from the state. DR: the byte received. */
    HIL_WORDS(word, cr1, cr2, sr, dr);
    bool dr_was_read;       /* first half of what clears OVR */
    bool holding, shifting; /* a byte in the transmit buffer; in the shift register */
    uint8_t held, shifted;
    uint64_t shift_end_cycle;
    bool selected; /* PB12 low as last seen */
    bool clocked;  /* a byte has begun since */
    bool floating; /* DR was received while nothing held MISO */
};

/* The chip behind the wires. */
struct hil_spi_slave {
    void *who;
    /* Chip select falls, rises (in_byte: not on a byte boundary); one byte in and out meanwhile. */
    void (*select)(void *who, uint64_t at);
    void (*deselect)(void *who, uint64_t at, bool in_byte);
    uint8_t (*exchange)(void *who, uint8_t in, uint64_t at);
    bool (*speaks)(const void *who); /* it drove MISO in the byte that was exchanged last */
};

struct hil_spi_device {
    HIL_NEIGHBOURS;
    struct hil_spi *state;
    struct hil_spi_slave slave;
};

/* Of SCK, by the present CR1. */
double hil_spi_period_ns(const struct hil_spi_device *dev);

/* For the bus, the event queue, DMA and the pins; `device` is a struct hil_spi_device. */
void hil_spi_reset(void *device, unsigned unit);
HIL_ON_BUS(spi)
/* Bring what has been shifted up to `at`. */
void hil_spi_catch_up(void *device, uint64_t at);
/* A stream of DMA1 was enabled: it may be the one that waited. */
void hil_spi_dma_enabled(void *device);
/* A pin of port B may have changed. */
void hil_spi_pins_changed(void *device, uint64_t at);

#endif
