/* Connections of a peripheral: its neighbours within the chip, and the line between the pins of a
 * link and its other end. The line carries frames and bytes, with the faults that the rig injects
 * (hil/rig/faults.h). */
#ifndef MATRIG_HIL_WIRE_H
#define MATRIG_HIL_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct hil_can_frame;

struct hil_core;
struct hil_dma_device;
struct hil_gpio_device;
struct hil_options;
struct hil_rcc_device;
struct hil_rules_device;

/* Pointers from each peripheral to its neighbours within the chip; mcu.c sets them. */
#define HIL_NEIGHBOUR_POINTERS    \
    struct hil_core *core;        \
    struct hil_options *options;  \
    struct hil_rcc_device *rcc;   \
    struct hil_dma_device *dma;   \
    struct hil_gpio_device *gpio; \
    struct hil_rules_device *rules

/* Declares the two calls of a peripheral for the bus (struct hil_peripheral). */
#define HIL_DECLARE_BUS_CALLS(name)                                           \
    uint32_t hil_##name##_read(void *device, unsigned unit, uint32_t offset); \
    void hil_##name##_write(void *device, unsigned unit, uint32_t offset, uint32_t value);

enum hil_parity { HIL_PARITY_NONE, HIL_PARITY_EVEN, HIL_PARITY_ODD };
enum hil_line { HIL_CAN_OUT, HIL_CAN_IN, HIL_SERIAL_OUT, HIL_SERIAL_IN, HIL_LINE_COUNT };
enum hil_line_fault {
    HIL_LINE_DROP,
    HIL_LINE_REPEAT,
    HIL_LINE_CORRUPT,
    HIL_LINE_DELAY,
    HIL_LINE_FRAMING,
    HIL_LINE_NOISE,
    HIL_LINE_FAULT_COUNT
};

struct hil_line_calls {
    void *context;
    /* Returns true if the next unit (frame or byte) on this line has this fault, which it then
     * counts down and reports. `what` names the unit. */
    bool (*has_fault)(void *context, enum hil_line line, enum hil_line_fault kind, const char *what,
                      uint32_t number);
    /* Delay of the last unit with the fault HIL_LINE_DELAY. */
    uint64_t (*delay_ps)(const void *context, enum hil_line line);
    /* Random number, 0 <= value < bound, from the sequence of the faults. */
    uint32_t (*random)(void *context, uint32_t bound);
    /* Called with data that the board has sent; their last bit ended at t_ps. The function may
     * change the bytes. */
    void (*can_out)(void *context, uint64_t t_ps, const struct hil_can_frame *frame);
    void (*serial_out)(void *context, uint64_t t_ps, uint8_t *bytes, size_t n);
};

#endif
