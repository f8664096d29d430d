/* Which registers and bits the emulated board models, in one table (registers.def): the bus refuses
 * by it, a reset takes its values, a test pokes every register of every peripheral and compares.
 *
 * A write that changes a reserved bit, a bit that is not modelled or a read-only register ends the
 * run with a message. Silicon ignores such writes; a program that makes them is wrong or relies on
 * something that is not here. */
#ifndef MATRIG_HIL_REGISTERS_H
#define MATRIG_HIL_REGISTERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct hil_register {
    uint16_t offset; /* of the first */
    uint8_t count;   /* so many alike, */
    uint8_t stride;  /* so many bytes apart */
    char access;     /* 'b' both, 'r' read-only, 'w' write-only */
    bool loose;      /* reserved bits may be written with anything: flags cleared by 0, keys */
    const char *name;
    uint32_t reset;
    uint32_t plain;   /* bits that read back as written */
    uint32_t action;  /* bits whose writing does something or clears a flag */
    uint32_t status;  /* bits that hardware sets; what is written there does not matter */
    uint32_t partly;  /* bits of which some values, or in some states, are modelled: see `what` */
    uint32_t refused; /* bits that silicon has and the board does not model */
    const char *what; /* about partly and refused */
};

struct hil_register_set {
    const char *peripheral;
    uint32_t base;
    const struct hil_register *all; /* the one behind the last has no name */
};

/* The table of a peripheral by its base address; NULL: it has none. */
const struct hil_register_set *hil_registers_of(uint32_t base);
const struct hil_register_set *hil_registers_all(size_t *count);
/* NULL: not modelled. */
const struct hil_register *hil_register_at(const struct hil_register_set *set, uint32_t offset);
/* Why silicon would not do what this write asks, as text in static storage; NULL: it may go on. */
const char *hil_register_objection(const struct hil_register *r, uint32_t value);
/* What `count` registers from `offset` on are after a reset; where there is none: 0. */
void hil_registers_reset(uint32_t base, uint32_t offset, uint32_t *word, size_t count);
#endif
