/* A CAN frame, and what the bus can be like. */
#ifndef MATRIG_HIL_CAN_FRAME_H
#define MATRIG_HIL_CAN_FRAME_H

#include <stdbool.h>
#include <stdint.h>

enum hil_can_bus {
    HIL_CAN_CONNECTED, /* the other side acknowledges */
    HIL_CAN_UNPLUGGED, /* nobody acknowledges */
    HIL_CAN_SHORTED,   /* wires touching: every bit reads back recessive */
    HIL_CAN_DOMINANT,  /* held dominant: no frame can begin, nobody leaves initialisation */
};

struct hil_can_frame {
    uint32_t id; /* 11 or 29 bits */
    bool extended;
    bool remote;
    uint8_t length; /* 0..8 */
    uint8_t data[8];
};

#endif
