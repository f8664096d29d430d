/* Pages of the black box: header, start and end by hand from common/boxpage.h; the CRC by zlib,
 * which shares no code. */
#include "common/boxpage.h"

#include <string.h>
#include <zlib.h>

#include "tests/cmocka_all.h"

static uint32_t u32_at(const uint8_t *p)
{
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static void make_page(uint8_t page[MR_BOXPAGE_BYTES], unsigned kind)
{
    for (unsigned i = 0; i < MR_BOXPAGE_BYTES; i++)
        page[i] = (uint8_t)(i * 11u);
    page[MR_BOXPAGE_KIND_OFFSET] = (uint8_t)kind;
    mr_boxpage_seal(page, 0x01020304, 0x0506);
}

TEST(the_header_is_that_of_the_table)
{
    uint8_t page[MR_BOXPAGE_BYTES];
    struct mr_boxpage_header header;
    make_page(page, MR_BOXPAGE_STREAM);
    assert_memory_equal(page, ((const uint8_t[]){4, 3, 2, 1, 6, 5, 0x82}), 7);
    assert_int_equal(u32_at(page + 252), (uint32_t)crc32(0, page, 252));
    assert_int_equal(mr_boxpage_check(page, &header), MR_OK);
    assert_int_equal(header.seq, 0x01020304);
    assert_int_equal(header.record, 0x0506);
    assert_int_equal(header.kind, MR_BOXPAGE_STREAM);
    assert_int_equal(header.first_record_byte, 7 * 11);
    assert_int_equal(header.is_freed, 0);
    page[MR_BOXPAGE_KIND_OFFSET] &= 0x7f; /* freeing programs one bit, and the page stays whole */
    assert_int_equal(mr_boxpage_check(page, &header), MR_OK);
    assert_int_equal(header.is_freed, 1);
}

TEST(what_is_no_page_is_noticed)
{
    uint8_t page[MR_BOXPAGE_BYTES];
    struct mr_boxpage_header header;
    make_page(page, MR_BOXPAGE_END);
    for (unsigned bit = 0; bit < 8 * MR_BOXPAGE_BYTES;
         bit++) { /* any single bit, but that of freeing */
        page[bit / 8] ^= (uint8_t)(1u << bit % 8);
        assert_int_equal(mr_boxpage_check(page, &header),
                         bit == 8 * MR_BOXPAGE_KIND_OFFSET + 7 ? MR_OK : MR_CRC);
        page[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    make_page(page, 0); /* a whole page of no kind is of somebody else */
    assert_int_equal(mr_boxpage_check(page, &header), MR_CRC);
    make_page(page, MR_BOXPAGE_END + 1);
    assert_int_equal(mr_boxpage_check(page, &header), MR_CRC);
    memset(page, 0xff, sizeof page);
    assert_int_equal(mr_boxpage_check(page, &header), MR_TOO_FEW);
}

TEST(start_and_end_come_back)
{
    uint8_t page[MR_BOXPAGE_BYTES];
    const struct mr_boxpage_start_page start = {3,          7,      1000,      2000, {1, 2, 3},
                                                0xdeadbeef, 0x1234, {4, 5, 6}, 1};
    const struct mr_boxpage_end end = {1000, 9999, 3, 2};
    struct mr_boxpage_start_page start_again;
    struct mr_boxpage_end end_again;
    mr_boxpage_put_start(page, &start);
    assert_int_equal(page[MR_BOXPAGE_KIND_OFFSET], 0x81);
    assert_int_equal(u32_at(page + 8), 7u << 16 | 3u);
    assert_int_equal(u32_at(page + 12), 1000);
    mr_boxpage_get_start(page, &start_again);
    assert_memory_equal(&start_again, &start, sizeof start);
    mr_boxpage_put_end(page, &end);
    assert_int_equal(page[MR_BOXPAGE_KIND_OFFSET], 0x83);
    assert_int_equal(u32_at(page + 12), 9999);
    mr_boxpage_get_end(page, &end_again);
    assert_memory_equal(&end_again, &end, sizeof end);
}
