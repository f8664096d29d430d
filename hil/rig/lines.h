/* The board's two links, from its pins to the host's end, and what befalls frames and bytes on the
 * way. */
#ifndef MATRIG_HIL_LINES_H
#define MATRIG_HIL_LINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "hil/core/state.h"
#include "hil/periph/canbits.h"
#include "hil/periph/wire.h"

struct hil_core;
struct hil_options;

#define HIL_FAULT_HELD  16u    /* frames on their way late; more than that are not delayed */
#define HIL_FAULT_BYTES 16384u /* bytes on their way late; likewise */
#define HIL_FAULT_ALL   UINT32_MAX

struct hil_callbacks {
    void *ctx;
    /* A frame of the board whose last bit (end of frame) ended at t_ps. */
    void (*on_can_frame)(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame);
    /* n bytes of the board; the stop bit of the last one ended at t_ps. */
    void (*on_serial_bytes)(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n);
};

struct hil_line_effect {
    uint32_t left; /* HIL_FAULT_ALL: no end */
    double probability;
    uint64_t duration_ps;
    unsigned file_line;
};

struct hil_lines {
    uint64_t random;
    struct hil_line_effect effect[HIL_LINES][HIL_LINE_FAULTS];
    uint32_t held_count; /* CAN frames on their way to the host */
    uint64_t held_ps[HIL_FAULT_HELD];
    uint8_t held_frame[HIL_FAULT_HELD][24];
    uint32_t bytes_count; /* serial bytes likewise */
    uint64_t bytes_ps;
    uint8_t bytes[HIL_FAULT_BYTES];
};

struct hil_lines_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_lines *state;
    struct hil_callbacks callbacks;     /* the host's end */
    struct hil_callbacks pin_callbacks; /* on the board's pins: before what befalls the links */
    struct hil_call frame_sent;         /* a CAN frame has left the board */
};

/* Nothing befalls them. `seed` of the probabilities and of corrupted bits. */
void hil_lines_create(struct hil_lines_device *dev, uint64_t seed);
void hil_lines_seed(struct hil_lines_device *dev, uint64_t seed);
/* The links as the peripherals see them. */
struct hil_wire hil_lines_wire(struct hil_lines_device *dev);
/* From now on. */
void hil_lines_order(struct hil_lines_device *dev, enum hil_line line, enum hil_line_fault kind,
                     const struct hil_line_effect *effect);

/* Reports a fault that fired, or a frame or byte that suffered one: a line with its virtual time to
 * the log and to the trace, and a count. `log` NULL: nobody reads it. `file_line` of the fault file
 * that ordered it; 0: none. */
__attribute__((format(printf, 4, 5))) void hil_fault_tell(struct hil_core *core, FILE *log,
                                                          unsigned file_line, const char *format,
                                                          ...);

#endif
