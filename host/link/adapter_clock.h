/* An adapter's clock against the host's. A frame reaches the host late, never early: the least
 * delay seen in the last 5 to 10 s is taken as the delay of the link, so what the host adds to it
 * by being busy is taken out. A zeroed clock is ready. Pure. */
#ifndef MATRIG_HOST_LINK_ADAPTER_CLOCK_H
#define MATRIG_HOST_LINK_ADAPTER_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

struct adapter_clock {
    bool known;
    int64_t offset_us[2]; /* least host - adapter time: of this period, of the one before */
    uint64_t period_us;   /* when this period began, adapter time */
};

/* Host time of a frame that the adapter received at `adapter_us`, by its own clock, and that came
 * at `host_us`; never later than that. The host's clock is one that is never set. */
uint64_t adapter_clock_time(struct adapter_clock *clock, uint64_t adapter_us, uint64_t host_us);

#endif
