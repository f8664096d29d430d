/* Copies a function to SRAM, runs it there, changes it, runs it again. */
#include "tests/hil/images/image.h"

int main(void)
{
    static uint16_t code[8];
    uint32_t (*run)(uint32_t) = (uint32_t(*)(uint32_t))((uintptr_t)code | 1u);
    code[0] = 0x3005; /* adds r0, #5 */
    code[1] = 0x4770; /* bx lr */
    __asm__ volatile("dsb\n isb" ::: "memory");
    results[1] = run(10);
    *(volatile uint16_t *)code = 0x3007; /* adds r0, #7 */
    __asm__ volatile("dsb\n isb" ::: "memory");
    results[2] = run(10);
    results[0] = 1;
    return 0;
}
