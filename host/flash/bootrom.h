/* The boot ROM of an STM32F407 or F446 over a serial line, as AN3155 has it: 8E1, every command
 * with its complement, addresses and data with their XOR, each answered 0x79 (yes) or 0x1F (no).
 *
 * What goes wrong on the line is told from what the chip refuses by asking again: each exchange is
 * tried BOOTROM_TRIES times, and between tries both ends are brought back in step. Nothing waits
 * without a bound. What READ answers has no checksum: who needs to be sure reads twice. */
#ifndef MATRIG_HOST_FLASH_BOOTROM_H
#define MATRIG_HOST_FLASH_BOOTROM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"

#define BOOTROM_TRIES 8u
#define BOOTROM_PAGE  256u   /* bytes in one exchange */
#define BOOTROM_CHIP  0x413u /* STM32F405, 407, 415, 417: AN2606; others: common/boards.def */
#define BOOTROM_BAUD  115200

/* The way to the chip. */
struct bootrom_line {
    void *context;
    const char *name; /* for errors */
    /* MR_OK; else `error` says that the line is gone. */
    enum mr_status (*send)(void *context, const uint8_t *bytes, size_t count, struct error *error);
    /* The next byte. MR_OK; MR_TIMEOUT without setting `error`: none within the time; else `error`
     * says that the line is gone. */
    enum mr_status (*receive)(void *context, uint8_t *byte, unsigned timeout_ms,
                              struct error *error);
};

struct bootrom {
    const struct bootrom_line *line;
    unsigned answer_ms; /* longest wait for an answer; 0: BOOTROM_ANSWER_MS */
    uint16_t wanted;    /* chip that is spoken to, its id; 0: BOOTROM_CHIP */
    uint8_t version;    /* 0x31: version 3.1 */
    uint16_t chip;
    unsigned repeated;       /* exchanges that had to be tried again */
    uint64_t sent, received; /* bytes */
};

#define BOOTROM_ANSWER_MS 1000u
#define BOOTROM_ERASE_MS  8000u /* of one sector; data sheet: at most 4 s for 128 KiB */

/* Gets an answer, whether the ROM has just started or an earlier conversation broke off anywhere,
 * and learns what chip it is. MR_TIMEOUT: nobody answers; MR_VERSION: another chip, or a ROM
 * without the commands needed. */
enum mr_status bootrom_begin(struct bootrom *rom, const struct bootrom_line *line,
                             struct error *error);

/* 1 to BOOTROM_PAGE bytes. MR_NOT_NOW: the chip is read-protected. */
enum mr_status bootrom_read(struct bootrom *rom, uint32_t address, uint8_t *bytes, size_t count,
                            struct error *error);
/* 4 to BOOTROM_PAGE bytes, a multiple of 4, on erased flash. After an answer that did not come the
 * page is looked at before it is written again. MR_WAIT, without setting `error`: the page holds
 * neither what it held nor what it should; erase its sector. */
enum mr_status bootrom_write(struct bootrom *rom, uint32_t address, const uint8_t *bytes,
                             size_t count, struct error *error);
enum mr_status bootrom_erase(struct bootrom *rom, unsigned sector, struct error *error);
/* Start the program whose vectors are at `address`. */
enum mr_status bootrom_go(struct bootrom *rom, uint32_t address, struct error *error);

#endif
