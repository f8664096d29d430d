/* The bus: which peripheral answers at an address, whether its clock is on, and refusals.
 *
 * An access that nothing here models stops the run; it never reads as 0. Registers are read at any size
 * and written as words; only where silicon has byte lanes or a one-byte register (GPIO, USART_DR, NVIC)
 * are smaller writes modelled. */
#ifndef MATRIG_HIL_BUS_H
#define MATRIG_HIL_BUS_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

/* The access in progress, for refusals. */
struct hil_access {
    uint32_t address;
    unsigned size;
    bool write;
};

/* Build the board's table of which peripheral is where. */
void hil_bus_init(struct hil_board *board);
/* Is there a peripheral at this base address? */
bool hil_bus_has(uint32_t base);
/* Access by the core. */
uint32_t hil_bus_read(struct hil_board *board, uint32_t address, unsigned size);
void hil_bus_write(struct hil_board *board, uint32_t address, unsigned size, uint32_t value);

/* Called by a peripheral that is asked for something it does not model, with what it is: "TIM4:
 * centre-aligned mode". Returns 0, so that a read can return it; the run stops. */
uint32_t hil_bus_refuse(struct hil_board *board, const char *what);
/* The same for a register that is not modelled. */
uint32_t hil_bus_no_register(struct hil_board *board);

#endif
