/* Links: what a LINK is, candump lines, files and sockets. */
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>

#include "host/link/candump.h"
#include "host/link/link.h"
#include "host/link/tty.h"
#include "tests/host/scratch.h"

TEST(refused_specs)
{
    static const struct {
        const char *spec;
        enum mr_status status;
        const char *names;
    } cases[] = {
        {"", MR_USAGE,
         "write unix:PATH, file:PATH[,interface=I], can:IFACE[,base=N], serial:TTY[:BAUD] or "
         "pty:PATH"},
        {"/dev/ttyUSB0", MR_USAGE, "/dev/ttyUSB0"},
        {"tcp:localhost", MR_USAGE, "tcp:localhost"},
        {"unix:", MR_USAGE, "without a path"},
        {"file:", MR_USAGE, "without a path"},
        {"can:", MR_USAGE, "write can:IFACE[,base=N]"},
        {"can:an_interface_name_too_long", MR_USAGE, "interface name of 26 characters"},
        {"can:no_such_can", MR_IO, "can:no_such_can"}, /* whether the kernel has CAN or not */
        {"serial:/dev/ttyUSB0", MR_USAGE,
         "cannot carry CAN frames: serial:/dev/ttyUSB0; give the link with --serial"},
        {"slcan:/dev/ttyACM0", MR_USAGE, "not a link: 'slcan:/dev/ttyACM0'"},
        {"file:build/test-tmp/no/such/file", MR_IO, "no/such/file"},
        {"file:build", MR_IO, "directory"},
    };
    scratch_begin();
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct link *link = NULL;
        struct error error = {0};
        assert_int_equal(link_open(cases[i].spec, LINK_CAN, &link, &error), cases[i].status);
        assert_error(&error, cases[i].status, cases[i].names);
        assert_null(link);
    }
}

/* What is written for a serial port, and its parts. */
TEST(serial_ports_and_rates)
{
    static const struct {
        const char *text, *path;
        int baud;
    } cases[] = {
        {"/dev/ttyUSB0", "/dev/ttyUSB0", 2000000},
        {"/dev/ttyUSB0:115200", "/dev/ttyUSB0", 115200},
        {"/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0",
         "/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0", 2000000},
        {"/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0:921600",
         "/dev/serial/by-path/pci-0000:00:14.0-usb-0:2:1.0-port0", 921600},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char path[TTY_PATH_SIZE];
        int baud;
        struct error error = {0};
        assert_int_equal(tty_parse(cases[i].text, "serial:TTY[:BAUD]", path, &baud, &error), MR_OK);
        assert_string_equal(path, cases[i].path);
        assert_int_equal(baud, cases[i].baud);
    }
}

TEST(bytes_are_no_frames)
{
    struct link *link = NULL;
    struct error error = {0};
    assert_int_equal(link_open("can:can0", LINK_SERIAL, &link, &error), MR_USAGE);
    assert_error(
        &error, MR_USAGE,
        "can:IFACE[,base=N] cannot carry serial bytes: can:can0; give the link with --can");
}

TEST(socket_path_too_long)
{
    char spec[200] = "unix:/tmp/";
    struct link *link = NULL;
    struct error error = {0};
    memset(spec + 10, 'x', 150);
    assert_int_equal(link_open(spec, LINK_CAN, &link, &error), MR_USAGE);
    assert_error(&error, MR_USAGE, "too long");
}

static void parse(const char *line, enum mr_status status, struct link_frame *frame)
{
    if (candump_parse(line, strlen(line), frame) != status)
        fail_msg("'%s' gives another status than %d", line, status);
}

/* The lines of candump's documentation and their meaning, by hand. */
TEST(candump_lines)
{
    struct link_frame f;
    parse("(1436509053.850870) vcan0 044#DEADBEEF", MR_OK, &f);
    assert_int_equal(f.host_us, 1436509053850870u);
    assert_int_equal(f.id, 0x44);
    assert_int_equal(f.length, 4);
    assert_memory_equal(f.data, "\xDE\xAD\xBE\xEF", 4);
    parse("(0000000001.5) can0 7FF#", MR_OK, &f);
    assert_int_equal(f.host_us, 1500000);
    assert_int_equal(f.length, 0);
    parse("(1.000001999) can0 1F334455#1122334455667788 R", MR_OK, &f);
    assert_int_equal(f.host_us, 1000001);
    assert_true(f.id == (0x1F334455u | LINK_ID_EXTENDED));
    assert_int_equal(f.length, 8);
    parse("(1.0) can0 123#R8\r", MR_OK, &f);
    assert_true(f.id == (0x123u | LINK_ID_REMOTE));
    assert_int_equal(f.length, 8);
    parse("(1.0) can0 20000004#0000000000000000", MR_OK, &f);
    assert_true(f.id & LINK_ID_ERROR);
    /* as can-utils 2020.11 pads it beside slcan0, with blanks of other programs, with the length
     * code of can-utils 2021 */
    parse("(1436509053.850870)   can0 044#DEADBEEF", MR_OK, &f);
    assert_int_equal(f.length, 4);
    parse("(1.0)\tcan0 \t 044#DEADBE   T  \r", MR_OK, &f);
    assert_int_equal(f.length, 3);
    parse("(1.0) can0 044#DEADBE ", MR_OK, &f);
    parse("(1.0) can0 044#1122334455667788_F", MR_OK, &f);
    assert_int_equal(f.length, 8);
    parse("(1.0) can0 044#R8_9", MR_OK, &f);
    assert_int_equal(f.length, 8);
}

TEST(refused_candump_lines)
{
    static const char *const lines[] = {
        "",
        "hello",
        "(1.0) can0",
        "1.0 can0 123#00",
        "(1.0) can0 123",
        "(1.0) can0 12#00",   /* two digits */
        "(1.0) can0 800#00",  /* 11 bits end at 7FF */
        "(1.0) can0 1234#00", /* neither 3 nor 8 digits */
        "(1.0) can0 123#0",   /* half a byte */
        "(1.0) can0 123#112233445566778899",
        "(1.0) can0 123##1112233", /* CAN FD */
        "(1.0) can0 123#00 X",
        "(1.) can0 123#00",
        "(1.0)  123#00",
        "(1.0) can0 123#GG",
        "(1.0)can0 123#00",
        "(1.0) can0 123 #00",
        "(1.0) can0 123#1122334455667788_8", /* 8 are no code */
        "(1.0) can0 123#11_9",
    };
    struct link_frame f;
    for (size_t i = 0; i < COUNT_OF(lines); i++)
        parse(lines[i], MR_MALFORMED, &f);
}

TEST(candump_there_and_back)
{
    static const struct link_frame frames[] = {
        {.host_us = 11203000, .id = 0x0A0, .length = 8, .data = {1, 1, 5, 0, 0xee, 0x2b, 0, 0}},
        {.host_us = 1, .id = 0x7ff, .length = 0},
        {.host_us = 1700000000123456u,
         .id = 0x00000012u | LINK_ID_EXTENDED,
         .length = 1,
         .data = {0xff}},
        {.host_us = 2, .id = 0x123u | LINK_ID_REMOTE, .length = 3},
    };
    for (size_t i = 0; i < COUNT_OF(frames); i++) {
        char line[CANDUMP_LINE_SIZE];
        struct link_frame back;
        size_t length = candump_write_line(&frames[i], line);
        assert_int_equal(length, strlen(line));
        assert_int_equal(line[length - 1], '\n');
        assert_int_equal(candump_parse(line, length - 1, &back), MR_OK);
        assert_int_equal(back.host_us, frames[i].host_us);
        assert_true(back.id == frames[i].id);
        assert_int_equal(back.length, frames[i].length);
        assert_memory_equal(back.data, frames[i].data, 8);
    }
    char line[CANDUMP_LINE_SIZE];
    candump_write_line(&frames[0], line);
    assert_string_equal(line, "(0000000011.203000) can0 0A0#01010500EE2B0000\n");
}

static struct link *open_text(const char *text)
{
    char path[200], spec[220];
    struct link *link = NULL;
    struct error error = {0};
    scratch_path(path, sizeof path, "link.log");
    scratch_write(path, text, strlen(text));
    snprintf(spec, sizeof spec, "file:%s", path);
    assert_int_equal(link_open(spec, LINK_CAN, &link, &error), MR_OK);
    return link;
}

TEST(file_ends_well)
{
    struct link_frame frame;
    struct error error = {0};
    struct link *link = open_text("(1.0) can0 001#11\n\n(2.0) can0 002#22\n");
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
    assert_int_equal(frame.id, 1);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
    assert_int_equal(frame.id, 2);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_CLOSED);
    assert_no_error(&error);
    assert_int_equal(link_counters(link)->received_count, 2);
    assert_int_equal(link_send_bytes(link, (const uint8_t *)"x", 1, &error), MR_NOT_NOW);
    link_close(link);
}

TEST(file_ends_inside_a_line)
{
    struct link_frame frame;
    struct error error = {0};
    struct link *link = open_text("(1.0) can0 001#11\n(2.0) can0 002#2");
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_TRUNCATED);
    assert_error(&error, MR_TRUNCATED, "line 2");
    link_close(link);
}

TEST(bad_lines_are_passed_over_and_told_at_the_end)
{
    struct link_frame frame;
    struct error error = {0};
    struct link *link = open_text("(1.0) can0 001#11\nsome other file\n(2.0) can0 002#22\n");
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
    assert_int_equal(frame.id, 2);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_MALFORMED);
    assert_error(&error, MR_MALFORMED, "line 2, column 1: ");
    assert_int_equal(link_counters(link)->bad_lines, 1);
    link_close(link);
}

TEST(another_file_is_no_log)
{
    struct link_frame frame;
    struct link *link = NULL;
    struct error error = {0}, piped = {0};
    const size_t length = 200000;
    char *text = malloc(length), path[200], spec[220];
    int ends[2];
    for (size_t i = 0; i < length; i++) /* one line longer than the buffer, then short ones */
        text[i] = i > 100000 && i % 50 == 0 ? '\n' : 'x';
    scratch_path(path, sizeof path, "strange.log");
    scratch_write(path, text, length);
    snprintf(spec, sizeof spec, "file:%s", path);
    assert_int_equal(link_open(spec, LINK_CAN, &link, &error), MR_MALFORMED);
    assert_error(&error, MR_MALFORMED, "not a CAN frame: ");

    /* of a pipe that is known when it has said much */
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(write(ends[1], text + length - 60000, 60000), 60000);
    snprintf(spec, sizeof spec, "file:/dev/fd/%d", ends[0]);
    assert_int_equal(link_open(spec, LINK_CAN, &link, &error), MR_OK);
    assert_int_equal(link_receive_frame(link, &frame, &piped), MR_MALFORMED);
    assert_error(&piped, MR_MALFORMED, "the first 1001 lines contain no CAN frame");
    link_close(link);
    close(ends[0]);
    close(ends[1]);
    free(text);
}

/* CAN error frames are counted by what they say. The frames are numbers from the kernel's
 * documentation of error frames (Documentation/networking/can.rst, linux/can/error.h). */
TEST(error_frames_are_counted)
{
#define BIT(fault) (1u << (fault))
    static const struct {
        const char *frame;
        uint32_t faults;
    } cases[] = {
        {"20000040#", BIT(LINK_BUS_OFF)},
        {"20000100#", BIT(LINK_RESTARTED)},
        {"20000004#0001", BIT(LINK_RX_OVERFLOW)},
        {"20000004#0002", BIT(LINK_TX_OVERFLOW)},
        {"20000004#0004", BIT(LINK_ERROR_WARNING)},
        {"20000004#0008", BIT(LINK_ERROR_WARNING)},
        {"20000204#003000000000887F", BIT(LINK_ERROR_PASSIVE)},
        {"20000004#0040", BIT(LINK_ERROR_ACTIVE)},
        {"20000004#0000", BIT(LINK_OTHER_ERROR)},
        {"20000020#", BIT(LINK_NO_ACK)},
        {"20000002#0B", BIT(LINK_ARBITRATION_LOST)},
        {"20000008#0000040A", BIT(LINK_PROTOCOL_ERROR)},
        {"20000088#00009019", BIT(LINK_PROTOCOL_ERROR) | BIT(LINK_BUS_ERROR)},
        {"20000010#0000000004", BIT(LINK_TRANSCEIVER)},
        {"20000001#", BIT(LINK_TX_TIMEOUT)},
        {"20000800#", BIT(LINK_OTHER_ERROR)},
    };
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        char line[80];
        struct link_frame frame;
        struct error error = {0};
        snprintf(line, sizeof line, "(1.0) can0 %s\n", cases[i].frame);
        struct link *link = open_text(line);
        assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
        for (unsigned k = 0; k < LINK_FAULT_COUNT; k++)
            assert_int_equal(link_counters(link)->fault_count[k], cases[i].faults >> k & 1u);
        assert_int_equal(link_counters(link)->received_count, 0);
        assert_int_equal(link_counters(link)->error_frames, 1);
        link_close(link);
    }
    /* These numbers are in campaign files. */
    assert_int_equal(LINK_BUS_OFF, 0);
    assert_int_equal(LINK_QUEUE_LOST, 14);
    assert_int_equal(LINK_BACK, 18);
    assert_string_equal(link_fault_text(LINK_FAULT_COUNT), "unknown trouble");
}

/* A board's end of a socket: `far` is what it writes to. */
static struct link *open_socket(enum link_kind kind, int *far)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    struct link *link = NULL;
    struct error error = {0};
    char spec[220];
    scratch_path(address.sun_path, sizeof address.sun_path, "link.socket");
    int listener = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listener, 1), 0);
    snprintf(spec, sizeof spec, "unix:%s", address.sun_path);
    assert_int_equal(link_open(spec, kind, &link, &error), MR_OK);
    *far = accept(listener, NULL, NULL);
    assert_true(*far >= 0);
    close(listener);
    unlink(address.sun_path);
    return link;
}

/* struct can_frame of SocketCAN by hand: id, length, padding, data. */
static const uint8_t raw_frame[16] = {0x23, 0x01, 0,    0, 3, 0, 0, 0,
                                      0xa1, 0xb2, 0xc3, 0, 0, 0, 0, 0};

TEST(socket_carries_can_frames)
{
    int far;
    struct link_frame frame;
    struct error error = {0};
    uint8_t back[16];
    struct link *link = open_socket(LINK_CAN, &far);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_TOO_FEW);
    assert_int_equal(write(far, raw_frame, 10), 10);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_TOO_FEW);
    assert_int_equal(write(far, raw_frame + 10, 6), 6);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_OK);
    assert_int_equal(frame.id, 0x123);
    assert_int_equal(frame.length, 3);
    assert_memory_equal(frame.data, "\xa1\xb2\xc3\0\0\0\0\0", 8);
    assert_true(frame.host_us > 1600000000000000u);
    assert_int_equal(link_send_frame(link, &frame, &error), MR_OK);
    assert_int_equal(read(far, back, 16), 16);
    assert_memory_equal(back, raw_frame, 16);
    close(far);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_CLOSED);
    assert_no_error(&error);
    link_close(link);
}

/* Of one that nobody accepts at, and that is full: no endless wait. */
TEST(full_socket)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    struct link *link = NULL;
    struct error error = {0};
    char spec[220];
    scratch_path(address.sun_path, sizeof address.sun_path, "link.full");
    int listener = socket(AF_UNIX, SOCK_STREAM, 0), first = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(bind(listener, (struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(listen(listener, 0), 0);
    assert_int_equal(connect(first, (struct sockaddr *)&address, sizeof address), 0);
    snprintf(spec, sizeof spec, "unix:%s", address.sun_path);
    assert_int_equal(link_open(spec, LINK_CAN, &link, &error), MR_IO);
    assert_error(&error, MR_IO, "other programs are waiting");
    close(first);
    close(listener);
    unlink(address.sun_path);
}

TEST(socket_ends_inside_a_frame)
{
    int far;
    struct link_frame frame;
    struct error error = {0};
    struct link *link = open_socket(LINK_CAN, &far);
    assert_int_equal(write(far, raw_frame, 15), 15);
    close(far);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_TRUNCATED);
    assert_error(&error, MR_TRUNCATED, "link.socket");
    link_close(link);
}

TEST(socket_with_an_impossible_length)
{
    int far;
    struct link_frame frame;
    struct error error = {0};
    uint8_t wrong[16] = {1, 0, 0, 0, 9};
    struct link *link = open_socket(LINK_CAN, &far);
    assert_int_equal(write(far, wrong, 16), 16);
    assert_int_equal(link_receive_frame(link, &frame, &error), MR_MALFORMED);
    close(far);
    link_close(link);
}

TEST(socket_carries_bytes)
{
    int far;
    uint8_t bytes[8];
    size_t length;
    uint64_t host_us;
    struct error error = {0};
    struct link *link = open_socket(LINK_SERIAL, &far);
    assert_int_equal(link_receive_bytes(link, bytes, 8, &length, &host_us, &error), MR_TOO_FEW);
    assert_int_equal(write(far, "abcdefghij", 10), 10);
    assert_int_equal(link_receive_bytes(link, bytes, 8, &length, &host_us, &error), MR_OK);
    assert_int_equal(length, 8);
    assert_int_equal(link_receive_bytes(link, bytes, 8, &length, &host_us, &error), MR_OK);
    assert_int_equal(length, 2);
    assert_memory_equal(bytes, "ij", 2);
    close(far);
    assert_int_equal(link_receive_bytes(link, bytes, 8, &length, &host_us, &error), MR_CLOSED);
    assert_int_equal(link_counters(link)->received_count, 10);
    link_close(link);
}

/* Two that read one terminal take bytes from each other. */
TEST(a_terminal_is_for_one_alone)
{
    struct error error = {0};
    struct link *first = NULL, *second = NULL;
    char spec[80];
    int board = posix_openpt(O_RDWR | O_NOCTTY);
    assert_true(board >= 0 && grantpt(board) == 0 && unlockpt(board) == 0);
    snprintf(spec, sizeof spec, "pty:%s", ptsname(board));
    assert_int_equal(link_open(spec, LINK_SERIAL, &first, &error), MR_OK);
    assert_int_equal(link_open(spec, LINK_SERIAL, &second, &error), MR_IO);
    assert_non_null(strstr(error.text, "another matrig uses the terminal"));
    link_close(first);
    assert_int_equal(link_open(spec, LINK_SERIAL, &second, &error), MR_OK);
    link_close(second);
    close(board);
}
