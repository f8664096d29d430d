/* Error messages about files that the emulated board reads: one line with the name of the file and
 * the line number. */
#ifndef MATRIG_HIL_FILE_PLACE_H
#define MATRIG_HIL_FILE_PLACE_H

#include <stddef.h>

#include "common/status.h"

struct hil_file_context {
    const char *path;
    unsigned line; /* line number, from 1; 0: the message is not about a line */
    char *error;   /* buffer of `error_size` bytes for the message of hil_file_refuse */
    size_t error_size;
};

/* Writes the message and returns `status`. Characters of a damaged file that are not safe for a
 * terminal are replaced by `?`. */
__attribute__((format(printf, 3, 4))) enum mr_status hil_file_refuse(
    const struct hil_file_context *at, enum mr_status status, const char *format, ...);

/* Reads a whole file and appends a 0. The caller frees `bytes`, also after a failure. MR_IO: the
 * message ends with `advice`, or, if there is no such file, with the path of the one that came with
 * the program; MR_TOO_LONG: more than `max_bytes` bytes. */
enum mr_status hil_file_read(const struct hil_file_context *at, size_t max_bytes,
                             const char *advice, char **bytes, size_t *size);

#endif
