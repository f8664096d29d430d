#include "hil/core/scb.h"

#include "hil/core/core.h"
#include "hil/core/cpu_registers.h"
#include "hil/core/nvic.h"
#include "hil/core/refuse.h"
#include "hil/core/systick.h"

#define DEMCR_TRCENA (1u << 24)
#define DWT_CYCCNTENA 1u
#define AIRCR_KEY 0x05fau
#define CSR_SOFTWARE (1u << 28) /* RCC_CSR.SFTRSTF */

void hil_scb_reset(struct hil_scb *scb)
{
    *scb = (struct hil_scb){
        .ccr = 0x200,        /* STKALIGN */
        .fpccr = 0xc0000000, /* ASPEN, LSPEN */
        .dwt_ctrl = 0x40000000,
    };
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
    return (active >> 4 & 1u) | (active >> 5 & 1u) << 1 | (active >> 6 & 1u) << 3 | (active >> 11 & 1u) << 7
           | (active >> 14 & 1u) << 10 | (active >> 15 & 1u) << 11 | (pending >> 6 & 1u) << 12
           | (pending >> 4 & 1u) << 13 | (pending >> 5 & 1u) << 14 | (pending >> 11 & 1u) << 15
           | (enabled >> 4 & 7u) << 16;
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

/* Priorities of the system handlers, bytes 0xD18 to 0xD23 for exceptions 4 to 15. */
static uint32_t shpr_read(const struct hil_nvic *nvic, uint32_t offset, unsigned size)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < size; i++)
        value |= (uint32_t)(nvic->priority[4 + offset - 0xd18u + i] & 0xff) << (8u * i);
    return value;
}

static void shpr_write(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    for (unsigned i = 0; i < size; i++)
        core->state.nvic.priority[4 + offset - 0xd18u + i] = (int16_t)(value >> (8u * i) & 0xf0u);
    hil_nvic_update(core);
}

static uint32_t scs_read(struct hil_core *core, uint32_t offset, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    uint32_t value = 0;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        return hil_systick_read(core, offset);
    if (offset >= 0x100u && offset < 0x500u)
        return hil_nvic_read(core, offset, size, &value) ? value : hil_bus_no_register(core);
    if (offset >= 0xd18u && offset + size <= 0xd24u)
        return shpr_read(&core->state.nvic, offset, size);
    if (offset >= 0xd28u && offset < 0xd2cu) /* CFSR and its byte parts */
        return scb->cfsr >> (8u * (offset & 3u)) & (size == 4 ? 0xffffffffu : (1u << (8u * size)) - 1u);
    if (size != 4)
        return hil_bus_no_register(core);
    switch (offset) {
    case 0x004: /* ICTR: interrupt lines in groups of 32, minus one */
        return 2;
    case 0xd00: /* CPUID: Cortex-M4 r0p1 */
        return 0x410fc241;
    case 0xd04:
        return icsr(core);
    case 0xd08:
        return scb->vtor;
    case 0xd0c: /* AIRCR reads with the key's complement */
        return 0xfa050000u | (uint32_t)core->state.nvic.prigroup << 8;
    case 0xd10:
        return scb->scr;
    case 0xd14:
        return scb->ccr;
    case 0xd24:
        return shcsr(&core->state.nvic);
    case 0xd2c:
        return scb->hfsr;
    case 0xd34:
        return scb->mmfar;
    case 0xd38:
        return scb->bfar;
    case 0xd88:
        return scb->cpacr;
    case 0xd90: /* MPU_TYPE: 8 regions; its other registers are refused */
        return 0x800;
    case 0xdf0: /* DHCSR: no debugger */
        return 0;
    case 0xdfc:
        return scb->demcr;
    case 0xf00: /* STIR: write-only */
        return 0;
    case 0xf34:
        return scb->fpccr;
    case 0xf38:
        return scb->fpcar;
    case 0xf3c:
        return scb->fpdscr;
    case 0xf40: /* MVFR0, MVFR1 of the single-precision unit */
        return 0x10110021;
    case 0xf44:
        return 0x11000011;
    default:
        return hil_bus_no_register(core);
    }
}

static void scs_write(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if (offset >= 0x10u && offset < 0x20u && size == 4) {
        hil_systick_write(core, offset, value);
        return;
    }
    if (offset >= 0x100u && offset < 0x500u) {
        if (!hil_nvic_write(core, offset, size, value))
            hil_bus_no_register(core);
        return;
    }
    if (offset == 0xf00u && size == 4) { /* STIR */
        if ((value & 0x1ffu) < HIL_INTERRUPTS)
            hil_nvic_pend(core, 16u + (value & 0x1ffu));
        return;
    }
    if (offset >= 0xd18u && offset + size <= 0xd24u) {
        shpr_write(core, offset, size, value);
        return;
    }
    if (size != 4) {
        hil_bus_no_register(core);
        return;
    }
    switch (offset) {
    case 0xd04:
        icsr_write(core, value);
        break;
    case 0xd08:
        scb->vtor = value & 0x3fffff80u;
        break;
    case 0xd0c:
        aircr_write(core, value);
        break;
    case 0xd10:
        if (value & 0x10u)
            hil_bus_refuse(core, "SEVONPEND");
        scb->scr = value & 0x16u;
        break;
    case 0xd14:
        if (value & 0x8u)
            hil_bus_refuse(core, "trapping of unaligned accesses");
        if (!(value & 0x200u))
            hil_bus_refuse(core, "stack frames without 8-byte alignment");
        scb->ccr = value & 0x313u; /* DIV_0_TRP is kept, but a division by zero gives 0 either way */
        break;
    case 0xd24:
        core->state.nvic.enabled[0] = (core->state.nvic.enabled[0] & ~0x70u) | (value >> 16 & 7u) << 4;
        hil_nvic_update(core);
        break;
    case 0xd28:
        scb->cfsr &= ~value;
        break;
    case 0xd2c:
        scb->hfsr &= ~value;
        break;
    case 0xd34:
        scb->mmfar = value;
        break;
    case 0xd38:
        scb->bfar = value;
        break;
    case 0xd88:
        scb->cpacr = value & 0x00f00000u;
        break;
    case 0xdfc:
        scb->demcr = value & (DEMCR_TRCENA | 0x7f1u);
        break;
    case 0xf34:
        scb->fpccr = value & 0xc0000000u;
        break;
    case 0xf38:
        scb->fpcar = value & ~7u;
        break;
    case 0xf3c:
        if (value & 0x07c00000u)
            hil_bus_refuse(core, "a default FPSCR other than 0");
        break;
    default:
        hil_bus_no_register(core);
    }
}

uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == 0xe000e000u)
        return scs_read(core, address & 0xfffu, size);
    if (size == 4) {
        switch (address) {
        case 0xe0001000u:
            return scb->dwt_ctrl;
        case 0xe0001004u:
            return cyccnt(core);
        case 0xe0042000u: /* DBGMCU_IDCODE: device 0x413, revision Y */
            return 0x100f6413;
        case 0xe0042004u:
            return scb->dbgmcu_cr;
        case 0xe0042008u:
            return scb->dbgmcu_apb1_fz;
        case 0xe004200cu:
            return scb->dbgmcu_apb2_fz;
        default:
            break;
        }
    }
    return hil_bus_no_register(core);
}

void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    uint32_t count;
    if ((address & ~0xfffu) == 0xe000e000u) {
        scs_write(core, address & 0xfffu, size, value);
        return;
    }
    if (size != 4) {
        hil_bus_no_register(core);
        return;
    }
    switch (address) {
    case 0xe0001000u:
        if (!(scb->demcr & DEMCR_TRCENA))
            break; /* as silicon: the unit is off */
        /* all but CYCCNTENA, and SYNCTAP/CYCTAP, which only matter to trace */
        if (value & 0x3ffffffeu & ~0x1e00u)
            hil_bus_refuse(core, "DWT functions other than the cycle counter");
        count = cyccnt(core);
        scb->dwt_ctrl = 0x40000000u | (value & DWT_CYCCNTENA);
        scb->dwt_offset = (value & DWT_CYCCNTENA) ? count - (uint32_t)hil_now(core) : count;
        break;
    case 0xe0001004u:
        scb->dwt_offset = (scb->dwt_ctrl & DWT_CYCCNTENA) ? value - (uint32_t)hil_now(core) : value;
        break;
    case 0xe0001fb0u: /* DWT lock access: not implemented on the STM32F4, writes ignored */
        break;
    case 0xe0042004u:
        scb->dbgmcu_cr = value & 0xffu;
        break;
    case 0xe0042008u:
        scb->dbgmcu_apb1_fz = value;
        break;
    case 0xe004200cu:
        scb->dbgmcu_apb2_fz = value;
        break;
    default:
        hil_bus_no_register(core);
    }
}
