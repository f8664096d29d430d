/* One misdeed each, chosen by control[0]. */
#include "tests/hil/images/image.h"

void bus_fault(void)
{
    uint32_t *frame;
    __asm__ volatile("mrs %0, msp" : "=r"(frame));
    results[2] = REG(0xe000ed28u);
    results[3] = REG(0xe000ed38u);
    results[1]++;
    control[0] = 0;
    REG(0xe000ed28u) = 0xffffffffu;
    REG(0xe000ed0cu) = 0x05fa0004u; /* and start again */
    for (;;)
        ;
}

__attribute__((noinline)) static uint32_t read_at(uint32_t address)
{
    uint32_t value;
    __asm__ volatile("movs r2, #1\n adds r2, r2, #2\n ldr %0, [%1]\n add %0, %0, r2"
                     : "=r"(value) : "r"(address) : "r2", "memory");
    return value;
}

int main(void)
{
    results[0]++; /* starts */
    results[5] = (uint32_t)(uintptr_t)read_at;
    switch (control[0]) {
    case 1: /* USART2: not modelled */
        read_at(0x40004404u);
        break;
    case 2: /* TIM4 without its clock */
        REG(0x40000800u) = 1;
        break;
    case 3: /* nothing there: bus fault, with a handler */
        REG(0xe000ed24u) = 7u << 16;
        read_at(0x60000000u);
        break;
    case 4: /* the same without the fault enabled and without a HardFault handler */
        read_at(0x60000000u);
        break;
    case 5:
        __asm__ volatile("vmov.f32 s0, #1.0");
        break;
    case 6: /* flash, also after it was read and a word of RAM was stored */
        results[6] = REG(0x08004000u);
        REG(0x08004000u) = 1;
        break;
    case 7: /* 168 MHz with no wait states */
        REG(0x40023800u) |= 1u << 16;
        while (!(REG(0x40023800u) & 1u << 17))
            ;
        REG(0x40023804u) = 8u | 336u << 6 | 0u << 16 | 1u << 22 | 7u << 24;
        REG(0x40023808u) = 5u << 10 | 4u << 13;
        REG(0x40023800u) |= 1u << 24;
        while (!(REG(0x40023800u) & 1u << 25))
            ;
        REG(0x40023808u) |= 2u;
        break;
    case 8: /* undefined instruction, no handler */
        __asm__ volatile("sev\n wfe\n udf #0");
        break;
    case 9: /* reserved register of a modelled peripheral */
        read_at(0x40023808u + 0x80u);
        break;
    default:
        break;
    }
    results[4] = 0x600d;
    for (;;)
        __asm__ volatile("wfi");
}
