/* A command for the board, put on one of its links as a host sends it. */
#ifndef MATRIG_HIL_RIG_COMMAND_IN_H
#define MATRIG_HIL_RIG_COMMAND_IN_H

#include <stdbool.h>
#include <stdint.h>

#include "common/command.h"
#include "common/status.h"

struct hil_can_device;
struct hil_usart_device;

/* `sequence`: the number of the next frame on serial. MR_OK; else too many wait for the board, and
 * the command is lost. */
enum mr_status hil_command_in(struct hil_can_device *can, struct hil_usart_device *usart,
                              uint16_t *sequence, const struct mr_command *message, bool serial);

#endif
