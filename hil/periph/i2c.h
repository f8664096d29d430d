/* I2C1 (RM0090 27) as a 7-bit master on PB6 SCL and PB7 SDA (alternate function 4), with one slave
 * and a pull-up on each line.
 *
 * Bytes take nine periods of SCL: 2 CCR of PCLK1 in standard mode, 3 CCR or 25 CCR in fast mode.
 * The master holds SCL low while SB, ADDR or BTF wait for the program, as hardware does. BUSY is
 * set by a low line and cleared by a stop condition, a software reset or a reset of the peripheral,
 * but not by a line that returns high while SCL is low. While the pins are not in I2C mode, I2C1
 * ignores them. Transfers are modelled byte by byte: the acknowledge at the end of a byte depends
 * on the bit ACK at that time (with POS: at the end of the previous byte). If SDA is held low,
 * arbitration is lost at the first 1 that is sent. When the program drives the pins as outputs, the
 * slave receives clocks, starts and stops, but no bytes. In addition to registers.def, 10-bit
 * addresses and changes of settings that hardware would ignore are refused. This chip has no
 * FLTR. */
#ifndef MATRIG_HIL_I2C_H
#define MATRIG_HIL_I2C_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

enum hil_i2c_phase {
    HIL_I2C_IDLE,
    HIL_I2C_STARTING, /* start condition in progress */
    HIL_I2C_STARTED,  /* SB: waiting for the address */
    HIL_I2C_ADDRESSING,
    HIL_I2C_ADDRESSED, /* ADDR: waiting for reads of SR1 and SR2 */
    HIL_I2C_SENDING,
    HIL_I2C_SENT, /* waiting for a byte, a stop or a start */
    HIL_I2C_RECEIVING,
    HIL_I2C_RECEIVER_FULL,    /* DR and the shift register contain a byte each */
    HIL_I2C_NOT_ACKNOWLEDGED, /* the slave did not acknowledge */
    HIL_I2C_STOPPING,
};

struct hil_i2c {
    HIL_NAMED_WORDS(word, cr1, cr2, oar1, oar2, dr, sr1, sr2, ccr, trise);
    enum hil_i2c_phase phase;
    bool is_master, is_transmitter, is_busy;
    /* SR1 was read, the first step of the sequences that clear SB, ADDR and BTF */
    bool is_sr1_read;
    bool is_dr_full; /* DR contains a byte to be sent */
    uint8_t shifted_byte;
    bool acknowledges_next_byte; /* with POS: the next byte will be acknowledged */
    uint64_t phase_begin_cycle, phase_end_cycle;
    bool scl_level, sda_level; /* levels at the last check */
};

/* Faults of a slave on the bus lines, apart from its bytes. */
struct hil_i2c_bus_faults {
    bool is_sda_stuck; /* SDA is held low permanently */
    unsigned
        /* number of clocks until the slave, interrupted within a byte, releases SDA */
        clocks_until_release;
    uint64_t stretch_ps;  /* time for which the slave holds SCL low at the next byte */
    bool has_false_error; /* I2C1 reports a false bus error in the next byte (ES0182) */
};

/* The slave on the bus. */
struct hil_i2c_slave {
    void *context;
    /* called at a start condition and the byte after it; returns true if acknowledged */
    bool (*address)(void *context, uint8_t byte);
    /* called for a byte from the master; returns true if acknowledged */
    bool (*write)(void *context, uint8_t byte);
    /* returns the next byte; 0xff if the slave is not being read */
    uint8_t (*read)(void *context);
    void (*stop)(void *context);
    /* returns true if the slave is addressed and responds */
    bool (*is_driving)(const void *context);
    struct hil_i2c_bus_faults *bus_faults;
};

struct hil_i2c_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_i2c *state;
    struct hil_i2c_slave slave;
};

/* Call at a reset of the chip or of the peripheral, and for SWRST. In all functions with a
 * parameter `device`, it is a struct hil_i2c_device. */
void hil_i2c_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(i2c)
void hil_i2c_event(void *device, uint64_t at);
/* Call when a pin of port B or the slave's effect on it may have changed; `device` is a struct
 * hil_i2c_device. */
void hil_i2c_on_lines_changed(void *device, uint64_t at);

#endif
