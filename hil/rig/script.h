/* Scripted commands of a run file: at their virtual time they arrive at the board as a CAN frame or as
 * bytes on the serial line, exactly as from the host. */
#ifndef MATRIG_HIL_SCRIPT_H
#define MATRIG_HIL_SCRIPT_H

#include <stdint.h>

struct hil_board;

struct hil_script {
    uint32_t next;     /* command of the run */
    uint16_t sequence; /* of serial frames sent */
};

void hil_script_start(struct hil_board *board);
void hil_script_event(struct hil_board *board, uint64_t at);

#endif
