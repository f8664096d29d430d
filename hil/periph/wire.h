/* What a peripheral is wired to: its neighbours within the chip, and the line between a link's pins
 * and its other end. The line accepts frames and bytes and decides their faults. The peripheral
 * asks; the rig answers (hil/rig/faults.h). */
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

/* What each peripheral finds beside it within the chip; mcu.c sets them. */
#define HIL_NEIGHBOURS            \
    struct hil_core *core;        \
    struct hil_options *options;  \
    struct hil_rcc_device *rcc;   \
    struct hil_dma_device *dma;   \
    struct hil_gpio_device *gpio; \
    struct hil_rules_device *rules

/* The two calls of a peripheral for the bus: struct hil_peripheral. */
#define HIL_ON_BUS(name)                                                      \
    uint32_t hil_##name##_read(void *device, unsigned unit, uint32_t offset); \
    void hil_##name##_write(void *device, unsigned unit, uint32_t offset, uint32_t value);

enum hil_parity { HIL_PARITY_NONE, HIL_PARITY_EVEN, HIL_PARITY_ODD };
enum hil_line { HIL_CAN_OUT, HIL_CAN_IN, HIL_SERIAL_OUT, HIL_SERIAL_IN, HIL_LINES };
enum hil_line_fault {
    HIL_DROP,
    HIL_REPEAT,
    HIL_CORRUPT,
    HIL_DELAY,
    HIL_FRAMING,
    HIL_NOISE,
    HIL_LINE_FAULTS
};

struct hil_wire {
    void *who;
    /* Does the next unit on this line have this fault? Counts it down and reports it; `what` names
     * the unit. */
    bool (*suffers)(void *who, enum hil_line line, enum hil_line_fault kind, const char *what,
                    uint32_t number);
    /* Time by which the last unit that suffered HIL_DELAY is to be late. */
    uint64_t (*delay_ps)(const void *who, enum hil_line line);
    /* 0 <= value < bound, from the faults' own sequence. */
    uint32_t (*random)(void *who, uint32_t bound);
    /* What the board sent; the last bit ended at t_ps. The bytes may be changed. */
    void (*can_out)(void *who, uint64_t t_ps, const struct hil_can_frame *frame);
    void (*serial_out)(void *who, uint64_t t_ps, uint8_t *bytes, size_t n);
};

#endif
