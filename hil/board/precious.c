#include "hil/board/precious.h"

#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool hil_is_precious(const char *path)
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
