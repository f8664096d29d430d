/* The header of this image, and whether flash holds what was built. */
#include "common/crc32.h"
#include "common/version.h"
#include "firmware/f407/drivers.h"

extern const uint8_t program_start[], program_end[]; /* linker script */

/* What is not known before linking is written by firmware/stamp/stamp.c. Only that reads this
 * object: the board reads flash. */
__attribute__((section(".header"), used)) static const struct {
    uint32_t magic;
    uint16_t format, bytes;
    const uint8_t *start, *end;
    uint32_t program_crc;
    uint8_t major, minor, patch, changed;
    uint32_t commit;
    uint16_t commit_more, board;
    uint32_t header_crc;
} header = {
    .magic = MR_IMAGE_MAGIC,
    .format = MR_IMAGE_FORMAT,
    .bytes = MR_IMAGE_BYTES,
    .start = program_start,
    .end = program_end,
    .major = FIRMWARE_MAJOR,
    .minor = FIRMWARE_MINOR,
    .patch = FIRMWARE_PATCH,
    .board = BOARD_NUMBER,
};
_Static_assert(sizeof header == MR_IMAGE_BYTES, "common/image.h says where what is");

static uint8_t look(struct mr_image *image, uint32_t *crc)
{
    enum mr_status status = mr_image_get(image, (const uint8_t *)MR_IMAGE_FLASH);
    *crc = mr_crc32(0, program_start, (size_t)(program_end - program_start));
    if (status == MR_UNKNOWN || status == MR_VERSION)
        return MR_IMAGE_NONE;
    if (status != MR_OK)
        return MR_IMAGE_HEADER;
    return image->program_crc == *crc ? MR_IMAGE_GOOD : MR_IMAGE_PROGRAM;
}

void image_identify(struct board_identity *identity)
{
    identity->image_state = look(&identity->image, &identity->image_crc);
}

bool board_image_check(bool *good)
{
    struct mr_image image;
    uint32_t crc;
    uint8_t state = look(&image, &crc);
    *good = state == MR_IMAGE_GOOD;
    return state != MR_IMAGE_NONE;
}
