/* USART1 at 2 Mbaud: sends 100 bytes by DMA, receives into a circle of 16, both with DMA2. */
#include "tests/hil/images/image.h"

static uint8_t out[100];
static volatile uint8_t in[16];

void dma2_stream7(void)
{
    results[7] |= REG(0x40026404u) >> 22;
    results[1] = REG(0xe0001004u);
    REG(0x4002640cu) = 0x3du << 22;
}

void usart1(void)
{
    uint32_t sr = REG(0x40011000u);
    if (sr & 0x10u) {
        (void)REG(0x40011004u);
        results[4]++;
        results[5] = REG(0x40026414u + 0x18u * 2u); /* NDTR of stream 2 */
    }
    if (sr & 0x40u) {
        results[2] = REG(0xe0001004u);
        REG(0x40011000u) = ~0x40u;
    }
}

int main(void)
{
    results[0] = 0x100u + (uint32_t)clock_168();
    REG(0xe000edfcu) |= 1u << 24;
    REG(0xe0001000u) |= 1u;
    for (unsigned i = 0; i < sizeof out; i++)
        out[i] = (uint8_t)(i + 1);
    REG(0x40023830u) |= 1u | 1u << 22;
    REG(0x40023844u) |= 1u << 4;
    REG(0x40020000u) = (REG(0x40020000u) & ~(0xfu << 18)) | 0xau << 18;
    REG(0x40020024u) |= 0x770u;
    REG(0x40011008u) = control[0] ? control[0] : 42; /* 84 MHz / 42 */
    REG(0x40011014u) = 0xc0;
    REG(0x4001100cu) = 1u << 13 | 0xcu | 0x10u;
    results[6] = (uint32_t)(uintptr_t)in;
    REG(0x40026410u + 0x18u * 2u + 4) = sizeof in;
    REG(0x40026410u + 0x18u * 2u + 8) = 0x40011004u;
    REG(0x40026410u + 0x18u * 2u + 12) = (uint32_t)(uintptr_t)in;
    REG(0x40026410u + 0x18u * 2u) = 4u << 25 | 0x500u | 1u;
    enable_irq(37);
    enable_irq(70);
    REG(0x40011000u) = 0;
    REG(0x4001100cu) |= 0x40u;
    REG(0x40026410u + 0x18u * 7u + 4) = sizeof out;
    REG(0x40026410u + 0x18u * 7u + 8) = 0x40011004u;
    REG(0x40026410u + 0x18u * 7u + 12) = control[1] ? 0x10000000u : (uint32_t)(uintptr_t)out;
    results[3] = REG(0xe0001004u);
    REG(0x40026410u + 0x18u * 7u) = 4u << 25 | 1u << 6 | 0x400u | 0x14u | 1u;
    return 0;
}
