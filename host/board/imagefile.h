/* A firmware image from a file: the bytes for each part of flash, and a check that the image is
 * complete.
 *
 *     .elf  the contents of its loadable segments for flash (recognised by its first bytes)
 *     .bin  flash from 0x08000000 on (recognised by its name)
 *
 * An image must not contain data in the configuration's sectors (in a .bin, all their bytes must be
 * 0xff). These sectors, and 0xff bytes after vectors and header, are not written. */
#ifndef MATRIG_HOST_BOARD_IMAGEFILE_H
#define MATRIG_HOST_BOARD_IMAGEFILE_H

#include "common/image.h"
#include "host/base/error.h"

#define IMAGEFILE_BYTES               ((uint32_t)MR_FLASH_BYTES)
/* Offsets of the configuration's sectors, which are never overwritten. */
#define IMAGEFILE_CONFIGURATION_START ((uint32_t)(MR_CONFIGURATION - MR_FLASH))
#define IMAGEFILE_CONFIGURATION_END   (IMAGEFILE_CONFIGURATION_START + MR_CONFIGURATION_BYTES)

struct imagefile {
    const char *path;
    uint8_t *bytes;         /* IMAGEFILE_BYTES of flash, 0xff where the image has no data */
    uint8_t *is_present;    /* 1: the image contains this byte */
    uint32_t present_count; /* number of bytes that the image contains */
    bool has_header;
    struct mr_image header;
};

/* Reads an image file. Keeps the pointer `path`. MR_IO: the file cannot be read. MR_MALFORMED,
 * MR_TRUNCATED, MR_TOO_LONG, MR_VERSION: not an image file, for another machine or address, with
 * data in the configuration's sectors, or without vectors. MR_CRC: wrong checksum, or a header that
 * marks the image as incomplete. The caller frees the image, also after a failure. */
enum mr_status imagefile_read(const char *path, struct imagefile *image, struct error *error);
void imagefile_free(struct imagefile *image);

#endif
