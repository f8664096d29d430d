/* I2C1 (RM0090 27) as a 7-bit master on PB6 SCL, PB7 SDA (alternate function 4), with the thermometer (hil/chips/tmp112.h) behind it and a
 * pull-up on each line.
 *
 * Bytes take nine periods of SCL: 2 CCR of PCLK1 in standard mode, 3 CCR or 25 CCR in fast mode. The master holds SCL low while SB, ADDR
 * or BTF wait for the program, as silicon does. BUSY is set by a line that is low and cleared by a stop condition, a software reset
 * or a reset of the peripheral: not by a line that merely comes back while SCL is low. While the pins are not I2C1's it sees nothing.
 * A byte at a time: the acknowledge that ends a byte is what ACK says then (POS: what it said when the byte before ended); a line
 * that is held low loses the arbitration of the first 1 sent. What the program does to the pins as outputs is seen by the chip behind
 * them as clocks, starts and stops, not as bytes.
 * Refused: slave mode, 10-bit addresses, SMBus, PEC, DMA; CR2.FREQ other than PCLK1 or CCR below its least while PE is set; CCR and TRISE written
 * while PE is set; CR1 written while START or STOP waits, but for a software reset; PE cleared in a transfer. FLTR is not in this chip. */
#ifndef MATRIG_HIL_I2C_H
#define MATRIG_HIL_I2C_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

enum hil_i2c_phase {
    HIL_I2C_IDLE,
    HIL_I2C_STARTING,   /* start condition on its way */
    HIL_I2C_STARTED,    /* SB: waits for the address */
    HIL_I2C_ADDRESSING,
    HIL_I2C_ADDRESSED,  /* ADDR: waits for SR1, SR2 to be read */
    HIL_I2C_SENDING,
    HIL_I2C_SENT,       /* waits for a byte, a stop or a start */
    HIL_I2C_RECEIVING,
    HIL_I2C_FULL,       /* DR and shift register hold a byte each */
    HIL_I2C_REFUSED,    /* not acknowledged */
    HIL_I2C_STOPPING,
};

struct hil_i2c {
    uint32_t cr1, cr2, oar1, sr1, ccr, trise;
    enum hil_i2c_phase phase;
    bool master, transmits, busy;
    bool sr1_was_read;         /* first half of what clears SB, ADDR, BTF */
    bool held;                 /* DR holds a byte to be sent */
    uint8_t dr, shifted;
    bool acknowledge;          /* POS: of the byte that is coming */
    uint64_t begin_cycle, end_cycle;
    bool scl, sda;             /* as last seen */
};

/* Reset of the chip, of the peripheral, or SWRST. */
void hil_i2c_reset(struct hil_board *board);
uint32_t hil_i2c_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_i2c_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
void hil_i2c_event(struct hil_board *board, uint64_t at);
/* A pin of port B, or what the thermometer does to it, may have changed. */
void hil_i2c_lines_changed(struct hil_board *board, uint64_t at);

#endif
