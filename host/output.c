#include "host/output.h"

#include <errno.h>
#include <string.h>

FILE *output_open(const char *path, struct error *error)
{
    if (!path)
        return stdout;
    FILE *file = fopen(path, "w");
    if (!file)
        error_set(error, MR_IO, "cannot write (%s): %s; check path and rights", strerror(errno), path);
    return file;
}

enum mr_status output_close(FILE *file, const char *path, struct error *error)
{
    int failed = ferror(file);
    failed |= path ? fclose(file) : fflush(file);
    if (failed)
        return error_set(error, MR_IO, "cannot write (%s): %s; check where it goes", strerror(errno),
                         path ? path : "standard output");
    return MR_OK;
}
