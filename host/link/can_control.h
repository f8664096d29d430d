/* What Linux tells beside a CAN frame that was received, and which frames it is asked for. */
#ifndef MATRIG_HOST_LINK_CAN_CONTROL_H
#define MATRIG_HOST_LINK_CAN_CONTROL_H

#include <linux/can.h>
#include <stddef.h>
#include <stdbool.h>
#include <stdint.h>
#include <sys/socket.h>

#include "host/link/bases.h"

#define CAN_CONTROL_BYTES 128u /* room for all of it */

struct can_control {
    uint64_t kernel_us;   /* Unix time of reception by the kernel; 0: not told */
    uint64_t hardware_us; /* by the adapter's own clock, which is no time of day; 0: it has none */
    bool lost_known;
    uint32_t lost; /* frames that the socket's queue has lost so far, 32 bits that wrap */
};

/* SO_TIMESTAMPING or SO_TIMESTAMPNS, and SO_RXQ_OVFL, of a message that recvmsg(2) gave. */
void can_control_take(struct msghdr *message, struct can_control *control);

/* Filters that pass the messages of the boards at these bases, and to them, and nothing else; at
 * most `most` of them. How many. */
size_t can_board_filters(const struct link_bases *bases, struct can_filter *filters, size_t most);

#endif
