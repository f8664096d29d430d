#include "hil/rig/command_in.h"

#include <string.h>

#include "common/framing.h"
#include "hil/core/core.h"
#include "hil/periph/can.h"
#include "hil/periph/usart.h"

enum mr_status hil_command_in(const struct hil_command_in *in, const struct mr_command *message, bool serial)
{
    uint8_t payload[MR_MESSAGE_MAX];
    size_t length = mr_command_put(message, payload);
    enum mr_status status;
    if (serial) {
        uint8_t bytes[MR_FRAME_MAX];
        size_t n = mr_frame_encode((*in->sequence)++, MR_ID_COMMAND, payload, length, bytes);
        status = hil_usart_inject(in->usart, bytes, n);
    } else {
        struct hil_can_frame frame = {.id = MR_ID_COMMAND, .length = (uint8_t)length};
        memcpy(frame.data, payload, length);
        status = hil_can_inject(in->can, &frame);
    }
    if (status == MR_OK)
        in->core->state.counters.commands_scripted++;
    return status;
}
