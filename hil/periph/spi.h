/* SPI2 (RM0090 28) as an 8-bit master with the NOR memory (hil/chips/w25q.h) on PB13 SCK, PB14 MISO, PB15 MOSI, chip select
 * PB12 driven by software, DMA1 streams 3 (receive) and 4 (send).
 *
 * A byte takes eight periods of PCLK1 / 2^(BR+1). While the three pins are not SPI2's, the memory sees no clock and
 * 0xff is received. With CPOL unlike CPHA the memory samples a clock edge off and each byte arrives shifted by a bit.
 * Refused: slave, NSS by hardware, 16 bits, one-line modes, CRC, TI mode, I2S, a change of settings in mid transfer. */
#ifndef MATRIG_HIL_SPI_H
#define MATRIG_HIL_SPI_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

struct hil_spi {
    uint32_t cr1, cr2, sr;      /* of SR only RXNE, MODF, OVR; the rest follows from the state */
    bool dr_was_read;           /* first half of what clears OVR */
    bool sr_was_accessed;       /* first half of what clears MODF */
    bool holding, shifting;     /* a byte in the transmit buffer; in the shift register */
    uint8_t held, shifted, received;
    uint8_t last_out, last_in;  /* the bytes before, for the wrong clock mode */
    uint64_t shift_end_cycle;
    bool selected;              /* PB12 low as last seen */
};

void hil_spi_reset(struct hil_board *board);
uint32_t hil_spi_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_spi_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
void hil_spi_event(struct hil_board *board, uint64_t at);
/* Bring what has been shifted up to `at`. */
void hil_spi_catch_up(struct hil_board *board, uint64_t at);
/* A stream of DMA1 was enabled: it may be the one that waited. */
void hil_spi_dma_enabled(struct hil_board *board);
/* A pin of port B may have changed. */
void hil_spi_pins_changed(struct hil_board *board, uint64_t at);

#endif
