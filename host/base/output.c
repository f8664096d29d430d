#include "host/base/output.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/xmalloc.h"

#define LINKS_MAX  40 /* symbolic ones in a row, as the kernel has it */
#define DRAFTS_MAX 100
#define TRIES_MAX  20 /* of another program that makes and removes the file meanwhile */

/* ---- where ---- */

/* The first bytes of a regular file; reading from a pipe or a terminal would wait for ever. False:
 * not so many. */
static bool read_beginning(const char *path, char *begins, size_t length)
{
    struct stat kind;
    if (stat(path, &kind) != 0 || !S_ISREG(kind.st_mode))
        return false;
    FILE *file = fopen(path, "r");
    if (!file)
        return false;
    size_t got = fread(begins, 1, length, file);
    fclose(file);
    return got == length;
}

/* A landing cannot be repeated: an output never takes the place of a database. */
bool output_is_database(const char *path)
{
    static const char magic[16] = "SQLite format 3";
    char begins[sizeof magic];
    return read_beginning(path, begins, sizeof begins) && memcmp(begins, magic, sizeof magic) == 0;
}

/* What the shell or a parent opened for us, by its name; -1: another path. It is written to where
 * it stands. */
static int open_already(const char *path)
{
    static const char *const folders[] = {"/dev/fd/", "/proc/self/fd/"};
    if (strcmp(path, "/dev/stdout") == 0)
        return STDOUT_FILENO;
    if (strcmp(path, "/dev/stderr") == 0)
        return STDERR_FILENO;
    for (size_t i = 0; i < sizeof folders / sizeof folders[0]; i++) {
        size_t length = strlen(folders[i]);
        char *end;
        if (strncmp(path, folders[i], length) == 0 && path[length] >= '0' && path[length] <= '9') {
            long number = strtol(path + length, &end, 10);
            if (!*end && number <= INT_MAX)
                return (int)number;
        }
    }
    return -1;
}

static enum mr_status cannot(const char *path, struct error *error)
{
    return error_set(error, MR_IO, "cannot write (%s): %s; check path and rights", strerror(errno),
                     path);
}

/* The folder of a path, with its last slash. */
static void folder_of(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    snprintf(folder, PATH_MAX, "%.*s", slash ? (int)(slash - path + 1) : 2, slash ? path : "./");
}

/* Follows symbolic links, also one to a file that is not there yet, to the file that is to be made
 * or replaced. */
static enum mr_status follow_links(const char *path, char at[PATH_MAX], struct error *error)
{
    char folder[PATH_MAX], link[PATH_MAX];
    if (snprintf(at, PATH_MAX, "%s", path) >= PATH_MAX)
        return errno = ENAMETOOLONG, cannot(path, error);
    for (int i = 0; i <= LINKS_MAX; i++) {
        ssize_t length = readlink(at, link, sizeof link - 1);
        if (length < 0)
            break;
        link[length] = '\0';
        folder_of(at, folder);
        if (i == LINKS_MAX ||
            snprintf(at, PATH_MAX, "%s%s", link[0] == '/' ? "" : folder, link) >= PATH_MAX)
            return errno = ELOOP, cannot(path, error);
    }
    return MR_OK;
}

static enum mr_status find_target(const char *path, char target[PATH_MAX], struct error *error)
{
    char at[PATH_MAX], folder[PATH_MAX], whole[PATH_MAX];
    if (follow_links(path, at, error) != MR_OK)
        return error->status;
    folder_of(at, folder);
    const char *slash = strrchr(at, '/'), *name = slash ? slash + 1 : at;
    if (!realpath(folder, whole) || !*name)
        return errno = *name ? errno : EISDIR, cannot(path, error);
    if (snprintf(target, PATH_MAX, "%s/%s", strcmp(whole, "/") == 0 ? "" : whole, name) >= PATH_MAX)
        return errno = ENAMETOOLONG, cannot(path, error);
    return MR_OK;
}

/* ---- whether ---- */

enum mr_status output_not_input(const char *path, const char *input, struct error *error)
{
    struct stat a, b;
    if (!path || !input || stat(path, &a) != 0 || stat(input, &b) != 0 || !S_ISREG(a.st_mode) ||
        a.st_dev != b.st_dev || a.st_ino != b.st_ino)
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "would overwrite what is read: %s; give another file for the output", path);
}

enum mr_status output_keep(const char *path, bool force, struct error *error)
{
    struct stat info;
    if (!path || force || stat(path, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size == 0)
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "exists already: %s; give another file, or --force to replace it", path);
}

/* Whether the regular file at `target`, which the user named `path`, may be replaced. */
static enum mr_status may_replace(const char *path, const char *target, struct error *error)
{
    if (!output_is_database(target))
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "would overwrite a database: %s; give another file for the output", path);
}

static enum mr_status check(const char *path, struct error *error)
{
    char target[PATH_MAX], folder[PATH_MAX];
    struct stat info;
    if (strcmp(path, "-") == 0)
        return error_set(error, MR_USAGE,
                         "not a file: -; give a path (/dev/stdout is standard output)");
    if (open_already(path) >= 0)
        return MR_OK;
    bool exists = stat(path, &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        return errno = EISDIR, cannot(path, error);
    if (exists && access(path, W_OK) != 0)
        return cannot(path, error);
    if (exists && !S_ISREG(info.st_mode))
        return MR_OK;
    if (find_target(path, target, error) != MR_OK)
        return error->status;
    folder_of(target, folder);
    if (exists && may_replace(path, target, error) != MR_OK)
        return error->status;
    return access(folder, W_OK | X_OK) == 0 ? MR_OK : cannot(path, error);
}

enum mr_status output_check(const char *path, const char *input, struct error *error)
{
    if (!path)
        return MR_OK;
    bool read = !output_is_database(path) && output_not_input(path, input, error) != MR_OK;
    return read ? error->status : check(path, error);
}

/* ---- into place ---- */

static bool write_all(int fd, const char *bytes, size_t length)
{
    size_t done = 0;
    while (done < length) {
        ssize_t put = write(fd, bytes + done, length - done);
        if (put < 0 && errno == EINTR)
            continue;
        if (put <= 0)
            return false;
        done += (size_t)put;
    }
    return true;
}

/* The draft takes the target's place, if that is still what it may replace. */
static enum mr_status rename_over(const char *draft, const char *target, const char *path,
                                  struct error *error)
{
    struct stat info;
    for (int i = 0; i < TRIES_MAX; i++) {
        bool exists = lstat(target, &info) == 0;
        if (exists && may_replace(path, target, error) != MR_OK)
            return error->status;
        int failed = exists ? rename(draft, target)
                            : renameat2(AT_FDCWD, draft, AT_FDCWD, target, RENAME_NOREPLACE);
        /* a file system that does not know how */
        if (failed && !exists && (errno == EINVAL || errno == ENOSYS))
            failed = rename(draft, target);
        if (!failed)
            return MR_OK;
        if (errno != EEXIST)
            return cannot(path, error);
    }
    return cannot(path, error);
}

/* What is in `fd`, at `draft`, goes on disk and to its place. */
static enum mr_status finish(int fd, const char *draft, const char *target, const char *path,
                             struct error *error)
{
    struct stat info;
    if (stat(target, &info) == 0) {
        /* whose it is and who may read it stays, as far as we may say so */
        int failed = fchown(fd, info.st_uid, info.st_gid);
        failed |= fchmod(fd, info.st_mode & 07777u);
        (void)failed;
    }
    if (fsync(fd) != 0 && errno != EINVAL)
        return cannot(path, error);
    return rename_over(draft, target, path, error);
}

/* A new file beside the target; -1: none can be made. */
static int make_draft(const char *target, mode_t mode, char draft[PATH_MAX + 64])
{
    char folder[PATH_MAX];
    int fd = -1;
    folder_of(target, folder);
    for (int i = 0; i < DRAFTS_MAX && fd < 0; i++) {
        snprintf(draft, PATH_MAX + 64, "%s.matrig-%ld-%d", folder, (long)getpid(), i);
        fd = open(draft, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (fd < 0 && errno != EEXIST)
            break;
    }
    return fd;
}

static enum mr_status replace(const struct output *output, struct error *error)
{
    char target[PATH_MAX], draft[PATH_MAX + 64];
    if (find_target(output->path, target, error) != MR_OK)
        return error->status;
    int fd = make_draft(target, output->executable ? 0777 : 0666, draft);
    if (fd < 0)
        return cannot(output->path, error);
    if (!write_all(fd, output->text, output->length))
        cannot(output->path, error);
    else
        finish(fd, draft, target, output->path, error);
    if (close(fd) != 0 && error->status == MR_OK)
        cannot(output->path, error);
    if (error->status != MR_OK)
        unlink(draft);
    return error->status;
}

/* To a pipe, a terminal, a device, or what is open already. */
static enum mr_status write_through(const struct output *output, struct error *error)
{
    int already = open_already(output->path);
    fflush(stdout);
    int fd = already >= 0 ? dup(already) : open(output->path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (fd < 0)
        return cannot(output->path, error);
    bool done = write_all(fd, output->text, output->length);
    if (!done)
        cannot(output->path, error);
    if (close(fd) != 0 && done)
        cannot(output->path, error);
    return error->status;
}

/* ---- the whole of it ---- */

enum mr_status output_begin(struct output *output, const char *path, struct error *error)
{
    *output = (struct output){.file = stdout, .path = path};
    if (!path)
        return MR_OK;
    output->file = NULL;
    if (check(path, error) != MR_OK)
        return error->status;
    output->file = xopen_memstream(&output->text, &output->length);
    return MR_OK;
}

enum mr_status output_end(struct output *output, struct error *error)
{
    struct stat info;
    if (!output->path)
        return fflush(stdout) == 0 && !ferror(stdout)
                 ? error->status
                 : error_set(error, MR_IO,
                             "cannot write (%s): standard output; check where it goes",
                             strerror(errno));
    bool whole = !ferror(output->file);
    whole &= fclose(output->file) == 0;
    output->file = NULL;
    if (error->status == MR_OK && !whole)
        error_set(error, MR_FULL, "no memory for the output: %s; close other programs",
                  output->path);
    if (error->status == MR_OK && (open_already(output->path) >= 0 ||
                                   (stat(output->path, &info) == 0 && !S_ISREG(info.st_mode))))
        write_through(output, error);
    else if (error->status == MR_OK)
        replace(output, error);
    free(output->text);
    output->text = NULL;
    return error->status;
}

enum mr_status output_bytes(const char *path, const void *bytes, size_t length, struct error *error)
{
    struct output output;
    if (output_begin(&output, path, error) != MR_OK)
        return error->status;
    fwrite(bytes, 1, length, output.file);
    return output_end(&output, error);
}
