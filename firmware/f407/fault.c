/* A processor fault stores what it was and resets; the next start counts it. A bus fault during a probe says instead that
 * nothing answers at the address probed. PM0214 2.4.4. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

#define NOTE_VALID 0x4641554cu /* "FAUL" */

/* Not cleared at start, so that it survives the reset. */
static struct {
    uint32_t valid;
    uint32_t cfsr;
    uint32_t hfsr;
    uint32_t crystal_stopped;
} note __attribute__((section(".noinit")));

void processor_fault(void);
void processor_fault(void)
{
    note.valid = NOTE_VALID;
    note.cfsr = SCB_CFSR;
    note.hfsr = SCB_HFSR;
    note.crystal_stopped = RCC->CIR & RCC_CIR_CSSF; /* NMI of the clock security comes here too */
    SCB_AIRCR = 0x05fa0004u; /* system reset request */
    for (;;) {
    }
}

static volatile bool probing, probe_failed;

void bus_fault_at(uint32_t *frame);
void bus_fault_at(uint32_t *frame)
{
    if (!probing)
        processor_fault();
    probe_failed = true;
    SCB_CFSR = 0xff00u;  /* write 1 to clear the bus fault bits */
    frame[6] += 2;       /* go on behind the probe's two-byte load */
}

/* Frames lie on the main stack: nothing here uses the process stack. */
__attribute__((naked)) void bus_fault(void);
__attribute__((naked)) void bus_fault(void)
{
    __asm volatile("mrs r0, msp\n\tb bus_fault_at");
}

bool probe_word(const volatile uint32_t *address, uint32_t *value)
{
    uint32_t word = 0;
    SCB_SHCSR |= SCB_SHCSR_BUSFAULTENA;
    probing = true;
    probe_failed = false;
    __asm volatile("ldr.n %0, [%1]\n\tdsb" : "=l"(word) : "l"(address) : "memory");
    probing = false;
    *value = probe_failed ? 0 : word;
    return !probe_failed;
}

bool answers(reg32 *reg, uint32_t probe)
{
    *reg = probe;
    return *reg == probe;
}

void fault_recall(void)
{
    /* Detail: which fault, from the status: 1 memory, 2 bus, 3 usage, 4 other, 5 the crystal stopped. */
    if (note.valid == NOTE_VALID)
        health_count(MR_FAULT_HARD_FAULT, note.crystal_stopped  ? 5
                                          : note.cfsr & 0xffu   ? 1
                                          : note.cfsr & 0xff00u ? 2
                                          : note.cfsr >> 16     ? 3
                                                                : 4);
    note.valid = 0;
}
