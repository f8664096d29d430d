/* Scripted commands of a run file: at their virtual time they arrive at the board as a CAN frame or
 * as bytes on the serial line, exactly as from the host. */
#ifndef MATRIG_HIL_SCRIPT_H
#define MATRIG_HIL_SCRIPT_H

#include <stdbool.h>
#include <stdint.h>

#include "common/command.h"
#include "common/status.h"

struct hil_can_device;
struct hil_core;
struct hil_rig_device;
struct hil_usart_device;

struct hil_script {
    uint32_t next;     /* command of the run */
    uint16_t sequence; /* of serial frames sent */
};

struct hil_script_device {
    struct hil_core *core;
    struct hil_script *state;
    const struct hil_rig_device *rig; /* whose run it is */
    struct hil_can_device *can;
    struct hil_usart_device *usart;
};

/* A command for the board, put on one of its links as a host sends it.
 * `sequence`: the number of the next frame on serial. MR_OK; else too many wait for the board, and
 * the command is lost. */
enum mr_status hil_command_in(struct hil_can_device *can, struct hil_usart_device *usart,
                              uint16_t *sequence, const struct mr_command *message, bool serial);

void hil_script_create(struct hil_script_device *dev);
/* Begin the rig's run. */
void hil_script_start(struct hil_script_device *dev);

#endif
