/* W25Q128JV serial NOR memory (Winbond data sheet rev. F): 16 MiB, a slave of SPI
 * (hil/periph/spi.h).
 *
 * Commands: write enable (06, 50, 04), status registers 1 to 3 (05 35 15, 01 31 11), page program
 * (02), erase of 4, 32, 64 KiB and all (20 52 D8 C7 60), read (03), fast read (0B), power-down and
 * release (B9 AB), identification (9F 90 AB), unique id (4B), reset (66 99). The others of the data
 * sheet (dual and quad, suspend, security registers, individual locks, SFDP) stop the run as not
 * modelled. While BUSY, all but status reads and reset are ignored.
 *
 * Programming turns ones into zeroes and wraps inside its page of 256 bytes. Times are drawn
 * between typical and maximum (hil/periph/cells.h). Commands act when the chip is deselected on a
 * byte boundary; else they do not act. A command on a protected place is ignored and leaves WEL
 * set. The content survives resets and power cuts; an operation that a power cut (or 66 99) ends
 * early leaves its cells half changed. */
#ifndef MATRIG_HIL_W25Q_H
#define MATRIG_HIL_W25Q_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/spi.h"

/* ---- w25q_rules ---- */

/* What the W25Q128JV demands of its master: its rows of hil/periph/rules.def. */

struct hil_rules_device;

/* What its next command is measured from. */
struct hil_w25q_past {
    uint8_t before;    /* the command before, 0: none since power came */
    uint8_t rests;     /* a command that was carried out and wants to be left alone, 0: none */
    uint64_t power_ps; /* when power came */
};

/* A command's first byte is there: only now is it known what its select had to keep. */
void hil_w25q_hold_rules(struct hil_rules_device *rules, const struct hil_w25q_past *past,
                         uint8_t command, double clock_period_ns);

/* ---- w25q ---- */

struct hil_core;
struct hil_options;
struct hil_spi_device;

#define HIL_NOR_SIZE   0x01000000u
#define HIL_NOR_SECTOR 4096u
#define HIL_NOR_PAGE   256u

/* What goes wrong, as bits. */
enum hil_w25q_fault {
    /* BUSY for ten times the maximum, then half of the bits are programmed */
    HIL_W25Q_PROGRAM_ERROR = 1,
    HIL_W25Q_ERASE_ERROR = 2,    /* likewise */
    HIL_W25Q_READ_ERROR = 4,     /* of 64 bytes read one has a wrong bit, at random */
    HIL_W25Q_PROGRAM_SILENT = 8, /* seems to work, changes nothing */
    HIL_W25Q_ERASE_SILENT = 16,
    HIL_W25Q_DEAD = 32, /* nothing answers: 0xff */
};

struct hil_w25q_faults {
    unsigned kinds;
    /* addresses concerned, [from, to); an operation that touches them is concerned */
    uint32_t from, to;
};

struct hil_w25q {
    uint8_t status[3];
    uint8_t written_status[3]; /* what an ongoing status write puts there */
    bool volatile_enabled;     /* 50h: the next status write does not last */
    uint8_t lasting_status[3]; /* what a power cut comes back to */
    bool powered_down, reset_enabled;
    /* the command that is shifted in */
    bool selected;
    uint8_t command;
    bool spoke; /* it drove its output in the byte that was exchanged last */
    struct hil_w25q_past past;
    uint32_t count; /* bytes since the chip was selected */
    uint32_t address;
    uint8_t parameter[2];
    uint8_t page[HIL_NOR_PAGE];
    uint8_t in_page[HIL_NOR_PAGE / 8u]; /* which bytes of it were shifted in */
    uint32_t page_count;
    /* the operation in progress */
    uint8_t operation;     /* its command, 0: none */
    uint32_t first, bytes; /* cells concerned */
    uint64_t begin_ps, end_ps;
    /* over all */
    uint64_t operations; /* programs, erases and status writes begun since creation */
    uint64_t cut_at;
    unsigned cut_permille;
    uint64_t random;
    struct hil_w25q_faults faults;
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
    struct hil_call cut;   /* the supply goes: what hil_w25q_cut_at ordered */
};

/* Its events and its state; to be connected: what hil_w25q_slave gives. */
void hil_w25q_create(struct hil_w25q_device *dev);
struct hil_spi_slave hil_w25q_slave(struct hil_w25q_device *dev);
void hil_w25q_power_lost(struct hil_w25q_device *dev);
void hil_w25q_power_back(struct hil_w25q_device *dev);

void hil_w25q_set_faults(struct hil_w25q_device *dev, const struct hil_w25q_faults *faults);
/* Cut the power in the n-th operation from now (1: the next; 0: no longer), permille (0..999) of
 * its time after it began. */
void hil_w25q_cut_at(struct hil_w25q_device *dev, uint64_t n, unsigned permille);
/* The cells as they are. MR_UNKNOWN: outside. */
enum mr_status hil_w25q_peek(const struct hil_w25q_device *dev, uint32_t address, void *out,
                             size_t n);
enum mr_status hil_w25q_poke(struct hil_w25q_device *dev, uint32_t address, const void *bytes,
                             size_t n);

/* ---- w25q_commands ---- */

/* Commands of the W25Q128JV that are modelled: data sheet rev. F, 8.1.2. */

enum command {
    WRITE_STATUS_1 = 0x01,
    PAGE_PROGRAM = 0x02,
    READ = 0x03,
    WRITE_DISABLE = 0x04,
    READ_STATUS_1 = 0x05,
    WRITE_ENABLE = 0x06,
    FAST_READ = 0x0b,
    WRITE_STATUS_3 = 0x11,
    READ_STATUS_3 = 0x15,
    ERASE_4K = 0x20,
    WRITE_STATUS_2 = 0x31,
    READ_STATUS_2 = 0x35,
    UNIQUE_ID = 0x4b,
    VOLATILE_ENABLE = 0x50,
    ERASE_32K = 0x52,
    ERASE_ALL_60 = 0x60,
    ENABLE_RESET = 0x66,
    MANUFACTURER_ID = 0x90,
    RESET = 0x99,
    JEDEC_ID = 0x9f,
    RELEASE = 0xab,
    POWER_DOWN = 0xb9,
    ERASE_ALL = 0xc7,
    ERASE_64K = 0xd8,
};

#endif
