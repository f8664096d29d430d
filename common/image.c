#include "common/image.h"

#include "common/crc32.h"
#include "common/wire.h"

#define CRC_OFFSET    (MR_IMAGE_HEAD_BYTES - 4u)
#define COMMIT_DIGITS 12u

static bool is_in_flash(const struct mr_image *image)
{
    return image->program_start >= MR_FLASH && image->program_start <= image->program_end &&
           image->program_end <= MR_FLASH + MR_FLASH_BYTES;
}

enum mr_status mr_image_decode(struct mr_image *image, const uint8_t head[MR_IMAGE_HEAD_BYTES])
{
    const uint8_t *p = head + MR_IMAGE_OFFSET;
    memset(image, 0, sizeof *image);
    if (mr_get_u32(&p) != MR_IMAGE_MAGIC)
        return MR_UNKNOWN;
    uint16_t format = mr_get_u16(&p);
    if (format != MR_IMAGE_FORMAT || mr_get_u16(&p) != MR_IMAGE_BYTES)
        return MR_VERSION;
    image->program_start = mr_get_u32(&p);
    image->program_end = mr_get_u32(&p);
    image->program_crc = mr_get_u32(&p);
    image->major = mr_get_u8(&p);
    image->minor = mr_get_u8(&p);
    image->patch = mr_get_u8(&p);
    image->is_modified = mr_get_u8(&p) != 0;
    image->commit = mr_get_u32(&p);
    image->commit_more = mr_get_u16(&p);
    image->board = mr_get_u16(&p);
    image->header_crc = mr_get_u32(&p);
    if (image->header_crc != mr_crc32(0, head, CRC_OFFSET))
        return MR_CRC;
    return is_in_flash(image) ? MR_OK : MR_MALFORMED;
}

void mr_image_encode(struct mr_image *image, uint8_t head[MR_IMAGE_HEAD_BYTES])
{
    uint8_t *p = mr_put_u32(head + MR_IMAGE_OFFSET, MR_IMAGE_MAGIC);
    p = mr_put_u16(mr_put_u16(p, MR_IMAGE_FORMAT), MR_IMAGE_BYTES);
    p = mr_put_u32(mr_put_u32(p, image->program_start), image->program_end);
    p = mr_put_u32(p, image->program_crc);
    p = mr_put_u8(mr_put_u8(mr_put_u8(p, image->major), image->minor), image->patch);
    p = mr_put_u8(p, image->is_modified);
    p = mr_put_u16(mr_put_u32(p, image->commit), image->commit_more);
    p = mr_put_u16(p, image->board);
    image->header_crc = mr_crc32(0, head, CRC_OFFSET);
    mr_put_u32(p, image->header_crc);
}

void mr_image_commit_text(uint32_t commit, uint16_t commit_more, bool changed,
                          char text[MR_IMAGE_COMMIT_TEXT])
{
    static const char digits[] = "0123456789abcdef";
    uint64_t value = (uint64_t)commit << 16 | commit_more;
    if (!value) {
        memcpy(text, "unknown", sizeof "unknown");
        return;
    }
    for (unsigned i = 0; i < COMMIT_DIGITS; i++)
        text[i] = digits[value >> 4u * (COMMIT_DIGITS - 1 - i) & 15u];
    memcpy(text + COMMIT_DIGITS, changed ? "-dirty" : "", changed ? sizeof "-dirty" : 1);
}

/* ---- boards ---- */

static const struct mr_board boards[] = {
#define BOARD(number, NAME, name, part, package, chip, text) \
    [number] = {#name, part, package, text, chip},
#include "common/boards.def"
};
#define BOARD_COUNT (sizeof boards / sizeof boards[0])

const struct mr_board *mr_board_by_number(unsigned number)
{
    return number < BOARD_COUNT && boards[number].name ? &boards[number] : NULL;
}

int mr_board_number_by_name(const char *name)
{
    for (unsigned i = 0; i < BOARD_COUNT; i++) {
        if (boards[i].name && strcmp(boards[i].name, name) == 0)
            return (int)i;
    }
    return -1;
}
