#include "hil/core/nvic.h"

#include <string.h>
#include <unicorn/unicorn.h>

#include "hil/core/core.h"

#define ISPR                  0x200u
#define ICPR                  0x280u
#define IABR                  0x300u
#define IPR                   0x400u
#define IPR_END               (IPR + (HIL_INTERRUPTS + 3u) / 4u * 4u)
#define THREAD_GROUP_PRIORITY 256

static bool is_exception_in_set(const uint32_t *set, unsigned i)
{
    return (set[i / 32u] >> (i % 32u) & 1u) != 0;
}
static void change_exception_in_set(uint32_t *set, unsigned i, bool on)
{
    uint32_t bit = 1u << (i % 32u);
    set[i / 32u] = on ? set[i / 32u] | bit : set[i / 32u] & ~bit;
}

void hil_nvic_reset(struct hil_nvic *nvic)
{
    *nvic = (struct hil_nvic){.active_group_priority = THREAD_GROUP_PRIORITY,
                              .next_group_priority = THREAD_GROUP_PRIORITY};
    nvic->priority[HIL_EXC_RESET] = -3;
    nvic->priority[HIL_EXC_NMI] = -2;
    nvic->priority[HIL_EXC_HARD_FAULT] = -1;
    /* these exceptions have no enable bit; SHCSR enables the configurable faults */
    change_exception_in_set(nvic->enabled, HIL_EXC_NMI, true);
    change_exception_in_set(nvic->enabled, HIL_EXC_HARD_FAULT, true);
    change_exception_in_set(nvic->enabled, HIL_EXC_SVCALL, true);
    change_exception_in_set(nvic->enabled, HIL_EXC_DEBUG_MONITOR, true);
    change_exception_in_set(nvic->enabled, HIL_EXC_PENDSV, true);
    change_exception_in_set(nvic->enabled, HIL_EXC_SYSTICK, true);
}

static int get_priority_group(const struct hil_nvic *nvic, int priority)
{
    /* Returns the group priority: bits PRIGROUP..0 of the priority byte are the subpriority and are
     * cleared. */
    return priority < 0 ? priority : priority & ~((2 << nvic->prigroup) - 1) & 0xff;
}

void hil_nvic_update(struct hil_core *core)
{
    struct hil_nvic *nvic = &core->state.nvic;
    int best_priority = THREAD_GROUP_PRIORITY;
    int active_group = THREAD_GROUP_PRIORITY;
    nvic->next_exception = 0;
    nvic->next_group_priority = THREAD_GROUP_PRIORITY;
    for (unsigned w = 0; w < HIL_EXCEPTION_WORDS; w++) {
        for (uint32_t set = nvic->pending[w] & nvic->enabled[w]; set; set &= set - 1) {
            unsigned i = 32u * w + (unsigned)__builtin_ctz(set);
            if (nvic->priority[i] < best_priority) {
                best_priority = nvic->priority[i];
                nvic->next_exception = (uint16_t)i;
            }
        }
        for (uint32_t set = nvic->active[w]; set; set &= set - 1) {
            unsigned i = 32u * w + (unsigned)__builtin_ctz(set);
            int group = get_priority_group(nvic, nvic->priority[i]);
            if (group < active_group)
                active_group = group;
        }
    }
    if (nvic->next_exception)
        nvic->next_group_priority = (int16_t)get_priority_group(nvic, best_priority);
    nvic->active_group_priority = (int16_t)active_group;
    if (nvic->next_exception && nvic->next_group_priority < nvic->active_group_priority)
        hil_core_request_check(core);
}

static void pend_exception(struct hil_core *core, unsigned exception)
{
    change_exception_in_set(core->state.nvic.pending, exception, true);
    hil_nvic_update(core);
}

static void unpend_exception(struct hil_core *core, unsigned exception)
{
    change_exception_in_set(core->state.nvic.pending, exception, false);
    hil_nvic_update(core);
}

void hil_irq_set_line(struct hil_core *core, unsigned irq, bool level)
{
    hil_nvic_set_line(core, 16u + irq, level);
}

void hil_nvic_set_line(struct hil_core *core, unsigned exception, bool level)
{
    struct hil_nvic *nvic = &core->state.nvic;
    bool before = is_exception_in_set(nvic->line_levels, exception);
    if (level == before)
        return;
    change_exception_in_set(nvic->line_levels, exception, level);
    if (level)
        pend_exception(core, exception);
}

static void activate_exception(struct hil_core *core, unsigned exception)
{
    change_exception_in_set(core->state.nvic.active, exception, true);
    change_exception_in_set(core->state.nvic.pending, exception, false);
    hil_nvic_update(core);
}

static void deactivate_exception(struct hil_core *core, unsigned exception)
{
    struct hil_nvic *nvic = &core->state.nvic;
    change_exception_in_set(nvic->active, exception, false);
    if (is_exception_in_set(nvic->line_levels, exception))
        change_exception_in_set(nvic->pending, exception, true);
    hil_nvic_update(core);
}

bool hil_nvic_is_active(const struct hil_nvic *nvic, unsigned exception)
{
    return is_exception_in_set(nvic->active, exception);
}

/* Returns register n of a set: the bits of interrupts 32 n to 32 n + 31. The set begins with the 16
 * system exceptions. */
static uint32_t read_interrupt_word(const uint32_t *set, unsigned n)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < 32u && 32u * n + i < HIL_INTERRUPTS; i++)
        value |= (uint32_t)is_exception_in_set(set, 16u + 32u * n + i) << i;
    return value;
}

static void write_interrupt_word(uint32_t *set, unsigned n, uint32_t bits, bool on)
{
    for (unsigned i = 0; i < 32u && 32u * n + i < HIL_INTERRUPTS; i++) {
        if (bits >> i & 1u)
            change_exception_in_set(set, 16u + 32u * n + i, on);
    }
}

/* Priorities of `count` exceptions (1 to 4) from this one on, one byte each, as in the priority
 * registers. */
static uint32_t read_priorities(const struct hil_nvic *nvic, unsigned exception, unsigned count)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < count && exception + i < HIL_EXCEPTIONS; i++)
        value |= (uint32_t)(nvic->priority[exception + i] & 0xff) << (8u * i);
    return value;
}

static void set_priorities(struct hil_core *core, unsigned exception, unsigned count,
                           uint32_t value)
{
    for (unsigned i = 0; i < count && exception + i < HIL_EXCEPTIONS; i++) {
        uint32_t byte = value >> (8u * i) & 0xffu;
        /* 0xff is allowed: software writes it to find out how many bits are implemented */
        if (byte && byte < 0x10u)
            hil_bus_refuse(core, "a priority in the lower four bits, which the chip reads as 0");
        core->state.nvic.priority[exception + i] = (int16_t)(byte & 0xf0u);
    }
    hil_nvic_update(core);
}

/* Returns the set to which the register at `offset` belongs (ISER, ICER, ISPR, ICPR or IABR). */
static uint32_t *get_register_set(struct hil_nvic *nvic, uint32_t offset)
{
    return offset < ISPR ? nvic->enabled : offset < IABR ? nvic->pending : nvic->active;
}

/* Reads registers 0x100..0x4FF of the system control space (ISER, ICER, ISPR, ICPR, IABR, IPR).
 * Returns false if there is no such register. */
static bool read_nvic(struct hil_core *core, uint32_t offset, unsigned size, uint32_t *value)
{
    if (offset >= IPR)
        *value = read_priorities(&core->state.nvic, 16u + offset - IPR, size);
    else
        *value = read_interrupt_word(get_register_set(&core->state.nvic, offset),
                                     (offset & 0x7fu) / 4u);
    return offset >= IPR ? offset + size <= IPR_END : size == 4 && offset % 4u == 0;
}

static bool write_nvic(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    struct hil_nvic *nvic = &core->state.nvic;
    if (offset >= IPR && offset + size <= IPR_END) {
        set_priorities(core, 16u + offset - IPR, size, value);
        return true;
    }
    if (size != 4 || offset % 4u)
        return false;
    unsigned n = (offset & 0x7fu) / 4u;
    write_interrupt_word(get_register_set(nvic, offset), n, value, !(offset & 0x80u));
    /* an interrupt line that is still high becomes pending again at once */
    for (unsigned i = 0; offset >= ICPR && i < 32u && 32u * n + i < HIL_INTERRUPTS; i++) {
        unsigned exception = 16u + 32u * n + i;
        if ((value >> i & 1u) && is_exception_in_set(nvic->line_levels, exception) &&
            !is_exception_in_set(nvic->active, exception))
            change_exception_in_set(nvic->pending, exception, true);
    }
    hil_nvic_update(core);
    return true;
}

/* --- entry and return, faults, sleep --- */

#define ENTRY_CYCLES   12u /* Cortex-M4 TRM: entry 12, return 10, tail-chain 6 */
#define RETURN_CYCLES  10u
#define TAIL_CYCLES    6u
#define CONTROL_NPRIV  1u
#define CONTROL_SPSEL  2u
#define CONTROL_FPCA   4u
#define XPSR_T         (1u << 24)
#define XPSR_ALIGN     (1u << 9)
#define XPSR_EXCEPTION 0x1ffu
#define FRAME_BASIC    0x20u
#define FRAME_FP       0x68u
#define FPCCR_ASPEN    (1u << 31)
#define HFSR_VECTTBL   (1u << 1)
#define HFSR_FORCED    (1u << 30)
#define HFSR_DEBUGEVT  (1u << 31)

static void read_mask_registers(struct hil_core *core, uint32_t *primask, uint32_t *basepri,
                                uint32_t *faultmask)
{
    int ids[3] = {UC_ARM_REG_PRIMASK, UC_ARM_REG_BASEPRI, UC_ARM_REG_FAULTMASK};
    void *values[3] = {primask, basepri, faultmask};
    *primask = *basepri = *faultmask = 0;
    uc_reg_read_batch(core->uc, ids, values, 3);
    *basepri &= 0xf0u; /* keep four priority bits, as the STM32 does; Unicorn keeps eight */
}

static bool is_exception_due(struct hil_core *core, bool use_primask)
{
    const struct hil_nvic *nvic = &core->state.nvic;
    uint32_t primask, basepri, faultmask;
    if (!nvic->next_exception || nvic->next_group_priority >= nvic->active_group_priority)
        return false;
    read_mask_registers(core, &primask, &basepri, &faultmask);
    if (basepri && nvic->next_group_priority >= get_priority_group(nvic, (int)basepri))
        return false;
    if (use_primask && (primask & 1u) && nvic->next_group_priority >= 0)
        return false;
    return !((faultmask & 1u) && nvic->next_group_priority >= -1);
}

unsigned hil_exception_next(struct hil_core *core)
{
    return is_exception_due(core, true) ? core->state.nvic.next_exception : 0;
}

bool hil_exception_can_wake(struct hil_core *core)
{
    return is_exception_due(core, false);
}

/* Updates the flags that Unicorn caches for the translator, handler mode among them. Unicorn does
 * so only when the condition flags are written as a register. */
static void update_core_flags(struct hil_core *core)
{
    uint32_t apsr = 0;
    uc_reg_read(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
    uc_reg_write(core->uc, UC_ARM_REG_APSR_NZCV, &apsr);
}

void hil_exception_trace(struct hil_core *core)
{
    const struct hil_observers *observers = &core->observers;
    if (observers->tracer)
        observers->tracer->on_exception_change(observers->tracer_context);
}

/* Enters the handler: mode, stack and PC. The frame is already on the stack. */
static void enter_handler(struct hil_core *core, unsigned exception, uint32_t exc_return)
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
    update_core_flags(core);
    core->state.counters.exceptions++;
    core->state.cpu.is_event_register_set = true;
    hil_trace(core, "enter %u at 0x%08x", exception, (unsigned)vector);
    hil_exception_trace(core);
    if (!(vector & 1u)) /* without the Thumb bit, the first instruction of the handler faults */
        hil_exception_fault(core, HIL_CFSR_INVSTATE, vector, 0);
}

/* Exception frame on the stack (ARMv7-M B1.5.6); FRAME_BASIC bytes without the floating-point
 * part. */
struct frame {
    uint32_t r[6], pc, xpsr; /* r0 to r3, r12, lr */
    uint64_t d[8];
    uint32_t fpscr, reserved;
};
_Static_assert(sizeof(struct frame) == FRAME_FP,
               "the structure has the layout that the core stores");

/* Moves R0 to R3, R12, LR and, with `fp`, D0 to D7 and FPSCR out of the core or into it. */
static void copy_frame_registers(struct hil_core *core, struct frame *frame, bool fp, bool into)
{
    int ids[15] = {UC_ARM_REG_R0, UC_ARM_REG_R1,  UC_ARM_REG_R2,
                   UC_ARM_REG_R3, UC_ARM_REG_R12, UC_ARM_REG_LR};
    void *values[15];
    for (unsigned i = 0; i < 6; i++)
        values[i] = &frame->r[i];
    for (int i = 0; i < 8; i++) {
        ids[6 + i] = UC_ARM_REG_D0 + i;
        values[6 + i] = &frame->d[i];
    }
    ids[14] = UC_ARM_REG_FPSCR;
    values[14] = &frame->fpscr;
    if (into)
        uc_reg_write_batch(core->uc, ids, values, fp ? 15 : 6);
    else
        uc_reg_read_batch(core->uc, ids, values, fp ? 15 : 6);
}

/* Handles an exception frame at an address without memory and returns the exception to enter. A
 * handler of bus faults or hard faults is entered anyway, without a frame (DUI 0553A 2.4.2, DDI
 * 0337E 5.12.1). Any other exception is replaced by a bus fault, or by a hard fault if bus faults
 * are disabled or their priority is too low. 0: the run has ended. */
static unsigned replace_exception_without_frame(struct hil_core *core, unsigned exception,
                                                uint32_t frame_at, uint32_t pc)
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
    core->state.counters.fault_exceptions++;
    core->state.counters.last_fault_pc = pc;
    if ((nvic->enabled[0] >> HIL_EXC_BUS_FAULT & 1u) &&
        get_priority_group(nvic, nvic->priority[HIL_EXC_BUS_FAULT]) <
            get_priority_group(nvic, nvic->priority[exception]))
        return HIL_EXC_BUS_FAULT;
    core->state.scb.hfsr |= HFSR_FORCED;
    return HIL_EXC_HARD_FAULT;
}

void hil_exception_enter(struct hil_core *core, unsigned exception, uint32_t pc)
{
    uint32_t xpsr = 0, sp = 0, control = 0;
    int ids[3] = {UC_ARM_REG_XPSR, UC_ARM_REG_SP, UC_ARM_REG_CONTROL};
    void *values[3] = {&xpsr, &sp, &control};
    uc_reg_read_batch(core->uc, ids, values, 3);

    bool fp = (control & CONTROL_FPCA) && (core->state.scb.fpccr & FPCCR_ASPEN);
    uint32_t size = fp ? FRAME_FP : FRAME_BASIC;
    uint32_t frame_at = (sp - size) & ~7u;
    uint8_t *to = hil_memory_at(core, frame_at, size, true);
    if (to) {
        struct frame frame = {.pc = pc & ~1u,
                              .xpsr = (xpsr & ~XPSR_ALIGN) | ((sp & 4u) ? XPSR_ALIGN : 0)};
        copy_frame_registers(core, &frame, fp, false);
        memcpy(to, &frame, size);
    } else {
        exception = replace_exception_without_frame(core, exception, frame_at, pc);
        if (!exception)
            return;
    }

    bool handler = (xpsr & XPSR_EXCEPTION) != 0;
    uint32_t exc_return = handler                   ? 0xfffffff1u
                        : (control & CONTROL_SPSEL) ? 0xfffffffdu
                                                    : 0xfffffff9u;
    if (fp)
        exc_return &= ~0x10u;
    uc_reg_write(core->uc, UC_ARM_REG_SP, &frame_at);
    activate_exception(core, exception);
    core->state.clock.now_cycle += ENTRY_CYCLES;
    enter_handler(core, exception, exc_return);
}

/* Returns the exception to enter for a synchronous exception: the same one, or HardFault if it is
 * disabled or its priority is not above the running code's. 0: the run has ended. */
static unsigned escalate_exception(struct hil_core *core, unsigned exception, uint32_t pc)
{
    struct hil_nvic *nvic = &core->state.nvic;
    uint32_t primask, basepri, faultmask;
    read_mask_registers(core, &primask, &basepri, &faultmask);
    int running = nvic->active_group_priority;
    if (basepri && get_priority_group(nvic, (int)basepri) < running)
        running = get_priority_group(nvic, (int)basepri);
    if ((primask & 1u) && running > 0)
        running = 0;
    if ((faultmask & 1u) && running > -1)
        running = -1;
    bool enabled = (nvic->enabled[0] >> exception & 1u) != 0;
    if (exception != HIL_EXC_HARD_FAULT &&
        (!enabled || get_priority_group(nvic, nvic->priority[exception]) >= running)) {
        core->state.scb.hfsr |= HFSR_FORCED;
        exception = HIL_EXC_HARD_FAULT;
    }
    if (exception == HIL_EXC_HARD_FAULT && running <= -1) {
        hil_core_stop(
            core, MR_HALTED,
            "lockup: fault at PC 0x%08x while a fault is handled (CFSR 0x%08x, HFSR 0x%08x)",
            (unsigned)pc, (unsigned)core->state.scb.cfsr, (unsigned)core->state.scb.hfsr);
        return 0;
    }
    return exception;
}

static void enter_fault_or_escalate(struct hil_core *core, unsigned exception, uint32_t pc)
{
    exception = escalate_exception(core, exception, pc);
    if (exception)
        hil_exception_enter(core, exception, pc);
}

static unsigned get_fault_exception(uint32_t cfsr)
{
    return (cfsr & 0xffu)   ? HIL_EXC_MEM_MANAGE
         : (cfsr & 0xff00u) ? HIL_EXC_BUS_FAULT
                            : HIL_EXC_USAGE_FAULT;
}

static void record_fault(struct hil_core *core, uint32_t cfsr, uint32_t pc, uint32_t address)
{
    struct hil_counters *counters = &core->state.counters;
    core->state.scb.cfsr |= cfsr;
    if (cfsr & HIL_CFSR_BFARVALID)
        core->state.scb.bfar = address;
    counters->fault_exceptions++;
    counters->last_fault_pc = pc;
    hil_trace(core, "fault at PC 0x%08x, address 0x%08x, CFSR 0x%08x", (unsigned)pc,
              (unsigned)address, (unsigned)core->state.scb.cfsr);
}

/* Enters the next handler directly: the frame stays on the stack. */
static void enter_by_tail_chain(struct hil_core *core, unsigned exception, uint32_t exc_return)
{
    core->state.counters.tail_chains++;
    core->state.clock.now_cycle += TAIL_CYCLES;
    activate_exception(core, exception);
    enter_handler(core, exception, exc_return);
}

/* Handles an invalid return: tail-chains its fault, with the stack unchanged (ARMv7-M B1.5.8,
 * PM0214 4.4.10). */
static void refuse_return(struct hil_core *core, uint32_t cfsr, uint32_t exc_return)
{
    record_fault(core, cfsr, exc_return, 0);
    unsigned exception = escalate_exception(core, get_fault_exception(cfsr), exc_return);
    if (exception)
        enter_by_tail_chain(core, exception, exc_return);
}

/* Restores the frame that `exc_return` selects. Returns false if a fault is taken instead. */
static bool restore_frame(struct hil_core *core, uint32_t exc_return)
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
    const uint8_t *from = hil_memory_at(core, frame_at, size, false);
    if (!from) {
        refuse_return(core, HIL_CFSR_UNSTKERR, exc_return);
        return false;
    }
    struct frame frame = {0};
    memcpy(&frame, from, size);
    uint32_t xpsr = frame.xpsr, pc = (frame.pc & ~1u) | ((xpsr & XPSR_T) != 0);
    if (((xpsr & XPSR_EXCEPTION) != 0) != handler) {
        refuse_return(core, HIL_CFSR_INVPC, exc_return);
        return false;
    }
    uint32_t sp = frame_at + size;
    if (xpsr & XPSR_ALIGN)
        sp |= 4u;
    *(psp ? &psp_value : &msp) = sp;

    /* Order: first the mode (writing xPSR switches it), then the stack selection, then both stack
     * pointers by name. */
    uint32_t new_control = (control & CONTROL_NPRIV) | (psp ? CONTROL_SPSEL : 0) |
                           (fp ? CONTROL_FPCA : 0);
    uint32_t new_xpsr = xpsr & ~XPSR_ALIGN;
    uint32_t privileged = new_control & ~CONTROL_NPRIV;
    uc_reg_write(core->uc, UC_ARM_REG_XPSR_NZCVQG, &new_xpsr);
    uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &privileged);
    uc_reg_write(core->uc, UC_ARM_REG_MSP, &msp);
    uc_reg_write(core->uc, UC_ARM_REG_PSP, &psp_value);
    copy_frame_registers(core, &frame, fp, true);
    uc_reg_write(core->uc, UC_ARM_REG_PC, &pc);
    if (new_control & CONTROL_NPRIV)
        uc_reg_write(core->uc, UC_ARM_REG_CONTROL, &new_control);
    update_core_flags(core);
    hil_exception_trace(core);
    if (!(xpsr & XPSR_T))
        hil_exception_fault(core, HIL_CFSR_INVSTATE, frame.pc, 0);
    return (xpsr & XPSR_T) != 0;
}

void hil_exception_return(struct hil_core *core, uint32_t exc_return)
{
    struct hil_nvic *nvic = &core->state.nvic;
    unsigned number = hil_cpu_register(core, 16) & XPSR_EXCEPTION, nested = 0;
    uint32_t form = exc_return | 0x10u, zero = 0;
    if (form < 0xfffffff0u) {
        hil_core_stop(core, MR_HALTED,
                      "the branch to 0x%08x in exception %u is not an exception return",
                      (unsigned)exc_return, number);
        return;
    }
    for (unsigned w = 0; w < HIL_EXCEPTION_WORDS; w++)
        nested += (unsigned)__builtin_popcount(nvic->active[w]);
    bool to_handler = form == 0xfffffff1u;
    bool valid = hil_nvic_is_active(nvic, number) &&
                 (to_handler || ((form == 0xfffffff9u || form == 0xfffffffdu) && nested == 1));
    if (number != HIL_EXC_NMI)
        uc_reg_write(core->uc, UC_ARM_REG_FAULTMASK, &zero);
    core->state.cpu.is_event_register_set = true;
    deactivate_exception(core, number);
    if (!valid) {
        refuse_return(core, HIL_CFSR_INVPC, exc_return);
        return;
    }
    unsigned next = hil_exception_next(core);
    if (next) {
        enter_by_tail_chain(core, next, exc_return);
        return;
    }
    core->state.clock.now_cycle += RETURN_CYCLES;
    if (!restore_frame(core, exc_return))
        return;
    hil_trace(core, "return from %u", number);
    if ((core->state.scb.scr & 2u) && !to_handler)
        core->state.cpu.is_asleep = true; /* SLEEPONEXIT */
}

void hil_exception_fault(struct hil_core *core, uint32_t cfsr, uint32_t pc, uint32_t address)
{
    record_fault(core, cfsr, pc, address);
    enter_fault_or_escalate(core, get_fault_exception(cfsr), pc);
}

void hil_exception_svc(struct hil_core *core, uint32_t pc)
{
    enter_fault_or_escalate(core, HIL_EXC_SVCALL, pc);
}

void hil_exception_bkpt(struct hil_core *core, uint32_t pc)
{
    core->state.scb.hfsr |= HFSR_DEBUGEVT;
    core->state.counters.fault_exceptions++;
    core->state.counters.last_fault_pc = pc;
    enter_fault_or_escalate(core, HIL_EXC_HARD_FAULT, pc);
}

/* --- SysTick --- */

#define SYST_ENABLE    1u
#define SYST_TICKINT   2u
#define SYST_CLKSOURCE 4u /* 1: HCLK, 0: HCLK / 8 */
#define SYST_COUNTFLAG (1u << 16)

static uint32_t get_systick_divider(const struct hil_systick *s)
{
    return (s->ctrl & SYST_CLKSOURCE) ? 1 : 8;
}

static uint32_t get_systick_value(const struct hil_core *core)
{
    const struct hil_systick *s = &core->state.systick;
    if (!(s->ctrl & SYST_ENABLE) || s->zero_cycle == HIL_NEVER)
        return s->value;
    uint64_t now = hil_now_cycle(core);
    uint64_t left = s->zero_cycle > now
                      ? (s->zero_cycle - now + get_systick_divider(s) - 1) / get_systick_divider(s)
                      : 0;
    return (uint32_t)left;
}

/* Schedules the time at which the running counter, whose value is now `value`, reaches 0. A counter
 * at 0 is reloaded first. */
static void schedule_systick_zero(struct hil_core *core, uint32_t value)
{
    struct hil_systick *s = &core->state.systick;
    uint64_t ticks = value ? value : s->load ? (uint64_t)s->load + 1u : 0;
    s->zero_cycle = ticks ? hil_now_cycle(core) + ticks * get_systick_divider(s) : HIL_NEVER;
    s->value = value;
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, s->zero_cycle);
}

static void on_systick_zero(void *device, uint64_t at)
{
    struct hil_core *core = device;
    struct hil_systick *s = &core->state.systick;
    s->ctrl |= SYST_COUNTFLAG;
    if (s->ctrl & SYST_TICKINT)
        pend_exception(core, HIL_EXC_SYSTICK);
    s->value = 0;
    s->zero_cycle = s->load ? at + ((uint64_t)s->load + 1u) * get_systick_divider(s) : HIL_NEVER;
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, s->zero_cycle);
}

void hil_systick_create(struct hil_core *core)
{
    hil_event_connect(core, HIL_EVENT_SYSTICK, on_systick_zero, core);
}

void hil_systick_reset(struct hil_core *core)
{
    core->state.systick = (struct hil_systick){.zero_cycle = HIL_NEVER};
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, HIL_NEVER);
}

static uint32_t read_systick(struct hil_core *core, uint32_t offset)
{
    struct hil_systick *s = &core->state.systick;
    uint32_t value;
    switch (offset) {
    case 0x10:
        value = s->ctrl;
        s->ctrl &= ~SYST_COUNTFLAG;
        return value;
    case 0x14: return s->load;
    case 0x18: return get_systick_value(core);
    default: /* CALIB: TENMS is 18750, SKEW is set */ return 0x4000493e;
    }
}

static void write_systick(struct hil_core *core, uint32_t offset, uint32_t value)
{
    struct hil_systick *s = &core->state.systick;
    uint32_t count = get_systick_value(core);
    switch (offset) {
    case 0x10:
        s->ctrl = (s->ctrl & SYST_COUNTFLAG) |
                  (value & (SYST_ENABLE | SYST_TICKINT | SYST_CLKSOURCE));
        s->value = count;
        if (s->ctrl & SYST_ENABLE)
            schedule_systick_zero(core, count);
        else
            hil_event_set_cycle(core, HIL_EVENT_SYSTICK, HIL_NEVER);
        break;
    case 0x14: s->load = value & 0xffffffu; break;
    case 0x18: /* any write clears counter and flag, without an interrupt */
        s->ctrl &= ~SYST_COUNTFLAG;
        s->value = 0;
        if (s->ctrl & SYST_ENABLE)
            schedule_systick_zero(core, 0);
        break;
    default: /* CALIB is read-only */ break;
    }
}

/* --- system control block --- */

#define SCS_BASE      0xe000e000u
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
#define CSR_SFTRSTF   (1u << 28) /* RCC_CSR.SFTRSTF */

void hil_scb_reset(struct hil_scb *scb, uint32_t idcode)
{
    *scb = (struct hil_scb){.dwt_ctrl = 0x40000000, .idcode = idcode};
    hil_registers_reset(SCS_BASE, SCB, scb->word, sizeof scb->word / 4u);
}

static uint32_t read_icsr(const struct hil_core *core)
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
    value |= (uint32_t)nvic->next_exception << 12;
    value |= (uint32_t)isr_pending << 22;
    value |= (nvic->pending[0] >> HIL_EXC_SYSTICK & 1u) << 26;
    value |= (nvic->pending[0] >> HIL_EXC_PENDSV & 1u) << 28;
    return value | (nvic->pending[0] >> HIL_EXC_NMI & 1u) << 31;
}

static void write_icsr(struct hil_core *core, uint32_t value)
{
    if (value >> 31 & 1u)
        pend_exception(core, HIL_EXC_NMI);
    if (value >> 28 & 1u)
        pend_exception(core, HIL_EXC_PENDSV);
    else if (value >> 27 & 1u)
        unpend_exception(core, HIL_EXC_PENDSV);
    if (value >> 26 & 1u)
        pend_exception(core, HIL_EXC_SYSTICK);
    else if (value >> 25 & 1u)
        unpend_exception(core, HIL_EXC_SYSTICK);
}

static uint32_t read_shcsr(const struct hil_nvic *nvic)
{
    uint32_t active = nvic->active[0], pending = nvic->pending[0], enabled = nvic->enabled[0];
    return (active >> 4 & 1u) | (active >> 5 & 1u) << 1 | (active >> 6 & 1u) << 3 |
           (active >> 11 & 1u) << 7 | (active >> 14 & 1u) << 10 | (active >> 15 & 1u) << 11 |
           (pending >> 6 & 1u) << 12 | (pending >> 4 & 1u) << 13 | (pending >> 5 & 1u) << 14 |
           (pending >> 11 & 1u) << 15 | (enabled >> 4 & 7u) << 16;
}

static void write_aircr(struct hil_core *core, uint32_t value)
{
    if (value >> 16 != AIRCR_KEY)
        return;
    core->state.nvic.prigroup = (uint8_t)(value >> 8 & 7u);
    hil_nvic_update(core);
    if (value & 4u)
        hil_core_request_reset(core, CSR_SFTRSTF);
}

static uint32_t read_cyccnt(const struct hil_core *core)
{
    const struct hil_scb *scb = &core->state.scb;
    return scb->dwt_offset + ((scb->dwt_ctrl & DWT_CYCCNTENA) ? (uint32_t)hil_now_cycle(core) : 0);
}

static uint32_t read_scs(struct hil_core *core, uint32_t offset, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    uint32_t value = 0;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        return read_systick(core, offset);
    if (offset >= 0x100u && offset < 0x500u)
        return read_nvic(core, offset, size, &value) ? value : hil_bus_refuse_register(core);
    if (offset >= SHPR && offset + size <= SHCSR)
        /* SHPR: exceptions 4 to 15 */
        return read_priorities(&core->state.nvic, 4u + offset - SHPR, size);
    if (offset >= CFSR && offset < HFSR) /* CFSR, also by bytes */
        return scb->cfsr >> (8u * (offset & 3u)) &
               (size == 4 ? 0xffffffffu : (1u << (8u * size)) - 1u);
    if (size != 4 || offset % 4u)
        return hil_bus_refuse_register(core);
    switch (offset) {
    case ICTR: /* interrupt lines in groups of 32, minus one */ return 2;
    case ICSR: return read_icsr(core);
    case AIRCR: /* the upper half reads as the complement of the key */
        return 0xfa050000u | (uint32_t)core->state.nvic.prigroup << 8;
    case SHCSR: return read_shcsr(&core->state.nvic);
    default: return scb->word[(offset - SCB) / 4u];
    }
}

static void write_scb_register(struct hil_core *core, uint32_t offset, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    switch (offset) {
    case ICSR: write_icsr(core, value); break;
    case AIRCR: write_aircr(core, value); break;
    case SHCSR:
        core->state.nvic.enabled[0] = (core->state.nvic.enabled[0] & ~0x70u) | (value >> 16 & 7u)
                                                                                   << 4;
        hil_nvic_update(core);
        break;
    case CFSR:
    case HFSR: /* flags are cleared by writing 1 */ scb->word[(offset - SCB) / 4u] &= ~value; break;
    case STIR:
        if ((value & 0x1ffu) < HIL_INTERRUPTS)
            pend_exception(core, 16u + (value & 0x1ffu));
        break;
    case FPCCR: scb->fpccr = value & 0xc0000000u; break;
    default: scb->word[(offset - SCB) / 4u] = value; break;
    }
}

static void write_scs(struct hil_core *core, uint32_t offset, unsigned size, uint32_t value)
{
    bool known = true;
    if (offset >= 0x10u && offset < 0x20u && size == 4)
        write_systick(core, offset, value);
    else if (offset >= 0x100u && offset < 0x500u)
        known = write_nvic(core, offset, size, value);
    else if (offset >= SHPR && offset + size <= SHCSR)
        set_priorities(core, 4u + offset - SHPR, size, value);
    else if (size == 4 && offset % 4u == 0)
        write_scb_register(core, offset, value);
    else
        known = false;
    if (!known)
        hil_bus_refuse_register(core);
}

uint32_t hil_scb_read(struct hil_core *core, uint32_t address, unsigned size)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == SCS_BASE)
        return read_scs(core, address & 0xfffu, size);
    if (size == 4 && address == DWT_CTRL)
        return scb->dwt_ctrl;
    if (size == 4 && address == DWT_CYCCNT)
        return read_cyccnt(core);
    if (size == 4 && address % 4u == 0 && address - DBGMCU < sizeof scb->dbgmcu)
        return scb->dbgmcu[(address - DBGMCU) / 4u];
    return hil_bus_refuse_register(core);
}

static void write_dwt(struct hil_core *core, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if (!(scb->demcr & DEMCR_TRCENA))
        return; /* as on hardware, the write is ignored because the unit is off */
    /* refuse all bits except CYCCNTENA, SYNCTAP and CYCTAP; the latter two affect only trace */
    if (value & 0x3ffffffeu & ~0x1e00u)
        hil_bus_refuse(core, "DWT functions other than the cycle counter");
    uint32_t count = read_cyccnt(core);
    scb->dwt_ctrl = 0x40000000u | (value & DWT_CYCCNTENA);
    scb->dwt_offset = (value & DWT_CYCCNTENA) ? count - (uint32_t)hil_now_cycle(core) : count;
}

void hil_scb_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value)
{
    struct hil_scb *scb = &core->state.scb;
    if ((address & ~0xfffu) == SCS_BASE)
        write_scs(core, address & 0xfffu, size, value);
    else if (size == 4 && address == DWT_CTRL)
        write_dwt(core, value);
    else if (size == 4 && address == DWT_CYCCNT)
        scb->dwt_offset = (scb->dwt_ctrl & DWT_CYCCNTENA) ? value - (uint32_t)hil_now_cycle(core)
                                                          : value;
    else if (size == 4 && address % 4u == 0 && address > DBGMCU &&
             address - DBGMCU < sizeof scb->dbgmcu)
        scb->dbgmcu[(address - DBGMCU) / 4u] = address == DBGMCU + 4u ? value & 0xffu : value;
    /* the lock is not implemented on the STM32F4, so writes are ignored */
    else if (size != 4 || address != DWT_LAR)
        hil_bus_refuse_register(core);
}

void hil_scb_hold_counters(struct hil_core *core, uint64_t cycles)
{
    struct hil_systick *s = &core->state.systick;
    if (s->zero_cycle != HIL_NEVER)
        s->zero_cycle += cycles;
    hil_event_set_cycle(core, HIL_EVENT_SYSTICK, s->zero_cycle);
    if (core->state.scb.dwt_ctrl & DWT_CYCCNTENA)
        core->state.scb.dwt_offset -= (uint32_t)cycles;
}
