#include "host/exchange/textfile.h"

#include <errno.h>
#include <fcntl.h>
#include <sha2.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/xmalloc.h"

/* A pipe, or what else cannot be mapped. */
static enum mr_status read_all(int fd, const char *path, struct textfile *file, struct error *error)
{
    size_t room = 0;
    char *text = NULL;
    for (;;) {
        if (file->length == room) {
            room = room ? 2 * room : 65536;
            text = xrealloc(text, room);
        }
        ssize_t count = read(fd, text + file->length, room - file->length);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0) {
            free(text);
            return error_set(error, MR_IO, "cannot read (%s): %s; check the file", strerror(errno),
                             path);
        }
        if (count == 0)
            break;
        file->length += (size_t)count;
    }
    file->text = text;
    return MR_OK;
}

static enum mr_status take_file(int fd, const char *path, struct textfile *file,
                                struct error *error)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || S_ISDIR(info.st_mode))
        return error_set(error, MR_IO, "cannot read (it is no file): %s; name a file", path);
    if (!S_ISREG(info.st_mode) || info.st_size == 0)
        return read_all(fd, path, file, error);
    void *at = mmap(NULL, (size_t)info.st_size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (at == MAP_FAILED)
        return read_all(fd, path, file, error);
    madvise(at, (size_t)info.st_size, MADV_SEQUENTIAL);
    file->text = at;
    file->length = (size_t)info.st_size;
    file->mapped = true;
    return MR_OK;
}

enum mr_status textfile_open(const char *path, struct textfile *file, struct error *error)
{
    *file = (struct textfile){0};
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path", strerror(errno),
                         path);
    enum mr_status status = take_file(fd, path, file, error);
    close(fd);
    if (status != MR_OK)
        return status;
    SHA2_CTX sha;
    SHA256Init(&sha);
    SHA256Update(&sha, (const uint8_t *)file->text, file->length);
    SHA256End(&sha, file->sha256);
    return MR_OK;
}

void textfile_close(struct textfile *file)
{
    if (file->mapped)
        munmap((void *)(uintptr_t)file->text, file->length);
    else
        free((void *)(uintptr_t)file->text);
    file->text = NULL;
}

void verdict_set(struct verdict *verdict, enum mr_status status, size_t line, size_t column,
                 const char *what)
{
    if (verdict->status != MR_OK)
        return;
    verdict->status = status;
    verdict->line = line;
    verdict->column = column;
    verdict->what = what;
}

void verdict_text(const struct verdict *verdict, char *out, size_t size)
{
    if (verdict->status == MR_OK) {
        snprintf(out, size, "complete");
        return;
    }
    int n = snprintf(out, size, "%s at line %zu, column %zu: %s",
                     verdict->status == MR_TRUNCATED ? "truncated" : "malformed", verdict->line,
                     verdict->column, verdict->what);
    if (verdict->bad_lines && n > 0 && (size_t)n < size)
        snprintf(out + n, size - (size_t)n, "; %zu %s passed over", verdict->bad_lines,
                 verdict->bad_lines == 1 ? "line was" : "lines were");
}
