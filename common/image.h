/* The header of a firmware image: what it is and whether it is whole. At a fixed place in flash,
 * right behind the vectors, in the sector that is programmed last; so the .elf, .hex and .bin carry
 * it too. Written after linking by firmware/stamp/stamp.c.
 *
 *     0x08000200  u32  magic, the bytes "MRIG"
 *             +4  u16  format of this header, 1; u16 its bytes, 36
 *             +8  u32  first byte of the program, u32 the byte after its last
 *            +16  u32  CRC-32 of the program (common/crc32.h)
 *            +20  u8   major, minor, patch of the version; u8 1: built from sources that differ
 *                      from the commit
 *            +24  u32  first eight hexadecimal digits of the commit, u16 the next four; 0: not
 *                      known
 *            +30  u16  board that it is for (common/boards.def); 0 before there were others
 *            +32  u32  CRC-32 of the flash from its start, the vectors, up to here
 *
 * Nothing in it depends on when or where it was built: one commit, one image. Little-endian. */
#ifndef MATRIG_COMMON_IMAGE_H
#define MATRIG_COMMON_IMAGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/catalogue.h"
#include "common/status.h"

/* Where things are in memory, and how much of it the largest chip has: MR_PROGRAM and
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
#define MR_IMAGE_PLACE       0x200u /* of the header, from there */
#define MR_IMAGE_BYTES       36u
#define MR_IMAGE_HEAD        (MR_IMAGE_PLACE + MR_IMAGE_BYTES) /* vectors and header */
#define MR_IMAGE_COMMIT_TEXT 24u

struct mr_image {
    uint8_t major, minor, patch;
    bool changed;                        /* built from sources that differ from the commit */
    uint32_t commit;                     /* eight hexadecimal digits of its hash */
    uint16_t commit_more;                /* and four more; both 0: not known */
    uint16_t board;                      /* enum mr_board_number; may be one that is not known */
    uint32_t program_start, program_end; /* addresses */
    uint32_t program_crc;
    uint32_t header_crc;
};

/* The header from the first MR_IMAGE_HEAD bytes of flash. MR_OK; MR_UNKNOWN: there is none;
 * MR_VERSION: of another format; MR_CRC: vectors or header are damaged, or were never stamped
 * (`image` is filled all the same); MR_MALFORMED: a program out of flash. */
enum mr_status mr_image_get(struct mr_image *image, const uint8_t head[MR_IMAGE_HEAD]);
/* Put the header into the first MR_IMAGE_HEAD bytes of flash, which hold the vectors; header_crc is
 * computed. */
void mr_image_put(struct mr_image *image, uint8_t head[MR_IMAGE_HEAD]);

/* "c7a3136ab3a3", "c7a3136ab3a3-dirty" or "unknown". */
void mr_image_commit_text(uint32_t commit, uint16_t commit_more, bool changed,
                          char text[MR_IMAGE_COMMIT_TEXT]);

/* ---- boards ---- */

/* Which boards there are images for: common/boards.def. */

enum mr_board_number {
#define BOARD(number, NAME, name, part, package, chip, text) MR_BOARD_##NAME = (number),
#include "common/boards.def"
};

struct mr_board {
    const char *name;           /* "zg": of make BOARD=zg and of its folder */
    const char *part, *package; /* of its chip */
    const char *text;
    uint16_t chip; /* device id */
};

/* NULL: there is no such board. Static storage. */
const struct mr_board *mr_board_of(unsigned number);
/* Its number, or -1. */
int mr_board_named(const char *name);

#endif
