/* For the bench: nothing but interrupts, one after the other. */
#include "tests/hil/images/image.h"

void irq6(void)
{
    results[0]++;
}

int main(void)
{
    enable_irq(6);
    for (;;)
        pend_irq(6);
}
