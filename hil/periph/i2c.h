/* I2C1 (RM0090 27) as a 7-bit master on PB6 SCL, PB7 SDA (alternate function 4), with one slave
 * behind it and a pull-up on each line.
 *
 * Bytes take nine periods of SCL: 2 CCR of PCLK1 in standard mode, 3 CCR or 25 CCR in fast mode.
 * The master holds SCL low while SB, ADDR or BTF wait for the program, as hardware does. BUSY is
 * set by a line that is low and cleared by a stop condition, a software reset or a reset of the
 * peripheral: not by a line that merely comes back while SCL is low. While the pins are not I2C1's
 * it sees nothing. A byte at a time: the acknowledge that ends a byte follows ACK at that time
 * (POS: ACK at the end of the byte before); a line that is held low loses the arbitration of the
 * first 1 sent. What the program does to the pins as outputs is seen by the chip behind them as
 * clocks, starts and stops, not as bytes. Refused beside registers.def: 10-bit addresses, and
 * changes of settings that hardware would ignore. FLTR is not in this chip. */
#ifndef MATRIG_HIL_I2C_H
#define MATRIG_HIL_I2C_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

enum hil_i2c_phase {
    HIL_I2C_IDLE,
    HIL_I2C_STARTING, /* start condition on its way */
    HIL_I2C_STARTED,  /* SB: waits for the address */
    HIL_I2C_ADDRESSING,
    HIL_I2C_ADDRESSED, /* ADDR: waits for SR1, SR2 to be read */
    HIL_I2C_SENDING,
    HIL_I2C_SENT, /* waits for a byte, a stop or a start */
    HIL_I2C_RECEIVING,
    HIL_I2C_FULL,    /* DR and shift register hold a byte each */
    HIL_I2C_REFUSED, /* not acknowledged */
    HIL_I2C_STOPPING,
};

struct hil_i2c {
    HIL_WORDS(word, cr1, cr2, oar1, oar2, dr, sr1, sr2, ccr, trise);
    enum hil_i2c_phase phase;
    bool master, transmits, busy;
    bool sr1_was_read; /* first half of what clears SB, ADDR, BTF */
    bool held;         /* DR holds a byte to be sent */
    uint8_t shifted;
    bool acknowledge; /* POS: of the byte that is coming */
    uint64_t begin_cycle, end_cycle;
    bool scl, sda; /* as last seen */
};

/* What a slave does to the lines beside its bytes. */
struct hil_i2c_hold {
    bool stuck;           /* it holds SDA low for good, */
    unsigned hung_clocks; /* or, left within a byte, until it has seen so many */
    uint64_t stretch_ps;  /* it holds SCL low for so long at the next byte */
    bool disturbed;       /* a bus error is seen in the next byte, where there is none (ES0182) */
};

/* The slave on the bus. */
struct hil_i2c_slave {
    void *who;
    /* a start condition and the byte behind it; true: acknowledged */
    bool (*address)(void *who, uint8_t byte);
    bool (*write)(void *who, uint8_t byte); /* true: acknowledged */
    /* the next byte; 0xff when it is not the slave that is read */
    uint8_t (*read)(void *who);
    void (*stop)(void *who);
    bool (*speaks)(const void *who); /* it is addressed, and answers */
    struct hil_i2c_hold *hold;
};

struct hil_i2c_device {
    HIL_NEIGHBOURS;
    struct hil_i2c *state;
    struct hil_i2c_slave slave;
};

/* Reset of the chip, of the peripheral, or SWRST. For the bus and the event queue, `device` is a
 * struct hil_i2c_device. */
void hil_i2c_reset(void *device, unsigned unit);
HIL_ON_BUS(i2c)
void hil_i2c_event(void *device, uint64_t at);
/* A pin of port B, or what the slave does to it, may have changed; `device` is a struct
 * hil_i2c_device. */
void hil_i2c_lines_changed(void *device, uint64_t at);

#endif
