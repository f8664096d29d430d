/* For the bench: peripheral registers, read and written. */
#include "tests/hil/images/image.h"

int main(void)
{
    REG(0x40023830u) |= 1u;
    (void)REG(0x40023830u);
    for (;;)
        REG(0x40020014u) = REG(0x40020014u) ^ 2u;
}
