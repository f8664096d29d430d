#include "hil/core/cpu_registers.h"

#include <unicorn/unicorn.h>

#include "hil/core/core.h"

uint32_t hil_cpu_register(const struct hil_core *core, unsigned number)
{
    int id = number < 13  ? UC_ARM_REG_R0 + (int)number
           : number == 13 ? UC_ARM_REG_SP
           : number == 14 ? UC_ARM_REG_LR
           : number == 15 ? UC_ARM_REG_PC
           : number == 16 ? UC_ARM_REG_XPSR
                          : UC_ARM_REG_PRIMASK;
    uint32_t value = 0;
    uc_reg_read(core->uc, id, &value);
    return value;
}
