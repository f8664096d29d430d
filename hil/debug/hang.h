/* Notices a firmware that hangs: virtual time goes on, the firmware does not.
 *
 * It hangs when for `limit_s` of virtual time
 * - the core neither slept nor took an exception, and no frame or byte left the board; or
 * - the core did not sleep, although this firmware has slept since the last reset: interrupts may
 * go on, the
 *   loop below them does not.
 * A firmware that polls without ever sleeping but is served by interrupts or keeps talking is
 * none. */
#ifndef MATRIG_HIL_HANG_H
#define MATRIG_HIL_HANG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "hil/board/board.h"
#include "hil/symbols.h"

#define HIL_HANG_PLACES 32u

struct hil_hang {
    uint64_t limit_ps; /* 0: never */
    uint64_t asleep_cycles, exceptions, spoken, resets;
    uint64_t slept_ps, progress_ps; /* when last seen to change */
    bool sleeps;                    /* since the last reset */
    /* Where the core was seen since it last slept: functions, or addresses without symbols. */
    struct {
        uint32_t address;
        uint32_t pc;
        unsigned seen;
    } place[HIL_HANG_PLACES];
    unsigned places;
};

void hil_hang_start(struct hil_hang *hang, double limit_s);
/* To be called every few milliseconds of virtual time, not while a debugger holds the board. True:
 * it hangs, and `text` says since when and where. */
bool hil_hang_look(struct hil_hang *hang, const struct hil_board *board,
                   const struct mr_symbols *symbols, char *text, size_t size);

#endif
