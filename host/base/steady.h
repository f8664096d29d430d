/* A clock that nobody sets: for how long things take and when waits end. */
#ifndef MATRIG_HOST_BASE_STEADY_H
#define MATRIG_HOST_BASE_STEADY_H

#include <stdint.h>

/* Since some time that is the same for all of a process. */
double steady_s(void);
int64_t steady_ms(void);
uint64_t steady_us(void);

/* Processor time that this process has used: other processes do not count. */
double processor_ms(void);

#endif
