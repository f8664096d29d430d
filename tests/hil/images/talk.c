/* USART1 at 2 Mbaud sends the same kilobyte for ever, by DMA, while the core sleeps. */
#include "tests/hil/images/image.h"

static uint8_t out[1024];

int main(void)
{
    (void)clock_168();
    for (unsigned i = 0; i < sizeof out; i++)
        out[i] = (uint8_t)i;
    REG(0x40023830u) |= 1u | 1u << 22;
    REG(0x40023844u) |= 1u << 4;
    REG(0x40020000u) = (REG(0x40020000u) & ~(3u << 18)) | 2u << 18;
    REG(0x40020024u) |= 0x70u;
    REG(0x40011008u) = 42; /* 84 MHz / 42 */
    REG(0x40011014u) = 0x80;
    REG(0x4001100cu) = 1u << 13 | 8u;
    REG(0x40026410u + 0x18u * 7u + 4) = sizeof out;
    REG(0x40026410u + 0x18u * 7u + 8) = 0x40011004u;
    REG(0x40026410u + 0x18u * 7u + 12) = (uint32_t)(uintptr_t)out;
    REG(0x40026410u + 0x18u * 7u) = 4u << 25 | 1u << 6 | 0x500u | 1u;
    return 0;
}
