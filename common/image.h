/* The header of a firmware image identifies the image and shows whether it is complete. It is at a
 * fixed address in flash, directly after the vectors, in the sector that is programmed last. The
 * .elf, .hex and .bin files therefore contain it too. firmware/stamp/stamp.c writes it after
 * linking.
 *
 *     0x08000200  u32  magic, the bytes "MRIG"
 *             +4  u16  format of this header, 1; u16 bytes of this header, 36
 *             +8  u32  first address of the program, u32 the address after its last byte
 *            +16  u32  CRC-32 of the program (common/crc32.h)
 *            +20  u8   major, minor, patch of the version; u8 1: the sources differed from the
 *                      commit
 *            +24  u32  first eight hexadecimal digits of the commit, u16 the next four; 0:
 *                      unknown
 *            +30  u16  board (common/boards.def); 0 in images older than this field
 *            +32  u32  CRC-32 of the flash from its start (the vectors) up to this word
 *
 * The header does not depend on the time or place of the build: one commit gives one image.
 * Little-endian. */
#ifndef MATRIG_COMMON_IMAGE_H
#define MATRIG_COMMON_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/status.h"

/* Start and size of each memory region on the largest chip, for example MR_PROGRAM and
 * MR_PROGRAM_BYTES. */
enum {
#define KIB(f407, f446)                f407
#define REGION(NAME, start, kib, text) MR_##NAME = (start), MR_##NAME##_BYTES = 1024 * (kib),
#include "common/memory.def"
    MR_FLASH = MR_VECTORS,
    MR_FLASH_BYTES = MR_PROGRAM + MR_PROGRAM_BYTES - MR_FLASH
};

#define MR_IMAGE_MAGIC       0x4749524du
#define MR_IMAGE_FORMAT      1u
#define MR_IMAGE_OFFSET      0x200u /* offset of the header from MR_FLASH */
#define MR_IMAGE_BYTES       36u
#define MR_IMAGE_HEAD_BYTES  (MR_IMAGE_OFFSET + MR_IMAGE_BYTES) /* bytes of vectors and header */
#define MR_IMAGE_COMMIT_TEXT 24u

struct mr_image {
    uint8_t major, minor, patch;
    bool is_modified;     /* built from sources that differ from the commit */
    uint32_t commit;      /* first eight hexadecimal digits of the commit's hash */
    uint16_t commit_more; /* next four digits; `commit` and `commit_more` 0: unknown */
    uint16_t board;       /* enum mr_board_number, or an unknown number */
    /* first address of the program, and the address after its last byte */
    uint32_t program_start, program_end;
    uint32_t program_crc;
    uint32_t header_crc;
};

/* Reads the header from the first MR_IMAGE_HEAD_BYTES bytes of flash. MR_OK; MR_UNKNOWN: no header;
 * MR_VERSION: a different format; MR_CRC: vectors or header are damaged, or stamp.c has not filled
 * the header (`image` is set nevertheless); MR_MALFORMED: the program is outside the flash. */
enum mr_status mr_image_decode(struct mr_image *image, const uint8_t head[MR_IMAGE_HEAD_BYTES]);
/* Writes the header into `head`, which already holds the vectors, and computes header_crc. */
void mr_image_encode(struct mr_image *image, uint8_t head[MR_IMAGE_HEAD_BYTES]);

/* Writes the commit as text: "c7a3136ab3a3", "c7a3136ab3a3-dirty" or "unknown". */
void mr_image_commit_text(uint32_t commit, uint16_t commit_more, bool changed,
                          char text[MR_IMAGE_COMMIT_TEXT]);

/* ---- boards ---- */

/* Boards for which firmware images exist (common/boards.def). */

enum mr_board_number {
#define BOARD(number, NAME, name, part, package, chip, text) MR_BOARD_##NAME = (number),
#include "common/boards.def"
};

struct mr_board {
    const char *name;           /* "zg": value of make BOARD=zg and name of the board's folder */
    const char *part, *package; /* part number and package of the chip */
    const char *text;
    uint16_t chip; /* device id of the chip, from DBGMCU_IDCODE */
};

/* Board with this number, or NULL. Static storage. */
const struct mr_board *mr_board_by_number(unsigned number);
/* Number of the board with this name, or -1. */
int mr_board_number_by_name(const char *name);

#endif
