/* What the two ends of a serial line make of each other, and the pseudo-terminal and the files by
 * which hosts reach a board. Expected bytes are drawn by hand: bits in the order of the line, least
 * significant first. */
#include <errno.h>
#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

#include "tests/hil/bench.h"

#include "hil/board/board.h"
#include "hil/board/parts.h"
#include "hil/chips/w25q.h"
#include "hil/link/wire_link.h"

#define BIT_PS 1e6

static const struct hil_serial_format none = {BIT_PS, HIL_PARITY_NONE},
                                      even = {BIT_PS, HIL_PARITY_EVEN},
                                      odd = {BIT_PS, HIL_PARITY_ODD};

static struct hil_heard_byte heard[HIL_HEARD_MAX];

static unsigned hear(uint8_t byte, int follower, const struct hil_serial_format *sender,
                     double rate, enum hil_parity parity)
{
    struct hil_serial_format receiver = {BIT_PS / rate, parity};
    memset(heard, 0, sizeof heard);
    return hil_serial_hear(byte, follower, sender, &receiver, heard);
}

TEST(test_agreement)
{
    static const struct hil_serial_format *const formats[] = {&none, &even, &odd};
    static const double rates[] = {0.96, 1.0, 1.04}; /* half a bit in 9.5 or 10.5 is 4.7 % */
    for (unsigned f = 0; f < 3; f++) {
        for (unsigned r = 0; r < 3; r++) {
            for (unsigned byte = 0; byte < 256; byte++) {
                int follower = (int)(byte * 7 % 256);
                assert_int_equal(
                    hear((uint8_t)byte, follower, formats[f], rates[r], formats[f]->parity), 1);
                assert_int_equal(heard[0].value, byte);
                assert_false(heard[0].parity_error || heard[0].framing_error);
            }
        }
    }
}

TEST(test_parity)
{
    /* 0x03 has two ones: even parity 0, odd 1. */
    assert_int_equal(hil_frame_levels(0x03, HIL_PARITY_NONE), 0x206);
    assert_int_equal(hil_frame_levels(0x03, HIL_PARITY_EVEN), 0x406);
    assert_int_equal(hil_frame_levels(0x03, HIL_PARITY_ODD), 0x606);
    assert_int_equal(hear(0x03, -1, &odd, 1.0, HIL_PARITY_EVEN), 1);
    assert_int_equal(heard[0].value, 0x03);
    assert_true(heard[0].parity_error && heard[0].parity_bit && !heard[0].framing_error);
    /* no parity sent: the stop bit is taken for it, and the stop bit is the idle line or the next
     * start bit */
    assert_int_equal(hear(0x03, -1, &none, 1.0, HIL_PARITY_EVEN), 1);
    assert_true(heard[0].parity_error && !heard[0].framing_error);
    assert_int_equal(hear(0x07, -1, &none, 1.0, HIL_PARITY_EVEN), 1);
    assert_false(heard[0].parity_error || heard[0].framing_error);
    assert_int_equal(hear(0x07, 0x55, &none, 1.0, HIL_PARITY_EVEN), 1);
    assert_true(!heard[0].parity_error && heard[0].framing_error);
    /* parity sent to one who expects none: it is the stop bit, wrong when 0 */
    assert_int_equal(hear(0x07, -1, &even, 1.0, HIL_PARITY_NONE), 1);
    assert_false(heard[0].framing_error);
    assert_int_equal(hear(0x03, -1, &even, 1.0, HIL_PARITY_NONE), 1);
    assert_true(heard[0].framing_error && heard[0].value == 0x03);
}

TEST(test_rates)
{
    /* Twice as fast a receiver sees 0x01 as 00 11 00 ... : start 0, data 0 1 1 0 0 0 0 0, stop 0;
     * then the line rises for good. */
    assert_int_equal(hear(0x01, -1, &none, 2.0, HIL_PARITY_NONE), 1);
    assert_int_equal(heard[0].value, 0x06);
    assert_true(heard[0].framing_error);
    /* 0x11: low, high, three low, high, three low, high, each sampled twice; the second fall gives
     * a second byte: start and five zeroes of six samples low, then high: 00000 111 -> 0xe0. */
    assert_int_equal(hear(0x11, -1, &none, 2.0, HIL_PARITY_NONE), 2);
    assert_int_equal(heard[0].value, 0x06);
    assert_int_equal(heard[1].value, 0xe0);
    assert_false(heard[1].framing_error);
    /* At 0.6 of the rate 0x55 (0 1 0 1 0 1 0 1 0 1 on the line) is sampled at 2.5, 4.2, 5.8, 7.5,
     * 9.2 of its bits: 0 0 1 1 1, and then the idle line. */
    assert_int_equal(hear(0x55, -1, &none, 0.6, HIL_PARITY_NONE), 1);
    assert_int_equal(heard[0].value, 0xfc);
}

/* A host opens, sets a rate, talks, hangs up. */
TEST(test_pty)
{
    char error[256];
    struct hil_link link;
    struct termios t;
    const char *path = BENCH_SCRATCH "/tty";
    unlink(path);
    bench_scratch("file", "x", 1);
    assert_int_equal(
        hil_link_open(&link, HIL_LINK_SERIAL, "pty:" BENCH_SCRATCH "/file", error, sizeof error),
        MR_IO);
    assert_non_null(strstr(error, "no link to a pseudo-terminal"));
    assert_int_equal(
        hil_link_open(&link, HIL_LINK_SERIAL, "pty:" BENCH_SCRATCH "/tty", error, sizeof error),
        MR_OK);
    for (unsigned turn = 0; turn < 2; turn++) {
        uint8_t bytes[4] = {0};
        int host = open(path, O_RDWR | O_NOCTTY);
        assert_true(host >= 0);
        assert_int_equal(tcgetattr(host, &t), 0);
        cfsetspeed(&t, turn ? B9600 : B460800);
        assert_int_equal(tcsetattr(host, TCSANOW, &t), 0);
        assert_int_equal(tcgetattr(link.fd, &t), 0);
        assert_int_equal(cfgetospeed(&t), turn ? B9600 : B460800);
        assert_int_equal(write(host, "\x03\n\x7f", 3), 3); /* raw: no signal, no line, no echo */
        assert_int_equal(read(link.fd, bytes, 4), 3);
        assert_memory_equal(bytes, "\x03\n\x7f", 3);
        assert_int_equal(write(link.fd, "\r\x04", 2), 2);
        assert_int_equal(read(host, bytes, 4), 2);
        assert_memory_equal(bytes, "\r\x04", 2);
        close(host);
    }
    hil_link_close(&link);
    assert_int_equal(access(path, F_OK), -1);
}

/* Flash and NOR through files; what is no such file is refused and not overwritten. */
TEST(test_files)
{
    static const uint8_t mark[3] = {0x12, 0x34, 0x56};
    uint8_t cells[3];
    struct hil_options options;
    hil_options_default(&options);
    unlink(BENCH_SCRATCH "/nor");
    struct hil_board *board = hil_board_create(&options), *other = hil_board_create(&options);
    assert_int_equal(hil_board_load_nor(board, BENCH_SCRATCH "/nor"), MR_OK); /* none yet: erased */
    assert_int_equal(hil_w25q_poke(&board->w25q, 0xfffffd, mark, 3), MR_OK);
    assert_int_equal(hil_board_save_nor(board, BENCH_SCRATCH "/nor"), MR_OK);
    assert_int_equal(hil_board_load_nor(other, BENCH_SCRATCH "/nor"), MR_OK);
    assert_int_equal(hil_w25q_peek(&other->w25q, 0xfffffd, cells, 3), MR_OK);
    assert_memory_equal(cells, mark, 3);
    /* sixteen times too large */
    assert_int_equal(hil_board_load_flash(other, BENCH_SCRATCH "/nor"), MR_MALFORMED);
    const char *database = bench_scratch("db", "SQLite format 3\0 and more", 26);
    assert_int_equal(hil_board_load_nor(other, database), MR_MALFORMED);
    assert_non_null(strstr(hil_board_reason(other), "a database"));
    assert_int_equal(hil_board_save_nor(other, "build/no/such/folder"), MR_IO);
    hil_board_destroy(board);
    hil_board_destroy(other);
}
