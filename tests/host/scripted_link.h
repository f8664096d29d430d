/* A link whose other end is a function of the test: what is sent is given to it, and it puts what
 * comes. Its clock is the test's too: each look that finds nothing takes SCRIPTED_LOOK_S. */
#ifndef MATRIG_TESTS_HOST_SCRIPTED_LINK_H
#define MATRIG_TESTS_HOST_SCRIPTED_LINK_H

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>

#include "common/catalogue.h"
#include "common/framing.h"
#include "host/link/link_ops.h"
#include "tests/host/scratch.h"

#define SCRIPTED_LOOK_S 0.01

struct scripted;
typedef void scripted_board(struct scripted *other_end, const struct mr_command *command);

struct scripted {
    struct link *link;
    scripted_board *board;                    /* NULL: silent */
    void (*idle)(struct scripted *other_end); /* nothing waits; NULL: nothing happens either */
    unsigned commands;                        /* that were sent */
    struct mr_command first, newest;
    uint8_t bytes[1u << 16]; /* serial, to be read */
    size_t start, end;
    struct link_frame frames[64]; /* CAN, to be read */
    size_t taken, put;
    bool closed;
    struct mr_deframer deframer;
    uint16_t seq;
};

static double scripted_now_s;

static inline double scripted_clock(void)
{
    return scripted_now_s;
}

static struct scripted *scripted_of[LINK_KINDS];

static inline void scripted_say(struct scripted *s, uint16_t id, const uint8_t *payload,
                                size_t length)
{
    if (s->link->kind == LINK_SERIAL) {
        s->end += mr_frame_encode(s->seq++, id, payload, length, s->bytes + s->end);
    } else {
        struct link_frame *frame = &s->frames[s->put++ % 64];
        *frame = (struct link_frame){.id = id, .length = (uint8_t)length};
        memcpy(frame->data, payload, length);
    }
}

#define SCRIPTED_SAY(s, name, ID, ...)                                                \
    do {                                                                              \
        uint8_t said_[MR_MESSAGE_BYTES_MAX];                                          \
        scripted_say(s, MR_ID_##ID, said_,                                            \
                     mr_##name##_put(&(const struct mr_##name){__VA_ARGS__}, said_)); \
    } while (0)

static inline bool scripted_empty(struct scripted *s)
{
    bool empty = s->link->kind == LINK_SERIAL ? s->start == s->end : s->taken == s->put;
    if (empty && s->idle)
        s->idle(s);
    empty = s->link->kind == LINK_SERIAL ? s->start == s->end : s->taken == s->put;
    if (empty && !s->closed)
        scripted_now_s += SCRIPTED_LOOK_S;
    return empty;
}

static inline ssize_t scripted_read(struct link *link, uint8_t *bytes, size_t size)
{
    struct scripted *s = scripted_of[link->kind];
    if (scripted_empty(s)) {
        errno = EAGAIN;
        return s->closed ? 0 : -1;
    }
    size_t count = s->end - s->start < size ? s->end - s->start : size;
    memcpy(bytes, s->bytes + s->start, count);
    s->start += count;
    if (s->start == s->end)
        s->start = s->end = 0;
    return (ssize_t)count;
}

static inline enum mr_status scripted_frame(struct link *link, struct link_frame *frame,
                                            struct error *error)
{
    struct scripted *s = scripted_of[link->kind];
    (void)error;
    if (scripted_empty(s))
        return s->closed ? MR_CLOSED : MR_TOO_FEW;
    *frame = s->frames[s->taken++ % 64];
    return MR_OK;
}

static inline void scripted_obey(struct scripted *s, const uint8_t *payload, size_t length)
{
    assert_int_equal(mr_command_get(&s->newest, payload, length), MR_OK);
    if (s->commands++ == 0)
        s->first = s->newest;
    if (s->board)
        s->board(s, &s->newest);
}

static inline enum mr_status scripted_send(struct link *link, const uint8_t *bytes, size_t length,
                                           struct error *error)
{
    struct scripted *s = scripted_of[link->kind];
    struct mr_frame frame;
    (void)error;
    if (link->kind == LINK_CAN) {
        assert_int_equal(bytes[0] | bytes[1] << 8, MR_ID_COMMAND);
        scripted_obey(s, bytes + 8, bytes[4]);
        return MR_OK;
    }
    for (size_t i = 0; i < length; i++) {
        if (mr_deframer_push(&s->deframer, bytes[i], &frame) == MR_OK &&
            frame.type == MR_ID_COMMAND)
            scripted_obey(s, frame.payload, frame.length);
    }
    return MR_OK;
}

static const struct link_ops scripted_ops = {.supported_kinds = 3,
                                             .receive_frame = scripted_frame,
                                             .read = scripted_read,
                                             .send = scripted_send};

/* As link_open makes one. The caller's dialogue closes it. */
static inline struct link *scripted_open(struct scripted *s, enum link_kind kind)
{
    struct link *link = calloc(1, sizeof *link);
    assert_non_null(link);
    *link = (struct link){.ops = &scripted_ops,
                          .syntax = "scripted:",
                          .kind = kind,
                          .spec = strdup(kind == LINK_CAN ? "scripted can" : "scripted")};
    link->fd = open("/dev/zero", O_RDONLY | O_CLOEXEC); /* always ready: waiting takes no time */
    assert_true(link->fd >= 0);
    pthread_mutex_init(&link->device_lock, NULL);
    pthread_mutex_init(&link->counters_lock, NULL);
    link_restart_counting(link, 0);
    *s = (struct scripted){.link = link};
    mr_deframer_init(&s->deframer);
    scripted_of[kind] = s;
    return link;
}

#endif
