#include "hil/rig/command_in.h"

#include <string.h>

#include "common/framing.h"
#include "hil/periph/can.h"
#include "hil/periph/usart.h"

enum mr_status hil_command_in(struct hil_can_device *can, struct hil_usart_device *usart,
                              uint16_t *sequence, const struct mr_command *message, bool serial)
{
    uint8_t payload[MR_MESSAGE_MAX];
    size_t length = mr_command_put(message, payload);
    if (serial) {
        uint8_t bytes[MR_FRAME_MAX];
        return hil_usart_inject(
            usart, bytes, mr_frame_encode((*sequence)++, MR_ID_COMMAND, payload, length, bytes));
    }
    struct hil_can_frame frame = {.id = MR_ID_COMMAND, .length = (uint8_t)length};
    memcpy(frame.data, payload, length);
    return hil_can_inject(can, &frame);
}
