/* Bring the clock up with bounded waits; then either idle or be watched by the watchdog. */
#include "tests/hil/images/image.h"

int main(void)
{
    results[0]++; /* starts: not cleared by a reset, SRAM keeps its contents */
    results[1] = (uint32_t)clock_168() + 0x100u;
    results[2] = REG(0x40023874u); /* RCC_CSR */
    REG(0x40023874u) |= 1u << 24;
    results[3] = REG(0x1fff7a10u);
    results[4] = *(volatile uint16_t *)0x1fff7a22u;
    results[5] = REG(0xe0042000u) & 0xfffu;
    __asm__ volatile("sev\n wfe");
    results[19] = 1;
    if (control[0]) { /* watchdog: 4 * 64 LSI cycles, fed until control[1] */
        REG(0x40003000u) = 0x5555;
        REG(0x40003004u) = 0;
        REG(0x40003008u) = 63;
        REG(0x40003000u) = 0xcccc;
        while (REG(0x4000300cu))
            ;
        while (!control[1])
            REG(0x40003000u) = 0xaaaa;
    }
    return 0;
}
