/* SPI2 as the test's hand: for each byte on the serial line, one transaction of control[1] bytes
 * from `out` to `in` with PB12 low around it. control[2]: 0 polled, 1 by DMA1 streams 3 and 4, 2
 * polled but PB12 rises in the middle of the last byte, 3 polled without reading anything.
 * control[3]: CR1 without MSTR, SPE, SSM, SSI. */
#include "tests/hil/images/image.h"

#define CR1       REG(0x40003800u)
#define CR2       REG(0x40003804u)
#define SR        REG(0x40003808u)
#define DR        REG(0x4000380cu)
#define BSRR      REG(0x40020418u)
#define CYCLES    REG(0xe0001004u)
#define STREAM(n) (0x40026010u + 0x18u * (n))

static uint8_t out[512], in[512];

static void polled(unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        *(volatile uint8_t *)0x4000380cu = out[i];
        while (!(SR & 1u))
            ;
        in[i] = (uint8_t)DR;
    }
    while (SR & 0x80u)
        ;
}

static void by_dma(unsigned n)
{
    REG(0x40026008u) = 0x0f7d0f7du;
    REG(0x4002600cu) = 0x0f7d0f7du;
    REG(STREAM(3) + 4) = n;
    REG(STREAM(3) + 8) = 0x4000380cu;
    REG(STREAM(3) + 12) = (uint32_t)(uintptr_t)in;
    REG(STREAM(3)) = 0x400u | 1u;
    REG(STREAM(4) + 4) = n;
    REG(STREAM(4) + 8) = 0x4000380cu;
    REG(STREAM(4) + 12) = (uint32_t)(uintptr_t)out;
    REG(STREAM(4)) = 0x400u | 1u << 6 | 1u;
    CR2 = 3;
    while (!(REG(0x40026000u) & 1u << 27)) /* TCIF3 */
        ;
    CR2 = 0;
}

static void transact(unsigned n)
{
    BSRR = 1u << 28;
    uint32_t begin = CYCLES;
    switch (control[2]) {
    case 1: by_dma(n); break;
    case 2:
        polled(n - 1);
        DR = out[n - 1];
        __asm__ volatile("isb\n nop\n nop\n nop\n nop\n nop\n nop\n nop\n nop\n nop\n nop\n isb");
        BSRR = 1u << 12;
        while (SR & 0x80u)
            ;
        (void)DR;
        break;
    case 3:
        for (unsigned i = 0; i < n; i++) {
            while (!(SR & 2u))
                ;
            DR = out[i];
        }
        while (SR & 0x80u)
            ;
        results[2] = SR;
        results[6] = DR;
        results[7] = SR; /* DR, then SR: OVR falls after this */
        results[8] = SR;
        break;
    default: polled(n); break;
    }
    results[1] = CYCLES - begin;
    BSRR = 1u << 12;
}

int main(void)
{
    results[3] = (uint32_t)clock_168();
    results[4] = (uint32_t)(uintptr_t)out;
    results[5] = (uint32_t)(uintptr_t)in;
    REG(0xe000edfcu) |= 1u << 24;
    REG(0xe0001000u) |= 1u;
    REG(0x40023830u) |= 2u | 1u << 21; /* GPIOB, DMA1 */
    REG(0x40023840u) |= 1u << 14;
    BSRR = 1u << 12;
    /* PB12 output, 13 to 15 alternate */
    REG(0x40020400u) = (REG(0x40020400u) & 0x00ffffffu) | 0xa9000000u;
    REG(0x40020408u) |= 0xaa000000u; /* fast enough for 21 MHz */
    REG(0x4002040cu) |= 1u << 28;    /* nothing drives MISO while the memory listens */
    REG(0x40020424u) = 0x55500000u;
    results[9] = SR;
    REG(0x40023830u) |= 1u; /* USART1, 2 Mbaud, receives on PA10 */
    REG(0x40023844u) |= 1u << 4;
    REG(0x40020000u) = (REG(0x40020000u) & ~(3u << 20)) | 2u << 20;
    REG(0x40020024u) |= 0x700u;
    REG(0x40011008u) = 42;
    REG(0x4001100cu) = 1u << 13 | 1u << 5 | 4u;
    enable_irq(37);
    __asm__ volatile("cpsid i");
    results[0] = 1;
    for (;;) {
        __asm__ volatile("wfi");
        if (!(REG(0x40011000u) & 0x20u))
            continue;
        (void)REG(0x40011004u);
        REG(0xe000e284u) = 1u << 5; /* no longer pending */
        CR1 = control[3] | 1u << 9 | 1u << 8 | 1u << 2;
        CR1 |= 1u << 6;
        transact(control[1]);
        CR1 = control[3] | 1u << 9 | 1u << 8 | 1u << 2;
        results[0]++;
    }
}
