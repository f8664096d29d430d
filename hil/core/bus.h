/* The bus: which peripheral answers at an address, whether its clock is on, and refusals.
 *
 * An access that nothing here models stops the run; it never reads as 0. Registers are read at any
 * size and written as words; only where silicon has byte lanes or a one-byte register (GPIO,
 * USART_DR, NVIC) are smaller writes modelled. */
#ifndef MATRIG_HIL_BUS_H
#define MATRIG_HIL_BUS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct hil_core;
struct hil_register;
struct hil_register_set;

/* The access in progress, for refusals. */
struct hil_access {
    uint32_t address;
    unsigned size;
    bool write;
};

/* A peripheral as the bus knows it; it has a kilobyte of addresses. `device` is handed to each
 * call, with `unit`. The bus refuses by registers.def before it calls: `read` and `write` see
 * registers of that table alone, and no value that the table refuses. */
struct hil_peripheral {
    uint32_t base;
    const char *name;
    unsigned unit; /* of several alike behind one device */
    uint32_t (*read)(void *device, unsigned unit, uint32_t offset);
    void (*write)(void *device, unsigned unit, uint32_t offset, uint32_t value);
    bool narrow; /* byte and halfword writes are modelled */
    /* What a narrow write leaves in the rest of the word: the register's own bits. NULL: nothing,
     * where a written 0 means nothing or the register is no wider. */
    uint32_t (*rest)(void *device, unsigned unit, uint32_t offset);
    void *device;
    const uint32_t *clocks; /* its clock is on while one of these bits is; NULL: always */
    uint32_t clock_mask;
};

/* Memory of the chip that no store changes, from 0x1fff7000: unique id, option bytes and the
 * like. */
struct hil_system_memory {
    uint32_t (*read)(void *device, uint32_t address); /* the word at `address` & ~3 */
    void *device;
};

/* Clocks that were switched on a moment ago. */
struct hil_fresh_clocks {
    const uint32_t *clocks; /* NULL: none; else as in struct hil_peripheral */
    uint32_t mask;
    void (*accessed)(void *who); /* the first access to one that has such a clock */
    void *who;
};

#define HIL_PERIPHERALS_MAX 64u
#define HIL_REGISTER_WORDS  256u /* a kilobyte */
#define HIL_BUS_PAGES       512u /* kilobytes from 0x40000000 */

struct hil_bus {
    struct hil_access access;
    uint32_t issued; /* the address that the core named: a bit-band alias, or that of `access` */
    uint64_t issues; /* how many the core has named */
    struct hil_system_memory system_memory;
    struct hil_fresh_clocks fresh;
    unsigned count;
    struct hil_peripheral peripheral[HIL_PERIPHERALS_MAX];
    uint8_t peripheral_of[HIL_BUS_PAGES];
    /* of each */
    const struct hil_register_set *registers_of[HIL_PERIPHERALS_MAX];
    /* by word of a peripheral; NULL: not yet looked for, or none */
    const struct hil_register *register_at[HIL_PERIPHERALS_MAX][HIL_REGISTER_WORDS];
};

#define HIL_NO_PERIPHERAL 0xffu

/* The peripheral at an address; NULL: none. */
static inline const struct hil_peripheral *hil_peripheral_at(const struct hil_bus *bus,
                                                             uint32_t address)
{
    uint32_t page = (address - 0x40000000u) >> 10;
    uint8_t i = page < HIL_BUS_PAGES ? bus->peripheral_of[page] : HIL_NO_PERIPHERAL;
    return i == HIL_NO_PERIPHERAL ? NULL : &bus->peripheral[i];
}

/* ---- call ---- */

/* A wire from one part to another: who is told, and by which call. The part at the near end knows
 * nothing of the far end, so that a peripheral does not know the board it sits on. */

struct hil_call {
    void (*call)(void *who); /* NULL: nobody is there */
    void *who;
};

static inline void hil_call(const struct hil_call *wire)
{
    if (wire->call)
        wire->call(wire->who);
}

/* ---- words ---- */

/* Registers of a peripheral by name and by offset: word[offset / 4] is the register that is named
 * at that place. A register that keeps nothing, and a place without a register, has a name too and
 * stays 0. */

#define HIL_WORDS(word, ...)                                          \
    union {                                                           \
        struct {                                                      \
            uint32_t __VA_ARGS__;                                     \
        };                                                            \
        uint32_t word[sizeof(struct { uint32_t __VA_ARGS__; }) / 4u]; \
    }

/* ---- bus ---- */

/* Nobody answers at any address. */
void hil_bus_create(struct hil_core *core);
/* A peripheral comes onto the bus, below 0x40080000. Aborts beyond HIL_PERIPHERALS_MAX, and when
 * registers.def lacks it. */
void hil_bus_attach(struct hil_core *core, const struct hil_peripheral *peripheral);
/* Access by the core. */
uint32_t hil_bus_read(struct hil_core *core, uint32_t address, unsigned size);
/* Of the word that the access in progress reads, the bits that the core is given. */
uint32_t hil_bus_bits_read(const struct hil_core *core);
void hil_bus_write(struct hil_core *core, uint32_t address, unsigned size, uint32_t value);

#endif
