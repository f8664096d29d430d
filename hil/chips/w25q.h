/* W25Q128JV serial NOR memory (Winbond data sheet rev. F): 16 MiB, a slave of SPI
 * (hil/periph/spi.h).
 *
 * Commands: write enable (06), status (05), page program (02), erase of 4 KiB (20), read (03),
 * power-down and release (B9 AB), identification (9F), reset (66 99). The others of the data sheet
 * stop the run as not modelled. While BUSY, all but status reads and reset are ignored.
 *
 * Programming turns ones into zeroes and wraps inside its page of 256 bytes. Times are drawn
 * between typical and maximum (hil/periph/flash.h). Commands act when the chip is deselected on a
 * byte boundary; else they do not act. The content survives resets and power cuts; an operation
 * that a power cut (or 66 99) ends early leaves its cells half changed. */
#ifndef MATRIG_HIL_W25Q_H
#define MATRIG_HIL_W25Q_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/spi.h"

struct hil_rules_device;

/* What its next command is measured from. */
struct hil_w25q_past {
    uint8_t before;    /* the command before, 0: none since power came */
    uint8_t rests;     /* a command that was carried out and wants to be left alone, 0: none */
    uint64_t power_ps; /* when power came */
};

struct hil_core;
struct hil_options;

#define HIL_NOR_SIZE   0x01000000u
#define HIL_NOR_SECTOR 4096u
#define HIL_NOR_PAGE   256u

struct hil_w25q {
    uint8_t status;
    bool powered_down, reset_enabled;
    /* the command that is shifted in */
    bool selected;
    uint8_t command;
    bool spoke; /* it drove its output in the byte that was exchanged last */
    struct hil_w25q_past past;
    uint32_t count; /* bytes since the chip was selected */
    uint32_t address;
    uint8_t page[HIL_NOR_PAGE];
    uint8_t in_page[HIL_NOR_PAGE / 8u]; /* which bytes of it were shifted in */
    uint32_t page_count;
    /* the operation in progress */
    uint8_t operation;     /* its command, 0: none */
    uint32_t first, bytes; /* cells concerned */
    uint64_t begin_ps, end_ps;
    /* over all */
    uint64_t operations; /* programs and erases begun since creation */
    uint64_t random;
    bool dead, fails_silently; /* by the fault script: the chip; the operation in progress */
    /* sectors that are not all erased (or were not) */
    uint8_t used[HIL_NOR_SIZE / HIL_NOR_SECTOR / 8u];
};

/* What a fault script orders of the chip: it carries out `fill_requested` and clears it, and
 * decrements the counts as it fails. */
struct hil_nor_orders {
    /* it does not drive its output: all ones are read, commands go nowhere */
    bool dead;
    bool fill_requested;   /* every byte is to be programmed with zeroes */
    uint32_t fail_program; /* so many page programs from now on change nothing */
    uint32_t fail_erase;
};

struct hil_w25q_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_w25q *state;
    struct hil_nor_orders *orders;
    struct hil_rules_device *rules; /* which the master is held to */
    const struct hil_spi_device *spi;
    uint8_t *cells;        /* HIL_NOR_SIZE, inverted: an erased chip is memory never touched */
    struct hil_call began; /* a program or erase has begun */
};

/* Its events and its state; to be connected: what hil_w25q_slave gives. */
void hil_w25q_create(struct hil_w25q_device *dev);
struct hil_spi_slave hil_w25q_slave(struct hil_w25q_device *dev);
void hil_w25q_power_lost(struct hil_w25q_device *dev);
void hil_w25q_power_back(struct hil_w25q_device *dev);

/* The cells as they are. MR_UNKNOWN: outside. */
enum mr_status hil_w25q_peek(const struct hil_w25q_device *dev, uint32_t address, void *out,
                             size_t n);
enum mr_status hil_w25q_poke(struct hil_w25q_device *dev, uint32_t address, const void *bytes,
                             size_t n);

#endif
