#include "hil/core/stuck.h"

#include <unicorn/unicorn.h>

#include "hil/board/machine.h"

static void hold(struct hil_board *board, unsigned i)
{
    uint8_t *cell = hil_board_memory(board, board->state.stuck.bit[i].address, 1, true);
    if (!cell)
        return;
    uint8_t mask = board->state.stuck.bit[i].mask;
    *cell = (uint8_t)(board->state.stuck.bit[i].level ? *cell | mask : *cell & ~mask);
}

static void on_load(struct uc_struct *uc, int type, uint64_t address, int size, int64_t value, void *context)
{
    struct hil_board *board = context;
    (void)uc;
    (void)type;
    (void)value;
    for (unsigned i = 0; i < board->state.stuck.count; i++) {
        uint32_t at = board->state.stuck.bit[i].address;
        if (at >= address && at < address + (uint64_t)size)
            hold(board, i);
    }
}

void hil_stuck_look(struct hil_board *board)
{
    uc_hook hook;
    if (!board->state.stuck.count || board->looks_at_loads)
        return;
    board->looks_at_loads = uc_hook_add(board->uc, &hook, UC_HOOK_MEM_READ, (void *)(uintptr_t)on_load, board,
                                        HIL_CCM_BASE, HIL_SRAM_BASE + HIL_SRAM_SIZE - 1u) == UC_ERR_OK;
    hil_cpu_forget_code(board); /* translated code does not look */
}

bool hil_stuck_add(struct hil_board *board, uint32_t address, unsigned bit, bool level)
{
    struct hil_stuck *stuck = &board->state.stuck;
    if (stuck->count == HIL_STUCK_MAX)
        return false;
    stuck->bit[stuck->count].address = address + bit / 8u;
    stuck->bit[stuck->count].mask = (uint8_t)(1u << bit % 8u);
    stuck->bit[stuck->count].level = level;
    hold(board, stuck->count++);
    hil_stuck_look(board);
    return true;
}
