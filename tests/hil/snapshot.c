#include "tests/hil/snapshot.h"

#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/board/board.h"
#include "hil/core/cpu.h"

struct snapshot {
    struct hil_core_state core;
    struct hil_state state;
    struct hil_cpu_registers registers;
    struct hil_memories memories;
    struct hil_options options;
};

static bool has_sector(const uint8_t *bits, uint32_t n)
{
    return bits && (bits[n / 8u] >> n % 8u & 1u);
}

/* Copy the cells; `stale`: sectors that `to` has in use (bits as in `used`), or NULL. */
static void copy_cells(uint8_t *to, const uint8_t *stale, const uint8_t *from, const uint8_t *used)
{
    for (uint32_t sector = 0; sector < HIL_NOR_SIZE / HIL_NOR_SECTOR_BYTES; sector++) {
        size_t at = (size_t)sector * HIL_NOR_SECTOR_BYTES;
        if (has_sector(used, sector))
            memcpy(to + at, from + at, HIL_NOR_SECTOR_BYTES);
        else if (has_sector(stale, sector))
            memset(to + at, 0, HIL_NOR_SECTOR_BYTES);
    }
}

static void save_registers(const struct hil_core *core, struct hil_cpu_registers *registers)
{
    *registers = (struct hil_cpu_registers){0};
    for (int i = 0; i < 13; i++)
        uc_reg_read(core->uc, UC_ARM_REG_R0 + i, &registers->r[i]);
    for (int i = 0; i < 16; i++)
        uc_reg_read(core->uc, UC_ARM_REG_D0 + i, &registers->d[i]);
    uc_reg_read(core->uc, UC_ARM_REG_MSP, &registers->msp);
    uc_reg_read(core->uc, UC_ARM_REG_PSP, &registers->psp);
    uc_reg_read(core->uc, UC_ARM_REG_LR, &registers->lr);
    uc_reg_read(core->uc, UC_ARM_REG_PC, &registers->pc);
    uc_reg_read(core->uc, UC_ARM_REG_XPSR, &registers->xpsr);
    uc_reg_read(core->uc, UC_ARM_REG_CONTROL, &registers->control);
    uc_reg_read(core->uc, UC_ARM_REG_PRIMASK, &registers->primask);
    uc_reg_read(core->uc, UC_ARM_REG_BASEPRI, &registers->basepri);
    uc_reg_read(core->uc, UC_ARM_REG_FAULTMASK, &registers->faultmask);
    uc_reg_read(core->uc, UC_ARM_REG_FPSCR, &registers->fpscr);
}

struct snapshot *snapshot_take(const struct hil_board *board)
{
    struct snapshot *snapshot = malloc(sizeof *snapshot);
    if (!snapshot)
        abort();
    snapshot->core = board->core.state;
    snapshot->state = board->state;
    snapshot->options = board->options;
    snapshot->options.trace = snapshot->options.fault_log = NULL;
    snapshot->memories.mcu = board->memories->mcu;
    copy_cells(snapshot->memories.nor, NULL, board->memories->nor, board->state.w25q.used_sectors);
    save_registers(&board->core, &snapshot->registers);
    return snapshot;
}

void snapshot_restore(struct hil_board *board, const struct snapshot *snapshot)
{
    struct hil_core *core = &board->core;
    FILE *log = board->options.fault_log;
    board->options = snapshot->options;
    board->options.fault_log = log;
    hil_board_set_electronics(board);
    copy_cells(board->memories->nor, board->state.w25q.used_sectors, snapshot->memories.nor,
               snapshot->state.w25q.used_sectors);
    core->state = snapshot->core;
    board->state = snapshot->state;
    board->memories->mcu = snapshot->memories.mcu;
    hil_cpu_discard_code(core);
    hil_cpu_load_registers(core, &snapshot->registers);
    hil_stuck_bits_enable(core);
    core->is_stopped = false;
    core->reset = (struct hil_reset){0};
    core->failure_reason[0] = '\0';
}

struct hil_board *snapshot_fork(const struct hil_board *board)
{
    struct hil_options options = board->options;
    options.trace = options.fault_log = NULL;
    struct hil_board *copy = hil_board_create(&options);
    struct snapshot *snapshot = snapshot_take(board);
    copy->rig.run = board->rig.run;
    if (board->replay.replay)
        hil_replay_connect(&copy->replay, board->replay.replay);
    snapshot_restore(copy, snapshot);
    free(snapshot);
    return copy;
}
