/* What the receiver at one end of a serial line makes of a byte that the other end sends, when the
 * two do not agree on rate or parity: the frame as a waveform, sampled as a receiver samples it. */
#ifndef MATRIG_HIL_SERIAL_LINE_H
#define MATRIG_HIL_SERIAL_LINE_H

#include <stdbool.h>
#include <stdint.h>

enum hil_parity { HIL_PARITY_NONE, HIL_PARITY_EVEN, HIL_PARITY_ODD };

/* Frames of eight data bits, parity or none, one stop bit. */
struct hil_serial_format {
    double bit_ps;
    enum hil_parity parity;
};

struct hil_heard_byte {
    uint8_t value;
    bool parity_bit; /* as sampled */
    bool parity_error;
    bool framing_error;
};

#define HIL_HEARD_MAX 16u

static inline unsigned hil_frame_bits(enum hil_parity parity)
{
    return parity == HIL_PARITY_NONE ? 10u : 11u;
}

/* Bits of the frame of a byte as they go over the line, first in bit 0: start, data, parity,
 * stop. */
uint32_t hil_frame_levels(uint8_t byte, enum hil_parity parity);

/* The bytes heard, in order, of one that is sent; `follower` is the byte right behind it, or -1
 * when the line is idle then. The receiver is taken to be ready at the begin of the byte. Returns
 * how many (at most HIL_HEARD_MAX: a receiver more than sixteen times as fast misses the rest). */
unsigned hil_serial_hear(uint8_t byte, int follower, const struct hil_serial_format *sender,
                         const struct hil_serial_format *receiver,
                         struct hil_heard_byte heard[HIL_HEARD_MAX]);

#endif
