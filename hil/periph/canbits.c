#include "hil/periph/canbits.h"

#define CRC15_POLYNOMIAL_BITS 0x4599u /* x15 + x14 + x10 + x8 + x7 + x4 + x3 + 1 */

struct stream {
    struct hil_can_bits bits;
    unsigned last_level; /* level of the last bit sent */
    unsigned equal_bits; /* number of equal bits in a row, including the last one */
};

static void send_bit(struct stream *s, unsigned bit)
{
    s->equal_bits = s->bits.length && bit == s->last_level ? s->equal_bits + 1u : 1u;
    s->last_level = bit;
    s->bits.length++;
    if (s->equal_bits == 5) { /* a stuff bit of the opposite level follows and begins a new run */
        s->last_level = !bit;
        s->equal_bits = 1;
        s->bits.length++;
        s->bits.stuff_bits++;
    }
}

static void send_field(struct stream *s, uint32_t value, unsigned width)
{
    while (width--) {
        unsigned bit = value >> width & 1u;
        unsigned next = bit ^ (unsigned)(s->bits.crc >> 14 & 1u);
        s->bits.crc = (uint16_t)((unsigned)s->bits.crc << 1 & 0x7fffu);
        if (next)
            s->bits.crc ^= CRC15_POLYNOMIAL_BITS;
        send_bit(s, bit);
    }
}

struct hil_can_bits hil_can_frame_bits(const struct hil_can_frame *frame)
{
    struct stream s = {0};
    unsigned length = frame->length > 8 ? 8 : frame->length;
    send_field(&s, 0, 1); /* start of frame */
    if (frame->is_extended) {
        send_field(&s, frame->id >> 18 & 0x7ffu, 11);
        send_field(&s, 3, 2); /* SRR, IDE */
        send_field(&s, frame->id & 0x3ffffu, 18);
        send_field(&s, frame->is_remote, 1);
        send_field(&s, 0, 2); /* r1, r0 */
    } else {
        send_field(&s, frame->id & 0x7ffu, 11);
        send_field(&s, frame->is_remote, 1);
        send_field(&s, 0, 2); /* IDE, r0 */
    }
    send_field(&s, frame->length & 15u, 4);
    for (unsigned i = 0; !frame->is_remote && i < length; i++)
        send_field(&s, frame->data[i], 8);
    uint16_t crc = s.bits.crc;
    send_field(&s, crc, 15);
    s.bits.crc = crc;
    s.bits.length += HIL_CAN_TAIL_BITS;
    return s.bits;
}

uint32_t hil_can_arbitration_value(const struct hil_can_frame *frame)
{
    if (!frame->is_extended)
        return (frame->id & 0x7ffu) << 21 | (uint32_t)frame->is_remote << 20;
    return (frame->id >> 18 & 0x7ffu) << 21 | 3u << 19 | (frame->id & 0x3ffffu) << 1 |
           frame->is_remote;
}
