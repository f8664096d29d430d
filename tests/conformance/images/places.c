/* Where a fault is: stacked PC and xPSR, number and status of faults in the middle of a block (ARM
 * B1.5.6, B1.5.8, B1.5.14, A7.3.2; PM0214 4.4). */
#include "frames.h"

#define IT_BITS  0x0600fc00u /* bits 26:25 and 15:10 of xPSR */
#define NOTHING  0x30000000u /* in the SRAM region, and nothing is there (RM0090 2.3) */
#define PAST     0x08100000u /* behind the flash */
#define PRECISE  0x00008200u
#define Z_AND_C  0x60000000u
#define THUMB    0x01000000u
#define IT(bits) (((bits)&3u) << 25 | ((bits)&0xfcu) << 8) /* ITSTATE in xPSR */

static volatile uint32_t may_continue, bfar_seen; /* where, with ITSTATE cleared */
static uint32_t words[8] __attribute__((aligned(8)));

static __attribute__((used)) void leave(uint32_t *at, uint32_t lr)
{
    bfar_seen = BFAR;
    keep(at, lr);
    at[6] = may_continue;
    at[7] = (at[7] & ~IT_BITS) | THUMB;
}
KEEPING(leaver, leave)

/* `code` faults at its label 2: once it has ended, or has faulted, label 3 is next. Registers of
 * it: r4 `there`, r5 `nothing`, r6, r7 at will. Flags as it begins: Z and C. */
#define PLACED(name, there, nothing, code, want_exception, want_xpsr, want_cfsr, want_bfar)  \
    do {                                                                                     \
        uint32_t pc_, base_;                                                                 \
        forget();                                                                            \
        __asm__ volatile("ldr r6, =3f\n\tstr r6, [%2]\n\tmov r4, %3\n\tmov r5, %4\n\t"       \
                         "msr apsr_nzcvq, %5\n\tb 1f\n\t.ltorg\n1:\t" code                   \
                         "\n3:\tadr.w %0, 2b\n\tmov %1, r4"                                  \
                         : "=&r"(pc_), "=&r"(base_)                                          \
                         : "r"(&may_continue), "r"(there), "r"(nothing), "r"(Z_AND_C)        \
                         : "r2", "r3", "r4", "r5", "r6", "r7", "r12", "lr", "memory", "cc"); \
        expect(name "_exception", ipsr_seen, want_exception);                                \
        expect(name "_pc", frame[6] - pc_, 0);                                               \
        expect(name "_xpsr", frame[7] & ~0x200u, THUMB | (want_xpsr));                       \
        expect(name "_cfsr", cfsr_seen, want_cfsr);                                          \
        if ((want_cfsr) == PRECISE)                                                          \
            expect(name "_bfar", bfar_seen, want_bfar);                                      \
        expect(name "_base", base_ - (uint32_t)(uintptr_t)(there), 0);                       \
    } while (0)

static void transfers(void)
{
    /* the third word is not there; the base is as it was (ARM B1.5.6, A7.7.41) */
    PLACED("ldm", PAST - 8u, 0, "nop\n2:\tldmia r4!, {r2, r3, r6}\n\tnop", 5, Z_AND_C, PRECISE,
           PAST);
    PLACED("ldrd", PAST - 4u, 0, "nop\n2:\tldrd r2, r3, [r4], #8\n\tnop", 5, Z_AND_C, PRECISE,
           PAST);
    PLACED("strd", NOTHING + 8u, 0, "nop\n2:\tstrd r2, r3, [r4, #-8]!\n\tnop", 5, Z_AND_C, PRECISE,
           NOTHING);
    PLACED("stm", NOTHING, 0, "movs r6, #0\n2:\tstmia.w r4!, {r2, r3, r6}\n\tnop", 5, Z_AND_C,
           PRECISE, NOTHING);
    PLACED("vldr", NOTHING, 0, "nop\n2:\tvldr d0, [r4, #16]\n\tnop", 5, Z_AND_C, PRECISE,
           NOTHING + 16u);
    PLACED("ldrex", NOTHING, 0, "nop\n2:\tldrex r2, [r4]\n\tnop", 5, Z_AND_C, PRECISE, NOTHING);
}

static void more_transfers(void)
{
    PLACED("tbb", words, NOTHING, "movs r6, #1\n2:\ttbb [r5, r6]\n\tnop", 5, 0x20000000u, PRECISE,
           NOTHING + 1u);
    PLACED("ldr_pc", words, NOTHING, "nop\n2:\tldr pc, [r5]", 5, Z_AND_C, PRECISE, NOTHING);
    PLACED("ldm_pc", NOTHING, 0, "nop\n2:\tldmia r4!, {r2, pc}", 5, Z_AND_C, PRECISE, NOTHING);
    PLACED("vldm", PAST - 8u, 0, "nop\n2:\tvldmia r4!, {d0, d1}\n\tnop", 5, Z_AND_C, PRECISE, PAST);
    PLACED("vstm", NOTHING + 16u, 0, "nop\n2:\tvstmdb r4!, {d0, d1}\n\tnop", 5, Z_AND_C, PRECISE,
           NOTHING);
    PLACED("ldrsh", NOTHING, 0, "nop\n2:\tldrsh r2, [r4, #2]!\n\tnop", 5, Z_AND_C, PRECISE,
           NOTHING + 2u);
}

/* What is behind the instruction that faults has not been done: registers, flags, memory. */
static void nothing_behind(void)
{
    words[0] = 1;
    PLACED(
        "store", words, NOTHING,
        "movs r6, #2\n\tcmp r6, r6\n2:\tstr r6, [r5]\n\tmovs r6, #3\n\tstr r6, [r4]\n\tadds r4, r6",
        5, Z_AND_C, PRECISE, NOTHING);
    expect("store_memory", words[0], 1);
    PLACED(
        "load", words, NOTHING,
        "movs r6, #2\n\tcmp r6, r6\n2:\tldr r2, [r5]\n\tmovs r6, #3\n\tstr r6, [r4]\n\tadds r4, r6",
        5, Z_AND_C, PRECISE, NOTHING);
    expect("load_memory", words[0], 1);
    PLACED("it_store", words, NOTHING,
           "cmp r4, r4\n\tit eq\n2:\tstreq r4, [r5]\n\tmovs r6, #3\n\tstr r6, [r4]\n\tadds r4, r6",
           5, Z_AND_C | IT(0x08u), PRECISE, NOTHING);
    expect("it_store_memory", words[0], 1);
}

/* A branch to where no code can be; the frame is that of the first instruction there. */
static void branch_to(uint32_t there)
{
    forget();
    __asm__ volatile("ldr r6, =3f\n\tstr r6, [%0]\n\tblx %1\n3:\tnop"
                     :
                     : "r"(&may_continue), "r"(there | 1u)
                     : "r0", "r1", "r2", "r3", "r6", "r12", "lr", "memory", "cc");
}

static void branches(void)
{
    branch_to(NOTHING);
    expect("no_code_exception", ipsr_seen, 5);
    expect("no_code_pc", frame[6], NOTHING);
    expect("no_code_cfsr", cfsr_seen, 0x00000100u); /* IBUSERR */
    branch_to(0x40000000u);
    expect("never_code_exception", ipsr_seen, 4);
    expect("never_code_pc", frame[6], 0x40000000u);
    expect("never_code_cfsr", cfsr_seen, 0x00000001u); /* IACCVIOL */
}

/* The registers as the fault finds them fit another instruction of the block. */
static void same_registers(void)
{
    PLACED("post_index", PAST - 8u, PAST - 8u,
           "ldr r2, [r5], #4\n\tldr r3, [r5], #4\n2:\tldr r6, [r5], #4\n\tldr r7, [r5], #4", 5,
           Z_AND_C, PRECISE, PAST);
    PLACED("base_changed", words, NOTHING,
           "mov r6, r4\n\tldr r2, [r6]\n\tmov r6, r5\n2:\tldr r2, [r6]", 5, Z_AND_C, PRECISE,
           NOTHING);
    PLACED("offset_changed", words, NOTHING - (uint32_t)(uintptr_t)words,
           "movs r6, #0\n\tstr r2, [r4, r6]\n\tmov r6, r5\n2:\tstr r2, [r4, r6]", 5, Z_AND_C,
           PRECISE, NOTHING);
    PLACED("skipped_one", words, NOTHING, "it ne\n\tldrne r2, [r5]\n2:\tldr r2, [r5]\n\tnop", 5,
           Z_AND_C, PRECISE, NOTHING);
}

/* ITSTATE of the instruction that faults (ARM A7.3.2): the condition in bits 7:4, with what is left
 * of the mask below. */
static void in_it_block(void)
{
    PLACED("it_second", words, NOTHING,
           "ittet eq\n\tmoveq r2, #1\n2:\tldreq r3, [r5]\n\tmovne r3, #2\n\tmoveq r3, #3", 5,
           Z_AND_C | IT(0x0au), PRECISE, NOTHING);
    PLACED("it_last", words, NOTHING, "ite ne\n\tmovne r2, #1\n2:\tstreq r3, [r5]\n\tnop", 5,
           Z_AND_C | IT(0x08u), PRECISE, NOTHING);
    PLACED("it_after_return", words, NOTHING, "itt eq\n\tsvceq #1\n2:\tldreq r3, [r5]\n\tnop", 5,
           Z_AND_C | IT(0x08u), PRECISE, NOTHING);
    PLACED("it_undefined", words, 0, "itt cs\n\tmovcs r2, #1\n2:\t.short 0xde00\n\tnop", 6,
           Z_AND_C | IT(0x28u), 0x00010000u, 0);
    CPACR &= ~(15u << 20);
    isb();
    PLACED("it_no_unit", words, 0,
           "it ne\n\tvmovne.f32 s0, s1\n\titt eq\n\tmoveq r2, #1\n2:\tvmoveq.f32 s0, s1\n\tnop", 6,
           Z_AND_C | IT(0x08u), 0x00080000u, 0);
    CPACR |= 15u << 20;
    isb();
}

static void in_handler(void)
{
    uint32_t pc;
    __asm__ volatile("ldr %0, =1f\n\tstr %0, [%1]\n\tadr.w %0, 2f\n\tmov r4, #0x30000000\n\tnop\n"
                     "2:\tldrb r5, [r4], #1\n\tnop\n1:\tmov %0, %0"
                     : "=&r"(pc)
                     : "r"(&may_continue)
                     : "r4", "r5", "memory");
    expect("nested_pc", frame[6] - pc, 0);
}

static void nested(void)
{
    on(11, in_handler);
    forget();
    __asm__ volatile("svc #0" ::: "memory");
    expect("nested_exception", ipsr_seen, 5);
    expect("nested_xpsr_number", frame[7] & 0x1ffu, 11);
    expect("nested_exc_return", exc_return, 0xfffffff1u);
    expect("nested_cfsr", cfsr_seen, PRECISE);
}

/* --- a return that cannot be: its fault is tail-chained, and the stack is as it was --- */

static uint32_t stack[64] __attribute__((aligned(8)));
static volatile uint32_t psp_seen, next_return, good_psp, mended_return;
static void (*volatile spoil)(uint32_t *frame);

/* Calls `body` with LR, and branches to what it gives. */
#define RETURNING(name, body)                                                                     \
    static NAKED void name(void)                                                                  \
    {                                                                                             \
        __asm__ volatile("mov r0, lr\n\tpush {r4, lr}\n\tbl " #body "\n\tpop {r4, lr}\n\tbx r0"); \
    }

static uint32_t *process_stack(void)
{
    uint32_t *psp;
    __asm__ volatile("mrs %0, psp" : "=r"(psp));
    return psp;
}

static void set_process_stack(uint32_t psp)
{
    __asm__ volatile("msr psp, %0" ::"r"(psp));
}

static __attribute__((used)) uint32_t spoil_return(uint32_t lr)
{
    good_psp = (uint32_t)(uintptr_t)process_stack();
    next_return = lr;
    spoil(process_stack());
    return next_return;
}
RETURNING(spoiler, spoil_return)

static __attribute__((used)) uint32_t mend_return(uint32_t lr)
{
    psp_seen = (uint32_t)(uintptr_t)process_stack();
    frame_at = good_psp;
    for (unsigned i = 0; i < 8; i++)
        frame[i] = ((uint32_t *)(uintptr_t)good_psp)[i];
    ((uint32_t *)(uintptr_t)good_psp)[7] = THUMB;
    set_process_stack(good_psp);
    __asm__ volatile("mrs %0, ipsr" : "=r"(ipsr_seen));
    exc_return = lr;
    cfsr_seen = CFSR;
    CFSR = 0xffffffffu;
    return mended_return;
}
RETURNING(mender, mend_return)

static void no_stack(uint32_t *at)
{
    (void)at;
    set_process_stack(NOTHING);
}
static void no_form(uint32_t *at)
{
    (void)at;
    next_return = 0xfffffff5u;
}
static void no_thumb(uint32_t *at)
{
    at[7] &= ~THUMB;
}

static void no_base(uint32_t *at)
{
    (void)at;
    ICSR = 1u << 28;
    isb();
}
static NAKED void to_thread(void) /* from an exception that another one waits below */
{
    __asm__ volatile("mvn lr, #6\n\tbx lr");
}

/* An SVC on the process stack whose handler spoils its own return. */
static uint32_t bad_return(void (*how)(uint32_t *))
{
    uint32_t pc;
    forget();
    spoil = how;
    mended_return = how == no_base ? 0xfffffff1u : 0xfffffffdu;
    __asm__ volatile(
        "msr psp, %1\n\tmov r4, #2\n\tmsr control, r4\n\tisb\n\tadr.w %0, 1f\n\tsvc #0\n"
        "1:\tmov r4, #0\n\tmsr control, r4\n\tisb"
        : "=&r"(pc)
        : "r"(&stack[60])
        : "r4", "memory");
    return pc;
}

static void returns(void)
{
    on(11, spoiler);
    on(5, mender);
    on(6, mender);
    (void)bad_return(no_stack);
    expect("no_stack_exception", ipsr_seen, 5);
    expect("no_stack_cfsr", cfsr_seen, 0x00000800u); /* UNSTKERR */
    expect("no_stack_psp", psp_seen, NOTHING);
    expect("no_stack_exc_return", exc_return, 0xfffffffdu);
    (void)bad_return(no_form);
    expect("no_form_exception", ipsr_seen, 6);
    expect("no_form_cfsr", cfsr_seen, 0x00040000u); /* INVPC */
    expect("no_form_psp", psp_seen, good_psp);
    expect("no_form_exc_return", exc_return, 0xfffffff5u);
    on(14, to_thread);
    SHPR(14) = 0x40; /* above the SVC, below the fault */
    (void)bad_return(no_base);
    expect("no_base_exception", ipsr_seen, 6);
    expect("no_base_cfsr", cfsr_seen, 0x00040000u);
    expect("no_base_exc_return", exc_return, 0xfffffff9u);
    uint32_t pc = bad_return(no_thumb);
    expect("no_thumb_exception", ipsr_seen, 6);
    expect("no_thumb_cfsr", cfsr_seen, 0x00020000u); /* INVSTATE */
    expect("no_thumb_psp", psp_seen, good_psp);
    expect("no_thumb_exc_return", exc_return, 0xfffffffdu);
    expect("no_thumb_pc", frame[6] - pc, 0);
    expect("no_thumb_t", frame[7] >> 24 & 1u, 0);
}

int main(void)
{
    CPACR |= 15u << 20;
    isb();
    for (unsigned n = 3; n < 7; n++)
        on(n, leaver);
    on(11, keeper);
    SHPR(11) = 0x80;  /* below the faults */
    SHCSR = 7u << 16; /* MemManage, BusFault, UsageFault */
    isb();
    transfers();
    more_transfers();
    nothing_behind();
    same_registers();
    in_it_block();
    nested();
    branches();
    returns();
    return 0;
}
