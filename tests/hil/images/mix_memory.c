/* For the bench: loads and stores of RAM. */
#include "tests/hil/images/image.h"

static volatile uint32_t from[256], to[256];

int main(void)
{
    for (;;)
        for (unsigned i = 0; i < 256; i++)
            to[i] = from[i] + i;
}
