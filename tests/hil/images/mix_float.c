/* For the bench: single-precision arithmetic. */
#include "tests/hil/images/image.h"

static volatile float out;

int main(void)
{
    enable_fpu();
    float a = 1.5f, b = 0.25f;
    for (;;) {
        for (unsigned i = 0; i < 1000; i++) {
            a = a * 0.999f + b;
            b = b - a * 0.001f;
        }
        out = a + b;
    }
}
