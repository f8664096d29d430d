/* Serial framing. A frame is  COBS( seq u16 | type u16 | payload | CRC-32 u32 )  0x00.
 *
 *     seq      number of the frame, per sender, wraps; a jump is the number of lost frames
 *     type     MR_ID_... of the catalogue (low 11 bits), or MR_ID_BLOCK, MR_ID_BOX_PART
 *     payload  0 to MR_FRAME_PAYLOAD_BYTES_MAX bytes
 *     CRC-32   of everything before it (common/crc32.h)
 *
 * COBS (Cheshire and Baker, 1999): every run of up to 254 non-zero bytes is preceded by its length
 * plus one, and each zero is replaced by the next run's length, so 0x00 occurs only at the end of a
 * frame. A receiver that starts late or loses bytes is synchronised again after the next 0x00. */
#ifndef MATRIG_COMMON_FRAMING_H
#define MATRIG_COMMON_FRAMING_H

#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

#define MR_FRAME_PAYLOAD_BYTES_MAX 136u
#define MR_FRAME_OVERHEAD_BYTES    8u /* bytes of seq, type and CRC */
/* one length byte of COBS (the content is shorter than 254 bytes) and the final zero */
#define MR_FRAME_BYTES_MAX         (MR_FRAME_PAYLOAD_BYTES_MAX + MR_FRAME_OVERHEAD_BYTES + 2u)
_Static_assert(MR_FRAME_PAYLOAD_BYTES_MAX + MR_FRAME_OVERHEAD_BYTES < 254u,
               "a frame must fit into one COBS run");

/* Encodes one frame, including the final zero. Returns its length, or 0 when `length` exceeds
 * MR_FRAME_PAYLOAD_BYTES_MAX. */
size_t mr_frame_encode(uint16_t seq, uint16_t type, const uint8_t *payload, size_t length,
                       uint8_t out[MR_FRAME_BYTES_MAX]);

struct mr_frame {
    uint16_t seq;
    uint16_t type;
    size_t length; /* bytes of the payload */
    /* points into the deframer; valid until the next call of mr_deframer_push */
    const uint8_t *payload;
};

struct mr_deframer {
    uint8_t bytes[MR_FRAME_BYTES_MAX];
    size_t length;
    uint8_t discarded_bytes; /* number of bytes discarded since the last zero byte */
};

/* Starts or restarts a deframer. */
void mr_deframer_init(struct mr_deframer *deframer);

/* Processes one received byte. MR_OK: `*frame` holds a complete frame. MR_TOO_FEW: more bytes are
 * needed (also returned for an empty frame). MR_MALFORMED, MR_CRC, MR_TOO_LONG or MR_TRUNCATED: the
 * bytes up to here are not a valid frame and are discarded; the next frame is not affected. */
enum mr_status mr_deframer_push(struct mr_deframer *deframer, uint8_t byte, struct mr_frame *frame);

#endif
