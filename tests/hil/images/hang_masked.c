/* A firmware that hangs for good: an endless loop with interrupts masked that even feeds the
 * watchdog. */
#include "tests/hil/images/image.h"

__attribute__((noinline)) static void wait_for_ever(void)
{
    for (;;)
        REG(0x40003000u) = 0xaaaa;
}

int main(void)
{
    REG(0x40003000u) = 0xcccc; /* the watchdog runs */
    __asm__ volatile("cpsid i" ::: "memory");
    wait_for_ever();
    return 0;
}
