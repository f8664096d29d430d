#include "host/sweep/sweep_results.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/output.h"
#include "host/sweep/sweep_study.h"

/* A whole file as text; *length bytes, and a 0 after them. */
static char *read_all(int fd, const char *path, size_t *length, struct error *error)
{
    struct stat kind;
    if (fstat(fd, &kind) != 0 || !S_ISREG(kind.st_mode)) {
        error_set(error, MR_IO, "not a file of results: %s; give a regular file", path);
        return NULL;
    }
    size_t size = (size_t)kind.st_size;
    char *text = malloc(size + 1);
    if (!text) {
        error_set(error, MR_FULL, "out of memory: %s: %zu bytes; close other programs", path, size);
        return NULL;
    }
    *length = 0;
    while (*length < size) {
        ssize_t got = pread(fd, text + *length, size - *length, (off_t)*length);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0) {
            error_set(error, MR_IO, "cannot read (%s): %s; check the disk", strerror(errno), path);
            free(text);
            return NULL;
        }
        if (got == 0)
            break;
        *length += (size_t)got;
    }
    text[*length] = '\0';
    return text;
}

static enum mr_status one_line(const char *path, size_t number, const char *text, size_t length,
                               sweep_line *each, void *ctx, struct error *error)
{
    json_error_t where;
    uint64_t id;
    json_t *line = json_loadb(text, length, JSON_REJECT_DUPLICATES, &where);
    const char *name = json_string_value(json_object_get(line, "case"));
    if (!sweep_id_parse(name, &id) || !json_is_object(json_object_get(line, "values")) ||
        !json_is_string(json_object_get(line, "status")))
        error_set(error, MR_MALFORMED,
                  "not a result: %s line %zu; is it a file of matrig sweep? Move it away, or take "
                  "the line out",
                  path, number);
    else
        each(ctx, number, id, line, text, error);
    json_decref(line);
    return error->status;
}

static enum mr_status each_line(int fd, const char *path, sweep_line *each, void *ctx,
                                struct error *error)
{
    size_t length, number = 0;
    char *text = read_all(fd, path, &length, error);
    if (!text)
        return error->status;
    for (char *line = text, *end; (end = memchr(line, '\n', length - (size_t)(line - text)));
         line = end + 1) {
        *end = '\0';
        if (one_line(path, ++number, line, (size_t)(end - line), each, ctx, error) != MR_OK)
            break;
    }
    free(text);
    return error->status;
}

enum mr_status sweep_results_lines(const struct sweep_results *results, sweep_line *each, void *ctx,
                                   struct error *error)
{
    return each_line(results->fd, results->path, each, ctx, error);
}

enum mr_status sweep_results_read(const char *path, sweep_line *each, void *ctx,
                                  struct error *error)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0 && errno == ENOENT)
        return MR_OK;
    if (fd < 0)
        return error_set(error, MR_IO, "cannot open (%s): %s; check path and rights",
                         strerror(errno), path);
    each_line(fd, path, each, ctx, error);
    close(fd);
    return error->status;
}

/* ---- writing ---- */

static enum mr_status lock(int fd, const char *path, struct error *error)
{
    struct flock whole = {.l_type = F_WRLCK, .l_whence = SEEK_SET};
    if (fcntl(fd, F_SETLK, &whole) == 0)
        return MR_OK;
    int why = errno;
    if (why != EACCES && why != EAGAIN)
        return error_set(error, MR_IO, "cannot lock (%s): %s; put it on a file system with locks",
                         strerror(why), path);
    if (fcntl(fd, F_GETLK, &whole) == 0 && whole.l_type != F_UNLCK && whole.l_pid > 0)
        return error_set(error, MR_NOT_NOW,
                         "another sweep writes: %s (process %d); wait until it has ended", path,
                         (int)whole.l_pid);
    return error_set(error, MR_NOT_NOW, "another sweep writes: %s; wait until it has ended", path);
}

/* Whether the path still names what is open: a rewrite by another process may have put a new file
 * there. */
static bool still_there(int fd, const char *path)
{
    struct stat open_one, named;
    return fstat(fd, &open_one) == 0 && stat(path, &named) == 0 &&
           open_one.st_ino == named.st_ino && open_one.st_dev == named.st_dev;
}

/* Whether the end of a file without a newline can be the beginning of a line that
 * sweep_results_append did not get to its end. */
static bool is_torn_line(const char *text, size_t length)
{
    static const char begins[] = "{\"case\":";
    size_t known = sizeof begins - 1, zeros = 0;
    /* as some file systems leave a file when the power goes */
    while (zeros < length && text[zeros] == '\0')
        zeros++;
    return zeros == length || (memcmp(text, begins, length < known ? length : known) == 0 &&
                               !memchr(text, '\n', length));
}

static enum mr_status count_nothing(void *ctx, size_t number, uint64_t id, const json_t *line,
                                    const char *text, struct error *error)
{
    (void)ctx, (void)number, (void)id, (void)line, (void)text, (void)error;
    return MR_OK;
}

static enum mr_status take_torn_off(struct sweep_results *results, struct error *error)
{
    size_t length;
    char *text = read_all(results->fd, results->path, &length, error);
    if (!text)
        return error->status;
    size_t whole = length;
    while (whole > 0 && text[whole - 1] != '\n')
        whole--;
    bool torn = is_torn_line(text + whole, length - whole);
    free(text);
    if (length > whole && whole > 0 &&
        sweep_results_lines(results, count_nothing, NULL, error) != MR_OK)
        return error->status;
    if (!torn)
        return error_set(error, MR_MALFORMED,
                         "not results: %s: its end is no line of matrig sweep; give another file, "
                         "or move it away",
                         results->path);
    results->torn = length - whole;
    results->size = (off_t)whole;
    if (results->torn && ftruncate(results->fd, results->size) != 0)
        return error_set(error, MR_IO, "cannot take a torn line off (%s): %s; check rights",
                         strerror(errno), results->path);
    return MR_OK;
}

enum mr_status sweep_results_open(struct sweep_results *results, const char *path,
                                  struct error *error)
{
    results->fd = -1;
    results->torn = 0;
    if ((size_t)snprintf(results->path, sizeof results->path, "%s", path) >= sizeof results->path)
        return error_set(error, MR_TOO_LONG, "path too long: %.100s...; give a shorter one", path);
    if (output_not_beside_database(path, error) != MR_OK)
        return error->status;
    int fd = open(path, O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
    if (fd < 0)
        return error_set(error, MR_IO, "cannot write (%s): %s; check path and rights",
                         strerror(errno), path);
    results->fd = fd;
    if (lock(fd, path, error) == MR_OK && !still_there(fd, path))
        error_set(error, MR_NOT_NOW, "another sweep writes: %s; wait until it has ended", path);
    if (error->status == MR_OK)
        take_torn_off(results, error);
    if (error->status != MR_OK)
        sweep_results_close(results);
    return error->status;
}

void sweep_results_close(struct sweep_results *results)
{
    if (results->fd >= 0)
        close(results->fd);
    results->fd = -1;
}

enum mr_status sweep_results_append(struct sweep_results *results, const char *line,
                                    struct error *error)
{
    size_t length = strlen(line);
    char *text = malloc(length + 2);
    if (!text)
        return error_set(error, MR_FULL,
                         "out of memory: %s: a line of %zu bytes; ask for fewer outputs",
                         results->path, length);
    memcpy(text, line, length);
    text[length] = '\n';
    ssize_t put;
    do
        put = write(results->fd, text, length + 1);
    while (put < 0 && errno == EINTR);
    free(text);
    if (put == (ssize_t)(length + 1)) {
        results->size += put;
        return MR_OK;
    }
    int why = put < 0 ? errno : ENOSPC;
    if (put > 0 && ftruncate(results->fd, results->size) != 0)
        why = errno; /* the torn line is found when the file is opened again */
    return error_set(error, MR_IO,
                     "cannot write (%s): %s; make room, then the same command goes on",
                     strerror(why), results->path);
}

enum mr_status sweep_results_sync(struct sweep_results *results, struct error *error)
{
    if (fdatasync(results->fd) == 0 || errno == EINVAL || errno == EROFS)
        return MR_OK;
    return error_set(error, MR_IO, "cannot write (%s): %s; check the disk", strerror(errno),
                     results->path);
}

struct rewrite {
    struct sweep_results *to;
    sweep_keep *keep;
    void *ctx;
};

static enum mr_status copy_kept(void *ctx, size_t number, uint64_t id, const json_t *line,
                                const char *text, struct error *error)
{
    struct rewrite *r = ctx;
    (void)number;
    (void)id;
    return r->keep(r->ctx, line) ? sweep_results_append(r->to, text, error) : MR_OK;
}

enum mr_status sweep_results_rewrite(struct sweep_results *results, sweep_keep *keep, void *ctx,
                                     struct error *error)
{
    struct sweep_results fresh;
    struct rewrite r = {&fresh, keep, ctx};
    char path[sizeof results->path + 8];
    snprintf(path, sizeof path, "%s.new", results->path);
    unlink(path); /* of a rewrite that was killed */
    if (strlen(path) >= sizeof fresh.path || sweep_results_open(&fresh, path, error) != MR_OK)
        return error_set(error, MR_TOO_LONG, "path too long: %.100s...; give a shorter one", path);
    if (sweep_results_lines(results, copy_kept, &r, error) == MR_OK &&
        sweep_results_sync(&fresh, error) == MR_OK && rename(path, results->path) != 0)
        error_set(error, MR_IO, "cannot replace (%s): %s; check rights", strerror(errno),
                  results->path);
    if (error->status != MR_OK) {
        sweep_results_close(&fresh);
        unlink(path);
        return error->status;
    }
    close(results->fd);
    results->fd = fresh.fd;
    results->size = fresh.size;
    return MR_OK;
}
