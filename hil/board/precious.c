#include "hil/board/precious.h"

#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define LINKS_MAX 40 /* symbolic ones in a row, as the kernel has it */

static bool begins_precious(const char *path)
{
    char begins[16] = {0};
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return false;
    ssize_t got = read(fd, begins, sizeof begins);
    close(fd);
    return got == (ssize_t)sizeof begins &&
           (memcmp(begins, "SQLite format 3", 16) == 0 || memcmp(begins, "\177ELF", 4) == 0);
}

/* What SQLite keeps beside a database is a part of it, there or not. */
static bool beside_database(const char *path)
{
    static const char *const tails[] = {"-wal", "-shm", "-journal"};
    char database[PATH_MAX];
    size_t length = strlen(path);
    for (size_t i = 0; i < sizeof tails / sizeof tails[0]; i++) {
        size_t tail = strlen(tails[i]);
        if (length > tail && length < sizeof database &&
            strcmp(path + length - tail, tails[i]) == 0) {
            snprintf(database, sizeof database, "%.*s", (int)(length - tail), path);
            return begins_precious(database);
        }
    }
    return false;
}

bool hil_is_another_file(const char *path, const char *head)
{
    char begins[64] = {0};
    struct stat st;
    if (stat(path, &st) != 0 || !S_ISREG(st.st_mode))
        return false;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    ssize_t got = fd < 0 ? 0 : read(fd, begins, sizeof begins - 1);
    if (fd >= 0)
        close(fd);
    return got <= 0 || strncmp(begins, head, strlen(head)) != 0;
}

bool hil_is_precious(const char *path)
{
    char at[PATH_MAX], to[PATH_MAX];
    bool precious = begins_precious(path);
    snprintf(at, sizeof at, "%s", path);
    for (int i = 0; !precious && i <= LINKS_MAX; i++) {
        /* also where links lead to, which need not be there */
        precious = beside_database(at);
        ssize_t length = readlink(at, to, sizeof to - 1);
        if (length < 0)
            break;
        to[length] = '\0';
        char *name = strrchr(at, '/');
        name = to[0] == '/' || !name ? at : name + 1;
        if (snprintf(name, sizeof at - (size_t)(name - at), "%s", to) >=
            (int)(sizeof at - (size_t)(name - at)))
            break;
    }
    return precious;
}
