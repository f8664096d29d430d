/* The board's ends of its wires: socket frames, candump text, refusals, a host that hangs up or
 * does not read. */
#include <fcntl.h>
#include <linux/can.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "hil/link/wire_link.h"
#include "tests/hil/bench.h"

#define SOCKET BENCH_SCRATCH "/link"
static const volatile int may_continue = 0;

/* A link that listens at SOCKET, with a host connected to it. */
static int connected(struct hil_link *link, enum hil_link_kind kind)
{
    char error[256];
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    bench_scratch("marker", "", 0); /* makes the folder */
    unlink(SOCKET);
    assert_int_equal(hil_link_open(link, kind, "unix:" SOCKET, error, sizeof error), MR_OK);
    snprintf(address.sun_path, sizeof address.sun_path, SOCKET);
    int host = socket(AF_UNIX, SOCK_STREAM, 0);
    assert_int_equal(connect(host, (const struct sockaddr *)&address, sizeof address), 0);
    assert_int_equal(hil_link_accept(link, 1000, &may_continue, error, sizeof error), MR_OK);
    return host;
}

/* The kernel's own struct reads what the board wrote, and the board reads the kernel's struct, cut
 * anywhere. */
TEST(test_can_frames)
{
    struct hil_link link;
    struct can_frame wire;
    char error[256];
    int host = connected(&link, HIL_LINK_CAN);
    struct hil_can_frame frame = {.id = 0x123, .length = 3, .data = {1, 2, 3}};
    hil_link_put_frame(&link, 0, &frame);
    frame = (struct hil_can_frame){
        .id = 0x1abcdef0, .is_extended = true, .is_remote = true, .length = 8};
    hil_link_put_frame(&link, 0, &frame);
    assert_int_equal(hil_link_flush(&link, 1000, &may_continue, error, sizeof error), MR_OK);
    assert_int_equal(sizeof wire, 16);
    assert_int_equal(recv(host, &wire, sizeof wire, MSG_WAITALL), sizeof wire);
    assert_int_equal(wire.can_id, 0x123);
    assert_int_equal(wire.can_dlc, 3);
    assert_memory_equal(wire.data, "\1\2\3\0\0\0\0\0", 8);
    assert_int_equal(recv(host, &wire, sizeof wire, MSG_WAITALL), sizeof wire);
    assert_int_equal(wire.can_id, 0x1abcdef0u | CAN_EFF_FLAG | CAN_RTR_FLAG);

    struct hil_board *board = bench_board("canbus", NULL);
    bench_run(board, 5 * HIL_PS_PER_MS);
    struct can_frame frames[3] = {{.can_id = 0x400, .can_dlc = 1, .data = {7}},
                                  /* not from the bus: ignored */
                                  {.can_id = CAN_ERR_FLAG | 4, .can_dlc = 8},
                                  {.can_id = 0x401}};
    const char *bytes = (const char *)frames;
    for (size_t i = 0; i < sizeof frames; i += 7) {
        size_t n = sizeof frames - i < 7 ? sizeof frames - i : 7;
        assert_int_equal(send(host, bytes + i, n, 0), n);
        hil_link_receive(&link, board);
    }
    bench_run(board, 10 * HIL_PS_PER_MS);
    assert_int_equal(bench_result(board, 2), 2);
    assert_int_equal(bench_result(board, 8), 0x400);
    assert_int_equal(bench_result(board, 9), 0x401);
    hil_board_destroy(board);
    close(host);
    hil_link_close(&link);
    assert_int_equal(access(SOCKET, F_OK), -1); /* the socket is gone */
}

/* A host that does not read: max waits and then gives up; real drops whole frames and counts
 * them. */
TEST(test_full_socket)
{
    struct hil_link link;
    struct hil_can_frame frame = {.id = 1, .length = 8};
    char error[256] = "";
    int host = connected(&link, HIL_LINK_CAN);
    enum mr_status status = MR_OK;
    unsigned put = 0;
    for (; put < 2000000 && status == MR_OK; put++) {
        hil_link_put_frame(&link, 0, &frame);
        if (put % 1000 == 0)
            status = hil_link_flush(&link, 50, &may_continue, error, sizeof error);
    }
    assert_int_equal(status, MR_TIMEOUT);
    assert_non_null(strstr(error, "has not read"));
    link.drops_when_full = true;
    for (unsigned i = 0; i < 10000; i++)
        hil_link_put_frame(&link, 0, &frame);
    assert_int_equal(hil_link_flush(&link, 0, &may_continue, error, sizeof error), MR_OK);
    assert_in_range(link.dropped_count, 1, 10000);
    /* what was not dropped arrives whole */
    uint64_t expected = (uint64_t)put + 10000u - link.dropped_count, arrived = 0;
    for (struct can_frame wire; arrived < expected; arrived++) {
        struct pollfd wait = {.fd = host, .events = POLLIN};
        hil_link_flush(&link, 0, &may_continue, error, sizeof error);
        assert_int_equal(poll(&wait, 1, 1000), 1);
        assert_int_equal(recv(host, &wire, sizeof wire, MSG_WAITALL), sizeof wire);
        assert_int_equal(wire.can_id, 1);
    }
    close(host);
    hil_link_close(&link);
}

TEST(test_host_hangs_up)
{
    struct hil_link link;
    char error[256];
    int host = connected(&link, HIL_LINK_SERIAL);
    close(host);
    for (unsigned i = 0; i < 3; i++) {
        hil_link_put_bytes(&link, (const uint8_t *)"hello", 5);
        assert_int_equal(hil_link_flush(&link, 1000, &may_continue, error, sizeof error), MR_OK);
    }
    assert_true(link.has_host_closed);
    assert_int_equal(link.dropped_count, 15);
    hil_link_close(&link);
}

TEST(test_candump_text)
{
    struct hil_link link;
    char error[256], text[256] = "";
    bench_scratch("can.log", "old", 3);
    assert_int_equal(
        hil_link_open(&link, HIL_LINK_CAN, "file:" BENCH_SCRATCH "/can.log", error, sizeof error),
        MR_OK);
    struct hil_can_frame frame = {.id = 0x5, .length = 2, .data = {0xab, 0x01}};
    hil_link_put_frame(&link, 12345678901ull * HIL_PS_PER_US / 1000u, &frame);
    frame = (struct hil_can_frame){
        .id = 0x1abcdef0, .is_extended = true, .is_remote = true, .length = 4};
    hil_link_put_frame(&link, 20 * HIL_PS_PER_S, &frame);
    assert_int_equal(hil_link_flush(&link, 1000, &may_continue, error, sizeof error), MR_OK);
    hil_link_close(&link);
    FILE *file = fopen(BENCH_SCRATCH "/can.log", "r");
    assert_non_null(file);
    assert_true(fread(text, 1, sizeof text - 1, file) > 0);
    fclose(file);
    assert_string_equal(
        text, "(0000000012.345678) can0 005#AB01\n(0000000020.000000) can0 1ABCDEF0#R4\n");
}

TEST(test_refusals)
{
    static const struct {
        const char *text;
        enum mr_status status;
        const char *part;
    } cases[] = {
        {"can:can0", MR_USAGE, "not a link of the emulated board"},
        {"unix:", MR_USAGE, "unix:PATH"},
        {"unix:" BENCH_SCRATCH
         "/aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
         "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa",
         MR_USAGE, "only 107 are allowed"},
        {"unix:" BENCH_SCRATCH "/no/such/folder", MR_IO, "cannot listen"},
        {"unix:" BENCH_SCRATCH "/marker", MR_IO, "not a socket"},
        {"file:" BENCH_SCRATCH "/no/such/folder", MR_IO, "cannot write"},
    };
    bench_scratch("marker", "", 0);
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct hil_link link;
        char error[512] = "";
        assert_int_equal(hil_link_open(&link, HIL_LINK_CAN, cases[i].text, error, sizeof error),
                         cases[i].status);
        if (!strstr(error, cases[i].part) || !strstr(error, "--can"))
            fail_msg("`%s` is not in: %s", cases[i].part, error);
        hil_link_close(&link);
    }
    assert_int_equal(access(BENCH_SCRATCH "/marker", F_OK), 0); /* not removed */
}

TEST(test_nobody_comes)
{
    struct hil_link link;
    char error[256];
    bench_scratch("marker", "", 0);
    unlink(SOCKET);
    assert_int_equal(hil_link_open(&link, HIL_LINK_SERIAL, "unix:" SOCKET, error, sizeof error),
                     MR_OK);
    assert_int_equal(hil_link_accept(&link, 10, &may_continue, error, sizeof error), MR_TIMEOUT);
    assert_non_null(strstr(error, "no host connected"));
    hil_link_close(&link);
}
