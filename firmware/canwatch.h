/* Watches the CAN link every 10 ms: its state, and the handling of frames while the bus is blocked.
 *
 * Nothing passes when a frame waits and none has gone out for 20 ms. An unplugged cable is
 * recognised by its error: no node acknowledges, TEC stands at 128, and bus-off never comes (ISO
 * 11898-1, fault confinement, exception 1). Frames wait for 100 ms: a connector that bounces loses
 * nothing. After that they would be stale, and serial and the black box have them: waiting and new
 * frames are dropped and counted, and one frame, the alarm, is left to the controller, which
 * repeats it until a node acknowledges it. Then frames are accepted again, and the first one
 * reports the length of the outage.
 *
 * Bus-off is left ten times a second at most: a board that is broken, or on a shorted bus, then
 * disturbs it for a hundredth of the time. Pure but for the calls of board.h. */
#ifndef MATRIG_FIRMWARE_CANWATCH_H
#define MATRIG_FIRMWARE_CANWATCH_H

#include "common/catalogue.h"
#include "common/fault.h"
#include "firmware/board.h"

#define CANWATCH_OUTAGE_TICKS 2u
#define CANWATCH_STALE_TICKS  10u
#define CANWATCH_REJOIN_TICKS 10u

enum canwatch_phase { CANWATCH_UP, CANWATCH_CLEARING, CANWATCH_PROBING };

struct canwatch {
    enum mr_can_state state;
    enum canwatch_phase phase;
    struct board_can_errors errors;
    bool silent;            /* the clock is not exact enough: nothing is sent, nothing is watched */
    uint32_t passed;        /* at the last tick */
    unsigned stalled_ticks; /* since a frame went out, or none waited */
    unsigned rejoin_ticks;  /* until bus-off may be left again */
    bool rejoining;
    uint16_t outages;
    uint32_t outage_ticks; /* of the one that goes on, or of the last */
    uint32_t removed;      /* frames that were queued, and dropped */
    struct mr_can_drops drops;
};

/* The report of a tick. */
struct canwatch_news {
    bool changed; /* the state: on serial at once */
    bool probe;   /* the alarm is to be left to the controller now */
    bool back;    /* an outage is over: alarm and drops on both links */
    bool passive; /* error passive since this tick */
    bool off;     /* bus-off since this tick */
};

void canwatch_start(struct canwatch *watch, bool silent);
struct canwatch_news canwatch_tick(struct canwatch *watch);
/* Whether a frame may be queued now. One that may not is counted. */
bool canwatch_takes(struct canwatch *watch);
/* The queue refused a frame. */
void canwatch_full(struct canwatch *watch);
struct mr_can_alarm canwatch_alarm(const struct canwatch *watch);

#endif
