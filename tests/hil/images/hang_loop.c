/* A firmware whose loop hangs while its interrupts go on: it sleeps ten times, then waits for a
 * flag that nobody sets. */
#include "tests/hil/images/image.h"

static volatile uint32_t flag;

void systick(void)
{
    results[0]++;
}

__attribute__((noinline)) static void wait_for_flag(void)
{
    while (!flag)
        results[1]++;
}

int main(void)
{
    REG(0xe000e014u) = 16000 - 1;
    REG(0xe000e018u) = 0;
    REG(0xe000e010u) = 7;
    for (unsigned i = 0; i < 10; i++)
        __asm__ volatile("wfi");
    wait_for_flag();
    return 0;
}
