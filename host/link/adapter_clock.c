#include "host/link/adapter_clock.h"

#define PERIOD_US 5000000u

uint64_t adapter_clock_time(struct adapter_clock *clock, uint64_t adapter_us, uint64_t host_us)
{
    int64_t offset_us = (int64_t)(host_us - adapter_us);
    bool back = clock->known && adapter_us < clock->period_us; /* the adapter began again */
    if (!clock->known || back) {
        clock->offset_us[0] = clock->offset_us[1] = offset_us;
        clock->period_us = adapter_us;
    } else if (adapter_us - clock->period_us >= PERIOD_US) {
        clock->offset_us[1] = clock->offset_us[0];
        clock->offset_us[0] = offset_us;
        clock->period_us = adapter_us;
    } else if (offset_us < clock->offset_us[0]) {
        clock->offset_us[0] = offset_us;
    }
    clock->known = true;
    int64_t least_us = clock->offset_us[0] < clock->offset_us[1] ? clock->offset_us[0]
                                                                 : clock->offset_us[1];
    return adapter_us + (uint64_t)least_us;
}
