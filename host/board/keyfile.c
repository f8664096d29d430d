#include "host/board/keyfile.h"

#include <errno.h>
#include <fcntl.h>
#include <pwd.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#define KEY_DIGITS (2u * MR_KEY_BYTES)

static void keyfile_folder(char path[KEYFILE_PATH_SIZE])
{
    const char *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    if (!home || !home[0]) {
        const struct passwd *user = getpwuid(getuid());
        home = user ? user->pw_dir : "";
    }
    if (config && config[0] == '/') /* the XDG specification ignores relative paths */
        snprintf(path, KEYFILE_PATH_SIZE, "%s/matrig", config);
    else
        snprintf(path, KEYFILE_PATH_SIZE, "%s/.config/matrig", home);
}

static void keyfile_make_path(const char *uid, const char *ending, char path[KEYFILE_PATH_SIZE])
{
    char in[KEYFILE_PATH_SIZE];
    keyfile_folder(in);
    if (snprintf(path, KEYFILE_PATH_SIZE, "%s/%s.key%s", in, uid, ending) >= (int)KEYFILE_PATH_SIZE)
        path[0] = '\0'; /* an empty path cannot be opened */
}

void keyfile_path(const char *uid, char path[KEYFILE_PATH_SIZE])
{
    keyfile_make_path(uid, "", path);
}

static int parse_hex_digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

static enum mr_status read_key(const char *uid, uint8_t key[MR_KEY_BYTES], struct error *error)
{
    char path[KEYFILE_PATH_SIZE], text[KEY_DIGITS + 2];
    struct stat info;
    keyfile_path(uid, path);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* opening a pipe must not block */
    if (fd < 0 && errno == ENOENT)
        return error_set(error, MR_UNKNOWN,
                         "board %s accepts commands only with its key, and the key file is "
                         "missing: %s; copy that file from the computer that created the key",
                         uid, path);
    if (fd < 0 || fstat(fd, &info) != 0) {
        int why = errno;
        if (fd >= 0)
            close(fd);
        return error_set(error, MR_IO, "cannot read the board's key (%s): %s", strerror(why), path);
    }
    ssize_t length = read(fd, text, sizeof text);
    close(fd);
    if (info.st_mode & (S_IRWXG | S_IRWXO))
        return error_set(
            error, MR_IO,
            "other users may read the key of the board: %s; run chmod 600 on that file, and if "
            "someone may have read the key, set a new one with matrig board key new",
            path);
    bool alone = length == (ssize_t)KEY_DIGITS ||
                 (length > (ssize_t)KEY_DIGITS && text[KEY_DIGITS] < ' ');
    for (unsigned i = 0; i < MR_KEY_BYTES; i++) {
        int high = alone ? parse_hex_digit(text[2 * i]) : -1;
        int low = high >= 0 ? parse_hex_digit(text[2 * i + 1]) : -1;
        if (low < 0)
            return error_set(error, MR_MALFORMED,
                             "the key file does not contain 64 hexadecimal digits: %s", path);
        key[i] = (uint8_t)(high << 4 | low);
    }
    return MR_OK;
}

enum mr_status keyfile_compute_proof(const char *uid, const uint32_t words[3],
                                     const uint8_t nonce[MR_PROOF_BYTES],
                                     const uint8_t command[MR_COMMAND_BYTES],
                                     uint8_t proof[MR_PROOF_BYTES], struct error *error)
{
    uint8_t key[MR_KEY_BYTES];
    enum mr_status status = read_key(uid, key, error);
    if (status == MR_OK)
        mr_proof_compute(proof, key, nonce, command, words);
    return status;
}

static enum mr_status set_write_error(const char *path, struct error *error)
{
    return error_set(error, MR_IO, "cannot write the board's key (%s): %s", strerror(errno), path);
}

/* Creates the folder and its missing parents. */
static void make_folder(void)
{
    char path[KEYFILE_PATH_SIZE];
    keyfile_folder(path);
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        (void)mkdir(path, 0700); /* ignore an error: opening the key file then reports it */
        *slash = '/';
    }
    (void)mkdir(path, 0700);
}

enum mr_status keyfile_generate(const char *uid, uint8_t key[MR_KEY_BYTES], struct error *error)
{
    char path[KEYFILE_PATH_SIZE], text[KEY_DIGITS + 2];
    if (getrandom(key, MR_KEY_BYTES, 0) != (ssize_t)MR_KEY_BYTES)
        return error_set(
            error, MR_IO,
            "cannot create a key, because this computer provides no random numbers (%s)",
            strerror(errno));
    for (unsigned i = 0; i < MR_KEY_BYTES; i++)
        snprintf(text + 2 * i, 3, "%02x", key[i]);
    text[KEY_DIGITS] = '\n';
    make_folder();
    keyfile_discard_new(uid);
    keyfile_make_path(uid, ".new", path);
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0)
        return set_write_error(path, error);
    bool written = write(fd, text, KEY_DIGITS + 1) == (ssize_t)KEY_DIGITS + 1 && fsync(fd) == 0;
    close(fd);
    return written ? MR_OK : set_write_error(path, error);
}

enum mr_status keyfile_activate(const char *uid, struct error *error)
{
    char from[KEYFILE_PATH_SIZE], to[KEYFILE_PATH_SIZE];
    keyfile_make_path(uid, ".new", from);
    keyfile_path(uid, to);
    return rename(from, to) == 0 ? MR_OK : set_write_error(to, error);
}

void keyfile_discard_new(const char *uid)
{
    char path[KEYFILE_PATH_SIZE];
    keyfile_make_path(uid, ".new", path);
    (void)unlink(path);
}
