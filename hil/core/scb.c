#include "hil/core/scb.h"

#include "hil/core/core.h"
#include "hil/core/cpu_registers.h"
#include "hil/core/nvic.h"
#include "hil/core/refuse.h"
#include "hil/core/registers.h"
#include "hil/core/systick.h"

#define SYSTEM        0xe000e000u
#define ICTR          0x004u
#define SCB           0xd00u
#define ICSR          0xd04u
#define AIRCR         0xd0cu
#define SHPR          0xd18u
#define SHCSR         0xd24u
#define CFSR          0xd28u
#define HFSR          0xd2cu
#define STIR          0xf00u
#define FPCCR         0xf34u
#define DWT_CTRL      0xe0001000u
#define DWT_CYCCNT    0xe0001004u
#define DWT_LAR       0xe0001fb0u
#define DBGMCU        0xe0042000u
#define DEMCR_TRCENA  (1u << 24)
#define DWT_CYCCNTENA 1u
#define AIRCR_KEY     0x05fau
#define CSR_SOFTWARE  (1u << 28) /* RCC_CSR.SFTRSTF */

void hil_scb_reset(struct hil_scb *scb, uint32_t idcode)
{
    *scb = (struct hil_scb){.dwt_ctrl = 0x40000000, .idcode = idcode};
    hil_registers_reset(SYSTEM, SCB, scb->word, sizeof scb->word / 4u);
}

static uint32_t icsr(const struct hil_core *core)
{
    const struct hil_nvic *nvic = &core->state.nvic;
    uint32_t value = hil_cpu_register(core, 16) & 0x1ffu; /* VECTACTIVE */
    unsigned active = 0;
    bool isr_pending = false;
    for (unsigned w = 0; w < HIL_EXCEPTION_WORDS; w++) {
        active += (unsigned)__builtin_popcount(nvic->active[w]);
        isr_pending |= (w ? nvic->pending[w] : nvic->pending[w] & 0xffff0000u) != 0;
    }
    if (active <= 1)
        value |= 1u << 11; /* RETTOBASE */
    value |= (uint32_t)nvic->best << 12;
    value |= (uint32_t)isr_pending << 22;
    value |= (nvic->pending[0] >> HIL_EXC_SYSTICK & 1u) << 26;
    value |= (nvic->pending[0] >> HIL_EXC_PENDSV & 1u) << 28;
    return value | (nvic->pending[0] >> HIL_EXC_NMI & 1u) << 31;
}

static void icsr_write(struct hil_core *core, uint32_t value)
{
    if (value >> 31 & 1u)
        hil_nvic_pend(core, HIL_EXC_NMI);
    if (value >> 28 & 1u)
        hil_nvic_pend(core, HIL_EXC_PENDSV);
    else if (value >> 27 & 1u)
        hil_nvic_unpend(core, HIL_EXC_PENDSV);
    if (value >> 26 & 1u)
        hil_nvic_pend(core, HIL_EXC_SYSTICK);
    else if (value >> 25 & 1u)
        hil_nvic_unpend(core, HIL_EXC_SYSTICK);
}

static uint32_t shcsr(const struct hil_nvic *nvic)
{
    uint32_t active = nvic->active[0], pending = nvic->pending[0], enabled = nvic->enabled[0];
    return (active >> 4 & 1u) | (active >> 5 & 1u) << 1 | (active >> 6 & 1u) << 3 |
           (active >> 11 & 1u) << 7 | (active >> 14 & 1u) << 10 | (active >> 15 & 1u) << 11 |
           (pending >> 6 & 1u) << 12 | (pending >> 4 & 1u) << 13 | (pending >> 5 & 1u) << 14 |
           (pending >> 11 & 1u) << 15 | (enabled >> 4 & 7u) << 16;
}

static void aircr_write(struct hil_core *core, uint32_t value)
{
    if (value >> 16 != AIRCR_KEY)
        return;
    core->state.nvic.prigroup = (uint8_t)(value >> 8 & 7u);
    hil_nvic_update(core);
    if (value & 4u)
        hil_core_request_reset(core, CSR_SOFTWARE);
}

static uint32_t cyccnt(const struct hil_core *core)
{
    const struct hil_scb *scb = &core->state.scb;
    return scb->dwt_offset + ((scb->dwt_ctrl & DWT_CYCCNTENA) ? (uint32_t)hil_now(core) : 0);
}

static uint32_t scs_read(struct hil_core *core, uint32_t offset, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    uint32_t value = 0;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        return hil_systick_read(core, offset);
    if (offset >= 0x100u && offset < 0x500u)
        return hil_nvic_read(core, offset, size, &value) ? value : hil_bus_no_register(core);
    if (offset >= SHPR && offset + size <= SHCSR)
        /* of exceptions 4 to 15 */
        return hil_nvic_priorities(&core->state.nvic, 4u + offset - SHPR, size);
    if (offset >= CFSR && offset < HFSR) /* CFSR and its byte parts */
        return scb->cfsr >> (8u * (offset & 3u)) &
               (size == 4 ? 0xffffffffu : (1u << (8u * size)) - 1u);
    if (size != 4 || offset % 4u)
        return hil_bus_no_register(core);
    switch (offset) {
    case ICTR: /* interrupt lines in groups of 32, minus one */ return 2;
    case ICSR: return icsr(core);
    case AIRCR: /* reads with the key's complement */
        return 0xfa050000u | (uint32_t)core->state.nvic.prigroup << 8;
    case SHCSR: return shcsr(&core->state.nvic);
    default: return scb->word[(offset - SCB) / 4u];
    }
}

static void system_write(struct hil_core *core, uint32_t offset, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    switch (offset) {
    case ICSR: icsr_write(core, value); break;
    case AIRCR: aircr_write(core, value); break;
    case SHCSR:
        core->state.nvic.enabled[0] = (core->state.nvic.enabled[0] & ~0x70u) | (value >> 16 & 7u)
                                                                                   << 4;
        hil_nvic_update(core);
        break;
    case CFSR:
    case HFSR: /* flags are cleared by writing 1 */ scb->word[(offset - SCB) / 4u] &= ~value; break;
    case STIR:
        if ((value & 0x1ffu) < HIL_INTERRUPTS)
            hil_nvic_pend(core, 16u + (value & 0x1ffu));
        break;
    case FPCCR: scb->fpccr = value & 0xc0000000u; break;
    default: /* CCR.DIV_0_TRP is kept, but a division by zero gives 0 either way */
        scb->word[(offset - SCB) / 4u] = value;
        break;
    }
}

static void scs_write(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    bool known = true;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        hil_systick_write(core, offset, value);
    else if (offset >= 0x100u && offset < 0x500u)
        known = hil_nvic_write(core, offset, size, value);
    else if (offset >= SHPR && offset + size <= SHCSR)
        hil_nvic_set_priorities(core, 4u + offset - SHPR, size, value);
    else if (size == 4 && offset % 4u == 0)
        system_write(core, offset, value);
    else
        known = false;
    if (!known)
        hil_bus_no_register(core);
}

uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == SYSTEM)
        return scs_read(core, address & 0xfffu, size);
    if (size == 4 && address == DWT_CTRL)
        return scb->dwt_ctrl;
    if (size == 4 && address == DWT_CYCCNT)
        return cyccnt(core);
    if (size == 4 && address % 4u == 0 && address - DBGMCU < sizeof scb->dbgmcu)
        return scb->dbgmcu[(address - DBGMCU) / 4u];
    return hil_bus_no_register(core);
}

static void dwt_write(struct hil_core *core, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if (!(scb->demcr & DEMCR_TRCENA))
        return; /* as silicon: the unit is off */
    /* all but CYCCNTENA, and SYNCTAP/CYCTAP, which only matter to trace */
    if (value & 0x3ffffffeu & ~0x1e00u)
        hil_bus_refuse(core, "DWT functions other than the cycle counter");
    uint32_t count = cyccnt(core);
    scb->dwt_ctrl = 0x40000000u | (value & DWT_CYCCNTENA);
    scb->dwt_offset = (value & DWT_CYCCNTENA) ? count - (uint32_t)hil_now(core) : count;
}

void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == SYSTEM)
        scs_write(core, address & 0xfffu, size, value);
    else if (size == 4 && address == DWT_CTRL)
        dwt_write(core, value);
    else if (size == 4 && address == DWT_CYCCNT)
        scb->dwt_offset = (scb->dwt_ctrl & DWT_CYCCNTENA) ? value - (uint32_t)hil_now(core) : value;
    else if (size == 4 && address % 4u == 0 && address > DBGMCU &&
             address - DBGMCU < sizeof scb->dbgmcu)
        scb->dbgmcu[(address - DBGMCU) / 4u] = address == DBGMCU + 4u ? value & 0xffu : value;
    /* the lock is not implemented on the STM32F4: writes are ignored */
    else if (size != 4 || address != DWT_LAR)
        hil_bus_no_register(core);
}
