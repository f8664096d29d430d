#include "host/base/scratch.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum mr_status scratch_make(char path[SCRATCH_PATH], const char *name, struct error *error)
{
    const char *base = getenv("TMPDIR");
    snprintf(path, SCRATCH_PATH, "%s/matrig-%s.XXXXXX",
             base && *base && strlen(base) < 150 ? base : "/tmp", name);
    if (mkdtemp(path))
        return MR_OK;
    error_set(error, MR_IO,
              "cannot make a temporary directory (%s): %s; set TMPDIR to one that can be written",
              strerror(errno), path);
    path[0] = '\0';
    return error->status;
}

void scratch_remove(const char *path, const char *const names[], size_t count)
{
    char file[SCRATCH_PATH + 40];
    if (!path[0])
        return;
    for (size_t i = 0; i < count; i++) {
        snprintf(file, sizeof file, "%s/%s", path, names[i]);
        unlink(file);
    }
    rmdir(path);
}
