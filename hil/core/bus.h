/* The bus: which peripheral answers at an address, whether its clock is on, and refusals.
 *
 * An access that nothing here models stops the run; it never reads as 0. Registers are read at any
 * size and written as words; only where hardware has byte lanes or a one-byte register (GPIO,
 * USART_DR, NVIC) are smaller writes modelled. */
#ifndef MATRIG_HIL_BUS_H
#define MATRIG_HIL_BUS_H

#include <stdint.h>

struct hil_core;
struct hil_peripheral;

/* A peripheral comes onto the bus, below 0x40080000. Aborts beyond HIL_PERIPHERALS_MAX, and when
 * registers.def lacks it. */
void hil_bus_attach(struct hil_core *core, const struct hil_peripheral *peripheral);
/* Access by the core. */
uint32_t hil_bus_read(struct hil_core *core, uint32_t address, unsigned size);
/* Of the word that the access in progress reads, the bits that the core is given. */
uint32_t hil_bus_bits_read(const struct hil_core *core);
void hil_bus_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

#endif
