#include "host/link/pts.h"

#include <asm/termbits.h> /* struct termios2, for any rate; not to be mixed with termios.h */
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/file.h>
#include <sys/ioctl.h>

enum mr_status pts_line(const char *spec, int fd, int baud, struct error *error)
{
    struct termios2 t;
    bool set = ioctl(fd, TCGETS2, &t) == 0;
    if (set) {
        t.c_iflag = t.c_oflag = t.c_lflag = 0;
        t.c_cflag = CS8 | CREAD | CLOCAL | BOTHER;
        t.c_ispeed = t.c_ospeed = (speed_t)baud;
        t.c_cc[VMIN] = 1;
        t.c_cc[VTIME] = 0;
        set = ioctl(fd, TCSETS2, &t) == 0;
    }
    if (!set)
        return error_set(error, MR_IO, "no terminal (%s): %s; write unix:PATH for a socket",
                         strerror(errno), spec);
    ioctl(fd, TCFLSH, TCIFLUSH);
    return MR_OK;
}

enum mr_status pts_open(const char *spec, const char *path, int baud, int *fd, struct error *error)
{
    *fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (*fd < 0)
        return error_set(error, MR_IO,
                         "cannot open the terminal (%s): %s; start the emulated board there first",
                         strerror(errno), spec);
    if (flock(*fd, LOCK_EX | LOCK_NB) != 0) /* each would take bytes from the other */
        return error_set(error, MR_IO, "another matrig has the terminal: %s; end it first", spec);
    return pts_line(spec, *fd, baud, error);
}
