/* Fault counters. Drivers and application count here; telemetry tells. May be called from
 * interrupts. */
#ifndef MATRIG_FIRMWARE_HEALTH_H
#define MATRIG_FIRMWARE_HEALTH_H

#include <stdbool.h>
#include <stdint.h>

#include "common/fault.h"

struct health_counter {
    uint16_t count; /* since reset; stays at 65535 */
    uint8_t detail; /* of the last one */
    uint8_t changed;
    uint32_t block; /* of the last one */
};

/* Count one fault. `detail` as the fault table says, else 0. */
void health_count(enum mr_fault_code fault, uint8_t detail);
/* The block that faults counted from now on belong to. */
void health_set_block(uint32_t block);
uint32_t health_block(void);
/* Times since reset; stays at 65535. */
uint16_t health_counted(enum mr_fault_code fault);
/* Bit n: fault n has occurred since reset. */
uint32_t health_faults(void);
/* Copy of a counter; clears its `changed`. */
struct health_counter health_take(enum mr_fault_code fault);

#endif
