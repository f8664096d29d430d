/* The bus finds the peripheral at an address, checks that its clock is on, and refuses accesses
 * that are not modelled.
 *
 * An access that is not modelled stops the run; it never reads as 0. Registers can be read at any
 * size and written as words. Smaller writes are modelled only where hardware has byte lanes or a
 * one-byte register (GPIO, USART_DR, NVIC). */
#ifndef MATRIG_HIL_BUS_H
#define MATRIG_HIL_BUS_H

#include <stdint.h>

struct hil_core;
struct hil_peripheral;

/* Adds a peripheral below 0x40080000 to the bus. Aborts if there are more than HIL_PERIPHERALS_MAX
 * or if registers.def does not list the peripheral. */
void hil_bus_attach(struct hil_core *core, const struct hil_peripheral *peripheral);
/* Read or write a register as the core does. A refused access stops the run, and the read returns
 * 0. */
uint32_t hil_bus_read(struct hil_core *core, uint32_t address, unsigned size);
/* Returns a mask of the bits that the core receives from the register being read. */
uint32_t hil_bus_read_mask(const struct hil_core *core);
void hil_bus_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

#endif
