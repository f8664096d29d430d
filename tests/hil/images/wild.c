/* One misdeed each, chosen by control[0]. */
#include "tests/hil/images/image.h"

/* The stack may be where no memory is. */
__attribute__((naked)) void bus_fault(void)
{
    __asm__ volatile("ldr r0, =0x20018000\n msr msp, r0\n b bus_fault_told\n .ltorg");
}

/* Not before the fault of its own frame; or its frame gets the number of a handler, and it returns
 * to thread mode. */
__attribute__((naked)) void svc(void)
{
    __asm__ volatile("ldr r0, [%0]\n cmp r0, #20\n bne bus_fault\n"
                     "ldr r0, [sp, #28]\n orr r0, #11\n str r0, [sp, #28]\n bx lr"
                     :
                     : "r"(control));
}

__attribute__((used)) void bus_fault_told(void);
void bus_fault_told(void)
{
    uint32_t exception;
    __asm__ volatile("mrs %0, ipsr" : "=r"(exception));
    results[8] = exception;
    results[2] = REG(0xe000ed28u);
    results[3] = REG(0xe000ed38u);
    results[1]++;
    control[0] = 0;
    REG(0xe000ed28u) = 0xffffffffu;
    REG(0xe000ed0cu) = 0x05fa0004u; /* and start again */
    for (;;)
        ;
}

void usage_fault(void)
{
    uint32_t *frame;
    __asm__ volatile("mrs %0, msp" : "=r"(frame));
    results[2] = REG(0xe000ed28u);
    results[6] = results[7];
    results[1]++;
    control[0] = 0;
    REG(0xe000ed28u) = 0xffffffffu;
    REG(0xe000ed0cu) = 0x05fa0004u;
    for (;;)
        ;
}

__attribute__((noinline)) static uint32_t read_at(uint32_t address)
{
    uint32_t value;
    __asm__ volatile("movs r2, #1\n adds r2, r2, #2\n ldr %0, [%1]\n add %0, %0, r2"
                     : "=r"(value)
                     : "r"(address)
                     : "r2", "memory");
    return value;
}

int main(void)
{
    results[0]++; /* starts */
    results[5] = (uint32_t)(uintptr_t)read_at;
    switch (control[0]) {
    case 1: /* USART2: not modelled */ read_at(0x40004404u); break;
    case 2: /* TIM4 without its clock */ REG(0x40000800u) = 1; break;
    case 3: /* nothing there: bus fault, with a handler */
        REG(0xe000ed24u) = 7u << 16;
        read_at(0x60000000u);
        break;
    case 4: /* the same without the fault enabled and without a HardFault handler */
        read_at(0x60000000u);
        break;
    case 5: __asm__ volatile("vmov.f32 s0, #1.0"); break;
    case 6: /* flash, also after it was read and a word of RAM was stored */
        results[6] = REG(0x08004000u);
        REG(0x08004000u) = 1;
        break;
    case 7: /* 168 MHz with no wait states */
        REG(0x40023800u) |= 1u << 16;
        while (!(REG(0x40023800u) & 1u << 17))
            ;
        REG(0x40023804u) = 2u << 28 | 8u | 336u << 6 | 0u << 16 | 1u << 22 | 7u << 24;
        REG(0x40023808u) = 5u << 10 | 4u << 13;
        REG(0x40023800u) |= 1u << 24;
        while (!(REG(0x40023800u) & 1u << 25))
            ;
        REG(0x40023808u) |= 2u;
        break;
    case 8: /* undefined instruction, no handler */ __asm__ volatile("sev\n wfe\n udf #0"); break;
    case 9: /* reserved register of a modelled peripheral */ read_at(0x40023808u + 0x80u); break;
    case 10: {
        /* LDRD at an odd address, in a block whose other instructions must have been done before */
        uint32_t a, b;
        REG(0xe000ed24u) = 7u << 16;
        __asm__ volatile("movs r2, #77\n str r2, [%3]\n ldrd %0, %1, [%2]"
                         : "=&r"(a), "=&r"(b)
                         : "r"(0x20000101u), "r"(&results[7])
                         : "r2", "memory");
        break;
    }
    case 11: /* LDM likewise */
        REG(0xe000ed24u) = 7u << 16;
        __asm__ volatile("mov r2, %0\n ldmia r2!, {r0, r1}"
                         :
                         : "r"(0x20000102u)
                         : "r0", "r1", "r2", "memory");
        break;
    case 12: { /* single loads and stores may be unaligned */
        uint32_t a = *(volatile uint32_t *)0x20000101u;
        *(volatile uint32_t *)0x20000105u = a;
        break;
    }
    case 13: /* floating point in the middle of a block, the unit off, with a handler */
        REG(0xe000ed24u) = 7u << 16;
        __asm__ volatile(
            "movs r2, #77\n str r2, [%0]\n vmov.f32 s0, #1.0\n movs r2, #78\n str r2, [%0]"
            :
            : "r"(&results[7])
            : "r2", "memory");
        break;
    case 14: /* erased flash */
        REG(0xe000ed24u) = 7u << 16;
        ((void (*)(void))0x080c0001u)();
        break;
    case 15: /* read-only register, reserved bit, bits that are not modelled */
        REG(0x40023830u) |= 1u;
        (void)REG(0x40023830u);
        REG(0x40020010u) = 0;
        break;
    case 16:
        REG(0x40023840u) |= 1u;
        (void)REG(0x40023840u);
        REG(0x40000000u) = 1u << 12;
        break;
    case 17: /* parity without its ninth bit */
        REG(0x40023844u) |= 1u << 4;
        (void)REG(0x40023844u);
        REG(0x4001100cu) = 1u << 10;
        break;
    case 18: /* a push below SRAM: nor is there memory for the fault's frame */
        REG(0xe000ed24u) = 7u << 16;
        __asm__ volatile("mov sp, %0\n push {r0, r1}" : : "r"(0x20000000u) : "memory");
        break;
    case 19: /* an exception whose frame finds no memory gives way to the bus fault that this is */
        REG(0xe000ed24u) = 7u << 16;
        REG(0xe000ed1cu) = 0x80u << 24; /* SVC below it */
        __asm__ volatile("mov sp, %0\n svc #0" : : "r"(0x20000000u) : "memory");
        break;
    case 20: /* an exception that returns to thread mode with the number of a handler */
        REG(0xe000ed24u) = 7u << 16;
        REG(0xe000ed1cu) = 0x80u << 24; /* SVC below the fault */
        __asm__ volatile("svc #0" : : : "memory");
        break;
    case 21: /* what an IT block passes over cannot fault */
        REG(0xe000ed24u) = 7u << 16;
        __asm__ volatile("cmp %0, %0\n it ne\n vmovne.f32 s0, #1.0\n"
                         "itt ne\n ldrdne r2, r3, [%0]\n stmiane %0!, {r2, r3}"
                         :
                         : "r"(0x20000101u)
                         : "r2", "r3", "cc", "memory");
        break;
    default: break;
    }
    results[4] = 0x600d;
    for (;;)
        __asm__ volatile("wfi");
}
