/* A CAN frame, the possible states of the bus, and the length of a frame on the wire, computed from
 * its real bit stream (ISO 11898-1 10.4 to 10.5). */
#ifndef MATRIG_HIL_CANBITS_H
#define MATRIG_HIL_CANBITS_H

#include <stdbool.h>
#include <stdint.h>

enum hil_can_bus {
    HIL_CAN_CONNECTED, /* the other node acknowledges */
    HIL_CAN_UNPLUGGED, /* no node acknowledges */
    HIL_CAN_SHORTED,   /* the wires are shorted: every bit reads back recessive */
    /* the bus is held dominant: no frame can begin, and no node leaves initialisation */
    HIL_CAN_DOMINANT,
};

struct hil_can_frame {
    uint32_t id; /* identifier of 11 or 29 bits */
    bool is_extended;
    bool is_remote;
    uint8_t length; /* 0..8 */
    uint8_t data[8];
};

/* Bits after the stuffed part: CRC delimiter, ACK slot, ACK delimiter and seven bits of end of
 * frame. */
#define HIL_CAN_TAIL_BITS         10u
#define HIL_CAN_INTERMISSION_BITS 3u
#define HIL_CAN_ERROR_BITS        14u /* bits of an error frame: flag 6, delimiter 8 */

struct hil_can_bits {
    uint16_t crc;        /* CRC-15 of the frame */
    unsigned stuff_bits; /* number of inserted stuff bits */
    /* bits from start of frame to the last bit of end of frame, including stuff bits */
    unsigned length;
};

struct hil_can_bits hil_can_frame_bits(const struct hil_can_frame *frame);
/* Arbitration value of a frame; the lower value wins the bus. */
uint32_t hil_can_arbitration_value(const struct hil_can_frame *frame);

#endif
