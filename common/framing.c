#include "common/framing.h"

#include <string.h>

#include "common/crc32.h"
#include "common/wire.h"

size_t mr_frame_encode(uint16_t seq, uint16_t type, const uint8_t *payload, size_t length,
                       uint8_t out[MR_FRAME_BYTES_MAX])
{
    uint8_t content[MR_FRAME_PAYLOAD_BYTES_MAX + MR_FRAME_OVERHEAD_BYTES];
    uint8_t *p = content;
    if (length > MR_FRAME_PAYLOAD_BYTES_MAX)
        return 0;
    p = mr_put_u16(p, seq);
    p = mr_put_u16(p, type);
    if (length > 0)
        memcpy(p, payload, length);
    p += length;
    p = mr_put_u32(p, mr_crc32(0, content, (size_t)(p - content)));

    uint8_t *run_length = out;
    uint8_t *to = out + 1;
    for (const uint8_t *from = content; from < p; from++) {
        if (*from == 0) {
            *run_length = (uint8_t)(to - run_length);
            run_length = to++;
        } else {
            *to++ = *from;
        }
    }
    *run_length = (uint8_t)(to - run_length);
    *to++ = 0;
    return (size_t)(to - out);
}

void mr_deframer_init(struct mr_deframer *deframer)
{
    deframer->length = 0;
    deframer->discarded_bytes = 0;
}

/* Decodes COBS in place. Returns the decoded length; 0 if the data is not valid COBS. */
static size_t decode_cobs(uint8_t *bytes, size_t length)
{
    size_t to = 0;
    for (size_t from = 0; from < length;) {
        size_t run = bytes[from++];
        if (run == 0 || from + run - 1 > length)
            return 0;
        memmove(bytes + to, bytes + from, run - 1);
        to += run - 1;
        from += run - 1;
        if (run < 255 && from < length)
            bytes[to++] = 0;
    }
    return to;
}

enum mr_status mr_deframer_push(struct mr_deframer *deframer, uint8_t byte, struct mr_frame *frame)
{
    if (byte != 0) {
        if (deframer->length < sizeof deframer->bytes)
            deframer->bytes[deframer->length++] = byte;
        else
            deframer->discarded_bytes = 1;
        return MR_TOO_FEW;
    }

    size_t raw_length = deframer->length;
    uint8_t overflow = deframer->discarded_bytes;
    mr_deframer_init(deframer);
    if (raw_length == 0)
        return MR_TOO_FEW;
    if (overflow)
        return MR_TOO_LONG;
    size_t length = decode_cobs(deframer->bytes, raw_length);
    if (length == 0)
        return MR_MALFORMED;
    if (length < MR_FRAME_OVERHEAD_BYTES)
        return MR_TRUNCATED;
    const uint8_t *p = deframer->bytes + length - 4;
    if (mr_get_u32(&p) != mr_crc32(0, deframer->bytes, length - 4))
        return MR_CRC;
    p = deframer->bytes;
    frame->seq = mr_get_u16(&p);
    frame->type = mr_get_u16(&p);
    frame->payload = p;
    frame->length = length - MR_FRAME_OVERHEAD_BYTES;
    return MR_OK;
}
