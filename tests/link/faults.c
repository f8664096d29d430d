/* Changes what one program takes for the time, and how much room its disk has. A library for
 * LD_PRELOAD, for tests:
 *
 *     CLOCK_RATE=FILE:20           both clocks pass 20 times as fast as long as FILE is there
 *     CLOCK_JUMP=FILE:SECONDS      the time of day is SECONDS later (earlier when negative) from
 *                                  when FILE is there
 *     DISK_FULL=FILE:PART          writing to paths that contain PART fails as on a full disk as
 *                                  long as FILE is there
 *     DISK_STALL=FILE:SECONDS      the next fsync or fdatasync after FILE came to be there takes
 *                                  SECONDS; FILE goes
 *     PLACE=PART:WHAT              what is at paths that contain PART lies on a disk that is
 *                                  read-only, failing or unreadable, or has no-locks, no-shared
 *                                  memory or no-quota left */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#define NS 1000000000ll

/* FILE of "FILE:REST" is there; `*rest` is REST. */
static int is_there(const char *variable, const char **rest)
{
    char path[512];
    const char *value = getenv(variable);
    const char *colon = value ? strrchr(value, ':') : NULL;
    if (!colon || (size_t)(colon - value) >= sizeof path)
        return 0;
    memcpy(path, value, (size_t)(colon - value));
    path[colon - value] = '\0';
    *rest = colon + 1;
    return access(path, F_OK) == 0;
}

int clock_gettime(clockid_t clock, struct timespec *at)
{
    static int (*real)(clockid_t, struct timespec *);
    static int64_t real_ns[2], shown_ns[2]; /* at the last look */
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    const char *seconds, *rate;
    pthread_mutex_lock(&lock);
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, at);
    if (result != 0 || (clock != CLOCK_REALTIME && clock != CLOCK_MONOTONIC)) {
        pthread_mutex_unlock(&lock);
        return result;
    }
    int which = clock == CLOCK_MONOTONIC;
    int64_t now_ns = at->tv_sec * NS + at->tv_nsec;
    int64_t passed_ns = real_ns[which] ? now_ns - real_ns[which] : 0;
    shown_ns[which] = real_ns[which] ? shown_ns[which] : now_ns;
    shown_ns[which] += is_there("CLOCK_RATE", &rate)
                         ? (int64_t)((double)passed_ns * strtod(rate, NULL))
                         : passed_ns;
    real_ns[which] = now_ns;
    int64_t shown = shown_ns[which];
    pthread_mutex_unlock(&lock);
    if (!which && is_there("CLOCK_JUMP", &seconds))
        shown += (int64_t)(strtod(seconds, NULL) * (double)NS);
    at->tv_sec = (time_t)(shown / NS);
    at->tv_nsec = (long)(shown % NS);
    return 0;
}

/* PLACE says so of the path. */
static int is_at(const char *path, const char *what)
{
    const char *value = getenv("PLACE"), *colon = value ? strrchr(value, ':') : NULL;
    char part[256];
    if (!colon || strcmp(colon + 1, what) != 0 || (size_t)(colon - value) >= sizeof part)
        return 0;
    memcpy(part, value, (size_t)(colon - value));
    part[colon - value] = '\0';
    return strstr(path, part) != NULL;
}

static int is_file_at(int fd, const char *what)
{
    char link[40], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = getenv("PLACE") && fd >= 0 ? readlink(link, path, sizeof path - 1) : -1;
    path[length > 0 ? length : 0] = '\0';
    return length > 0 && is_at(path, what);
}

static int refused(int number)
{
    errno = number;
    return -1;
}

#define OPENS(name)                                                              \
    int name(const char *path, int flags, ...)                                   \
    {                                                                            \
        int (*real)(const char *, int, ...);                                     \
        va_list more;                                                            \
        va_start(more, flags);                                                   \
        mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;                \
        va_end(more);                                                            \
        *(void **)&real = dlsym(RTLD_NEXT, #name);                               \
        return flags & (O_WRONLY | O_RDWR | O_CREAT) && is_at(path, "read-only") \
                 ? refused(EROFS)                                                \
                 : real(path, flags, mode);                                      \
    }
OPENS(open)
OPENS(open64)

int access(const char *path, int how)
{
    int (*real)(const char *, int);
    *(void **)&real = dlsym(RTLD_NEXT, "access");
    return how & W_OK && is_at(path, "read-only") ? refused(EROFS) : real(path, how);
}

#define LOCKS(name)                                                                     \
    int name(int fd, int command, ...)                                                  \
    {                                                                                   \
        int (*real)(int, int, ...);                                                     \
        va_list more;                                                                   \
        va_start(more, command);                                                        \
        void *argument = va_arg(more, void *);                                          \
        va_end(more);                                                                   \
        *(void **)&real = dlsym(RTLD_NEXT, #name);                                      \
        return (command == F_SETLK || command == F_GETLK) && is_file_at(fd, "no-locks") \
                 ? refused(ENOLCK)                                                      \
                 : real(fd, command, argument);                                         \
    }
LOCKS(fcntl)
LOCKS(fcntl64)

#define MAPS(name)                                                                  \
    void *name(void *at, size_t length, int how, int flags, int fd, off64_t offset) \
    {                                                                               \
        void *(*real)(void *, size_t, int, int, int, off64_t);                      \
        *(void **)&real = dlsym(RTLD_NEXT, #name);                                  \
        if (fd >= 0 && flags & MAP_SHARED && is_file_at(fd, "no-shared")) {         \
            errno = ENODEV;                                                         \
            return MAP_FAILED;                                                      \
        }                                                                           \
        return real(at, length, how, flags, fd, offset);                            \
    }
MAPS(mmap)
MAPS(mmap64)

static int is_full(int fd)
{
    char link[64], path[512];
    const char *part;
    if (!is_there("DISK_FULL", &part))
        return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    path[length > 0 ? length : 0] = '\0';
    return strstr(path, part) != NULL;
}

ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t at)
{
    static ssize_t (*real)(int, const void *, size_t, off64_t);
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "pwrite64");
    if (is_full(fd))
        return refused(ENOSPC);
    if (is_file_at(fd, "no-quota"))
        return refused(EDQUOT);
    return is_file_at(fd, "failing") ? refused(EIO) : real(fd, bytes, size, at);
}

ssize_t pread64(int fd, void *bytes, size_t size, off64_t at)
{
    static ssize_t (*real)(int, void *, size_t, off64_t);
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "pread64");
    return at > 0 && is_file_at(fd, "unreadable") ? refused(EIO) : real(fd, bytes, size, at);
}

static void stall(void)
{
    char path[512];
    const char *seconds, *value = getenv("DISK_STALL");
    if (!value || !is_there("DISK_STALL", &seconds))
        return;
    memcpy(path, value, (size_t)(seconds - 1 - value));
    path[seconds - 1 - value] = '\0';
    if (unlink(path) != 0)
        return;
    double left_s = strtod(seconds, NULL);
    struct timespec wait = {(time_t)left_s, (long)((left_s - (double)(time_t)left_s) * (double)NS)};
    while (nanosleep(&wait, &wait) != 0 && errno == EINTR)
        ;
}

int fsync(int fd)
{
    static int (*real)(int);
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "fsync");
    stall();
    return real(fd);
}

int fdatasync(int fd)
{
    static int (*real)(int);
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "fdatasync");
    stall();
    return real(fd);
}
