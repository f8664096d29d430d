/* Length and CRC of CAN frames against counts done by hand. */
#include "hil/periph/canbits.h"
#include "tests/hil/bench.h"

/* All zero up to the CRC, which is then zero too: 1 + 11 + 3 + 4 + 15 = 34 equal bits, so a stuff
 * bit after every fifth: 6 of them (the 31st to 34th zero make no five). 34 + 6 + 10 = 50. */
TEST(test_all_zero)
{
    struct hil_can_frame frame = {.id = 0};
    struct hil_can_bits bits = hil_can_frame_bits(&frame);
    assert_int_equal(bits.crc, 0);
    assert_int_equal(bits.stuff_bits, 6);
    assert_int_equal(bits.length, 50);
}

/* Identifier 0, one data byte 0: the only one among the 27 bits before the CRC is the last of the
 * DLC, 8 places from the end. CRC = x^23 mod x^15+x^14+x^10+x^8+x^7+x^4+x^3+1. By hand, starting
 * from x^15 = 4599: 4EAB, 58CF, 7407, 2D97, 5B2E, 73C5, 2213, 4426. Bits: 18 zeros, 1, 8 zeros,
 * 100010000100110. Stuff bits after zeros 5, 10, 15 of the 18, and after 5 of the 8: 4. The CRC
 * begins with 1 and has no run of five. 19 + 8 + 15 + 4 + 10 = 56. */
TEST(test_one_bit)
{
    struct hil_can_frame frame = {.id = 0, .length = 1};
    struct hil_can_bits bits = hil_can_frame_bits(&frame);
    assert_int_equal(bits.crc, 0x4426);
    assert_int_equal(bits.stuff_bits, 4);
    assert_int_equal(bits.length, 56);
}

/* A remote frame has the length of its data in the DLC and none of it on the wire: 1 + 11 + 1 + 2 +
 * 4 + 15 + 10 bits. */
TEST(test_remote_carries_no_data)
{
    struct hil_can_frame frame = {.id = 0x2aa, .is_remote = true, .length = 8};
    struct hil_can_bits bits = hil_can_frame_bits(&frame);
    assert_int_equal(bits.length - bits.stuff_bits, 44);
}

/* A second way to the CRC: long division of the message as text. */
static unsigned crc_by_division(const char *bits)
{
    char m[256];
    size_t n = strlen(bits);
    static const char divisor[] = "1100010110011001";
    unsigned crc = 0;
    memcpy(m, bits, n);
    memset(m + n, '0', 15);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; m[i] == '1' && k < 16; k++) {
            if (k)
                m[i + k] = m[i + k] == divisor[k] ? '0' : '1';
        }
    }
    for (size_t i = 0; i < 15; i++)
        crc = crc << 1 | (m[n + i] == '1');
    return crc;
}

static void append(char *text, uint32_t value, unsigned width)
{
    size_t n = strlen(text);
    while (width--)
        text[n++] = (char)('0' + (value >> width & 1u));
    text[n] = '\0';
}

static unsigned count_stuffed(const char *bits)
{
    char sent[320];
    size_t n = 0;
    for (; *bits; bits++) {
        sent[n++] = *bits;
        if (n >= 5 && sent[n - 1] == sent[n - 2] && sent[n - 2] == sent[n - 3] &&
            sent[n - 3] == sent[n - 4] && sent[n - 4] == sent[n - 5]) {
            sent[n] = sent[n - 1] == '0' ? '1' : '0';
            n++;
        }
    }
    return (unsigned)n;
}

TEST(test_against_text)
{
    uint32_t random = 12345;
    for (unsigned trial = 0; trial < 2000; trial++) {
        struct hil_can_frame frame = {0};
        char text[256] = "0";
        random = random * 1664525u + 1013904223u;
        frame.is_extended = random >> 31;
        frame.id = random >> 3 & (frame.is_extended ? 0x1fffffffu : 0x7ffu);
        frame.length = (uint8_t)(trial % 9);
        for (unsigned i = 0; i < frame.length; i++) {
            random = random * 1664525u + 1013904223u;
            /* some zeros, to be stuffed */
            frame.data[i] = (uint8_t)((random >> 28) ? random >> 16 : 0);
        }
        if (frame.is_extended) {
            append(text, frame.id >> 18, 11);
            append(text, 3, 2);
            append(text, frame.id & 0x3ffff, 18);
            append(text, 0, 3);
        } else {
            append(text, frame.id, 11);
            append(text, 0, 3);
        }
        append(text, frame.length, 4);
        for (unsigned i = 0; i < frame.length; i++)
            append(text, frame.data[i], 8);
        unsigned crc = crc_by_division(text);
        append(text, crc, 15);
        struct hil_can_bits bits = hil_can_frame_bits(&frame);
        assert_int_equal(bits.crc, crc);
        assert_int_equal(bits.length, count_stuffed(text) + 10);
    }
}

/* Dominant bits win: lower identifiers; a data frame before its remote frame; standard before
 * extended of equal base. */
TEST(test_arbitration)
{
    struct hil_can_frame low = {.id = 0x080}, high = {.id = 0x400};
    struct hil_can_frame remote = {.id = 0x080, .is_remote = true};
    struct hil_can_frame extended = {.id = 0x080u << 18, .is_extended = true};
    assert_true(hil_can_arbitration_value(&low) < hil_can_arbitration_value(&high));
    assert_true(hil_can_arbitration_value(&low) < hil_can_arbitration_value(&remote));
    assert_true(hil_can_arbitration_value(&remote) < hil_can_arbitration_value(&extended));
    assert_true(hil_can_arbitration_value(&extended) < hil_can_arbitration_value(&high));
}
