/* CAN1, the bxCAN controller (RM0090 32), and its bus.
 *
 * A frame holds the bus for its exact number of bits, stuff bits included, at the rate that BTR
 * gives. The other side is one node: it acknowledges, receives at the last bit of end of frame, and
 * sends frames in the order given, arbitrating by identifier with the board's mailboxes whenever
 * the bus becomes free. Nobody there: no acknowledge, TEC rises to 128 and sticks. Wires touching,
 * a wrong bit rate, or pins not given to CAN: bit errors, TEC rises to bus-off. Held dominant:
 * nothing begins, initialisation is not left, a transmitter counts to bus-off and a receiver to
 * error passive, eight for each eight bits. CAN2 and time-triggered mode are not modelled. */
#ifndef MATRIG_HIL_CAN_H
#define MATRIG_HIL_CAN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/canbits.h"
#include "hil/periph/wire.h"

#define HIL_CAN_QUEUE      64u
#define HIL_CAN_BANKS      28u
#define HIL_CAN_HOST_RATE  1000000u
#define HIL_CAN_OTHER_NODE 3 /* as a sender; the board's are its mailboxes */

struct hil_can_mailbox {
    HIL_WORDS(word, tir, tdtr, tdlr, tdhr);
    uint32_t order; /* of its request */
};

struct hil_can_received {
    HIL_WORDS(word, rir, rdtr, rdlr, rdhr);
};

enum hil_can_phase {
    HIL_CAN_IDLE,
    HIL_CAN_FRAME,   /* from start of frame to the end, good or bad */
    HIL_CAN_GAP,     /* intermission; suspended transmission of a passive node included */
    HIL_CAN_JOINING, /* leaving initialisation: waits for 11 recessive bits */
    HIL_CAN_OFF,     /* bus-off, waiting */
    HIL_CAN_JAMMED,  /* the bus is held dominant: counting errors, then waiting */
    HIL_CAN_LEAVING, /* on the way to initialisation */
};

struct hil_can {
    HIL_WORDS(word, mcr, msr, tsr, rfr[2], ier, esr, btr); /* RFR: FULL and FOVR; ESR: LEC */
    uint32_t tec, rec;
    bool bus_off;
    struct hil_can_mailbox mailbox[3];
    uint32_t orders; /* requests so far */
    struct hil_can_received fifo[2][3];
    uint8_t fifo_count[2];
    HIL_WORDS(filter_word, fmr, fm1r, at_208, fs1r, at_210, ffa1r, at_218, fa1r);
    uint32_t filter[HIL_CAN_BANKS][2];

    uint32_t phase;
    int8_t sender;           /* mailbox 0..2, 3: the other node */
    bool spoiled;            /* the frame under way will be destroyed */
    bool repeated;           /* the other node's frame has been sent once too often */
    uint64_t other_waits_ps; /* the other node does not begin before */
    bool abort_current;
    uint32_t queue_head, queue_count;
    struct hil_can_frame queue[HIL_CAN_QUEUE];
};

struct hil_can_device {
    HIL_NEIGHBOURS;
    struct hil_can *state;
    struct hil_wire wire;
};

/* A frame of the other node; it waits for the bus and arbitrates. MR_FULL when HIL_CAN_QUEUE
 * wait. */
enum mr_status hil_can_inject(struct hil_can_device *dev, const struct hil_can_frame *frame);
void hil_can_set_bus(struct hil_can_device *dev, enum hil_can_bus can_bus);

/* For the bus and the event queue; `device` is a struct hil_can_device. */
void hil_can_reset(void *device, unsigned unit);
HIL_ON_BUS(can)
void hil_can_event(void *device, uint64_t at);
void hil_can_other_event(void *device, uint64_t at);

/* Does the frame pass the filters, into which FIFO, by which filter number? (32.7.4) */
bool hil_can_filter(const struct hil_can *can, const struct hil_can_frame *frame, unsigned *fifo,
                    unsigned *match);

#endif
