/* CAN error frames, as SocketCAN makes them: LINK_ID_ERROR in the identifier, the class of the
 * error in its other bits, details in the data (linux/can/error.h). Pure. */
#ifndef MATRIG_HOST_LINK_CAN_ERROR_H
#define MATRIG_HOST_LINK_CAN_ERROR_H

#include <stddef.h>

#include "host/link/link.h"

#define CAN_ERROR_TEXT_MAX 400u

/* Bit 1 << enum link_trouble for each trouble that the error frame tells of; at least one is
 * set. */
uint32_t can_error_troubles(const struct link_frame *frame);

/* All that the frame says, in words: "bus off; error passive (transmitting); error counters:
 * transmit 255, receive 0". Cut to CAN_ERROR_TEXT_MAX. */
void can_error_text(const struct link_frame *frame, char out[CAN_ERROR_TEXT_MAX]);

#endif
