#include "host/base/written.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <sha2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <unistd.h>

#define ATTRIBUTE  "user.matrig.written"
#define DIGEST     65 /* hexadecimal digits and NUL */
#define RECORD_MAX (DIGEST + 40 + PATH_MAX)

static void to_hex(SHA2_CTX *hash, char hex[DIGEST])
{
    uint8_t sum[SHA256_DIGEST_LENGTH];
    SHA256Final(sum, hash);
    for (size_t i = 0; i < sizeof sum; i++)
        snprintf(hex + 2 * i, 3, "%02x", sum[i]);
}

static bool digest_file(int fd, char hex[DIGEST])
{
    SHA2_CTX hash;
    uint8_t bytes[65536];
    ssize_t got;
    off_t at = 0;
    SHA256Init(&hash);
    while ((got = pread(fd, bytes, sizeof bytes, at)) > 0) {
        SHA256Update(&hash, bytes, (size_t)got);
        at += got;
    }
    to_hex(&hash, hex);
    return got == 0;
}

/* ---- in the file's attribute ---- */

/* What is said of the file: false: it cannot be told. */
static bool attribute_text(int fd, const char *path, char text[RECORD_MAX])
{
    char hex[DIGEST];
    struct stat info;
    const char *slash = strrchr(path, '/');
    if (fstat(fd, &info) != 0 || !digest_file(fd, hex))
        return false;
    snprintf(text, RECORD_MAX, "%s %llu %s", hex, (unsigned long long)info.st_ino,
             slash ? slash + 1 : path);
    return true;
}

/* ---- in the state folder ---- */

static bool make_folder(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        if (mkdir(path, 0700) != 0 && errno != EEXIST)
            return false;
        *slash = '/';
    }
    return true;
}

/* Where the record of a path lies; false: there is no folder for it. */
static bool record_place(const char *path, char place[PATH_MAX])
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    char hex[DIGEST];
    SHA2_CTX hash;
    bool own = state && state[0] == '/'; /* the specification has relative ones left out */
    if (!own && !(home && home[0] == '/')) {
        errno = ENOENT;
        return false;
    }
    SHA256Init(&hash);
    SHA256Update(&hash, (const uint8_t *)path, strlen(path));
    to_hex(&hash, hex);
    int length = snprintf(place, PATH_MAX, "%s%s/matrig/written/%s", own ? state : home,
                          own ? "" : "/.local/state", hex);
    errno = ENAMETOOLONG;
    return length < PATH_MAX;
}

/* As sha256sum writes it. */
static void record_text(const char *hex, const char *path, char text[RECORD_MAX])
{
    snprintf(text, RECORD_MAX, "%.*s  %s\n", DIGEST - 1, hex, path);
}

static bool put_record(const char *path, const char *hex)
{
    char place[PATH_MAX], fresh[PATH_MAX + 32], text[RECORD_MAX];
    if (!record_place(path, place) || !make_folder(place))
        return false;
    snprintf(fresh, sizeof fresh, "%s.%ld", place, (long)getpid());
    record_text(hex, path, text);
    FILE *file = fopen(fresh, "w");
    if (!file)
        return false;
    bool done = fputs(text, file) >= 0;
    done &= fclose(file) == 0;
    if (done && rename(fresh, place) == 0)
        return true;
    unlink(fresh);
    return false;
}

static bool get_record(const char *path, char text[RECORD_MAX])
{
    char place[PATH_MAX];
    FILE *file = record_place(path, place) ? fopen(place, "r") : NULL;
    size_t got = file ? fread(text, 1, RECORD_MAX - 1, file) : 0;
    text[got] = '\0';
    if (file)
        fclose(file);
    return got > 0;
}

/* ---- both ---- */

static enum written_state state_of(int fd, const char *path)
{
    char said[RECORD_MAX], is[RECORD_MAX], hex[DIGEST];
    ssize_t length = fgetxattr(fd, ATTRIBUTE, said, sizeof said - 1);
    if (length > 0) {
        said[length] = '\0';
        if (!attribute_text(fd, path, is))
            return WRITTEN_UNKNOWN;
        if (strcmp(said, is) == 0)
            return WRITTEN_HERE;
        bool same_file = length > DIGEST && strcmp(said + DIGEST, is + DIGEST) == 0;
        return same_file ? WRITTEN_CHANGED : WRITTEN_UNKNOWN;
    }
    if (!get_record(path, said) || !digest_file(fd, hex))
        return WRITTEN_UNKNOWN;
    record_text(hex, path, is);
    return strcmp(said, is) == 0 ? WRITTEN_HERE : WRITTEN_CHANGED;
}

enum written_state written_state(const char *path)
{
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (fd < 0)
        return WRITTEN_UNKNOWN;
    enum written_state state = state_of(fd, path);
    close(fd);
    return state;
}

bool written_record(int fd, const char *path)
{
    char text[RECORD_MAX];
    if (!attribute_text(fd, path, text))
        return false;
    if (fsetxattr(fd, ATTRIBUTE, text, strlen(text), 0) == 0)
        return true;
    text[DIGEST - 1] = '\0';
    return put_record(path, text);
}
