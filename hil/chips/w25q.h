/* W25Q128JV serial NOR memory (Winbond data sheet rev. F): 16 MiB, a slave of SPI
 * (hil/periph/spi.h).
 *
 * Commands: write enable (06), status (05), page program (02), erase of 4 KiB (20), read (03),
 * power-down and release (B9 AB), identification (9F), reset (66 99). Other commands of the data
 * sheet stop the run as not modelled. While BUSY, only status reads and reset are executed.
 *
 * Programming turns ones into zeroes and wraps inside its page of 256 bytes. Times are drawn
 * between typical and maximum (hil/periph/flash.h). A command takes effect only when the chip is
 * deselected on a byte boundary. The content survives resets and power failures. An operation that
 * is interrupted by a power failure (or by 66 99) leaves its cells partly changed. */
#ifndef MATRIG_HIL_W25Q_H
#define MATRIG_HIL_W25Q_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/spi.h"

struct hil_rules_device;

/* Times of earlier events, from which the rules measure the time to the next command. */
struct hil_w25q_times {
    uint8_t previous_command; /* previous command; 0: none since power on */
    uint8_t pause_command;    /* executed command that must be followed by a pause; 0: none */
    uint64_t power_on_ps;     /* time of power on */
};

struct hil_core;
struct hil_options;

#define HIL_NOR_SIZE         0x01000000u
#define HIL_NOR_SECTOR_BYTES 4096u
#define HIL_NOR_PAGE_BYTES   256u

struct hil_w25q {
    uint8_t status;
    bool is_powered_down, is_reset_enabled;
    /* state of the command being shifted in */
    bool is_selected;
    uint8_t command;
    bool has_driven_output; /* the chip drove its output in the last byte */
    struct hil_w25q_times times;
    uint32_t byte_count; /* number of bytes since the chip was selected */
    uint32_t address;
    uint8_t page_buffer[HIL_NOR_PAGE_BYTES];
    /* bit mask of the bytes of the page that were shifted in */
    uint8_t page_mask[HIL_NOR_PAGE_BYTES / 8u];
    uint32_t page_byte_count;
    /* the program or erase in progress */
    uint8_t operation_command;       /* its command; 0: none */
    uint32_t first_cell, cell_count; /* cells being changed */
    /* operation_end_ps HIL_NEVER: the operation lasts until a reset */
    uint64_t operation_begin_ps, operation_end_ps;
    /* totals */
    uint64_t operation_count; /* number of programs and erases begun since creation */
    uint64_t random_state;
    /* Set by the fault script. is_dead: the chip does not respond; is_always_busy: the chip is
     * busy, even after a reset; is_operation_failing: the operation in progress changes nothing. */
    bool is_dead, is_always_busy, is_operation_failing;
    /* sectors that may contain bytes other than 0xff */
    uint8_t used_sectors[HIL_NOR_SIZE / HIL_NOR_SECTOR_BYTES / 8u];
};

/* Requests of a fault script to the chip. The chip executes and then clears `is_fill_requested`; it
 * decrements a count at each failure. */
struct hil_nor_fault_requests {
    /* the chip does not drive its output, so reads give ones, and ignores commands */
    bool is_dead;
    bool is_always_busy;            /* always busy, also after its reset command */
    bool is_fill_requested;         /* program every byte with zeroes */
    uint32_t failing_program_count; /* number of following page programs that change nothing */
    uint32_t failing_erase_count;
    uint32_t
        /* number of following programs and erases that do not end until a reset */
        hanging_operation_count;
};

struct hil_w25q_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_w25q *state;
    struct hil_nor_fault_requests *fault_requests;
    struct hil_rules_device *rules; /* rules that are checked for the master */
    const struct hil_spi_device *spi;
    uint8_t
        *inverted_cells; /* HIL_NOR_SIZE bytes, inverted, so that an erased chip needs no memory */
    struct hil_callback on_operation_begin; /* called when a program or erase has begun */
};

/* Initialises events and state. Connect the result of hil_w25q_slave afterwards. */
void hil_w25q_create(struct hil_w25q_device *dev);
struct hil_spi_slave hil_w25q_slave(struct hil_w25q_device *dev);
void hil_w25q_power_off(struct hil_w25q_device *dev);
void hil_w25q_power_on(struct hil_w25q_device *dev);

/* Read and write the cells directly. MR_UNKNOWN: out of range. */
enum mr_status hil_w25q_peek(const struct hil_w25q_device *dev, uint32_t address, void *out,
                             size_t n);
enum mr_status hil_w25q_poke(struct hil_w25q_device *dev, uint32_t address, const void *bytes,
                             size_t n);

#endif
