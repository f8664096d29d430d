#include "hil/core/exception.h"

#include <unicorn/unicorn.h>

#include "common/wire.h"
#include "hil/core/core.h"
#include "hil/core/nvic.h"

#define ENTRY_CYCLES  12u /* Cortex-M4 TRM: entry 12, return 10, tail-chain 6 */
#define RETURN_CYCLES 10u
#define TAIL_CYCLES   6u
#define CONTROL_NPRIV 1u
#define CONTROL_SPSEL 2u
#define CONTROL_FPCA  4u
#define XPSR_T        (1u << 24)
#define XPSR_ALIGN    (1u << 9)
#define XPSR_NUMBER   0x1ffu
#define FRAME_BASIC   0x20u
#define FRAME_FP      0x68u
#define FPCCR_ASPEN   (1u << 31)
#define HFSR_VECTTBL  (1u << 1)
#define HFSR_FORCED   (1u << 30)
#define HFSR_DEBUGEVT (1u << 31)

static void read_masks(struct hil_core *core, uint32_t *primask, uint32_t *basepri,
                       uint32_t *faultmask)
{
    int ids[3] = {UC_ARM_REG_PRIMASK, UC_ARM_REG_BASEPRI, UC_ARM_REG_FAULTMASK};
    void *values[3] = {primask, basepri, faultmask};
    *primask = *basepri = *faultmask = 0;
    uc_reg_read_batch(core->uc, ids, values, 3);
    *basepri &= 0xf0u; /* the STM32 has four bits; Unicorn keeps eight */
}

static bool beats(struct hil_core *core, bool use_primask)
{
    const struct hil_nvic *nvic = &core->state.nvic;
    uint32_t primask, basepri, faultmask;
    if (!nvic->best || nvic->best_group >= nvic->active_group)
        return false;
    read_masks(core, &primask, &basepri, &faultmask);
    if (basepri && nvic->best_group >= hil_nvic_group(nvic, (int)basepri))
        return false;
    if (use_primask && (primask & 1u) && nvic->best_group >= 0)
        return false;
    return !((faultmask & 1u) && nvic->best_group >= -1);
}

unsigned hil_exception_due(struct hil_core *core)
{
    return beats(core, true) ? core->state.nvic.best : 0;
}

bool hil_exception_wakes(struct hil_core *core)
{
    return beats(core, false);
}

/* Unicorn keeps flags of the translator's view of the core (handler mode among them) and renews
 * them only when the condition flags are written as a register. */
static void renew_core_flags(struct hil_core *core)
{
    uint32_t apsr = 0;
    uc_reg_read(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
    uc_reg_write(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
}

void hil_exception_seen(struct hil_core *core)
{
    const struct hil_onlookers *lookers = &core->onlookers;
    if (lookers->tracer)
        lookers->tracer->exception(lookers->tracer_who);
}

/* Go to the handler: mode, stack and PC. SP is already below the frame. */
static void jump_to_handler(struct hil_core *core, unsigned exception, uint32_t exc_return)
{
    uint32_t vector = 0;
    if (hil_memory_peek(core, core->state.scb.vtor + 4u * exception, &vector, 4) != MR_OK) {
        core->state.scb.hfsr |= HFSR_VECTTBL;
        hil_core_stop(core, MR_HALTED, "vector table at 0x%08x is not in memory (exception %u)",
                      (unsigned)core->state.scb.vtor, exception);
        return;
    }
    if (!vector) {
        hil_core_stop(core, MR_HALTED,
                      "exception %u has no handler: its vector is 0x%08x (CFSR 0x%08x, PC 0x%08x)",
                      exception, (unsigned)vector, (unsigned)core->state.scb.cfsr,
                      (unsigned)core->state.counters.last_fault_pc);
        return;
    }
    uint32_t xpsr = XPSR_T | exception;
    uint32_t control = 0;
    uint32_t pc = vector;
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &xpsr);
    uc_reg_read(core->uc, UC_ARM_REG_CONTROL, &control);
    control &= ~CONTROL_FPCA;
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &control);
    uc_reg_write(core->uc, UC_ARM_REG_LR, &exc_return);
    uc_reg_write(core->uc, UC_ARM_REG_PC, &pc);
    renew_core_flags(core);
    core->state.counters.exceptions++;
    core->state.cpu.event = true;
    hil_trace(core, "enter %u at 0x%08x", exception, (unsigned)vector);
    hil_exception_seen(core);
    if (!(vector & 1u)) /* no Thumb state: the handler's first instruction faults */
        hil_exception_fault(core, HIL_CFSR_INVSTATE, vector, 0);
}

/* D0 to D7 and FPSCR, out of the core or into it. */
static void move_fp(struct hil_core *core, uint64_t d[8], uint32_t *fpscr, bool into)
{
    int ids[9];
    void *values[9];
    for (int i = 0; i < 8; i++) {
        ids[i] = UC_ARM_REG_D0 + i;
        values[i] = &d[i];
    }
    ids[8] = UC_ARM_REG_FPSCR;
    values[8] = fpscr;
    if (into)
        uc_reg_write_batch(core->uc, ids, values, 9);
    else
        uc_reg_read_batch(core->uc, ids, values, 9);
}

static void save_fp(struct hil_core *core, uint8_t *p)
{
    uint64_t d[8] = {0};
    uint32_t fpscr = 0;
    move_fp(core, d, &fpscr, false);
    for (unsigned i = 0; i < 8; i++)
        p = mr_put_u32(mr_put_u32(p, (uint32_t)d[i]), (uint32_t)(d[i] >> 32));
    mr_put_u32(mr_put_u32(p, fpscr), 0);
}

static void restore_fp(struct hil_core *core, const uint8_t *p)
{
    uint64_t d[8];
    for (unsigned i = 0; i < 8; i++) {
        d[i] = mr_get_u32(&p);
        d[i] |= (uint64_t)mr_get_u32(&p) << 32;
    }
    uint32_t fpscr = mr_get_u32(&p);
    move_fp(core, d, &fpscr, true);
}

/* There is no memory for the frame. A handler of bus faults or hard faults runs all the same, and
 * finds nothing on its stack (DUI 0553A 2.4.2, DDI 0337E 5.12.1); another exception gives way to
 * the bus fault that this is, or to a hard fault where that is disabled or not above it. 0: the run
 * has ended. */
static unsigned instead_of(struct hil_core *core, unsigned exception, uint32_t frame_at,
                           uint32_t pc)
{
    struct hil_nvic *nvic = &core->state.nvic;
    core->state.scb.cfsr |= HIL_CFSR_STKERR;
    hil_trace(core, "no memory at 0x%08x for the frame of exception %u", (unsigned)frame_at,
              exception);
    if (exception == HIL_EXC_NMI) {
        hil_core_stop(core, MR_HALTED,
                      "no memory at 0x%08x for the frame of exception %u, PC 0x%08x, CFSR 0x%08x",
                      (unsigned)frame_at, exception, (unsigned)pc, (unsigned)core->state.scb.cfsr);
        return 0;
    }
    if (exception == HIL_EXC_BUS_FAULT || exception == HIL_EXC_HARD_FAULT)
        return exception;
    core->state.counters.faults++;
    core->state.counters.last_fault_pc = pc;
    if ((nvic->enabled[0] >> HIL_EXC_BUS_FAULT & 1u) &&
        hil_nvic_group(nvic, nvic->priority[HIL_EXC_BUS_FAULT]) <
            hil_nvic_group(nvic, nvic->priority[exception]))
        return HIL_EXC_BUS_FAULT;
    core->state.scb.hfsr |= HFSR_FORCED;
    return HIL_EXC_HARD_FAULT;
}

void hil_exception_enter(struct hil_core *core, unsigned exception, uint32_t pc)
{
    uint32_t r[6] = {0};
    uint32_t xpsr = 0, sp = 0, control = 0;
    int ids[9] = {UC_ARM_REG_R0, UC_ARM_REG_R1,   UC_ARM_REG_R2, UC_ARM_REG_R3,     UC_ARM_REG_R12,
                  UC_ARM_REG_LR, UC_ARM_REG_XPSR, UC_ARM_REG_SP, UC_ARM_REG_CONTROL};
    void *values[9] = {&r[0], &r[1], &r[2], &r[3], &r[4], &r[5], &xpsr, &sp, &control};
    uc_reg_read_batch(core->uc, ids, values, 9);

    bool fp = (control & CONTROL_FPCA) && (core->state.scb.fpccr & FPCCR_ASPEN);
    bool align = (sp & 4u) != 0;
    uint32_t frame_at = (sp - (fp ? FRAME_FP : FRAME_BASIC)) & ~7u;
    uint8_t *p = hil_memory_at(core, frame_at, fp ? FRAME_FP : FRAME_BASIC, true);
    if (p) {
        for (unsigned i = 0; i < 6; i++)
            p = mr_put_u32(p, r[i]);
        p = mr_put_u32(p, pc & ~1u);
        p = mr_put_u32(p, (xpsr & ~XPSR_ALIGN) | (align ? XPSR_ALIGN : 0));
        if (fp)
            save_fp(core, p);
    } else {
        exception = instead_of(core, exception, frame_at, pc);
        if (!exception)
            return;
    }

    bool handler = (xpsr & XPSR_NUMBER) != 0;
    uint32_t exc_return = handler                   ? 0xfffffff1u
                        : (control & CONTROL_SPSEL) ? 0xfffffffdu
                                                    : 0xfffffff9u;
    if (fp)
        exc_return &= ~0x10u;
    uc_reg_write(core->uc, UC_ARM_REG_SP, &frame_at);
    hil_nvic_activate(core, exception);
    core->state.clock.now_cycle += ENTRY_CYCLES;
    jump_to_handler(core, exception, exc_return);
}

/* Undo the frame that `exc_return` points to. */
static void unstack(struct hil_core *core, uint32_t exc_return)
{
    bool psp = (exc_return & 4u) != 0;
    bool handler = (exc_return & 8u) == 0;
    bool fp = (exc_return & 0x10u) == 0;
    uint32_t msp = 0, psp_value = 0, control = 0;
    int sp_ids[3] = {UC_ARM_REG_MSP, UC_ARM_REG_PSP, UC_ARM_REG_CONTROL};
    void *sp_values[3] = {&msp, &psp_value, &control};
    uc_reg_read_batch(core->uc, sp_ids, sp_values, 3);

    uint32_t frame_at = psp ? psp_value : msp;
    uint32_t size = fp ? FRAME_FP : FRAME_BASIC;
    const uint8_t *frame = hil_memory_at(core, frame_at, size, false);
    if (!frame) {
        hil_core_stop(core, MR_HALTED, "exception return 0x%08x: no frame in memory at 0x%08x",
                      (unsigned)exc_return, (unsigned)frame_at);
        return;
    }
    uint32_t r[6];
    const uint8_t *p = frame;
    for (unsigned i = 0; i < 6; i++)
        r[i] = mr_get_u32(&p);
    uint32_t pc = mr_get_u32(&p);
    uint32_t xpsr = mr_get_u32(&p);
    if (((xpsr & XPSR_NUMBER) != 0) != handler || !(xpsr & XPSR_T)) {
        hil_core_stop(core, MR_HALTED,
                      "exception return 0x%08x does not fit the stacked xPSR 0x%08x (PC 0x%08x)",
                      (unsigned)exc_return, (unsigned)xpsr, (unsigned)pc);
        return;
    }
    if (fp)
        restore_fp(core, p);
    uint32_t sp = frame_at + size;
    if (xpsr & XPSR_ALIGN)
        sp |= 4u;
    *(psp ? &psp_value : &msp) = sp;

    /* Mode first (writing xPSR switches it), then the stack selection, then both stack pointers by
     * name. */
    uint32_t new_control = (control & CONTROL_NPRIV) | (psp ? CONTROL_SPSEL : 0) |
                           (fp ? CONTROL_FPCA : 0);
    uint32_t new_xpsr = xpsr & ~XPSR_ALIGN;
    uint32_t privileged = new_control & ~CONTROL_NPRIV;
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &new_xpsr);
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &privileged);
    uc_reg_write(core->uc, UC_ARM_REG_MSP, &msp);
    uc_reg_write(core->uc, UC_ARM_REG_PSP, &psp_value);
    pc |= 1u;
    int ids[7] = {UC_ARM_REG_R0,  UC_ARM_REG_R1, UC_ARM_REG_R2, UC_ARM_REG_R3,
                  UC_ARM_REG_R12, UC_ARM_REG_LR, UC_ARM_REG_PC};
    void *values[7] = {&r[0], &r[1], &r[2], &r[3], &r[4], &r[5], &pc};
    uc_reg_write_batch(core->uc, ids, values, 7);
    if (new_control & CONTROL_NPRIV)
        uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &new_control);
    renew_core_flags(core);
    hil_exception_seen(core);
}

void hil_exception_return(struct hil_core *core, uint32_t exc_return)
{
    uint32_t xpsr = 0;
    uc_reg_read(core->uc, UC_ARM_REG_XPSR, &xpsr);
    unsigned number = xpsr & XPSR_NUMBER;
    uint32_t form = exc_return | 0x10u;
    if ((form != 0xfffffff1u && form != 0xfffffff9u && form != 0xfffffffdu) ||
        !hil_nvic_is_active(&core->state.nvic, number)) {
        hil_core_stop(core, MR_HALTED, "branch to 0x%08x in exception %u is no exception return",
                      (unsigned)exc_return, number);
        return;
    }
    if (number != HIL_EXC_NMI) {
        uint32_t zero = 0;
        uc_reg_write(core->uc, UC_ARM_REG_FAULTMASK, &zero);
    }
    core->state.cpu.event = true;
    hil_nvic_deactivate(core, number);
    unsigned next = hil_exception_due(core);
    if (next) {
        core->state.counters.tail_chains++;
        core->state.clock.now_cycle += TAIL_CYCLES;
        hil_nvic_activate(core, next);
        jump_to_handler(core, next, exc_return);
        return;
    }
    core->state.clock.now_cycle += RETURN_CYCLES;
    unstack(core, exc_return);
    hil_trace(core, "return from %u", number);
    if ((core->state.scb.scr & 2u) && form != 0xfffffff1u)
        core->state.cpu.asleep = true; /* SLEEPONEXIT */
}

/* Take a synchronous exception, or HardFault in its place when it is disabled or not above what
 * runs. */
static void take_or_escalate(struct hil_core *core, unsigned exception, uint32_t pc)
{
    struct hil_nvic *nvic = &core->state.nvic;
    uint32_t primask, basepri, faultmask;
    read_masks(core, &primask, &basepri, &faultmask);
    int running = nvic->active_group;
    if (basepri && hil_nvic_group(nvic, (int)basepri) < running)
        running = hil_nvic_group(nvic, (int)basepri);
    if ((primask & 1u) && running > 0)
        running = 0;
    if ((faultmask & 1u) && running > -1)
        running = -1;
    bool enabled = (nvic->enabled[0] >> exception & 1u) != 0;
    if (exception != HIL_EXC_HARD_FAULT &&
        (!enabled || hil_nvic_group(nvic, nvic->priority[exception]) >= running)) {
        core->state.scb.hfsr |= HFSR_FORCED;
        exception = HIL_EXC_HARD_FAULT;
    }
    if (exception == HIL_EXC_HARD_FAULT && running <= -1) {
        hil_core_stop(
            core, MR_HALTED,
            "lockup: fault at PC 0x%08x while a fault is handled (CFSR 0x%08x, HFSR 0x%08x)",
            (unsigned)pc, (unsigned)core->state.scb.cfsr, (unsigned)core->state.scb.hfsr);
        return;
    }
    hil_exception_enter(core, exception, pc);
}

void hil_exception_fault(struct hil_core *core, uint32_t cfsr, uint32_t pc, uint32_t address)
{
    struct hil_counters *counters = &core->state.counters;
    core->state.scb.cfsr |= cfsr;
    if (cfsr & HIL_CFSR_BFARVALID)
        core->state.scb.bfar = address;
    counters->faults++;
    counters->last_fault_pc = pc;
    hil_trace(core, "fault at PC 0x%08x, address 0x%08x, CFSR 0x%08x", (unsigned)pc,
              (unsigned)address, (unsigned)core->state.scb.cfsr);
    unsigned exception = HIL_EXC_USAGE_FAULT;
    if (cfsr & 0xffffu)
        exception = (cfsr & 0xffu) ? HIL_EXC_MEM_MANAGE : HIL_EXC_BUS_FAULT;
    take_or_escalate(core, exception, pc);
}

void hil_exception_svc(struct hil_core *core, uint32_t pc)
{
    take_or_escalate(core, HIL_EXC_SVCALL, pc);
}

void hil_exception_bkpt(struct hil_core *core, uint32_t pc)
{
    core->state.scb.hfsr |= HFSR_DEBUGEVT;
    core->state.counters.faults++;
    core->state.counters.last_fault_pc = pc;
    take_or_escalate(core, HIL_EXC_HARD_FAULT, pc);
}
