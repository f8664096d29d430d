/* Bring the clock up with bounded waits; then either idle or be watched by the watchdog. */
#include "tests/hil/images/image.h"

/* Memory to memory by DMA2 stream 0: 8 words of the vector table to `to`. Returns the stream's
 * flags when it has ended. */
static uint32_t copy(uint32_t to)
{
    uint32_t flags = 0;
    REG(0x40023830u) |= 1u << 22;
    REG(0x40026408u) = 0x3d;
    REG(0x40026414u) = 8;
    REG(0x40026418u) = 0x08000000u;
    REG(0x4002641cu) = to;
    REG(0x40026424u) = 0x27; /* FIFO mode */
    REG(0x40026410u) = 2u << 6 | 3u << 9 | 2u << 11 | 2u << 13 | 1u;
    for (unsigned wait = 1000; wait && !(flags & 0x28u); wait--)
        flags = REG(0x40026400u) & 0x3du;
    return flags;
}

int main(void)
{
    results[0]++; /* starts: not cleared by a reset, SRAM keeps its contents */
    results[1] = (uint32_t)clock_168() + 0x100u;
    results[2] = REG(0x40023874u); /* RCC_CSR */
    REG(0x40023874u) |= 1u << 24;
    results[3] = REG(0x1fff7a10u);
    results[4] = *(volatile uint16_t *)0x1fff7a22u;
    results[5] = REG(0xe0042000u) & 0xfffu;
    results[6] = copy((uint32_t)(uintptr_t)&results[8]);
    results[7] = copy(0x10000000u);
    /* bit-band: set bit 3 of results[17], read HSERDY (bit 17 of RCC_CR) */
    REG(0x22000000u + ((uint32_t)(uintptr_t)&results[17] - 0x20000000u) * 32u + 3u * 4u) = 1;
    results[18] = REG(0x42000000u + 0x23800u * 32u + 17u * 4u);
    __asm__ volatile("sev\n wfe");
    results[19] = 1;
    if (control[0]) { /* watchdog: 4 * 64 LSI cycles, fed until control[1] */
        REG(0x40003000u) = 0x5555;
        REG(0x40003004u) = 0;
        REG(0x40003008u) = 63;
        REG(0x40003000u) = 0xcccc;
        while (!control[1])
            REG(0x40003000u) = 0xaaaa;
    }
    return 0;
}
