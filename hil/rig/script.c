#include "hil/rig/script.h"

#include <string.h>

#include "common/framing.h"
#include "hil/board/machine.h"

static void schedule(struct hil_board *board)
{
    const struct hil_script *script = &board->state.script;
    bool more = board->run && script->next < board->run->command_count;
    hil_event_set_ps(board, HIL_EVENT_SCRIPT, more ? board->run->commands[script->next].t_ps : HIL_NEVER);
}

void hil_script_start(struct hil_board *board)
{
    board->state.script = (struct hil_script){0};
    schedule(board);
}

static void give(struct hil_board *board, const struct hil_run_command *command)
{
    uint8_t payload[MR_MESSAGE_MAX];
    size_t length = mr_command_put(&command->message, payload);
    enum mr_status status;
    if (command->serial) {
        uint8_t bytes[MR_FRAME_MAX];
        size_t n = mr_frame_encode(board->state.script.sequence++, MR_ID_COMMAND, payload, length, bytes);
        status = hil_board_serial_inject(board, bytes, n);
    } else {
        struct hil_can_frame frame = {.id = MR_ID_COMMAND, .length = (uint8_t)length};
        memcpy(frame.data, payload, length);
        status = hil_board_can_inject(board, &frame);
    }
    if (status == MR_OK)
        board->state.counters.commands_scripted++;
    else
        hil_board_stop(board, MR_FULL, "scripted command %u of the run file: too many wait for the %s",
                       (unsigned)command->message.tag, command->serial ? "serial line" : "CAN bus");
}

void hil_script_event(struct hil_board *board, uint64_t at)
{
    struct hil_script *script = &board->state.script;
    uint64_t now_ps = hil_clock_ps(&board->state.clock, at);
    while (board->run && script->next < board->run->command_count
           && board->run->commands[script->next].t_ps <= now_ps)
        give(board, &board->run->commands[script->next++]);
    schedule(board);
}
