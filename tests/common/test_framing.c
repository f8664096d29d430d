#include "common/framing.h"

#include <string.h>
#include <zlib.h>

#include "common/crc32.h"
#include "tests/cmocka_all.h"

TEST(crc_has_the_published_check_value)
{
    const uint8_t *digits = (const uint8_t *)"123456789";
    assert_int_equal(mr_crc32(0, digits, 9), 0xcbf43926u);
    assert_int_equal(mr_crc32(mr_crc32(0, digits, 4), digits + 4, 5), 0xcbf43926u);
}

TEST(crc_equals_zlib)
{
    uint8_t bytes[300];
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (uint8_t)(i * i * 7 + i);
    for (size_t n = 0; n <= sizeof bytes; n += 13)
        assert_int_equal(mr_crc32(0, bytes, n), crc32(0, bytes, (uInt)n));
}

/* By hand: content 02 01 | 80 00 | 11 00 22 | CRC. zlib.crc32(bytes.fromhex("02018000110022")) =
 * 0xb8cd25c3, so the stream is 04 02 01 80 | 02 11 | 06 22 c3 25 cd b8 | 00: each length byte
 * counts to the next zero of the content. */
TEST(a_frame_worked_out_by_hand)
{
    const uint8_t payload[] = {0x11, 0x00, 0x22};
    const uint8_t expected[] = {0x04, 0x02, 0x01, 0x80, 0x02, 0x11, 0x06,
                                0x22, 0xc3, 0x25, 0xcd, 0xb8, 0x00};
    uint8_t out[MR_FRAME_BYTES_MAX];
    assert_int_equal(mr_frame_encode(0x0102, 0x0080, payload, sizeof payload, out),
                     sizeof expected);
    assert_memory_equal(out, expected, sizeof expected);
}

static enum mr_status push_all(struct mr_deframer *deframer, const uint8_t *bytes, size_t n,
                               struct mr_frame *frame)
{
    enum mr_status status = MR_TOO_FEW;
    for (size_t i = 0; i < n; i++) {
        status = mr_deframer_push(deframer, bytes[i], frame);
        if (i + 1 < n)
            assert_int_equal(status, MR_TOO_FEW);
    }
    return status;
}

TEST(what_goes_in_comes_out)
{
    struct mr_deframer deframer;
    struct mr_frame frame;
    uint8_t payload[MR_FRAME_PAYLOAD_BYTES_MAX], out[MR_FRAME_BYTES_MAX];
    mr_deframer_init(&deframer);
    for (size_t n = 0; n <= sizeof payload; n++) {
        for (size_t i = 0; i < n; i++)
            payload[i] = (uint8_t)((i * 37 + n) % 5 ? i : 0);
        size_t length = mr_frame_encode((uint16_t)(n * 257), MR_FRAME_PAYLOAD_BYTES_MAX, payload, n,
                                        out);
        assert_true(length <= MR_FRAME_BYTES_MAX);
        assert_null(memchr(out, 0, length - 1));
        assert_int_equal(push_all(&deframer, out, length, &frame), MR_OK);
        assert_int_equal(frame.seq, (uint16_t)(n * 257));
        assert_int_equal(frame.type, MR_FRAME_PAYLOAD_BYTES_MAX);
        assert_int_equal(frame.length, n);
        assert_memory_equal(frame.payload, payload, n);
    }
    assert_int_equal(mr_frame_encode(0, 0, payload, MR_FRAME_PAYLOAD_BYTES_MAX + 1, out), 0);
}

TEST(every_single_bit_error_is_noticed)
{
    struct mr_deframer deframer;
    struct mr_frame frame;
    uint8_t out[MR_FRAME_BYTES_MAX], bad[MR_FRAME_BYTES_MAX];
    const uint8_t payload[] = {1, 0, 2, 0, 0, 3};
    size_t length = mr_frame_encode(7, 9, payload, sizeof payload, out);
    for (size_t bit = 0; bit < 8 * (length - 1); bit++) {
        memcpy(bad, out, length);
        bad[bit / 8] = (uint8_t)(bad[bit / 8] ^ 1u << (bit % 8));
        mr_deframer_init(&deframer);
        enum mr_status status = MR_TOO_FEW;
        for (size_t i = 0; i < length; i++) {
            status = mr_deframer_push(&deframer, bad[i], &frame);
            assert_int_not_equal(status, MR_OK);
        }
        /* and the next frame is received */
        assert_int_equal(push_all(&deframer, out, length, &frame), MR_OK);
    }
}

TEST(too_long_and_too_short_are_refused)
{
    struct mr_deframer deframer;
    struct mr_frame frame;
    mr_deframer_init(&deframer);
    for (unsigned i = 0; i < 1000; i++)
        assert_int_equal(mr_deframer_push(&deframer, 0x55, &frame), MR_TOO_FEW);
    assert_int_equal(mr_deframer_push(&deframer, 0, &frame), MR_TOO_LONG);
    assert_int_equal(mr_deframer_push(&deframer, 0, &frame), MR_TOO_FEW);
    const uint8_t short_frame[] = {0x03, 0x01, 0x02, 0x00};
    assert_int_equal(push_all(&deframer, short_frame, sizeof short_frame, &frame), MR_TRUNCATED);
    /* zlib.crc32(b'\x11'): the checksum is right, but there is no room for seq and type */
    const uint8_t no_header[] = {0x06, 0x11, 0x7f, 0xcf, 0xb2, 0xb8, 0x00};
    assert_int_equal(push_all(&deframer, no_header, sizeof no_header, &frame), MR_TRUNCATED);
    const uint8_t run_beyond_end[] = {0x09, 0x01, 0x02, 0x00};
    assert_int_equal(push_all(&deframer, run_beyond_end, sizeof run_beyond_end, &frame),
                     MR_MALFORMED);
}
