/* Stores to a pin at known distances, in instructions, on the internal oscillator (62.5 ns a
 * cycle): PB12 high for 5, 1, 4 and 30 of them. Among them a conditional store that is not made, in
 * a block that stores to the same register before and after. */
#include "tests/hil/images/image.h"

#define GPIOB_MODER   0x40020400u
#define GPIOB_OSPEEDR 0x40020408u
#define GPIOB_BSRR    0x40020418u
#define HIGH          (1u << 12)
#define LOW           (1u << 28)

int main(void)
{
    REG(0x40023830u) |= 2u; /* clock of port B */
    (void)REG(0x40023830u);
    REG(GPIOB_BSRR) = LOW;
    REG(GPIOB_MODER) = (REG(GPIOB_MODER) & ~(3u << 24)) | 1u << 24;
    REG(GPIOB_OSPEEDR) |= 3u << 24;
    __asm__ volatile("str %[high], [%[bsrr]]\n"
                     "nop\n nop\n nop\n nop\n"
                     "str %[low], [%[bsrr]]\n" /* 5 after */
                     "str %[high], [%[bsrr]]\n"
                     "str %[low], [%[bsrr]]\n" /* 1 */
                     "str %[high], [%[bsrr]]\n"
                     "cmp %[bsrr], #0\n"
                     "it eq\n"
                     "streq %[low], [%[bsrr]]\n"
                     "str %[low], [%[bsrr]]\n" /* 4 */
                     "str %[high], [%[bsrr]]\n"
                     "movs r3, #9\n"
                     "1: subs r3, #1\n nop\n bne 1b\n"
                     "nop\n"
                     "str %[low], [%[bsrr]]\n" /* 1 + 1 + 9 * 3 + 1 = 30, over ten blocks */
                     :
                     : [high] "l"(HIGH), [low] "l"(LOW), [bsrr] "l"(GPIOB_BSRR)
                     : "r3", "cc", "memory");
    results[0] = 1;
    return 0;
}
