/* Precise bus faults (ARM B1.5.14). */
#include "frames.h"

static void bus_faults(void)
{
    keep_faults();
    SHCSR = 1u << 17; /* BusFault enabled */
    isb();
    /* 0x30000000 is in the SRAM region and nothing is there on this chip (RM0090 2.3). */
    FAULT("bus_read", "", 0x30000000, "ldr.w r5, [%1]", 4, 5, 0x00008200u, 0);
    expect("bus_read_bfar", BFAR, 0x30000000u);
    SHCSR = 0;
    isb();
    FAULT("escalated_bus_read", "", 0x30000000, "ldr.w r5, [%1]", 4, 3, 0x00008200u, 0x40000000u);
}

int main(void)
{
    bus_faults();
    return 0;
}
