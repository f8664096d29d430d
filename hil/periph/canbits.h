/* Length of a CAN 2.0 frame on the wire, from its real bit stream (ISO 11898-1 10.4 to 10.5). */
#ifndef MATRIG_HIL_CANBITS_H
#define MATRIG_HIL_CANBITS_H

#include <stdint.h>

#include "hil/periph/can_frame.h"

/* Bits after the stuffed part: CRC delimiter, ACK slot, ACK delimiter, seven of end of frame. */
#define HIL_CAN_TAIL_BITS         10u
#define HIL_CAN_INTERMISSION_BITS 3u
#define HIL_CAN_ERROR_BITS        14u /* error frame: flag of 6, delimiter of 8 */

struct hil_can_bits {
    uint16_t crc;   /* CRC-15 of the frame */
    unsigned stuff; /* stuff bits inserted */
    /* bits from start of frame to the last bit of end of frame, stuff bits included */
    unsigned length;
};

struct hil_can_bits hil_can_frame_bits(const struct hil_can_frame *frame);
/* Who wins the bus: the lower number. */
uint32_t hil_can_arbitration(const struct hil_can_frame *frame);

#endif
