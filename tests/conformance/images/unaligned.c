/* Accesses that must be aligned (ARM A3.2.1), and the trap for all others (PM0214 4.4.7,
 * UNALIGN_TRP). */
#include "frames.h"

static uint32_t two_words[4] __attribute__((aligned(8)));

int main(void)
{
    keep_faults();
    SHCSR = 1u << 18;
    isb();
    /* ARM A3.2.1 */
    FAULT("ldm", "", (uintptr_t)two_words + 2, "ldmia.w %1, {r4, r5}", 4, 6, 0x01000000u, 0);
    FAULT("ldrd", "", (uintptr_t)two_words + 2, "ldrd r4, r5, [%1]", 4, 6, 0x01000000u, 0);
    FAULT("ldrex", "", (uintptr_t)two_words + 2, "ldrex r4, [%1]", 4, 6, 0x01000000u, 0);
    while (!(USART1_SR & 0x40u)) /* TC: where the run ends here, all is said */
        ;
    CCR |= 1u << 3; /* UNALIGN_TRP */
    isb();
    FAULT("trap", "", (uintptr_t)two_words + 1, "ldr.w r5, [%1]", 4, 6, 0x01000000u, 0);
    CCR &= ~(1u << 3);
    isb();
    return 0;
}
