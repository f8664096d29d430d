#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "host/bundle/inside.h"
#include "host/base/output.h"

uint8_t *bundle_unpack(struct bundle *bundle, const char *name, size_t *size, char *why,
                       size_t why_size)
{
    sqlite3_stmt *row = NULL;
    uint8_t *out = NULL;
    *size = 0;
    snprintf(why, why_size, "it cannot be read");
    int code = sqlite3_prepare_v2(bundle->database, "SELECT sz, data, mode FROM sqlar WHERE name=?",
                                  -1, &row, NULL);
    if (code == SQLITE_OK && sqlite3_bind_text(row, 1, name, -1, SQLITE_STATIC) == SQLITE_OK)
        code = sqlite3_step(row);
    if (code == SQLITE_DONE)
        snprintf(why, why_size, "it is not in the archive");
    int64_t claimed = code == SQLITE_ROW ? sqlite3_column_int64(row, 0) : 0;
    int64_t mode = code == SQLITE_ROW ? sqlite3_column_int64(row, 2) : 0;
    const void *data = code == SQLITE_ROW ? sqlite3_column_blob(row, 1) : NULL;
    uLong packed = data ? (uLong)sqlite3_column_bytes(row, 1) : 0;
    uLongf got = (uLongf)claimed;
    if (code == SQLITE_ROW && (mode & S_IFMT) != S_IFREG) {
        snprintf(why, why_size, "it is no plain file (mode %llo)", (unsigned long long)mode);
    } else if (code == SQLITE_ROW && (claimed < 0 || claimed > (int64_t)BUNDLE_FILE_MAX)) {
        snprintf(why, why_size, "it claims to be %lld bytes long, at most %u are allowed",
                 (long long)claimed, BUNDLE_FILE_MAX);
    } else if (code == SQLITE_ROW && (data || claimed == 0)) {
        out = malloc((size_t)claimed + 1u);
        if (!out)
            abort();
        if (packed == (uLong)claimed && packed)
            memcpy(out, data, packed);
        else if (claimed &&
                 (uncompress2(out, &got, data, &packed) != Z_OK || got != (uLongf)claimed)) {
            snprintf(why, why_size, "its packed bytes are damaged");
            free(out);
            out = NULL;
        }
        *size = (size_t)claimed;
    }
    sqlite3_finalize(row);
    return out;
}

static enum mr_status write_new(const char *path, const uint8_t *bytes, size_t size,
                                struct error *error)
{
    int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0644);
    if (file < 0)
        return error_set(error, MR_IO,
                         "cannot be written (%s): %s; give a folder where it is not yet",
                         strerror(errno), path);
    size_t done = 0;
    while (done < size) {
        ssize_t count = write(file, bytes + done, size - done);
        if (count <= 0)
            break;
        done += (size_t)count;
    }
    int code = errno;
    if (close(file) != 0 || done < size) {
        unlink(path);
        return error_set(error, MR_IO, "cannot be written (%s): %s; is there room?", strerror(code),
                         path);
    }
    return MR_OK;
}

enum mr_status bundle_save_file(struct bundle *bundle, enum bundle_file file, const char *path,
                                struct error *error)
{
    char why[160];
    size_t size;
    uint8_t *bytes = bundle_unpack(bundle, bundle_files[file].name, &size, why, sizeof why);
    enum mr_status status = bytes ? write_new(path, bytes, size, error)
                                  : error_set(error, MR_MALFORMED,
                                              "no %s in the bundle (%s): make it again",
                                              bundle_files[file].name, why);
    free(bytes);
    return status;
}

enum mr_status bundle_save_campaign(struct bundle *bundle, const char *path, struct error *error)
{
    return write_new(path, bundle->bytes, bundle->size, error);
}

/* For a user, into a folder where it may lie already. */
static enum mr_status save_output(struct bundle *bundle, enum bundle_file file, const char *path,
                                  bool force, struct error *error)
{
    char why[160];
    size_t size;
    uint8_t *bytes = bundle_unpack(bundle, bundle_files[file].name, &size, why, sizeof why);
    enum mr_status status = bytes ? output_bytes(path, force, bytes, size, error)
                                  : error_set(error, MR_MALFORMED,
                                              "no %s in the bundle (%s): make it again",
                                              bundle_files[file].name, why);
    free(bytes);
    return status;
}

enum mr_status bundle_save(struct bundle *bundle, const struct bundle_check *check,
                           const char *folder, bool force, bool saved[BUNDLE_FILES],
                           struct error *error)
{
    enum mr_status status = MR_OK;
    char path[4200];
    for (size_t i = 0; i < check->parts && status == MR_OK; i++) {
        const struct bundle_part *part = &check->part[i];
        int file = bundle_known_file(part->name, strlen(part->name));
        if (file < 0 || part->state != BUNDLE_WHOLE || strcmp(part->kind, "file") != 0)
            continue;
        if (snprintf(path, sizeof path, "%s/%s", folder, bundle_files[file].name) >=
            (int)sizeof path)
            return error_set(error, MR_USAGE, "path too long: %.40s...; give a shorter one",
                             folder);
        status = save_output(bundle, (enum bundle_file)file, path, force, error);
        saved[file] = status == MR_OK;
    }
    return status;
}
