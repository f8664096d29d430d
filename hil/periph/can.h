/* CAN1, the bxCAN controller (RM0090 32), and its bus.
 *
 * A frame occupies the bus for its exact number of bits, including stuff bits, at the rate set by
 * BTR. The other end is a single node. It acknowledges frames, receives a frame at the last bit of
 * end of frame, and sends its frames in the given order. Whenever the bus becomes free, its frame
 * and the board's mailboxes arbitrate by identifier. Without the other node, no frame is
 * acknowledged, and TEC rises to 128 and stays there. With shorted wires, a wrong bit rate, or pins
 * that are not in CAN mode there are bit errors, and TEC rises to bus-off. If the bus is held
 * dominant, no frame begins and initialisation does not end; the error count rises by 8 every eight
 * bits, of a transmitter up to bus-off and of a receiver up to error passive. CAN2 and
 * time-triggered mode are not modelled. */
#ifndef MATRIG_HIL_CAN_H
#define MATRIG_HIL_CAN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/canbits.h"
#include "hil/periph/wire.h"

#define HIL_CAN_QUEUE_LENGTH      64u
#define HIL_CAN_FILTER_BANKS      28u
#define HIL_CAN_OTHER_NODE_HZ     1000000u
/* number of the other node as sender; the senders 0 to 2 are the board's mailboxes */
#define HIL_CAN_SENDER_OTHER_NODE 3

struct hil_can_mailbox {
    HIL_NAMED_WORDS(word, tir, tdtr, tdlr, tdhr);
    uint32_t request_number; /* numbers the requests in the order in which they were made */
};

struct hil_can_received_frame {
    HIL_NAMED_WORDS(word, rir, rdtr, rdlr, rdhr);
};

enum hil_can_phase {
    HIL_CAN_IDLE,
    HIL_CAN_FRAME,        /* from start of frame to the end of the frame or of an error */
    HIL_CAN_INTERMISSION, /* intermission, and the pause after it that a passive node must make */
    HIL_CAN_JOINING,      /* leaving initialisation: waiting for 11 recessive bits */
    HIL_CAN_BUS_OFF,      /* bus-off: waiting for recovery */
    HIL_CAN_JAMMED,       /* the bus is held dominant: the error counters rise */
    HIL_CAN_LEAVING,      /* entering initialisation */
};

struct hil_can {
    /* RFR contains only FULL and FOVR, ESR only LEC */
    HIL_NAMED_WORDS(word, mcr, msr, tsr, rfr[2], ier, esr, btr);
    uint32_t tec, rec;
    bool is_bus_off;
    struct hil_can_mailbox mailbox[3];
    uint32_t request_count; /* number of requests so far */
    struct hil_can_received_frame fifo[2][3];
    uint8_t fifo_count[2];
    HIL_NAMED_WORDS(filter_word, fmr, fm1r, reserved_208, fs1r, reserved_210, ffa1r, reserved_218,
                    fa1r);
    uint32_t filter[HIL_CAN_FILTER_BANKS][2];

    uint32_t phase;
    int8_t sender;                      /* 0..2: a mailbox; 3: the other node */
    bool is_frame_destroyed;            /* the frame in progress will be destroyed */
    bool is_frame_repeated;             /* the other node's frame has been repeated by a fault */
    uint64_t other_node_waits_until_ps; /* the other node does not start a frame before this time */
    bool is_abort_requested;
    uint32_t other_node_queue_head, other_node_queue_count;
    struct hil_can_frame other_node_queue[HIL_CAN_QUEUE_LENGTH];
};

struct hil_can_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_can *state;
    struct hil_line_calls line_calls;
};

/* Queues a frame of the other node; the frame waits for the bus and arbitrates. MR_FULL:
 * HIL_CAN_QUEUE_LENGTH frames are waiting. */
enum mr_status hil_can_inject(struct hil_can_device *dev, const struct hil_can_frame *frame);
void hil_can_set_bus(struct hil_can_device *dev, enum hil_can_bus can_bus);

/* Functions that bus and event queue call; `device` is a struct hil_can_device. */
void hil_can_reset(void *device, unsigned unit);
HIL_DECLARE_BUS_CALLS(can)
void hil_can_event(void *device, uint64_t at);
void hil_can_other_node_event(void *device, uint64_t at);

/* True if the frame passes the filters; returns the FIFO and the filter number (RM0090 32.7.4). */
bool hil_can_match_filters(const struct hil_can *can, const struct hil_can_frame *frame,
                           unsigned *fifo, unsigned *match);

#endif
