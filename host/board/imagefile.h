/* A firmware image from a file: what belongs where in flash, and whether it is whole.
 *
 *     .elf  what its loadable segments put into flash (known by its first bytes)
 *     .bin  flash from 0x08000000 on (known by its name); the configuration's sectors in it must be
 *           blank, 0xff: they are left out, as is what is blank behind vectors and header
 *
 * No image may hold anything in the configuration's sectors. */
#ifndef MATRIG_HOST_BOARD_IMAGEFILE_H
#define MATRIG_HOST_BOARD_IMAGEFILE_H

#include "common/image.h"
#include "host/base/error.h"

#define IMAGEFILE_BYTES               ((uint32_t)MR_FLASH_BYTES)
/* The configuration's sectors as offsets; they are always kept. */
#define IMAGEFILE_CONFIGURATION_START ((uint32_t)(MR_CONFIGURATION - MR_FLASH))
#define IMAGEFILE_CONFIGURATION_END   (IMAGEFILE_CONFIGURATION_START + MR_CONFIGURATION_BYTES)

struct imagefile {
    const char *path;
    uint8_t *bytes; /* IMAGEFILE_BYTES of flash, 0xff where the image gives nothing */
    uint8_t *given; /* 1: the image gives this byte */
    uint32_t count; /* bytes given */
    bool stamped;   /* it has a header, which is right */
    struct mr_image header;
};

/* `path` is kept. MR_IO; MR_MALFORMED, MR_TRUNCATED, MR_TOO_LONG, MR_VERSION: no such file, of
 * another machine, for another place, with something in the configuration's sectors, without
 * vectors; MR_CRC: a wrong checksum, or a header that marks it as incomplete. The caller frees it,
 * also after a failure. */
enum mr_status imagefile_read(const char *path, struct imagefile *image, struct error *error);
void imagefile_free(struct imagefile *image);

#endif
