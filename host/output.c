#include "host/output.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A landing cannot be repeated: an output never takes the place of a database. Only a regular file can be one; reading
 * from a pipe or a terminal would wait for ever. */
static bool is_database(const char *path)
{
    static const char magic[16] = "SQLite format 3";
    char begins[sizeof magic] = {0};
    struct stat kind;
    if (stat(path, &kind) != 0 || !S_ISREG(kind.st_mode))
        return false;
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    size_t got = fread(begins, 1, sizeof begins, file);
    fclose(file);
    return got == sizeof begins && memcmp(begins, magic, sizeof magic) == 0;
}

static enum mr_status refuse(const char *path, struct error *error)
{
    if (strcmp(path, "-") == 0)
        return error_set(error, MR_USAGE, "not a file: -; give a path (/dev/stdout is standard output)");
    if (is_database(path))
        return error_set(error, MR_USAGE, "would overwrite a database: %s; give another file for the output", path);
    return MR_OK;
}

enum mr_status output_not_input(const char *path, const char *input, struct error *error)
{
    struct stat a, b;
    if (!path || !input || stat(path, &a) != 0 || stat(input, &b) != 0 || !S_ISREG(a.st_mode) || a.st_dev != b.st_dev || a.st_ino != b.st_ino)
        return MR_OK;
    return error_set(error, MR_USAGE, "would overwrite what is read: %s; give another file for the output", path);
}

enum mr_status output_check(const char *path, const char *input, struct error *error)
{
    struct stat out;
    if (!path)
        return MR_OK;
    if (refuse(path, error) != MR_OK || output_not_input(path, input, error) != MR_OK)
        return error->status;
    bool exists = stat(path, &out) == 0;
    const char *slash = strrchr(path, '/');
    char folder[4096];
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path + 1) : 1, slash ? path : ".");
    if (exists && S_ISDIR(out.st_mode))
        errno = EISDIR;
    else if (access(exists ? path : folder, exists ? W_OK : W_OK | X_OK) == 0)
        return MR_OK;
    return error_set(error, MR_IO, "cannot write (%s): %s; check path and rights", strerror(errno), path);
}

FILE *output_open(const char *path, struct error *error)
{
    if (!path)
        return stdout;
    if (refuse(path, error) != MR_OK)
        return NULL;
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
