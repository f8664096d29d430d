/* Who sits at the live page: a bounded number of connections, so shared out that who has the token
 * always gets through.
 *
 * Every connection takes a seat. A request with the token keeps the seat until the answer is out.
 * Else, when all seats are taken, the oldest connection that reads no events gives way: one that
 * sends no request, sends a request slowly, takes an answer slowly, or waits for the next request.
 * Readers of events have seats of their own, few for who has no token and some for who has one. A
 * reader that takes nothing for SEATS_STALLED_MS gives way to the next one; without any such reader
 * the next one without the token is refused, and the next one with the token takes the place of the
 * oldest with it.
 *
 * A connection gives way by shutdown(2): its thread sees the end and closes it. Times come in as
 * arguments, monotonic ms. All functions lock for themselves. */
#ifndef MATRIG_HOST_LIVE_SEATS_H
#define MATRIG_HOST_LIVE_SEATS_H

#include <stdbool.h>
#include <stdint.h>

#define SEATS             96u
#define SEATS_CONNECTIONS 400u /* with those that have given way and are not closed yet */
#define SEATS_READERS     16u  /* of events, without the token */
#define SEATS_OWN_READERS 8u   /* with the token: a browser's tabs */
/* for a request and its answer; for a command, which waits for the board 3 s */
#define SEATS_ASK_MS      10000
#define SEATS_IDLE_MS     15000 /* between two requests of a connection */
#define SEATS_STALLED_MS  3000  /* a reader gets something each second: it has not taken that */
/* a reader that takes nothing for so long is ended, wanted or not */
#define SEATS_DROPPED_MS  10000

struct seats;
struct seat;

struct seats *seats_open(void); /* NULL: no memory */
/* After the last seats_leave. NULL is allowed. */
void seats_close(struct seats *seats);

/* A seat for the connection `fd`, which stays the caller's; NULL: there is none. */
struct seat *seats_take(struct seats *seats, int fd, int64_t now_ms);
/* The connection ends: before `fd` is closed. */
void seats_leave(struct seats *seats, struct seat *seat);

/* A request begins, with the token or without; it is answered, to the last byte. */
void seats_ask(struct seats *seats, struct seat *seat, bool token, int64_t now_ms);
void seats_answered(struct seats *seats, struct seat *seat, int64_t now_ms);
/* The request is one for events. False: there is no place. */
bool seats_read(struct seats *seats, struct seat *seat, int64_t now_ms);
/* The reader has taken what it was sent. False: it has given way. */
bool seats_taken(struct seats *seats, struct seat *seat, int64_t now_ms);

/* Ends those whose time is over. Call it about once a second. */
void seats_sweep(struct seats *seats, int64_t now_ms);

#endif
