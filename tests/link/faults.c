/* Changes what one program takes for the time, and how much room its disk has. A library for LD_PRELOAD, for tests:
 *
 *     CLOCK_RATE=20                both clocks pass 20 times as fast
 *     CLOCK_JUMP=FILE:SECONDS      the time of day is SECONDS later (earlier when negative) from when FILE is there
 *     DISK_FULL=FILE:PART          writing to paths that contain PART fails as on a full disk as long as FILE is there
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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
    static struct timespec begun[2];
    const char *seconds, *rate = getenv("CLOCK_RATE");
    if (!real)
        *(void **)&real = dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, at);
    if (result != 0 || (clock != CLOCK_REALTIME && clock != CLOCK_MONOTONIC))
        return result;
    struct timespec *first = &begun[clock == CLOCK_MONOTONIC];
    if (first->tv_sec == 0)
        *first = *at;
    int64_t passed = (at->tv_sec - first->tv_sec) * NS + at->tv_nsec - first->tv_nsec;
    int64_t now = first->tv_sec * NS + first->tv_nsec + (int64_t)((double)passed * (rate ? strtod(rate, NULL) : 1.0));
    if (clock == CLOCK_REALTIME && is_there("CLOCK_JUMP", &seconds))
        now += (int64_t)(strtod(seconds, NULL) * (double)NS);
    at->tv_sec = (time_t)(now / NS);
    at->tv_nsec = (long)(now % NS);
    return 0;
}

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
    if (is_full(fd)) {
        errno = ENOSPC;
        return -1;
    }
    return real(fd, bytes, size, at);
}
