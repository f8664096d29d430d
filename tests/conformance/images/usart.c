/* USART1 as a transmitter (RM0090 30.6), which also carries these lines. */
#include "bench.h"

static volatile uint32_t empties;

static void empty(void)
{
    empties++;
    USART1_CR1 &= ~(1u << 7);
    __asm__ volatile("dsb");
}

/* Everything that was put has gone out. */
static uint32_t drained(void)
{
    for (uint32_t n = 0; n < 5000000u; n++) {
        if (USART1_SR & 0x40u) /* TC */
            return 1;
    }
    return 0;
}

int main(void)
{
    uint32_t sr, cr1;
    expect("drains", drained(), 1);
    drained();
    sr = USART1_SR;
    expect("txe_and_tc", sr & 0xc0u, 0xc0u);
    expect("no_errors", sr & 0x0fu, 0);
    expect("nothing_received", sr & 0x20u, 0);
    expect("brr_reads_back", USART1_BRR, 0x10u);
    expect("cr1_reads_back", USART1_CR1, 0xa008u);
    expect("cr2_reset", USART1_CR2, 0);
    expect("cr3_reset", USART1_CR3, 0);
    drained();
    sr = USART1_SR;
    USART1_SR = sr & ~0x40u; /* TC is cleared by writing 0 */
    sr = USART1_SR;
    expect("tc_cleared", sr & 0x40u, 0);
    drained();
    on(IRQ(37), empty);
    ISER(37) = BIT(37);
    cr1 = USART1_CR1;
    USART1_CR1 = cr1 | 1u << 7; /* TXEIE: the register is empty, so at once */
    __asm__ volatile("dsb\n\tisb");
    for (uint32_t n = 0; n < 100000u && !empties; n++)
        ;
    expect("txe_interrupt", empties, 1);
    USART1_CR3 = 1u << 7;
    expect("cr3_reads_back", USART1_CR3, 0x80u);
    USART1_CR3 = 0;
    return 0;
}
