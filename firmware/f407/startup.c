/* Vector table and reset. The floating-point unit is enabled before any code that could use it. The
 * Go command of the boot ROM or a debugger may have started the program and left the core in any
 * state. */
#include <stdint.h>

#include "firmware/f407/regs.h"

extern uint32_t stack_top[], data_start[], data_end[], bss_start[], bss_end[];
extern const uint32_t data_load[];

int main(void);
void reset(void);
void enter_rom_if_requested(void);
void processor_fault(void);
void systick(void);
void adc_irq(void);
void can1_tx_irq(void);
void can1_rx0_irq(void);
void dma1_stream3_irq(void);
void dma2_stream1_irq(void);
void dma2_stream4_irq(void);
void dma2_stream7_irq(void);

typedef void (*handler)(void);
#define VECTORS (16u + 82u)

/* Unexpected interrupts are faults too: every entry is the fault handler by default, and later
 * initialisers replace it for interrupts with a handler. */
#pragma GCC diagnostic ignored "-Woverride-init"
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    handler handlers[VECTORS - 1];
} vectors = {
    stack_top,
    {
        [0 ... VECTORS - 2] = processor_fault,
        [1 - 1] = reset,
        [15 - 1] = systick,
        [16 + IRQ_DMA1_STREAM3 - 1] = dma1_stream3_irq,
        [16 + IRQ_ADC - 1] = adc_irq,
        [16 + IRQ_CAN1_TX - 1] = can1_tx_irq,
        [16 + IRQ_CAN1_RX0 - 1] = can1_rx0_irq,
        [16 + IRQ_DMA2_STREAM1 - 1] = dma2_stream1_irq,
        [16 + IRQ_DMA2_STREAM4 - 1] = dma2_stream4_irq,
        [16 + IRQ_DMA2_STREAM7 - 1] = dma2_stream7_irq,
    },
};

void start_program(void);

__attribute__((naked)) void reset(void)
{
    __asm volatile("cpsid i\n\t"
                   "cpsie f\n\t"
                   "movs r0, #0\n\t"
                   "msr basepri, r0\n\t"
                   "msr control, r0\n\t"
                   "isb\n\t"
                   "ldr r0, =stack_top\n\t"
                   "msr msp, r0\n\t"
                   "b.w start_program\n\t"
                   ".ltorg");
}

__attribute__((used)) void start_program(void)
{
    SYST_CSR = 0;
    SCB_ICSR = SCB_ICSR_PENDSTCLR | SCB_ICSR_PENDSVCLR;
    for (unsigned n = 0; n < NVIC_WORDS; n++) {
        NVIC_ICER[n] = 0xffffffffu;
        NVIC_ICPR[n] = 0xffffffffu;
    }
    enter_rom_if_requested();
    /* set the vector table, because after a start by the boot ROM address 0 holds the ROM's
     * vectors */
    SCB_VTOR = (uint32_t)(uintptr_t)&vectors;
    SCB_CPACR |= 0xfu << 20; /* full access to CP10 and CP11; PM0214 4.6.6 */
    __asm volatile("dsb\n\tisb" ::: "memory");
    const uint32_t *from = data_load;
    for (uint32_t *to = data_start; to < data_end; to++)
        *to = *from++;
    for (uint32_t *to = bss_start; to < bss_end; to++)
        *to = 0;
    __asm volatile("cpsie i" ::: "memory");
    (void)main();
    processor_fault();
}
