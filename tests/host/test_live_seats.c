/* The seats of the live page: whatever readers and senders do that have no token, the page comes
 * and a command reaches the board. */
#include "tests/cmocka_all.h"

#include <arpa/inet.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#include "common/command.h"
#include "host/live/hub.h"
#include "host/live/seats.h"
#include "host/live/server.h"

#define CROWD_MOST 200
/* bound of every wait; a board that answers at once is heard of within milliseconds */
#define ANSWER_MS  5000

static const struct live_source source = {
    .db = "campaign.db", .can = "unix:can", .serial = "unix:serial", .commands = true};

struct rig {
    struct live_hub *hub;
    struct live_server *server;
    pthread_t board;
    atomic_bool over;
    atomic_uint disarmed; /* commands that the board has taken */
    uint16_t port;
    const char *token;
    int crowd[CROWD_MOST];
    size_t count;
};

/* Acknowledges each command, as a board does, and has something to tell meanwhile. */
static void *board(void *context)
{
    struct rig *rig = context;
    while (!rig->over) {
        struct mr_command command;
        uint8_t payload[MR_MESSAGE_MAX];
        if (live_hub_take_command(rig->hub, &command)) {
            const struct mr_ack ack = {.code = command.code, .status = MR_OK, .tag = command.tag};
            rig->disarmed += command.code == MR_COMMAND_DISARM;
            struct mr_message message;
            mr_message_read(&message, MR_ID_ACK, payload, mr_ack_put(&ack, payload));
            live_hub_message(rig->hub, &(struct collector_event){.link = LINK_CAN,
                                                                 .message = &message,
                                                                 .host_us = 1,
                                                                 .board_us = 1000});
        }
        live_hub_turn(rig->hub);
        usleep(2000);
    }
    return NULL;
}

static int set_up(void **state)
{
    struct rig *rig = calloc(1, sizeof *rig);
    struct error error = {0};
    assert_non_null(rig);
    assert_int_equal(live_hub_open(&source, &rig->hub, &error), MR_OK);
    assert_int_equal(live_server_open("0", rig->hub, NULL, &rig->server, &error), MR_OK);
    const char *url = live_server_url(rig->server);
    rig->port = (uint16_t)atoi(strrchr(url, ':') + 1);
    rig->token = strchr(url, '#') + 1;
    assert_int_equal(pthread_create(&rig->board, NULL, board, rig), 0);
    *state = rig;
    return 0;
}

static int take_down(void **state)
{
    struct rig *rig = *state;
    for (size_t i = 0; i < rig->count; i++)
        close(rig->crowd[i]);
    rig->over = true;
    pthread_join(rig->board, NULL);
    live_server_close(rig->server);
    live_hub_close(rig->hub);
    free(rig);
    return 0;
}

static int64_t now_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

/* A connection on which `text` was sent; who holds the other end does not matter. */
static int connection(const struct rig *rig, const char *text)
{
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons(rig->port),
                                        .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    const struct timeval bound = {.tv_sec = ANSWER_MS / 1000};
    int fd = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    assert_true(fd >= 0);
    setsockopt(fd, SOL_SOCKET, SO_SNDTIMEO, &bound, sizeof bound);
    assert_int_equal(connect(fd, (const struct sockaddr *)&address, sizeof address), 0);
    (void)!send(fd, text, strlen(text), MSG_NOSIGNAL);
    return fd;
}

/* What comes until `wanted` is in it, the other end closes, or ANSWER_MS are over. */
static void hear(int fd, const char *wanted, char *text, size_t size)
{
    int64_t until = now_ms() + ANSWER_MS;
    size_t length = 0;
    text[0] = '\0';
    while (length + 1 < size && !strstr(text, wanted)) {
        struct pollfd ready = {.fd = fd, .events = POLLIN};
        int64_t left = until - now_ms();
        if (left <= 0 || poll(&ready, 1, (int)left) <= 0)
            return;
        ssize_t got = recv(fd, text + length, size - 1 - length, 0);
        if (got <= 0)
            return;
        length += (size_t)got;
        text[length] = '\0';
    }
}

static void ask(const struct rig *rig, const char *request, const char *wanted, char *text,
                size_t size)
{
    int fd = connection(rig, request);
    hear(fd, wanted, text, size);
    close(fd);
}

static void crowd(struct rig *rig, size_t count, const char *text)
{
    for (size_t i = 0; i < count && rig->count < CROWD_MOST; i++)
        rig->crowd[rig->count++] = connection(rig, text);
}

static void disarm(struct rig *rig)
{
    char request[400], text[2000];
    static const char body[] = "{\"command\":\"disarm\"}";
    unsigned before = rig->disarmed;
    snprintf(request, sizeof request,
             "POST /command HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: "
             "application/json\r\nX-Matrig-Token: %s\r\nContent-Length: %zu\r\n\r\n%s",
             rig->token, sizeof body - 1, body);
    ask(rig, request, "{\"done\":true}", text, sizeof text);
    assert_non_null(strstr(text, "{\"done\":true}"));
    assert_int_equal(rig->disarmed, before + 1);
}

/* The page, its state and a command, within their bounds. */
static void it_serves(struct rig *rig)
{
    static char text[200000];
    ask(rig, "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", "</html>", text, sizeof text);
    assert_non_null(strstr(text, "</html>"));
    ask(rig, "GET /live.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", "  start();\n})();", text,
        sizeof text);
    assert_non_null(strstr(text, "  start();\n})();"));
    for (int i = 0; i < 3; i++)
        disarm(rig);
}

static int with_token(const struct rig *rig)
{
    char request[200];
    snprintf(request, sizeof request, "GET /events?token=%s HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
             rig->token);
    return connection(rig, request);
}

static const char anonymous[] = "GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n";

static void readers_that_never_read(void **state)
{
    struct rig *rig = *state;
    it_serves(rig);
    crowd(rig, 24, anonymous);
    it_serves(rig);
    crowd(rig, 176, anonymous);
    it_serves(rig);
}

static void senders_that_never_send(void **state)
{
    struct rig *rig = *state;
    crowd(rig, 200, "");
    it_serves(rig);
}

/* Each sends a byte more of its headers now and then: none of them is ever idle. */
static void *dribble(void *context)
{
    struct rig *rig = context;
    for (size_t i = 0; !rig->over; i = (i + 1) % rig->count) {
        (void)!send(rig->crowd[i], "x", 1, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (i == 0)
            usleep(5000);
    }
    return NULL;
}

static void senders_that_dribble(void **state)
{
    struct rig *rig = *state;
    pthread_t thread;
    crowd(rig, 200, "GET /events HTTP/1.1\r\nHost: 127.0.0.1\r\nX-Slow: ");
    assert_int_equal(pthread_create(&thread, NULL, dribble, rig), 0);
    it_serves(rig);
    rig->over = true;
    pthread_join(thread, NULL);
}

/* A command whose body does not come holds nobody up. */
static void half_a_command(void **state)
{
    struct rig *rig = *state;
    char half[300];
    snprintf(half, sizeof half,
             "POST /command HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: "
             "application/json\r\nX-Matrig-Token: %s\r\nContent-Length: 20\r\n\r\n{",
             "00000000000000000000000000000000");
    crowd(rig, 200, half);
    it_serves(rig);
}

/* The page of who has the token goes on while others come, in whatever number; and it finds a place
 * when they were first. */
static void who_has_the_token_watches(void **state)
{
    struct rig *rig = *state;
    static char text[100000];
    int before = with_token(rig);
    hear(before, "event: state", text, sizeof text);
    assert_non_null(strstr(text, "HTTP/1.1 200"));
    assert_non_null(strstr(text, "event: state"));
    crowd(rig, 200, anonymous);
    int after = with_token(rig);
    hear(after, "event: state", text, sizeof text);
    assert_non_null(strstr(text, "event: state"));
    for (int i = 0; i < 5; i++) {
        /* a state each 200 ms: it was not thrown out by those who came after it */
        hear(before, "event: state", text, sizeof text);
        assert_non_null(strstr(text, "event: state"));
    }
    close(before);
    close(after);
}

/* Places for who has none are few; the next one is told so in words, and has a place when one has
 * gone. */
static void who_finds_no_place_is_told(void **state)
{
    struct rig *rig = *state;
    static char text[100000];
    unsigned served = 0;
    for (int i = 0; i < 40; i++) {
        crowd(rig, 1, anonymous);
        hear(rig->crowd[rig->count - 1], "event: state", text, sizeof text);
        if (!strstr(text, "HTTP/1.1 200"))
            break;
        served++;
    }
    assert_in_range(served, 8, 24);
    assert_non_null(strstr(text, "HTTP/1.1 503"));
    assert_non_null(strstr(text, "open the address that matrig printed"));
    close(rig->crowd[0]);
    rig->crowd[0] = connection(rig, "");
    for (int i = 0; i < 50; i++) { /* that one has gone is seen with the next heartbeat */
        int fd = connection(rig, anonymous);
        hear(fd, "\r\n\r\n", text, sizeof text);
        close(fd);
        if (strstr(text, "HTTP/1.1 200"))
            return;
        usleep(100000);
    }
    fail_msg("no place in 5 s after one had gone");
}

/* ---- the rules alone, with a clock made by hand ---- */

struct sitter {
    int mine, theirs;
    struct seat *seat;
};

static struct sitter sit(struct seats *seats, int64_t at_ms)
{
    int pair[2];
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair), 0);
    return (struct sitter){pair[0], pair[1], seats_take(seats, pair[0], at_ms)};
}

/* Its end was shut: the other end reads the end of the stream, where else it would have to wait. */
static bool gave_way(const struct sitter *sitter)
{
    char byte;
    return recv(sitter->theirs, &byte, 1, MSG_DONTWAIT) == 0;
}

static struct sitter reader(struct seats *seats, bool token, int64_t at_ms, bool *may)
{
    struct sitter sitter = sit(seats, at_ms);
    assert_non_null(sitter.seat);
    seats_ask(seats, sitter.seat, token, at_ms);
    *may = seats_read(seats, sitter.seat, at_ms);
    return sitter;
}

static void leave(struct seats *seats, struct sitter *sitter)
{
    seats_leave(seats, sitter->seat);
    close(sitter->mine);
    close(sitter->theirs);
}

static void a_stalled_reader_gives_way(void **state)
{
    (void)state;
    struct seats *seats = seats_open();
    struct sitter readers[SEATS_READERS + 2];
    bool may;
    for (unsigned i = 0; i < SEATS_READERS; i++)
        readers[i] = reader(seats, false, 1000, &may);
    assert_true(may);
    for (unsigned i = 0; i < SEATS_READERS; i++)
        assert_true(i == 5 || seats_taken(seats, readers[i].seat, 1000 + SEATS_STALLED_MS));
    readers[SEATS_READERS] = reader(seats, false, 1000 + SEATS_STALLED_MS, &may);
    assert_false(may); /* the sixth has not stalled for long enough */
    readers[SEATS_READERS + 1] = reader(seats, false, 1001 + SEATS_STALLED_MS, &may);
    assert_true(may);
    for (unsigned i = 0; i < SEATS_READERS; i++)
        assert_int_equal(gave_way(&readers[i]), i == 5);
    assert_false(seats_taken(seats, readers[5].seat, 9999));
    for (unsigned i = 0; i < SEATS_READERS + 2; i++)
        leave(seats, &readers[i]);
    seats_close(seats);
}

static void of_one_s_own_the_oldest_gives_way(void **state)
{
    (void)state;
    struct seats *seats = seats_open();
    struct sitter readers[SEATS_OWN_READERS + 1];
    bool may = true;
    for (unsigned i = 0; i <= SEATS_OWN_READERS && may; i++)
        readers[i] = reader(seats, true, 1000 + i, &may);
    assert_true(may);
    for (unsigned i = 0; i <= SEATS_OWN_READERS; i++) {
        assert_int_equal(gave_way(&readers[i]), i == 0);
        leave(seats, &readers[i]);
    }
    seats_close(seats);
}

static void a_command_under_way_gives_way_to_nobody(void **state)
{
    (void)state;
    struct seats *seats = seats_open();
    struct sitter command = sit(seats, 1000), crowd_[3 * SEATS];
    unsigned shut = 0;
    seats_ask(seats, command.seat, true, 1001);
    for (unsigned i = 0; i < 3 * SEATS; i++) {
        crowd_[i] = sit(seats, 1002);
        assert_non_null(crowd_[i].seat);
    }
    assert_false(gave_way(&command));
    for (unsigned i = 0; i < 3 * SEATS; i++)
        shut += gave_way(&crowd_[i]);
    assert_int_equal(shut, 3 * SEATS + 1 - SEATS); /* all but those that have seats */
    assert_true(gave_way(&crowd_[0]));             /* the oldest first */
    assert_false(gave_way(&crowd_[3 * SEATS - 1]));
    leave(seats, &command);
    for (unsigned i = 0; i < 3 * SEATS; i++)
        leave(seats, &crowd_[i]);
    seats_close(seats);
}

static void time_is_over_for_each_in_its_way(void **state)
{
    (void)state;
    struct seats *seats = seats_open();
    bool may;
    struct sitter asks = sit(seats, 0), idle = sit(seats, 0), reads = reader(seats, false, 0, &may),
                  stalls = reader(seats, true, 0, &may);
    seats_ask(seats, idle.seat, false, 0);
    seats_answered(seats, idle.seat, 0);
    /* its headers came slowly: no time is won by that */
    seats_ask(seats, asks.seat, false, SEATS_ASK_MS - 1);
    seats_taken(seats, reads.seat, SEATS_DROPPED_MS - 1);
    seats_sweep(seats, SEATS_ASK_MS);
    assert_false(gave_way(&asks) || gave_way(&idle) || gave_way(&reads) || gave_way(&stalls));
    seats_sweep(seats, SEATS_ASK_MS + 1);
    assert_true(gave_way(&asks) && gave_way(&stalls));
    assert_false(gave_way(&idle) || gave_way(&reads));
    seats_sweep(seats, SEATS_IDLE_MS + 1);
    assert_true(gave_way(&idle));
    assert_false(gave_way(&reads));
    leave(seats, &asks);
    leave(seats, &idle);
    leave(seats, &reads);
    leave(seats, &stalls);
    seats_close(seats);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(readers_that_never_read, set_up, take_down),
        cmocka_unit_test_setup_teardown(senders_that_never_send, set_up, take_down),
        cmocka_unit_test_setup_teardown(senders_that_dribble, set_up, take_down),
        cmocka_unit_test_setup_teardown(half_a_command, set_up, take_down),
        cmocka_unit_test_setup_teardown(who_has_the_token_watches, set_up, take_down),
        cmocka_unit_test_setup_teardown(who_finds_no_place_is_told, set_up, take_down),
        cmocka_unit_test(a_stalled_reader_gives_way),
        cmocka_unit_test(of_one_s_own_the_oldest_gives_way),
        cmocka_unit_test(a_command_under_way_gives_way_to_nobody),
        cmocka_unit_test(time_is_over_for_each_in_its_way),
    };
    return cmocka_run_group_tests_name("host/live_seats", tests, NULL, NULL);
}
