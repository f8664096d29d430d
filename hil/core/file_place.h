/* What is wrong with a file that the emulated board reads: one line, with the file's name and the
 * line's number. */
#ifndef MATRIG_HIL_FILE_PLACE_H
#define MATRIG_HIL_FILE_PLACE_H

#include <stddef.h>

#include "common/status.h"

struct hil_file_place {
    const char *path;
    unsigned line; /* from 1; 0: no certain one */
    char *error;   /* what hil_file_refuse writes, `error_size` bytes */
    size_t error_size;
};

/* Returns `status`. Characters that may not be fit for a terminal, of a damaged file, become
 * `?`. */
__attribute__((format(printf, 3, 4))) enum mr_status hil_file_refuse(
    const struct hil_file_place *at, enum mr_status status, const char *format, ...);

/* A whole file, with a 0 behind it; the caller frees it, also after a failure. MR_IO: the message
 * ends in `advice`; MR_TOO_LONG: more than `most` bytes. */
enum mr_status hil_file_read(const struct hil_file_place *at, size_t most, const char *advice,
                             char **bytes, size_t *size);

#endif
