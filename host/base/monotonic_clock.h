/* The monotonic clock, which nobody sets: for durations and the ends of waits. */
#ifndef MATRIG_HOST_BASE_MONOTONIC_CLOCK_H
#define MATRIG_HOST_BASE_MONOTONIC_CLOCK_H

#include <stdint.h>

/* Since some time that is the same for all of a process. */
double monotonic_s(void);
int64_t monotonic_ms(void);
uint64_t monotonic_us(void);

/* Processor time that this process has used: other processes do not count. */
double processor_ms(void);

#endif
