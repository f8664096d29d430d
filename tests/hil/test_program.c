/* build/matrig-board as a process: what it writes over sockets, into files, and in-process are the
 * same bytes. Its options and mistakes: tests/cli/board.sh. */
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "hil/rig/runfile.h"
#include "tests/hil/bench.h"

#define PROGRAM       "build/matrig-board"
#define ELF           "build/firmware/matrig.elf"
#define RUN           "tests/runs/landing5.run"
#define CAN_SOCKET    BENCH_SCRATCH "/p.can"
#define SERIAL_SOCKET BENCH_SCRATCH "/p.serial"
#define BYTES_MAX     (4u << 20)

struct bytes {
    size_t n;
    uint8_t *at;
};

static pid_t start(char *const arguments[])
{
    bench_scratch("p.bin", "", 0); /* makes the folder */
    pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        execv(PROGRAM, arguments);
        _exit(98);
    }
    return child;
}

static int finish(pid_t child)
{
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static struct bytes file_bytes(const char *path)
{
    struct bytes bytes = {0, malloc(BYTES_MAX)};
    FILE *file = fopen(path, "rb");
    assert_non_null(bytes.at);
    assert_non_null(file);
    bytes.n = fread(bytes.at, 1, BYTES_MAX, file);
    fclose(file);
    return bytes;
}

static int connect_to(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    snprintf(address.sun_path, sizeof address.sun_path, "%s", path);
    for (unsigned tries = 0; tries < 1000; tries++) {
        int fd = socket(AF_UNIX, SOCK_STREAM, 0);
        if (connect(fd, (const struct sockaddr *)&address, sizeof address) == 0)
            return fd;
        close(fd);
        nanosleep(&(struct timespec){.tv_nsec = 10000000}, NULL);
    }
    fail_msg("no board at %s", path);
    return -1;
}

/* Read both sockets to their ends. */
static void read_both(const int fds[2], struct bytes into[2])
{
    bool open[2] = {true, true};
    into[0] = (struct bytes){0, malloc(BYTES_MAX)};
    into[1] = (struct bytes){0, malloc(BYTES_MAX)};
    while (open[0] || open[1]) {
        struct pollfd wait[2] = {{.fd = open[0] ? fds[0] : -1, .events = POLLIN},
                                 {.fd = open[1] ? fds[1] : -1, .events = POLLIN}};
        assert_true(poll(wait, 2, 60000) > 0);
        for (unsigned i = 0; i < 2; i++) {
            if (!wait[i].revents)
                continue;
            ssize_t n = recv(fds[i], into[i].at + into[i].n, BYTES_MAX - into[i].n, 0);
            open[i] = n > 0;
            into[i].n += n > 0 ? (size_t)n : 0;
        }
    }
    close(fds[0]);
    close(fds[1]);
}

static void play_over_sockets(struct bytes into[2])
{
    char *arguments[] = {(char *)PROGRAM,
                         (char *)"--elf",
                         (char *)ELF,
                         (char *)"--rig",
                         (char *)RUN,
                         (char *)"--can",
                         (char *)"unix:" CAN_SOCKET,
                         (char *)"--serial",
                         (char *)"unix:" SERIAL_SOCKET,
                         (char *)"--for",
                         (char *)"2.5",
                         NULL};
    pid_t child = start(arguments);
    int can = connect_to(CAN_SOCKET);
    const int fds[2] = {can, connect_to(SERIAL_SOCKET)};
    read_both(fds, into);
    assert_int_equal(finish(child), 0);
}

static void append_frame(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct bytes *bytes = ctx;
    uint8_t wire[16] = {0};
    (void)t_ps;
    wire[0] = (uint8_t)frame->id;
    wire[1] = (uint8_t)(frame->id >> 8);
    wire[4] = frame->length;
    memcpy(wire + 8, frame->data, frame->length);
    memcpy(bytes[0].at + bytes[0].n, wire, sizeof wire);
    bytes[0].n += sizeof wire;
}

static void append_bytes(void *ctx, uint64_t t_ps, const uint8_t *at, size_t n)
{
    struct bytes *bytes = ctx;
    (void)t_ps;
    memcpy(bytes[1].at + bytes[1].n, at, n);
    bytes[1].n += n;
}

static void play_in_process(double for_s, struct bytes into[2])
{
    struct hil_options options;
    struct hil_run run;
    char error[256];
    hil_options_default(&options);
    into[0] = (struct bytes){0, malloc(BYTES_MAX)};
    into[1] = (struct bytes){0, malloc(BYTES_MAX)};
    struct hil_callbacks callbacks = {into, append_frame, append_bytes};
    struct hil_board *board = hil_board_create(&options);
    assert_int_equal(hil_board_load_elf(board, ELF), MR_OK);
    assert_int_equal(hil_run_read(RUN, &run, error, sizeof error), MR_OK);
    hil_board_attach_rig(board, &run);
    hil_board_set_callbacks(board, &callbacks);
    bench_run(board, (uint64_t)(for_s * 1e12));
    hil_board_destroy(board);
    hil_run_free(&run);
}

static void assert_same_bytes(const struct bytes a, const struct bytes b)
{
    assert_int_equal(a.n, b.n);
    assert_memory_equal(a.at, b.at, a.n);
}

static void free_both(struct bytes bytes[2])
{
    free(bytes[0].at);
    free(bytes[1].at);
}

/* Arming, commands and the first switches of landing 5. */
TEST(test_same_bytes_everywhere)
{
    struct bytes inside[2], sockets[2];
    play_in_process(2.5, inside);
    assert_true(inside[0].n > 16 * 4000 && inside[1].n > 100000);
    play_over_sockets(sockets);
    assert_same_bytes(sockets[0], inside[0]);
    assert_same_bytes(sockets[1], inside[1]);
    free_both(sockets);

    char *arguments[] = {(char *)PROGRAM,
                         (char *)"--elf",
                         (char *)ELF,
                         (char *)"--rig",
                         (char *)RUN,
                         (char *)"--for",
                         (char *)"2.5",
                         (char *)"--serial",
                         (char *)"file:" BENCH_SCRATCH "/p.bin",
                         (char *)"--can",
                         (char *)"file:" BENCH_SCRATCH "/p.log",
                         NULL};
    assert_int_equal(finish(start(arguments)), 0);
    struct bytes serial = file_bytes(BENCH_SCRATCH "/p.bin");
    assert_same_bytes(serial, inside[1]);
    free(serial.at);
    free_both(inside);
}

TEST(test_signal_ends_cleanly)
{
    char *arguments[] = {(char *)PROGRAM,
                         (char *)"--elf",
                         (char *)ELF,
                         (char *)"--can",
                         (char *)"unix:" CAN_SOCKET,
                         (char *)"--speed",
                         (char *)"real",
                         NULL};
    pid_t child = start(arguments);
    int can = connect_to(CAN_SOCKET);
    uint8_t byte;
    assert_int_equal(recv(can, &byte, 1, MSG_WAITALL), 1); /* it runs */
    kill(child, SIGTERM);
    close(can);
    assert_int_equal(finish(child), 0);
    assert_int_equal(access(CAN_SOCKET, F_OK), -1);
}
