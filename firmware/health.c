#include "firmware/health.h"

static volatile struct health_counter counters[MR_FAULT_COUNT];
static volatile uint32_t current_block;

_Static_assert(MR_FAULT_COUNT <= 32, "health.faults has one bit per fault");

void health_count(enum mr_fault_code fault, uint8_t detail)
{
    volatile struct health_counter *counter = &counters[fault];
    if (counter->count < UINT16_MAX)
        counter->count++;
    counter->detail = detail;
    counter->block = current_block;
    counter->changed = 1;
}

void health_set_block(uint32_t block)
{
    current_block = block;
}

uint16_t health_counted(enum mr_fault_code fault)
{
    return counters[fault].count;
}

uint32_t health_block(void)
{
    return current_block;
}

uint32_t health_faults(void)
{
    uint32_t faults = 0;
    for (unsigned i = 0; i < MR_FAULT_COUNT; i++) {
        if (counters[i].count)
            faults |= 1u << i;
    }
    return faults;
}

struct health_counter health_take(enum mr_fault_code fault)
{
    volatile struct health_counter *counter = &counters[fault];
    /* Clear first: a fault counted by an interrupt in between is then told again rather than
     * lost. */
    uint8_t changed = counter->changed;
    counter->changed = 0;
    return (struct health_counter){.count = counter->count,
                                   .detail = counter->detail,
                                   .changed = changed,
                                   .block = counter->block};
}
