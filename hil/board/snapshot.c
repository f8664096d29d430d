#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "hil/board/board.h"
#include "hil/board/parts.h"
#include "hil/core/context.h"
#include "hil/core/cpu.h"
#include "hil/core/stuck.h"

struct hil_snapshot {
    struct hil_core_state core;
    struct hil_state state;
    struct hil_cpu_registers registers;
    struct hil_memories memories;
    struct hil_options options;
};

struct hil_snapshot *hil_board_snapshot(const struct hil_board *board)
{
    struct hil_snapshot *snapshot = malloc(sizeof *snapshot);
    if (!snapshot)
        abort();
    snapshot->core = board->core.state;
    snapshot->state = board->state;
    snapshot->options = board->options;
    snapshot->options.trace = snapshot->options.log = NULL;
    snapshot->memories.own = board->memories->own;
    hil_w25q_copy(snapshot->memories.nor, NULL, board->memories->nor, board->state.w25q.used);
    hil_cpu_save(&board->core, &snapshot->registers);
    return snapshot;
}

void hil_board_restore(struct hil_board *board, const struct hil_snapshot *snapshot)
{
    struct hil_core *core = &board->core;
    FILE *log = board->options.log;
    board->options = snapshot->options;
    board->options.log = log;
    hil_w25q_copy(board->memories->nor, board->state.w25q.used, snapshot->memories.nor,
                  snapshot->state.w25q.used);
    core->state = snapshot->core;
    board->state = snapshot->state;
    board->memories->own = snapshot->memories.own;
    hil_cpu_forget_code(core);
    hil_cpu_load(core, &snapshot->registers);
    hil_stuck_look(core);
    core->stopped = false;
    core->reset = (struct hil_reset){0};
    core->reason[0] = '\0';
}

struct hil_board *hil_board_fork(const struct hil_board *board)
{
    struct hil_options options = board->options;
    options.trace = options.log = NULL;
    struct hil_board *copy = hil_board_create(&options);
    struct hil_snapshot *snapshot = hil_board_snapshot(board);
    copy->rig.run = board->rig.run;
    if (board->replay.replay)
        hil_replay_connect(&copy->replay, board->replay.replay);
    hil_board_restore(copy, snapshot);
    free(snapshot);
    return copy;
}
