/* A register of the core, for those who look. */
#ifndef MATRIG_HIL_CPU_REGISTERS_H
#define MATRIG_HIL_CPU_REGISTERS_H

#include <stdint.h>

struct hil_core;

/* One register: 0..12, 13 the current SP, 14, 15 PC, 16 xPSR, 17 PRIMASK. */
#define HIL_PRIMASK 17u
uint32_t hil_cpu_register(const struct hil_core *core, unsigned number);

#endif
