/* One CAN bus with several boards and one host on it, in lockstep.
 *
 *     struct hil_canbus *bus = hil_canbus_create();
 *     hil_canbus_join(bus, board);                   (each, before it runs)
 *     hil_canbus_run_until(bus, 10 * HIL_SECOND_PS); (in place of hil_board_run_until)
 *
 * Who begins. A frame holds the bus for its exact number of bits and the three of intermission.
 * When the bus is free, who is ready first begins; who is ready less than a bit later begins with
 * it, and the lowest identifier wins: at the end of a frame all who wait. The loser's mailbox is
 * marked (ALST). The host has one queue, in the order given; it acknowledges, and its frames wait
 * until a board listens.
 *
 * Exact, though boards run one after the other. A frame that begins changes what another board does
 * when it ends, 44 bits later at the soonest. So all boards run HIL_CANBUS_LOOK_PS past the moment
 * when the bus is free, each only notes since when it has a frame ready, and then the bus decides
 * who has begun, and when. Until it has decided, MSR.TXM and RXM do not show that a frame is under
 * way.
 *
 * Not there. A board that is in reset, bus-off, joining, or whose cable is unplugged, and one with
 * a wrong bit rate: the others go on without it (on a real bus a wrong bit rate disturbs all). A
 * frame whose sender is reset breaks off: all see an error.
 *
 * Errors. A frame that a fault corrupts at one of its ends is bad for all: error frame, counters,
 * sent again. Two boards that send the same identifier with other data are told and counted: where
 * the data differ, who sends a recessive bit sees an error, and destroys the frame unless it is
 * error passive; the bus is held as for a frame that is bad at the end of its CRC. The same
 * identifier with the same data: one after the other, which a real bus does not tell apart. */
#ifndef MATRIG_HIL_CANBUS_H
#define MATRIG_HIL_CANBUS_H

#include <stdint.h>

#include "common/status.h"
#include "hil/core/time.h"

struct hil_board;
struct hil_canbus; /* opaque */

#define HIL_CANBUS_BOARDS  4u
/* Less than the 44 bits of the shortest frame at 1 Mbit/s, by a bit and by the longest block of
 * instructions. */
#define HIL_CANBUS_LOOK_PS (36ull * HIL_US_PS)

struct hil_canbus_counts {
    uint64_t frames;     /* that began, good or bad */
    uint64_t bad;        /* of these */
    uint64_t collisions; /* of these: the same identifier from two boards at the same time */
    uint64_t busy_ps;    /* time that frames, good or bad, held the bus; without intermissions */
};

/* Aborts on lack of memory. Destroying frees the bus, not its boards. NULL is allowed. */
struct hil_canbus *hil_canbus_create(void);
void hil_canbus_destroy(struct hil_canbus *bus);
/* The board's CAN is on this bus from now on; both must live while either runs. MR_USAGE: its chip
 * has the identity of one that is there already. MR_FULL: HIL_CANBUS_BOARDS are there. */
enum mr_status hil_canbus_join(struct hil_canbus *bus, struct hil_board *board);
/* Run all boards until virtual time t_ps. Otherwise as hil_board_run_until; *stopped is the number
 * of the board that cannot go on, in the order in which they joined, from 0. */
enum mr_status hil_canbus_run_until(struct hil_canbus *bus, uint64_t t_ps, unsigned *stopped);
uint64_t hil_canbus_now_ps(const struct hil_canbus *bus);
const struct hil_canbus_counts *hil_canbus_counts(const struct hil_canbus *bus);

#endif
