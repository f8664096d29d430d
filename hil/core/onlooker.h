/* Who looks on while the core runs: a debugger, a trace, a profile, a watch of single stores. The core calls them, and
 * knows none of them by name; what they are is in hil/debug/. An onlooker whose calls are NULL is not there.
 *
 * Nothing here changes what a board does: a debugger holds virtual time, the others only look. */
#ifndef MATRIG_HIL_ONLOOKER_H
#define MATRIG_HIL_ONLOOKER_H

#include <stdbool.h>
#include <stdint.h>

struct hil_debugger_calls {
    bool (*holds)(const void *who);
    bool (*hit)(const void *who);                                     /* a watchpoint was hit: hold at the block's end */
    void (*hold_hit)(void *who);
    void (*hold_bkpt)(void *who);                                     /* the firmware's own instruction */
    bool (*wants)(const void *who, uint32_t address, uint32_t size);  /* must this block be walked through? */
    bool (*stops_before)(void *who, uint32_t pc);                     /* of an instruction of such a block */
};

struct hil_tracer_calls {
    void (*sample)(void *who, uint64_t at);                /* something may have changed at this cycle */
    void (*exception)(void *who);                          /* the core goes to another exception */
    bool (*marks)(const void *who, uint32_t address);      /* tell when a block at this address is entered? */
    void (*block)(void *who, uint32_t address);
    void (*end)(void *who);                                /* the board is destroyed */
};

struct hil_profiler_calls {
    uint32_t (*block)(void *who, uint32_t address, uint32_t size);       /* its number */
    void (*count)(void *who, uint32_t number, uint32_t instructions);    /* so many of that block have run */
    void (*exception)(void *who, unsigned exception);                    /* 0: thread */
    void (*end)(void *who);
};

struct hil_store_watch_calls {
    bool (*wants)(const void *who, uint32_t address, uint32_t size); /* must this block be walked through? */
    void (*at)(void *who, uint32_t pc);                              /* the instruction that runs, of such a block */
};

struct hil_onlookers {
    const struct hil_debugger_calls *debugger;
    const struct hil_tracer_calls *tracer;
    const struct hil_profiler_calls *profiler;
    const struct hil_store_watch_calls *store_watch;
    void *debugger_who, *tracer_who, *profiler_who, *store_watch_who;
};

#endif
