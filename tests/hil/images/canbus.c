/* CAN1 at 1 Mbit/s: sends what control asks for, counts what comes. control[0]: bit 0 request
 * order, bit 1 leave frames in the FIFO, bit 2 automatic bus-off recovery; wrongly: bit 3 does not
 * wait for INAK, bit 4 clears flags of TSR by reading it, bit 5 gives a priority unshifted.
 * control[1]: number of frames to queue at once, then control[2..4] their standard identifiers. */
#include "tests/hil/images/image.h"

void can_rx0(void)
{
    results[8 + (results[2] & 15u)] = REG(0x400065b0u) >> 21;
    results[3] = REG(0x400065b4u);
    results[4] = REG(0x400065b8u);
    results[2]++;
    REG(0x4000640cu) = 0x20;
}

void can_tx(void)
{
    results[5] |= REG(0x40006408u);
    if (control[0] & 16u)
        REG(0x40006408u) |= 0x010101;
    REG(0x40006408u) = 0x010101;
    results[6]++;
}

int main(void)
{
    unsigned wait;
    results[0] = 0x100u + (uint32_t)clock_168();
    REG(0x40023830u) |= 8u;
    REG(0x40023840u) |= 1u << 25;
    REG(0x40020c00u) |= 0xau;
    REG(0x40020c20u) |= 0x99u;
    REG(0x40006400u) = 1u | (control[0] & 1u) << 2 | (control[0] >> 2 & 1u) << 6;
    for (wait = 100000; wait && !(control[0] & 8u) && !(REG(0x40006404u) & 1u); wait--)
        ;
    REG(0x4000641cu) = 2u | 10u << 16 | 1u << 20; /* 42 MHz / 3 / (1 + 11 + 2) */
    REG(0x40006600u) |= 1u;
    REG(0x4000660cu) = 1;
    REG(0x40006640u) = 0;
    REG(0x40006644u) = 0;
    REG(0x4000661cu) = 1;
    REG(0x40006600u) &= ~1u;
    REG(0x40006414u) = 1u | (control[0] & 2u ? 0u : 2u);
    if (control[0] & 32u)
        *(volatile uint8_t *)0xe000e413u = 2;
    enable_irq(19);
    enable_irq(20);
    REG(0x40006400u) &= ~1u;
    for (wait = 100000; wait && (REG(0x40006404u) & 1u); wait--)
        ;
    results[1] = 0x100u + (wait == 0);
    for (;;) {
        for (unsigned m = 0; m < control[1] && m < 3; m++) {
            REG(0x40006584u + 16u * m) = 8;
            REG(0x40006588u + 16u * m) = 0x33221100u;
            REG(0x4000658cu + 16u * m) = 0x77665544u;
            REG(0x40006580u + 16u * m) = control[2 + m] << 21 | 1u;
        }
        control[1] = 0;
        results[7] = REG(0x40006418u);  /* ESR */
        results[40] = REG(0x4000640cu); /* RF0R */
    }
}
