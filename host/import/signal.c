#include "host/import/signal.h"

#include <math.h>
#include <string.h>

/* Bit n of the signal from its lowest: its place in the frame. Big-endian signals begin at their
 * highest bit and go on at bit 7 of the next byte. */
static unsigned place_of(const struct import_signal *signal, unsigned n)
{
    if (!signal->big_endian)
        return signal->start_bit + n;
    unsigned from_top = signal->bits - 1 - n;
    unsigned in_order = (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + from_top;
    return (in_order / 8) * 8 + (7 - in_order % 8);
}

bool signal_fits(const struct import_signal *signal, unsigned length)
{
    if (signal->bits == 0 || signal->bits > 64 || signal->start_bit > 63 ||
        (signal->is_float && signal->bits != 32 && signal->bits != 64))
        return false;
    return signal->big_endian
             ? (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + signal->bits <=
                   8 * length
             : signal->start_bit + signal->bits <= 8 * length;
}

bool signal_value(const struct import_signal *signal, const struct link_frame *frame, double *value)
{
    uint64_t raw = 0;
    if (frame->id != signal->id || !signal_fits(signal, frame->length))
        return false;
    for (unsigned n = 0; n < signal->bits; n++) {
        unsigned bit = place_of(signal, n);
        raw |= (uint64_t)(frame->data[bit / 8] >> (bit % 8) & 1u) << n;
    }
    if (signal->is_float && signal->bits == 32) {
        float single;
        uint32_t low = (uint32_t)raw;
        memcpy(&single, &low, sizeof single);
        *value = (double)single;
    } else if (signal->is_float) {
        memcpy(value, &raw, sizeof *value);
    } else if (signal->is_signed && raw >> (signal->bits - 1) & 1u) {
        if (signal->bits < 64)
            raw |= ~0ull << signal->bits;
        *value = (double)(int64_t)raw;
    } else {
        *value = (double)raw;
    }
    return isfinite(*value);
}
