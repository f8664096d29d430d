/* A floating-point instruction while CPACR keeps the unit off: UsageFault, NOCP (PM0214 4.4.14). */
#include "frames.h"

int main(void)
{
    keep_faults();
    SHCSR = 1u << 18;
    isb();
    FAULT("no_coprocessor", "", 0, ".short 0xee00, 0x0a10", 4, 6, 0x00080000u, 0); /* VMOV S0, R0 */
    return 0;
}
