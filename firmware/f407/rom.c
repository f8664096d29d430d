/* Into the chip's boot ROM. It expects the chip as after a reset, so the way there is a reset: a
 * note in RAM that survives it, read before anything else. AN2606 3 (STM32F40x: vectors at
 * 0x1FFF0000). */
#include "firmware/f407/drivers.h"

#define ROM_VECTORS 0x1fff0000u
#define NOTE_VALID  0x21524f4du /* "MOR!" */

/* Not cleared at start. With its complement, for at power on RAM holds anything. */
static struct {
    uint32_t valid;
    uint32_t complement;
} note __attribute__((section(".noinit")));

bool board_rom_hears(void)
{
    return BOARD_ROM_HEARS_SERIAL;
}

void board_enter_rom(void)
{
    note.valid = NOTE_VALID;
    note.complement = ~NOTE_VALID;
    __asm volatile("dsb" ::: "memory");
    SCB_AIRCR = 0x05fa0004u; /* system reset request */
    for (;;) {
    }
}

/* What a reset starts is what stands at address 0: with BOOT0 high that is the boot ROM itself. */
static bool rom_came_first(const uint32_t *vectors)
{
    uintptr_t at = 4;
    __asm volatile("" : "+r"(at)); /* or the compiler takes it for a null pointer's neighbour */
    return *(const volatile uint32_t *)at == vectors[1];
}

void rom_if_asked(void)
{
    const uint32_t *vectors = (const uint32_t *)ROM_VECTORS;
    if (note.valid != NOTE_VALID || note.complement != ~NOTE_VALID)
        return;
    note.valid = 0;
    if (rom_came_first(vectors)) /* and is through: it has started us */
        return;
    /* Its interrupts (USB, CAN) take their vectors from address 0: VTOR is 0 after a reset. */
    RCC->APB2ENR |= RCC_APB2ENR_SYSCFG;
    (void)RCC->APB2ENR;
    SYSCFG_MEMRMP = SYSCFG_MEMRMP_MEM_MODE_0;
    __asm volatile("dsb\n\tisb" ::: "memory");
    __asm volatile("msr msp, %0\n\tbx %1" : : "r"(vectors[0]), "r"(vectors[1]) : "memory");
}
