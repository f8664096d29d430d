/* Which board an image is for, by its header (common/image.h). */
#ifndef MATRIG_HIL_WHICH_H
#define MATRIG_HIL_WHICH_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

struct hil_board_type;

/* By the first bytes of flash. An image without a header is for any board: `type` stays as it is.
 * MR_VERSION: for a board that is not modelled; `error` says which. */
enum mr_status hil_which_head(const uint8_t *flash, const struct hil_board_type **type, char *error,
                              size_t size);
/* By what is in a file; a file that cannot be read leaves `type` as it is, for whoever loads it
 * says why. Either may be NULL; the ELF has precedence. MR_VERSION, as above. */
enum mr_status hil_which_files(const char *elf, const char *flash,
                               const struct hil_board_type **type, char *error, size_t size);

#endif
