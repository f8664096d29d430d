#include "host/base/output.h"

#include <errno.h>
#include <fcntl.h>
#include <jansson.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/xmalloc.h"

#define TEMPORARY_FILES_MAX 100

/* ---- target ---- */

/* True if the file is a database. An output file never replaces a database, because its landings
 * cannot be repeated. Only a regular file is read: reading a pipe or a terminal would block. */
static bool begins_with(const char *path, const char *magic, size_t length)
{
    char begins[16];
    struct stat kind;
    FILE *file = stat(path, &kind) == 0 && S_ISREG(kind.st_mode) ? fopen(path, "r") : NULL;
    bool is = file && fread(begins, length, 1, file) == 1 && memcmp(begins, magic, length) == 0;
    if (file)
        fclose(file);
    return is;
}

bool output_is_database(const char *path)
{
    return begins_with(path, "SQLite format 3", 16);
}

enum mr_status output_check_file_format(const char *path, const char *wanted, struct error *error)
{
    static const struct {
        const char *prefix, *kind, *advice;
    } kinds[] = {
        {"PK\003\004", "a spreadsheet or an archive", "save the sheet as CSV"},
        {"\320\317\021\340", "an old spreadsheet", "save the sheet as CSV"},
        {"%PDF", "a PDF", "give the file with the data"},
        {"\211PNG", "a picture", "give the file with the data"},
        {"SQLite format 3", "a campaign", "list its contents with matrig show"},
        {"matrig-run ", "a recorded landing", "play the landing with matrig-board --rig"},
        {"MDF     ", "an MDF4 file", "export the file as CSV"},
        {"# matrig configuration", "a board's configuration",
         "load the configuration with matrig board config set"},
        {"<!DOCTYPE", "a web page", "give the file with the data"},
        {"\037\213", "a compressed file", "unpack the file with gunzip"},
        {"\375\067zXZ", "a compressed file", "unpack the file with unxz"},
        {"(\265/\375", "a compressed file", "unpack the file with unzstd"},
        {"LOGG\220", "a BLF log", "convert the file to a candump log"},
        {";$FILEVERSION", "a PEAK trace", "convert the file to a candump log"},
        {"\377\376", "a text in UTF-16", "save the text as CSV in UTF-8"},
    };
    char begins[32] = "";
    struct stat kind;
    FILE *file = stat(path, &kind) == 0 && S_ISREG(kind.st_mode) ? fopen(path, "r") : NULL;
    if (file) {
        (void)!fread(begins, 1, sizeof begins - 1, file);
        fclose(file);
    }
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
        if (strncasecmp(begins, kinds[i].prefix, strlen(kinds[i].prefix)) == 0)
            return error_set(error, MR_MALFORMED, "%s, not a %s: %s; %s", kinds[i].kind, wanted,
                             path, kinds[i].advice);
    return MR_OK;
}

size_t utf8_bom_length(const char *text, size_t length)
{
    return length >= 3 && memcmp(text, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
}

static char *find_control(const char *text)
{
    while ((unsigned char)*text >= 0x20 && *text != 0x7f &&
           !((unsigned char)*text == 0xc2 && ((unsigned char)text[1] & 0xe0) == 0x80))
        text++;
    return (char *)text;
}

bool text_is_plain(const char *text)
{
    json_t *utf8 = json_string(text);
    const bool is_plain = utf8 && text[strspn(text, " ")] && !*find_control(text);
    json_decref(utf8);
    return is_plain;
}

void text_blank_controls(char *text)
{
    while (*(text = find_control(text))) {
        if ((unsigned char)*text == 0xc2)
            text[1] = ' ';
        *text = ' ';
    }
}

static enum mr_status set_write_error(const char *path, struct error *error)
{
    return error_set(error, MR_IO, "cannot write (%s): %s; check the path and the permissions",
                     strerror(errno), path);
}

/* Writes the folder part of a path, with the slash at its end. */
static void get_parent_folder(const char *path, char folder[PATH_MAX])
{
    const char *slash = strrchr(path, '/');
    snprintf(folder, PATH_MAX, "%.*s", slash ? (int)(slash - path + 1) : 2, slash ? path : "./");
}

/* Finds the file to be created or replaced, by resolving symbolic links. */
static enum mr_status find_target(const char *path, char target[PATH_MAX], struct error *error)
{
    char folder[PATH_MAX], whole[PATH_MAX];
    if (realpath(path, target))
        return MR_OK;
    get_parent_folder(path, folder);
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    if (errno != ENOENT || !realpath(folder, whole) || !*name)
        return errno = *name ? errno : EISDIR, set_write_error(path, error);
    if (snprintf(target, PATH_MAX, "%s/%s", strcmp(whole, "/") == 0 ? "" : whole, name) >= PATH_MAX)
        return errno = ENAMETOOLONG, set_write_error(path, error);
    return MR_OK;
}

/* ---- checks ---- */

enum mr_status output_check_not_input(const char *path, const char *input, struct error *error)
{
    struct stat a, b;
    if (!path || !input || stat(path, &a) != 0 || stat(input, &b) != 0 || !S_ISREG(a.st_mode) ||
        a.st_dev != b.st_dev || a.st_ino != b.st_ino)
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "would overwrite the input: %s; give a different file for the output", path);
}

enum mr_status output_check_new(const char *path, bool force, struct error *error)
{
    struct stat info;
    if (!path || force || stat(path, &info) != 0 || !S_ISREG(info.st_mode) || info.st_size == 0)
        return MR_OK;
    return error_set(
        error, MR_USAGE,
        "file exists already: %s; give a different file, or --force to replace this file", path);
}

/* Fails if the regular file `target` may not be replaced. `path` is the name that the user gave. */
static enum mr_status check_replaceable(const char *path, const char *target, struct error *error)
{
    /* SQLite's write-ahead log and rollback journal have parts of a database */
    if (!output_is_database(target) && !begins_with(target, "\x37\x7f\x06\x82", 4) &&
        !begins_with(target, "\x37\x7f\x06\x83", 4) && !begins_with(target, "\xd9\xd5\x05\xf9", 4))
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "would overwrite a database: %s; give a different file for the output", path);
}

static enum mr_status check_path(const char *path, struct error *error)
{
    char target[PATH_MAX], folder[PATH_MAX];
    struct stat info;
    if (strcmp(path, "-") == 0)
        return error_set(
            error, MR_USAGE,
            "the file name - is not accepted; give a path (/dev/stdout for standard output)");
    bool exists = stat(path, &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        return errno = EISDIR, set_write_error(path, error);
    if (exists && access(path, W_OK) != 0)
        return set_write_error(path, error);
    if (exists && !S_ISREG(info.st_mode))
        return MR_OK;
    if (find_target(path, target, error) != MR_OK)
        return error->status;
    get_parent_folder(target, folder);
    if (exists && check_replaceable(path, target, error) != MR_OK)
        return error->status;
    return access(folder, W_OK | X_OK) == 0 ? MR_OK : set_write_error(path, error);
}

enum mr_status output_check(const char *path, const char *input, struct error *error)
{
    if (!path)
        return MR_OK;
    bool read = !output_is_database(path) && output_check_not_input(path, input, error) != MR_OK;
    return read ? error->status : check_path(path, error);
}

/* ---- writing ---- */

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

/* Syncs the draft (the temporary file with the new content) to disk and renames it to `target`. */
static enum mr_status commit_temporary_file(int fd, const char *draft, const char *target,
                                            const char *path, struct error *error)
{
    struct stat info;
    if (stat(target, &info) == 0) {
        /* keeps owner and mode of the replaced file if the user has the permission */
        int failed = fchown(fd, info.st_uid, info.st_gid);
        failed |= fchmod(fd, info.st_mode & 07777u);
        (void)failed;
    }
    if (fsync(fd) != 0 && errno != EINVAL)
        return set_write_error(path, error);
    if (check_replaceable(path, target, error) != MR_OK)
        return error->status;
    return rename(draft, target) == 0 ? MR_OK : set_write_error(path, error);
}

/* Creates an empty draft file in the folder of the target. Returns its descriptor, or -1. */
static int create_temporary_file(const char *target, mode_t mode, char draft[PATH_MAX + 64])
{
    char folder[PATH_MAX];
    int fd = -1;
    get_parent_folder(target, folder);
    for (int i = 0; i < TEMPORARY_FILES_MAX && fd < 0; i++) {
        snprintf(draft, PATH_MAX + 64, "%s.matrig-%ld-%d", folder, (long)getpid(), i);
        fd = open(draft, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, mode);
        if (fd < 0 && errno != EEXIST)
            break;
    }
    return fd;
}

/* Replaces the target by the new content. Removes the draft before it sets `error`, because setting
 * `error` may end the program. */
static enum mr_status replace_target(const struct output *output, struct error *error)
{
    char target[PATH_MAX], draft[PATH_MAX + 64];
    struct error failed = {0};
    if (find_target(output->path, target, error) != MR_OK)
        return error->status;
    int fd = create_temporary_file(target, output->is_executable ? 0777 : 0666, draft);
    if (fd < 0)
        return set_write_error(output->path, error);
    if (!write_all(fd, output->text, output->length))
        set_write_error(output->path, &failed);
    else
        commit_temporary_file(fd, draft, target, output->path, &failed);
    if (close(fd) != 0)
        set_write_error(output->path, &failed);
    if (failed.status == MR_OK)
        return MR_OK;
    unlink(draft);
    return error_set(error, failed.status, "%s", failed.text);
}

/* Writes the content to a pipe, a terminal or a device. */
static enum mr_status write_directly(const struct output *output, struct error *error)
{
    int fd = open(output->path, O_WRONLY | O_CLOEXEC | O_NOCTTY);
    if (fd < 0)
        return set_write_error(output->path, error);
    bool done = write_all(fd, output->text, output->length);
    if (!done)
        set_write_error(output->path, error);
    if (close(fd) != 0 && done)
        set_write_error(output->path, error);
    return error->status;
}

/* ---- interface ---- */

enum mr_status output_begin(struct output *output, const char *path, struct error *error)
{
    if (path && strcmp(path, "/dev/stdout") == 0)
        path = NULL;
    *output = (struct output){.file = stdout, .path = path};
    if (!path)
        return MR_OK;
    output->file = NULL;
    if (check_path(path, error) != MR_OK)
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
                             "cannot write to standard output (%s); check the pipe, file or disk",
                             strerror(errno));
    bool whole = !ferror(output->file);
    whole &= fclose(output->file) == 0;
    output->file = NULL;
    if (error->status == MR_OK && !whole)
        error_set(error, MR_FULL, "out of memory, writing %s; close other programs", output->path);
    if (error->status == MR_OK && stat(output->path, &info) == 0 && !S_ISREG(info.st_mode))
        write_directly(output, error);
    else if (error->status == MR_OK)
        replace_target(output, error);
    free(output->text);
    output->text = NULL;
    return error->status;
}

enum mr_status output_write_bytes(const char *path, const void *bytes, size_t length,
                                  struct error *error)
{
    struct output output;
    if (output_begin(&output, path, error) != MR_OK)
        return error->status;
    fwrite(bytes, 1, length, output.file);
    return output_end(&output, error);
}

FILE *output_open_temporary(const char *what, struct error *error)
{
    FILE *file = tmpfile();
    if (!file)
        error_set(error, MR_IO,
                  "cannot create a temporary file in /tmp (%s): %s; free space in /tmp",
                  strerror(errno), what);
    return file;
}

void output_copy_temporary(FILE *temporary, FILE *to)
{
    char bytes[65536];
    size_t count;
    rewind(temporary);
    while ((count = fread(bytes, 1, sizeof bytes, temporary)) > 0)
        fwrite(bytes, 1, count, to);
}

enum mr_status output_write_json(const char *path, const json_t *json, unsigned digits,
                                 struct error *error)
{
    struct output output;
    if (output_begin(&output, path, error) != MR_OK)
        return error->status;
    json_dumpf(json, output.file,
               JSON_INDENT(2) | JSON_PRESERVE_ORDER | JSON_REAL_PRECISION(digits));
    fputc('\n', output.file);
    return output_end(&output, error);
}
