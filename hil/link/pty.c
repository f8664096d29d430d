#include "hil/link/pty.h"

#include <asm/termbits.h> /* struct termios2, for any rate; not to be mixed with termios.h */
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

static bool set_raw(int fd, uint32_t baud)
{
    struct termios2 t;
    if (ioctl(fd, TCGETS2, &t) != 0)
        return false;
    t.c_iflag = t.c_oflag = t.c_lflag = 0;
    t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
    t.c_ospeed = t.c_ispeed = baud;
    return ioctl(fd, TCSETS2, &t) == 0;
}

/* Only after its first close does an unused pseudo-terminal say that nobody is there. */
static bool open_once(int fd)
{
    int other = open(ptsname(fd), O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (other < 0)
        return false;
    close(other);
    return true;
}

enum mr_status hil_pty_open(const char *path, uint32_t baud, int *fd, char *error, size_t size)
{
    static const char left[] = "/dev/pts/";
    struct stat st;
    char target[sizeof left] = "";
    *fd = -1;
    if (lstat(path, &st) == 0) {
        if (readlink(path, target, sizeof left - 1) < 0 || strcmp(target, left) != 0) {
            snprintf(error, size,
                     "--serial: %s is there and no link to a pseudo-terminal; remove it or give "
                     "another path",
                     path);
            return MR_IO;
        }
        unlink(path); /* left by an earlier run */
    }
    *fd = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
    if (*fd >= 0 && grantpt(*fd) == 0 && unlockpt(*fd) == 0 && set_raw(*fd, baud) &&
        open_once(*fd) && symlink(ptsname(*fd), path) == 0)
        return MR_OK;
    snprintf(error, size, "--serial: cannot make a pseudo-terminal at %s: %s; give another path",
             path, strerror(errno));
    if (*fd >= 0)
        close(*fd);
    *fd = -1;
    return MR_IO;
}

bool hil_pty_in_use(int fd)
{
    struct pollfd look = {.fd = fd};
    return poll(&look, 1, 0) >= 0 && !(look.revents & POLLHUP);
}

uint32_t hil_pty_baud(int fd)
{
    struct termios2 t;
    return ioctl(fd, TCGETS2, &t) == 0 ? t.c_ospeed : 0;
}

void hil_pty_close(const char *path, int fd)
{
    if (fd < 0)
        return;
    close(fd);
    unlink(path);
}
