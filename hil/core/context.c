#include "hil/core/context.h"

#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/core/core.h"
#include "hil/core/exception.h"
#include "hil/core/map.h"
#include "hil/core/whatif.h"

#define XPSR_T (1u << 24)

void hil_cpu_load(struct hil_core *core, const struct hil_cpu_registers *registers)
{
    uint32_t thread = XPSR_T;
    uint32_t none = 0;
    uint32_t pc = registers->pc | 1u;
    core->engine.stamped = (struct hil_stamped){0};
    hil_whatif_forget(core);
    hil_map_follow_boot_pin(core);
    /* From any state to privileged thread mode on MSP, then everything, then the mode. */
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &thread);
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &none);
    for (int i = 0; i < 13; i++)
        uc_reg_write(core->uc, UC_ARM_REG_R0 + i, &registers->r[i]);
    for (int i = 0; i < 16; i++)
        uc_reg_write(core->uc, UC_ARM_REG_D0 + i, &registers->d[i]);
    uc_reg_write(core->uc, UC_ARM_REG_FPSCR, &registers->fpscr);
    uc_reg_write(core->uc, UC_ARM_REG_PRIMASK, &registers->primask);
    uc_reg_write(core->uc, UC_ARM_REG_BASEPRI, &registers->basepri);
    uc_reg_write(core->uc, UC_ARM_REG_FAULTMASK, &registers->faultmask);
    uint32_t control = registers->control & ~1u;
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &control);
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &registers->xpsr);
    uc_reg_write(core->uc, UC_ARM_REG_MSP, &registers->msp);
    uc_reg_write(core->uc, UC_ARM_REG_PSP, &registers->psp);
    uc_reg_write(core->uc, UC_ARM_REG_LR, &registers->lr);
    uc_reg_write(core->uc, UC_ARM_REG_PC, &pc);
    if (registers->control & 1u)
        uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &registers->control);
    uint32_t apsr = 0;
    uc_reg_read(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
    uc_reg_write(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
}

void hil_cpu_reset(struct hil_core *core)
{
    struct hil_cpu_registers registers = {.lr = 0xffffffffu, .xpsr = XPSR_T};
    /* What BOOT0 chose is aliased at 0. */
    const uint8_t *table = core->state.bank.boot_rom ? hil_bootrom_image : core->memory->flash;
    hil_map_follow_boot_pin(core);
    memcpy(&registers.msp, table, 4);
    memcpy(&registers.pc, table + 4, 4);
    registers.msp &= ~3u;
    hil_cpu_load(core, &registers);
    core->state.cpu = (struct hil_cpu){0};
    hil_exception_seen(core, 0);
    if (!(registers.pc & 1u) || registers.pc == 0xffffffffu)
        hil_core_stop(core, MR_HALTED, "no firmware: the reset vector is 0x%08x",
                      (unsigned)registers.pc);
}
