#include "hil/periph/serial_line.h"

uint32_t hil_frame_levels(uint8_t byte, enum hil_parity parity)
{
    uint32_t bits = (uint32_t)byte << 1;
    bool odd_ones = (__builtin_popcount(byte) & 1) != 0;
    if (parity == HIL_PARITY_NONE)
        return bits | 1u << 9;
    return bits | (uint32_t)(odd_ones != (parity == HIL_PARITY_ODD)) << 9 | 1u << 10;
}

static bool level_at(uint64_t levels, unsigned bits, double bit_ps, double t_ps)
{
    double n = t_ps / bit_ps;
    return n >= bits || (levels >> (unsigned)n & 1u);
}

unsigned hil_serial_hear(uint8_t byte, int follower, const struct hil_serial_format *sender,
                         const struct hil_serial_format *receiver,
                         struct hil_heard_byte heard[HIL_HEARD_MAX])
{
    unsigned bits = hil_frame_bits(sender->parity),
             data_bits = hil_frame_bits(receiver->parity) - 2u;
    double end_ps = bits * sender->bit_ps, t_ps = 0.0; /* t: begin of a start bit */
    unsigned count = 0;
    uint64_t after = follower < 0 ? UINT64_MAX
                                  : hil_frame_levels((uint8_t)follower, sender->parity);
    uint64_t levels = hil_frame_levels(byte, sender->parity) | after << bits;
    while (t_ps < end_ps && count < HIL_HEARD_MAX) {
        uint32_t sampled = 0;
        for (unsigned i = 0; i <= data_bits; i++) {
            if (level_at(levels, 2 * bits, sender->bit_ps, t_ps + (i + 1.5) * receiver->bit_ps))
                sampled |= 1u << i;
        }
        struct hil_heard_byte *h = &heard[count++];
        h->value = (uint8_t)sampled;
        h->parity_bit = data_bits == 9 && (sampled >> 8 & 1u);
        h->framing_error = !(sampled >> data_bits & 1u);
        h->parity_error = data_bits == 9 &&
                          h->parity_bit != (hil_frame_levels(h->value, receiver->parity) >> 9 & 1u);
        /* from the middle of the stop bit, the next fall of the line */
        t_ps += (data_bits + 1.5) * receiver->bit_ps;
        unsigned at = t_ps < end_ps ? (unsigned)(t_ps / sender->bit_ps) : bits;
        while (at < bits && !((levels >> at & 1u) && at + 1 < bits && !(levels >> (at + 1) & 1u)))
            at++;
        t_ps = at < bits ? (at + 1) * sender->bit_ps : end_ps;
    }
    return count;
}
