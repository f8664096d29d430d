#include "hil/rig/script.h"

#include <string.h>

#include "common/canbase.h"
#include "common/framing.h"
#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/periph/can.h"
#include "hil/periph/options.h"
#include "hil/periph/usart.h"
#include "hil/rig/rig.h"

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
    struct hil_can_frame frame = {
        .id = mr_can_to_bus(MR_ID_COMMAND, (uint16_t)can->options->can_base),
        .length = (uint8_t)length};
    memcpy(frame.data, payload, length);
    return hil_can_inject(can, &frame);
}

static void schedule(struct hil_script_device *dev)
{
    const struct hil_script *script = dev->state;
    bool more = dev->rig->run && script->next < dev->rig->run->command_count;
    hil_event_set_ps(dev->core, HIL_EVENT_SCRIPT,
                     more ? dev->rig->run->commands[script->next].t_ps : HIL_NEVER);
}

void hil_script_start(struct hil_script_device *dev)
{
    *dev->state = (struct hil_script){0};
    schedule(dev);
}

static void give(struct hil_script_device *dev, const struct hil_run_command *command)
{
    if (hil_command_in(dev->can, dev->usart, &dev->state->sequence, &command->message,
                       command->serial) != MR_OK)
        hil_core_stop(dev->core, MR_FULL,
                      "scripted command %u of the run file: too many wait for the %s",
                      (unsigned)command->message.tag, command->serial ? "serial line" : "CAN bus");
}

static void on_event(void *device, uint64_t at)
{
    struct hil_script_device *dev = device;
    struct hil_script *script = dev->state;
    uint64_t now_ps = hil_clock_ps(&dev->core->state.clock, at);
    while (dev->rig->run && script->next < dev->rig->run->command_count &&
           dev->rig->run->commands[script->next].t_ps <= now_ps)
        give(dev, &dev->rig->run->commands[script->next++]);
    schedule(dev);
}

void hil_script_create(struct hil_script_device *dev)
{
    hil_event_wire(dev->core, HIL_EVENT_SCRIPT, on_event, dev);
}
