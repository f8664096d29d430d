/* For the bench: integer arithmetic in registers. */
#include "tests/hil/images/image.h"

int main(void)
{
    uint32_t a = 1, b = 2;
    for (;;) {
        for (unsigned i = 0; i < 1000; i++) {
            a = a * 1664525u + 1013904223u;
            b ^= a >> 7;
            b += a << 3;
        }
        results[0] = a ^ b;
    }
}
