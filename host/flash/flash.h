/* Brings an image into flash through the boot ROM.
 *
 * What is there is read first: a sector that holds its part of the image already is kept, one whose
 * other pages are blank is gone on with, the rest are erased and written anew; sectors the image
 * does not touch, the configuration's above all, are not touched. A board that breaks off in
 * between never starts half a program: while there is one, sector 0 holds a few instructions that
 * go to the boot ROM, and vectors and header come last, after all else has been read back. */
#ifndef MATRIG_HOST_FLASH_FLASH_H
#define MATRIG_HOST_FLASH_FLASH_H

#include "host/flash/bootrom.h"
#include "host/flash/imagefile.h"
#include "host/flash/sectors.h"

enum flash_phase { FLASH_COMPARING, FLASH_WRITING, FLASH_VERIFYING };

struct flash_options {
    bool all;                 /* erase and write also what is there already */
    bool erase_configuration; /* sectors 2 and 3 too */
    /* pages; may be NULL */
    void (*progress)(void *context, enum flash_phase phase, unsigned done, unsigned of);
    void *context;
};

struct flash_result {
    unsigned pages, written, kept; /* of the image, 256 bytes or less each */
    unsigned verified;             /* bytes read back and found right */
    unsigned erased;               /* sectors, bit n: sector n */
    bool resumed;                  /* an earlier flash had broken off */
    unsigned reread;               /* pages whose first reading back was wrong on the line */
};

/* The boot ROM has been begun. MR_LIMIT: what is read back is not what was written; MR_NOT_NOW:
 * protected; else the line's. */
enum mr_status flash_run(struct bootrom *rom, const struct imagefile *image,
                         const struct flash_options *options, struct flash_result *result,
                         struct error *error);

#endif
