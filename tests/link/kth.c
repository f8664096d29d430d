/* Lets one call of a kind fail. A library for LD_PRELOAD, for tests:
 *
 *     KTH=KIND:K:ERRNO    the K-th call fails with that number, once; K 0: none does
 *     KTH=KIND:-K:ERRNO   the K-th and all that follow
 *     KTH_COUNT=FILE      gets the number of calls at each call: 8 bytes
 *
 * KIND is write, sync, rename, open or mmap. Counted are calls of the program and of the libraries
 * it is linked with, SQLite among them, but not those within libc. Writes to standard output and
 * standard error are not counted. */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <unistd.h>

static _Atomic int64_t calls;
static int64_t *count, fails_at;
static int number;
static char kind[16];

__attribute__((constructor)) static void read_environment(void)
{
    const char *what = getenv("KTH"), *path = getenv("KTH_COUNT");
    long long at = 0;
    if (!what || sscanf(what, "%15[a-z]:%lld:%d", kind, &at, &number) != 3)
        return;
    fails_at = at;
    int (*open_file)(const char *, int, ...);
    void *(*map)(void *, size_t, int, int, int, off64_t);
    *(void **)&open_file = dlsym(RTLD_NEXT, "open64");
    *(void **)&map = dlsym(RTLD_NEXT, "mmap64");
    int fd = path ? open_file(path, O_RDWR | O_CLOEXEC) : -1;
    void *place = fd >= 0 ? map(NULL, 8, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) : MAP_FAILED;
    if (place != MAP_FAILED)
        count = place;
    if (fd >= 0)
        close(fd);
}

static int fails(const char *this)
{
    if (strcmp(kind, this) != 0)
        return 0;
    int64_t call = atomic_fetch_add(&calls, 1) + 1;
    if (count)
        *count = call;
    if (call != fails_at && (fails_at >= 0 || call < -fails_at))
        return 0;
    errno = number;
    return 1;
}

#define STANDARD(fd) ((fd) == STDOUT_FILENO || (fd) == STDERR_FILENO)
/* RESULT NAME(PARAMETERS): `failed` when a call of KIND is to fail, else what the next library's
 * does. */
#define CALL(kind_of, result, failed, name, parameters, arguments, counted) \
    result name parameters                                                  \
    {                                                                       \
        static result(*real) parameters;                                    \
        if (!real)                                                          \
            *(void **)&real = dlsym(RTLD_NEXT, #name);                      \
        return (counted) && fails(kind_of) ? (failed) : real arguments;     \
    }
CALL("write", ssize_t, -1, write, (int fd, const void *from, size_t size), (fd, from, size),
     !STANDARD(fd))
CALL("write", ssize_t, -1, pwrite, (int fd, const void *from, size_t size, off_t at),
     (fd, from, size, at), 1)
CALL("write", ssize_t, -1, pwrite64, (int fd, const void *from, size_t size, off64_t at),
     (fd, from, size, at), 1)
CALL("sync", int, -1, fsync, (int fd), (fd), 1)
CALL("sync", int, -1, fdatasync, (int fd), (fd), 1)
CALL("rename", int, -1, rename, (const char *from, const char *to), (from, to), 1)
CALL("open", FILE *, NULL, fopen, (const char *path, const char *mode), (path, mode), 1)
CALL("open", FILE *, NULL, fopen64, (const char *path, const char *mode), (path, mode), 1)
CALL("mmap", void *, MAP_FAILED, mmap,
     (void *at, size_t size, int how, int flags, int fd, off_t from),
     (at, size, how, flags, fd, from), 1)
CALL("mmap", void *, MAP_FAILED, mmap64,
     (void *at, size_t size, int how, int flags, int fd, off64_t from),
     (at, size, how, flags, fd, from), 1)

#define OPENS(name)                                               \
    int name(const char *path, int flags, ...)                    \
    {                                                             \
        static int (*real)(const char *, int, ...);               \
        va_list more;                                             \
        va_start(more, flags);                                    \
        mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0; \
        va_end(more);                                             \
        if (!real)                                                \
            *(void **)&real = dlsym(RTLD_NEXT, #name);            \
        return fails("open") ? -1 : real(path, flags, mode);      \
    }
OPENS(open)
OPENS(open64)
