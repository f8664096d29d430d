/* The header of a firmware image. Expected bytes are laid out by hand from the table in
 * common/image.h, and the CRCs computed with zlib, which shares no code with common/crc32.c. */
#include <string.h>
#include <zlib.h>

#include "common/image.h"
#include "tests/cmocka_all.h"

static const uint8_t by_hand[MR_IMAGE_BYTES - 4] = {
    'M',  'R',  'I',  'G',  1,    0,    36,   0,
    0x00, 0x00, 0x01, 0x08, 0x18, 0xe0, 0x01, 0x08, /* 0x08010000 to 0x0801e018 */
    0xef, 0xbe, 0xad, 0xde, 1,    2,    3,    1,
    0x6a, 0x13, 0xa3, 0xc7, 0xa3, 0xb3, 0,    0,
};

static void make_head(uint8_t head[MR_IMAGE_HEAD_BYTES])
{
    for (unsigned i = 0; i < MR_IMAGE_OFFSET; i++)
        head[i] = (uint8_t)(i * 7u);
    memcpy(head + MR_IMAGE_OFFSET, by_hand, sizeof by_hand);
    uint32_t crc = (uint32_t)crc32(0, head, MR_IMAGE_HEAD_BYTES - 4);
    for (unsigned i = 0; i < 4; i++)
        head[MR_IMAGE_HEAD_BYTES - 4 + i] = (uint8_t)(crc >> 8 * i);
}

TEST(reads_and_writes_the_layout)
{
    uint8_t head[MR_IMAGE_HEAD_BYTES], again[MR_IMAGE_HEAD_BYTES];
    struct mr_image image;
    make_head(head);
    assert_int_equal(mr_image_decode(&image, head), MR_OK);
    assert_int_equal(image.program_start, 0x08010000);
    assert_int_equal(image.program_end, 0x0801e018);
    assert_int_equal(image.program_crc, 0xdeadbeef);
    assert_int_equal(image.major, 1);
    assert_int_equal(image.minor, 2);
    assert_int_equal(image.patch, 3);
    assert_true(image.is_modified);
    assert_int_equal(image.commit, 0xc7a3136a);
    assert_int_equal(image.commit_more, 0xb3a3);
    memcpy(again, head, MR_IMAGE_OFFSET);
    image.header_crc = 0;
    mr_image_encode(&image, again);
    assert_memory_equal(again, head, sizeof head);
}

/* Every bit of vectors and header, the magic and the format included. */
TEST(every_single_bit_is_noticed)
{
    uint8_t head[MR_IMAGE_HEAD_BYTES];
    struct mr_image image;
    make_head(head);
    for (unsigned bit = 0; bit < 8 * MR_IMAGE_HEAD_BYTES; bit++) {
        head[bit / 8] ^= (uint8_t)(1u << bit % 8);
        enum mr_status expected = bit / 8 - MR_IMAGE_OFFSET < 4 ? MR_UNKNOWN
                                : bit / 8 - MR_IMAGE_OFFSET < 8 ? MR_VERSION
                                                                : MR_CRC;
        assert_int_equal(mr_image_decode(&image, head), expected);
        head[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    assert_int_equal(mr_image_decode(&image, head), MR_OK);
}

TEST(a_program_out_of_flash_is_refused)
{
    static const uint32_t places[][2] = {
        {0x07ffffff, 0x08000010}, {0x08010000, 0x08100001}, {0x08010010, 0x0801000f}};
    for (unsigned i = 0; i < 3; i++) {
        uint8_t head[MR_IMAGE_HEAD_BYTES] = {0};
        struct mr_image image = {.program_start = places[i][0], .program_end = places[i][1]};
        mr_image_encode(&image, head);
        assert_int_equal(mr_image_decode(&image, head), MR_MALFORMED);
    }
}

TEST(commits_as_text)
{
    char text[MR_IMAGE_COMMIT_TEXT];
    mr_image_commit_text(0xc7a3136au, 0xb3a3u, false, text);
    assert_string_equal(text, "c7a3136ab3a3");
    mr_image_commit_text(0, 0xff, true, text);
    assert_string_equal(text, "0000000000ff-dirty");
    mr_image_commit_text(0, 0, false, text);
    assert_string_equal(text, "unknown");
}

TEST(every_state_has_its_own_text)
{
    for (unsigned a = 0; a <= MR_IMAGE_HEADER_DAMAGED; a++) {
        assert_string_not_equal(mr_image_state_text(a), "unknown");
        for (unsigned b = 0; b < a; b++)
            assert_string_not_equal(mr_image_state_text(a), mr_image_state_text(b));
    }
    assert_string_equal(mr_image_state_text(MR_IMAGE_HEADER_DAMAGED + 1), "unknown");
}
