/* A hand-made board's output, logged into a fresh database without processes: for tests of
 * collector and analysis. */
#ifndef MATRIG_TESTS_HOST_SESSION_H
#define MATRIG_TESTS_HOST_SESSION_H

#include "host/collect/collect.h"
#include "tests/host/scratch.h"
#include "tests/host/stream.h"

struct session {
    struct stream stream;
    char *can; /* candump text */
    size_t can_length;
    char *serial;
    size_t serial_length;
    struct store *store;
    struct collector *collector;
    struct error error;
};

/* Begin to write on the links that are wanted. */
static inline void session_begin(struct session *session, bool can, bool serial)
{
    memset(session, 0, sizeof *session);
    session->stream.host_us = 1700000000000000u;
    if (can)
        session->stream.can = open_memstream(&session->can, &session->can_length);
    if (serial)
        session->stream.serial = open_memstream(&session->serial, &session->serial_length);
}

static inline void session_feed_line(struct session *session, const char **at)
{
    struct link_frame frame;
    const char *end = strchr(*at, '\n');
    assert_non_null(end);
    assert_int_equal(candump_parse(*at, (size_t)(end - *at), &frame), MR_OK);
    *at = end + 1;
    collector_receive_frame(session->collector, &frame, &session->error);
}

/* Log all that was written, the links in step as `matrig log` keeps them. Stops at the first
 * error. */
static inline void session_log(struct session *session, const char *db)
{
    char path[200];
    if (session->stream.can)
        fclose(session->stream.can);
    if (session->stream.serial)
        fclose(session->stream.serial);
    struct error *error = &session->error;
    store_open(scratch_path(path, sizeof path, db), STORE_CREATE, &session->store, error);
    store_begin(session->store, error);
    collector_open(session->store, session->can ? "file:can" : NULL, 0,
                   session->serial ? "file:serial" : NULL, &session->collector, error);
    assert_no_error(error);
    const char *can = session->can;
    size_t serial = 0;
    while (error->status == MR_OK) {
        bool can_left = can && *can;
        bool serial_left = serial < session->serial_length;
        if (!can_left && !serial_left)
            break;
        if (can_left &&
            (!serial_left || collector_get_lagging_link(session->collector) == LINK_CAN)) {
            session_feed_line(session, &can);
        } else {
            size_t length = session->serial_length - serial < 100 ? session->serial_length - serial
                                                                  : 100;
            collector_receive_bytes(session->collector, (const uint8_t *)session->serial + serial,
                                    length, 1700000000000000u, error);
            serial += length;
        }
    }
    if (error->status == MR_OK && session->can)
        collector_end_link(session->collector, LINK_CAN, error);
    if (error->status == MR_OK && session->serial)
        collector_end_link(session->collector, LINK_SERIAL, error);
    struct error late = {0};
    collector_end(session->collector, "end", &late);
    store_commit(session->store, &late);
    assert_no_error(&late);
}

static inline void session_end(struct session *session)
{
    collector_close(session->collector);
    store_close(session->store);
    free(session->can);
    free(session->serial);
}

#endif
