/* Serial framing: a frame is  COBS( seq u16 | type u16 | payload | CRC-32 u32 )  0x00.
 *
 *     seq      counts frames of one sender, wraps; a jump says how many were lost
 *     type     MR_ID_... of the catalogue (its low 11 bits), or MR_ID_BLOCK, MR_ID_BOX_PART
 *     payload  0 to MR_FRAME_PAYLOAD_MAX bytes
 *     CRC-32   of everything before it (common/crc32.h)
 *
 * COBS (Cheshire and Baker, 1999): every run of up to 254 non-zero bytes is preceded by its length
 * plus one, and each zero is replaced by the next run's length, so 0x00 occurs only at the end of a
 * frame. A receiver that joins late or loses bytes is in step again after the next 0x00. */
#ifndef MATRIG_COMMON_FRAMING_H
#define MATRIG_COMMON_FRAMING_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

#define MR_FRAME_PAYLOAD_MAX 136u
#define MR_FRAME_OVERHEAD    8u /* seq, type, CRC */
/* One COBS length byte (the content never reaches 254 bytes) and the final zero. */
#define MR_FRAME_MAX         (MR_FRAME_PAYLOAD_MAX + MR_FRAME_OVERHEAD + 2u)
_Static_assert(MR_FRAME_PAYLOAD_MAX + MR_FRAME_OVERHEAD < 254u, "a frame must fit one COBS run");

/* Encode one frame, final zero included. Returns its length; 0 when `length` exceeds
 * MR_FRAME_PAYLOAD_MAX. */
size_t mr_frame_encode(uint16_t seq, uint16_t type, const uint8_t *payload, size_t length,
                       uint8_t out[MR_FRAME_MAX]);

struct mr_frame {
    uint16_t seq;
    uint16_t type;
    size_t length;          /* of payload, bytes */
    const uint8_t *payload; /* inside the deframer; valid until its next push */
};

struct mr_deframer {
    uint8_t bytes[MR_FRAME_MAX];
    size_t length;
    uint8_t overflow; /* bytes thrown away since the last zero */
};

/* Start (or restart) a deframer. */
void mr_deframer_init(struct mr_deframer *deframer);

/* Give one received byte. MR_OK: `*frame` holds a complete frame. MR_TOO_FEW: more bytes needed
 * (empty frames count as that too). MR_MALFORMED, MR_CRC, MR_TOO_LONG, MR_TRUNCATED: what ended
 * here was no frame; the next one starts clean. */
enum mr_status mr_deframer_push(struct mr_deframer *deframer, uint8_t byte, struct mr_frame *frame);

#endif
