/* CAN through SocketCAN: error frames in words, what Linux adds to a frame, an adapter's clock.
 * Pure. */
#ifndef MATRIG_HOST_LINK_CAN_H
#define MATRIG_HOST_LINK_CAN_H

#include <linux/can.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/socket.h>

#include "host/link/link.h"

/* An adapter's clock against the host's. A frame reaches the host late, never early: the least
 * delay seen in the last 5 to 10 s is taken as the delay of the link, so what the host adds to it
 * by being busy is taken out. A zeroed clock is ready. Pure. */

struct adapter_clock {
    bool known;
    int64_t offset_us[2]; /* least host - adapter time: of this period, of the one before */
    uint64_t period_us;   /* when this period began, adapter time */
};

/* Host time of a frame that the adapter received at `adapter_us`, by its own clock, and that came
 * at `host_us`; never later than that. The host's clock is one that is never set. */
uint64_t adapter_clock_time(struct adapter_clock *clock, uint64_t adapter_us, uint64_t host_us);

/* What Linux tells beside a CAN frame that was received, and which frames it is asked for. */

#define CAN_CONTROL_BYTES 128u /* room for all of it */

struct can_control {
    uint64_t kernel_us;   /* Unix time of reception by the kernel; 0: not told */
    uint64_t hardware_us; /* by the adapter's own clock, which is no time of day; 0: it has none */
    bool lost_known;
    uint32_t lost; /* frames that the socket's queue has lost so far, 32 bits that wrap */
};

/* SO_TIMESTAMPING or SO_TIMESTAMPNS, and SO_RXQ_OVFL, of a message that recvmsg(2) gave. */
void can_control_take(struct msghdr *message, struct can_control *control);

/* Filters that pass the messages of the board at this base, and to it, and nothing else; at most
 * `most` of them. How many. */
size_t can_board_filters(uint16_t base, struct can_filter *filters, size_t most);

/* CAN error frames, as SocketCAN makes them: LINK_ID_ERROR in the identifier, the class of the
 * error in its other bits, details in the data (linux/can/error.h). Pure. */

#define CAN_ERROR_TEXT_MAX 400u

/* Bit 1 << enum link_trouble for each trouble that the error frame tells of; at least one is
 * set. */
uint32_t can_error_troubles(const struct link_frame *frame);

/* All that the frame says, in words: "bus off; error passive (transmitting); error counters:
 * transmit 255, receive 0". Cut to CAN_ERROR_TEXT_MAX. */
void can_error_text(const struct link_frame *frame, char out[CAN_ERROR_TEXT_MAX]);

#endif
