/* What the test images share: a vector table, register access by address, words where the test
 * looks and where it tells.
 *
 * results[] is at 0x20000000. The test writes results[56..63] (`control`) before or while the image
 * runs and reads the rest. An image defines handlers by the names below; those it does not define
 * halt the board (a zero vector). */
#ifndef MATRIG_TESTS_HIL_IMAGE_H
#define MATRIG_TESTS_HIL_IMAGE_H

#include <stdint.h>

#define REG(address) (*(volatile uint32_t *)(address))
#define WORDS        64
__attribute__((section(".results"), used)) static volatile uint32_t results[WORDS];
#define control (results + 56)

int main(void);
void reset(void) __attribute__((noreturn));

#define WEAK          __attribute__((weak))
/* clang-format off */
#define HANDLERS(X)                                                                  \
    X(nmi) X(hard_fault) X(mem_manage) X(bus_fault) X(usage_fault)                   \
    X(svc) X(pendsv) X(systick) X(irq4) X(irq6) X(irq7) X(irq8) X(dma1_stream5)      \
    X(can_tx) X(can_rx0) X(tim2) X(usart1) X(dma2_stream4) X(dma2_stream7)
/* clang-format on */
#define DECLARE(name) void name(void) WEAK;
HANDLERS(DECLARE)

typedef void (*vector)(void);
__attribute__((section(".vectors"), used)) static const vector vectors[16 + 82] = {
    [0] = (vector)0x20018000,
    [1] = (vector)reset,
    [2] = nmi,
    [3] = hard_fault,
    [4] = mem_manage,
    [5] = bus_fault,
    [6] = usage_fault,
    [11] = svc,
    [14] = pendsv,
    [15] = systick,
    [16 + 4] = irq4,
    [16 + 6] = irq6,
    [16 + 7] = irq7,
    [16 + 8] = irq8,
    [16 + 16] = dma1_stream5,
    [16 + 19] = can_tx,
    [16 + 20] = can_rx0,
    [16 + 28] = tim2,
    [16 + 37] = usart1,
    [16 + 60] = dma2_stream4,
    [16 + 70] = dma2_stream7,
};

void reset(void)
{
    main();
    for (;;)
        __asm__ volatile("wfi");
}

static inline void enable_irq(unsigned n)
{
    REG(0xe000e100u + 4u * (n / 32u)) = 1u << (n % 32u);
}
static inline void pend_irq(unsigned n)
{
    REG(0xe000e200u + 4u * (n / 32u)) = 1u << (n % 32u);
}
static inline void irq_priority(unsigned n, uint8_t p)
{
    *(volatile uint8_t *)(0xe000e400u + n) = p;
}
static inline void enable_fpu(void)
{
    REG(0xe000ed88u) |= 0xfu << 20;
    __asm__ volatile("dsb\n isb");
}

/* 8 MHz crystal, PLL, 168 MHz; APB1 42, APB2 84 MHz. Returns 0, or which wait gave up: 1 crystal, 2
 * PLL, 3 switch. */
static inline int clock_168(void)
{
    unsigned wait;
    REG(0x40023800u) |= 1u << 16;
    for (wait = 200000; wait && !(REG(0x40023800u) & 1u << 17); wait--)
        ;
    if (!wait)
        return 1;
    REG(0x40023c00u) = 0x705; /* five wait states, caches */
    (void)REG(0x40023c00u);
    REG(0x40023804u) = 2u << 28 | 8u | 336u << 6 | 0u << 16 | 1u << 22 | 7u << 24;
    REG(0x40023808u) = 5u << 10 | 4u << 13;
    REG(0x40023800u) |= 1u << 24;
    for (wait = 200000; wait && !(REG(0x40023800u) & 1u << 25); wait--)
        ;
    if (!wait)
        return 2;
    REG(0x40023808u) |= 2u;
    for (wait = 200000; wait && (REG(0x40023808u) >> 2 & 3u) != 2u; wait--)
        ;
    return wait ? 0 : 3;
}

#endif
