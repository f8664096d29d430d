/* Both converters triggered by TIM4 at 8 kHz, excitation reversed every scan, edges captured by
 * TIM2, all with DMA. control[0]: bit 0 leaves PD12 and PD13, bit 1 leaves PA15 without their
 * alternate function. */
#include "tests/hil/images/image.h"

#define SCANS 4
static volatile uint16_t adc1[SCANS][16];
static volatile uint16_t adc3[SCANS][8];
static volatile uint32_t edges[8];

void dma2_stream4(void)
{
    uint32_t tick = REG(0x40000024u);
    uint32_t flags = REG(0x40026404u) & 0x3fu; /* HISR, stream 4 */
    REG(0x4002640cu) = flags;
    if (flags & 0x10u)
        results[2] = tick;
    if (flags & 0x20u)
        results[3] = tick;
    results[1]++;
}

static void stream(uint32_t base, unsigned n, uint32_t par, volatile void *memory, uint32_t count,
                   uint32_t cr)
{
    uint32_t s = base + 0x10u + 0x18u * n;
    REG(s + 4) = count;
    REG(s + 8) = par;
    REG(s + 12) = (uint32_t)(uintptr_t)memory;
    REG(s) = cr;
    REG(s) = cr | 1u;
}

static void converter(uint32_t base, uint32_t length, uint32_t sqr3, uint32_t sqr2, uint32_t sqr1)
{
    REG(base + 4) = 1u << 8;
    REG(base + 0xc) = 0555555555u; /* channels 10 to 18; 112 cycles everywhere: code 5 */
    REG(base + 0x10) = 05555555555u;
    REG(base + 0x34) = sqr3;
    REG(base + 0x30) = sqr2;
    REG(base + 0x2c) = sqr1 | (length - 1u) << 20;
    REG(base + 8) = 1u | 1u << 8 | 1u << 9 | 9u << 24 | 1u << 28;
}

#define SQ(a, b, c, d, e, f) \
    ((uint32_t)(a) | (b) << 5 | (c) << 10 | (d) << 15 | (e) << 20 | (f) << 25)

int main(void)
{
    results[0] = 0x100u + (uint32_t)clock_168();
    results[4] = (uint32_t)(uintptr_t)adc1;
    results[5] = (uint32_t)(uintptr_t)adc3;
    results[6] = (uint32_t)(uintptr_t)edges;
    REG(0x40023830u) |= 0x2fu | 3u << 21; /* ports A to D, F; both DMA */
    REG(0x40023840u) |= 5u;               /* TIM2, TIM4 */
    REG(0x40023844u) |= 5u << 8;          /* ADC1, ADC3 */
    /* PA15 alternate, PA0-7 analogue */
    REG(0x40020000u) = (REG(0x40020000u) & 0x3fff0000u) | 0x80000000u | 0xffffu;
    if (!(control[0] & 2u))
        REG(0x40020024u) = 1u << 28; /* PA15: function 1 */
    REG(0x40020400u) |= 0xfu;
    REG(0x40020800u) |= 0xfffu;
    REG(0x40021400u) |= 0x3fffc0u; /* PF3 to PF10 */
    if (!(control[0] & 1u))
        REG(0x40020c00u) |= 0xau << 24; /* PD12, PD13 alternate */
    REG(0x40020c24u) = 0x22u << 16;     /* function 2 */

    REG(0x40012304u) = 1u << 16; /* ADCCLK = PCLK2 / 4 */
    stream(0x40026400u, 4, 0x4001204cu, adc1, SCANS * 16,
           0u << 25 | 1u << 13 | 1u << 11 | 0x400u | 0x100u | 0x18u);
    stream(0x40026400u, 1, 0x4001224cu, adc3, SCANS * 8,
           2u << 25 | 1u << 13 | 1u << 11 | 0x400u | 0x100u);
    stream(0x40026000u, 5, 0x40000034u, edges, 8, 3u << 25 | 2u << 13 | 2u << 11 | 0x400u | 0x100u);
    converter(0x40012000u, 16, SQ(0, 1, 2, 3, 4, 5), SQ(6, 7, 8, 9, 10, 11),
              SQ(12, 13, 14, 15, 0, 0));
    converter(0x40012200u, 8, SQ(9, 14, 15, 4, 5, 6), SQ(7, 8, 0, 0, 0, 0), 0);
    enable_irq(60);

    REG(0x40000018u) = 1; /* TIM2: IC1 on TI1 */
    REG(0x40000020u) = 1;
    REG(0x4000000cu) = 1u << 9;
    REG(0x4000002cu) = 0xffffffffu;
    REG(0x40000008u) = 0x36; /* starts with TIM4 */

    REG(0x4000082cu) = 10499; /* TIM4: 125 us */
    REG(0x40000834u) = 100;
    REG(0x40000838u) = 100;
    REG(0x40000840u) = 2000;
    REG(0x4000081cu) = 7u << 12;           /* channel 4: PWM 2, rises at 2000 */
    REG(0x40000818u) = 5u << 4 | 4u << 12; /* outputs 1 high, 2 low */
    REG(0x40000820u) = 0x1011;
    REG(0x40000818u) = 3u << 4 | 3u << 12; /* and toggling from there */
    REG(0x40000804u) = 1u << 4;
    REG(0x40000814u) = 1;
    REG(0x40000810u) = 0;
    REG(0x40000800u) = 1;
    return 0;
}
