/* A command for the board, put on one of its links as a host sends it. */
#ifndef MATRIG_HIL_RIG_COMMAND_IN_H
#define MATRIG_HIL_RIG_COMMAND_IN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/command.h"
#include "common/status.h"

struct hil_core;
struct hil_can_device;
struct hil_usart_device;

/* The links, and the number of the next frame on serial. */
struct hil_command_in {
    struct hil_core *core;
    struct hil_can_device *can;
    struct hil_usart_device *usart;
    uint16_t *sequence;
};

/* Counted among the scripted commands. MR_OK; else too many wait for the board, and the command is lost. */
enum mr_status hil_command_in(const struct hil_command_in *in, const struct mr_command *message, bool serial);

#endif
