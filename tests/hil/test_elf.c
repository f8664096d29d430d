/* The loader refuses what is not firmware for this chip, each with its status and a message that
 * names the file. */
#include "tests/hil/bench.h"

static uint8_t image[32768];
static size_t image_size;

static void read_image(void)
{
    FILE *file = fopen(BENCH_IMAGES "clock.elf", "rb");
    assert_non_null(file);
    image_size = fread(image, 1, sizeof image, file);
    fclose(file);
    assert_in_range(image_size, 500, sizeof image - 1);
}

static uint32_t word(size_t at)
{
    uint32_t value;
    memcpy(&value, image + at, 4);
    return value;
}

/* First load segment with contents. */
static size_t segment(void)
{
    for (size_t p = word(28);; p += 32) {
        if (word(p) == 1 && word(p + 16))
            return p;
    }
}

static void expect(size_t size, enum mr_status status, const char *part)
{
    struct hil_options options;
    const char *path = bench_scratch("damaged.elf", image, size);
    hil_options_default(&options);
    struct hil_board *board = hil_board_create(&options);
    assert_int_equal(hil_board_load_elf(board, path), status);
    if (status != MR_OK) {
        assert_non_null(strstr(hil_board_failure_reason(board), "damaged.elf"));
        if (!strstr(hil_board_failure_reason(board), part))
            fail_msg("`%s` is not in: %s", part, hil_board_failure_reason(board));
    }
    hil_board_destroy(board);
}

TEST(test_whole)
{
    read_image();
    expect(image_size, MR_OK, "");
}

/* The image with a segment that begins with the file's headers: `before` bytes before its first
 * section, which is at `address`. It is one segment of the file from its begin, as GNU ld makes it
 * without -n. Returns its size. */
static size_t with_headers(uint32_t before, uint32_t address)
{
    static uint8_t code[sizeof image];
    read_image();
    size_t p = segment();
    uint32_t bytes = word(p + 16);
    uint32_t header[8] = {1, 0, address - before, address - before, before + bytes, before + bytes};
    uint16_t one = 1;
    uint32_t at = 52;
    memcpy(code, image + word(p + 4), bytes);
    memset(image + at, 0, sizeof image - at);
    memcpy(image + 28, &at, 4);
    memcpy(image + 44, &one, 2);
    memcpy(image + at, header, sizeof header);
    assert_in_range(before + bytes, 100, sizeof image);
    memcpy(image + before, code, bytes);
    return before + bytes;
}

TEST(test_headers_in_first_segment)
{
    struct hil_options options;
    struct hil_board *whole = bench_board("clock", NULL);
    size_t size = with_headers(0x1000, 0x08000000);
    hil_options_default(&options);
    struct hil_board *board = hil_board_create(&options);
    assert_int_equal(hil_board_load_elf(board, bench_scratch("headers.elf", image, size)), MR_OK);
    for (uint32_t at = 0; at < 0x10000u; at += 4)
        assert_int_equal(bench_word(board, 0x08000000u + at), bench_word(whole, 0x08000000u + at));
    hil_board_destroy(whole);
    hil_board_destroy(board);
    /* what is linked for behind the headers has no vector table, but they are no such either */
    expect(with_headers(0x200, 0x08000200), MR_VERSION,
           "no vector table at 0x08000000; link with -n, because the headers of the file");
}

TEST(test_missing)
{
    struct hil_options options;
    hil_options_default(&options);
    struct hil_board *board = hil_board_create(&options);
    assert_int_equal(hil_board_load_elf(board, "build/test-tmp/hil/no-such.elf"), MR_IO);
    assert_non_null(strstr(hil_board_failure_reason(board), "no-such.elf"));
    /* erased flash has no reset vector */
    assert_int_equal(hil_board_run_until(board, HIL_PS_PER_MS), MR_HALTED);
    hil_board_destroy(board);
}

TEST(test_no_elf)
{
    read_image();
    image[1] = 'F';
    expect(image_size, MR_MALFORMED, "not an ELF");
    expect(0, MR_MALFORMED, "not an ELF");
}

TEST(test_other_machine)
{
    read_image();
    image[18] = 62; /* x86-64 */
    expect(image_size, MR_VERSION, "machine 62");
    read_image();
    image[4] = 2; /* 64 bits */
    expect(image_size, MR_VERSION, "class 2");
    read_image();
    image[5] = 2; /* big-endian */
    expect(image_size, MR_VERSION, "data 2");
}

TEST(test_object_file)
{
    read_image();
    image[16] = 1;
    expect(image_size, MR_MALFORMED, "type 1");
}

TEST(test_other_chip)
{
    uint32_t address = 0x00200000; /* where another vendor has its flash */
    read_image();
    memcpy(image + segment() + 12, &address, 4);
    expect(image_size, MR_VERSION, "0x00200000");
    read_image();
    address = 0x080ffff0; /* beyond the end of flash */
    memcpy(image + segment() + 12, &address, 4);
    expect(image_size, MR_VERSION, "outside");
    read_image();
    address = 0x08004000; /* inside, but no vector table */
    memcpy(image + segment() + 12, &address, 4);
    expect(image_size, MR_VERSION, "vector table");
}

TEST(test_truncated)
{
    read_image();
    expect(30, MR_TRUNCATED, "header");
    expect(60, MR_TRUNCATED, "program headers");
    expect(word(segment() + 4) + word(segment() + 16) - 1, MR_TRUNCATED, "segment");
}

/* A refused image leaves the one that is loaded. */
TEST(test_refused_changes_nothing)
{
    struct hil_board *board = bench_board("clock", NULL);
    uint32_t before = bench_word(board, 0x08000004);
    read_image();
    assert_int_equal(
        hil_board_load_elf(board, bench_scratch("short.elf", image, word(segment() + 4) + 8)),
        MR_TRUNCATED);
    assert_int_equal(bench_word(board, 0x08000004), before);
    bench_run(board, 5 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 1), 0x100);
    hil_board_destroy(board);
}
