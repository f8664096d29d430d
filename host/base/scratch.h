/* A temporary folder, in $TMPDIR or /tmp. */
#ifndef MATRIG_HOST_BASE_SCRATCH_H
#define MATRIG_HOST_BASE_SCRATCH_H

#include <stddef.h>

#include "host/base/error.h"

#define SCRATCH_PATH 200

/* Makes matrig-NAME.XXXXXX, which is the caller's to remove. MR_IO: `path` is then "". */
enum mr_status scratch_make(char path[SCRATCH_PATH], const char *name, struct error *error);
/* Removes these files, as far as they are there, and the folder; nothing for "". */
void scratch_remove(const char *path, const char *const names[], size_t count);

#endif
