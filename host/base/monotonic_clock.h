/* The monotonic clock, for durations and timeouts. Unlike the time of day it cannot be set, so it
 * never jumps. */
#ifndef MATRIG_HOST_BASE_MONOTONIC_CLOCK_H
#define MATRIG_HOST_BASE_MONOTONIC_CLOCK_H

#include <stdint.h>
#include <time.h>

/* Returns the time in microseconds since an arbitrary start, which is fixed for the life of a
 * process. */
static inline uint64_t monotonic_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}
static inline int64_t monotonic_ms(void)
{
    return (int64_t)(monotonic_us() / 1000u);
}
static inline double monotonic_s(void)
{
    return 1e-6 * (double)monotonic_us();
}

/* Returns the processor time that this process has used, in milliseconds. */
static inline double processor_time_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

#endif
