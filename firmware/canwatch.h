/* Supervises the CAN link every 10 ms: determines its state and handles frames while the bus is
 * blocked.
 *
 * The bus counts as blocked if a frame is waiting and none has been sent for 20 ms. An unplugged
 * cable is recognised by its errors: no node acknowledges, TEC stays at 128, and bus-off never
 * occurs (ISO 11898-1, fault confinement, exception 1). Frames wait for 100 ms, so that a bouncing
 * connector causes no loss. After that, waiting and new frames are dropped and counted, because
 * their data would be out of date and is also sent to serial and the black box. Only the alarm
 * frame stays in the controller, which repeats it until a node acknowledges it. Then frames are
 * accepted again, and the first one reports the length of the outage.
 *
 * The board leaves bus-off at most ten times per second, so that a broken board disturbs the bus
 * for only a hundredth of the time. Pure except for the calls of board.h. */
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
    /* nothing is sent or supervised, because the clock is not accurate enough for CAN */
    bool is_silent;
    uint32_t sent_count;    /* frames sent up to the last tick */
    unsigned stalled_ticks; /* number of ticks since a frame was sent or no frame was waiting */
    unsigned rejoin_ticks;  /* number of ticks until the board may leave bus-off again */
    bool is_rejoining;
    uint16_t outages;
    uint32_t outage_ticks;  /* length of the present or the last outage, ticks */
    uint32_t removed_count; /* queued frames that were dropped */
    struct mr_can_drops drop_count;
};

/* Result of a tick. */
struct canwatch_changes {
    bool has_state_changed;  /* the state changed: report it on serial at once */
    bool must_send_probe;    /* the alarm frame must be passed to the controller now */
    bool has_outage_ended;   /* an outage has ended: send alarm and drops on both links */
    bool has_become_passive; /* the controller has become error passive in this tick */
    bool has_become_off;     /* the controller has become bus-off in this tick */
};

void canwatch_start(struct canwatch *watch, bool silent);
struct canwatch_changes canwatch_tick(struct canwatch *watch);
/* True if a frame may be queued now. Counts the frame as refused if not. */
bool canwatch_is_accepting(struct canwatch *watch);
/* Call when the queue has refused a frame. */
void canwatch_count_queue_full(struct canwatch *watch);
struct mr_can_alarm canwatch_get_alarm(const struct canwatch *watch);

#endif
