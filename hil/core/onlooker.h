/* Who looks on while the core runs: a debugger, a trace, a profile. The core calls them, and
 * knows none of them by name; what they are is in hil/debug/. An onlooker whose calls are NULL is
 * not there.
 *
 * Nothing here changes what a board does: a debugger holds virtual time, the others only look. */
#ifndef MATRIG_HIL_ONLOOKER_H
#define MATRIG_HIL_ONLOOKER_H

#include <stdbool.h>
#include <stdint.h>

struct hil_debugger_calls {
    bool (*holds)(const void *who);
    /* a watchpoint was hit: hold at the block's end */
    bool (*hit)(const void *who);
    void (*hold_hit)(void *who);
    /* the firmware's own instruction */
    void (*hold_bkpt)(void *who);
    /* must this block be walked through? */
    bool (*wants)(const void *who, uint32_t address, uint32_t size);
    /* of an instruction of such a block */
    bool (*stops_before)(void *who, uint32_t pc);
};

struct hil_tracer_calls {
    /* something may have changed at this cycle */
    void (*sample)(void *who, uint64_t at);
    void (*exception)(void *who); /* the core goes to another exception */
    /* tell when a block at this address is entered? */
    bool (*marks)(const void *who, uint32_t address);
    void (*block)(void *who, uint32_t address);
    void (*end)(void *who); /* the board is destroyed */
};

struct hil_profiler_calls {
    uint32_t (*block)(void *who, uint32_t address, uint32_t size); /* its number */
    /* so many of that block have run */
    void (*count)(void *who, uint32_t number, uint32_t instructions);
    void (*exception)(void *who, unsigned exception); /* 0: thread */
    void (*end)(void *who);
};

struct hil_onlookers {
    const struct hil_debugger_calls *debugger;
    const struct hil_tracer_calls *tracer;
    const struct hil_profiler_calls *profiler;
    void *debugger_who, *tracer_who, *profiler_who;
};

#endif
