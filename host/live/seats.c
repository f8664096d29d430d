#include "host/live/seats.h"

#include <pthread.h>
#include <stdlib.h>
#include <sys/socket.h>

enum doing { NOTHING, ASKING, READING };

struct seat {
    bool taken, leaving, token;
    int fd;
    enum doing doing;
    int64_t since_ms; /* it does so; a reader: it took something */
    uint64_t number;  /* of all that ever came: the least is the oldest */
};

struct seats {
    pthread_mutex_t lock;
    uint64_t came;
    struct seat seat[SEATS_CONNECTIONS];
};

struct seats *seats_open(void)
{
    struct seats *seats = calloc(1, sizeof *seats);
    if (seats)
        pthread_mutex_init(&seats->lock, NULL);
    return seats;
}

void seats_close(struct seats *seats)
{
    if (!seats)
        return;
    pthread_mutex_destroy(&seats->lock);
    free(seats);
}

/* ---- what follows is called locked ---- */

static void give_way(struct seat *seat)
{
    seat->leaving = true;
    shutdown(seat->fd, SHUT_RDWR);
}

static bool sits(const struct seat *seat)
{
    return seat->taken && !seat->leaving;
}

static unsigned count_of(const struct seats *seats)
{
    unsigned count = 0;
    for (unsigned i = 0; i < SEATS_CONNECTIONS; i++)
        count += sits(&seats->seat[i]);
    return count;
}

static unsigned readers_of(const struct seats *seats, bool token)
{
    unsigned count = 0;
    for (unsigned i = 0; i < SEATS_CONNECTIONS; i++)
        count += sits(&seats->seat[i]) && seats->seat[i].doing == READING &&
                 seats->seat[i].token == token;
    return count;
}

/* The one that came first of those that do nothing that is owed to them; NULL: there is none. */
static struct seat *oldest_idle(struct seats *seats)
{
    struct seat *oldest = NULL;
    for (unsigned i = 0; i < SEATS_CONNECTIONS; i++) {
        struct seat *seat = &seats->seat[i];
        if (sits(seat) && seat->doing != READING && !seat->token &&
            (!oldest || seat->number < oldest->number))
            oldest = seat;
    }
    return oldest;
}

/* The reader that has taken nothing for the longest; NULL: each has taken something since
 * `since_ms`. */
static struct seat *most_stalled(struct seats *seats, bool token, int64_t since_ms)
{
    struct seat *found = NULL;
    for (unsigned i = 0; i < SEATS_CONNECTIONS; i++) {
        struct seat *seat = &seats->seat[i];
        if (sits(seat) && seat->doing == READING && seat->token == token &&
            seat->since_ms < since_ms && (!found || seat->since_ms < found->since_ms))
            found = seat;
    }
    return found;
}

static struct seat *oldest_own_reader(struct seats *seats)
{
    struct seat *oldest = NULL;
    for (unsigned i = 0; i < SEATS_CONNECTIONS; i++) {
        struct seat *seat = &seats->seat[i];
        if (sits(seat) && seat->doing == READING && seat->token &&
            (!oldest || seat->number < oldest->number))
            oldest = seat;
    }
    return oldest;
}

static bool overdue(const struct seat *seat, int64_t now_ms)
{
    int64_t most_ms = seat->doing == READING ? SEATS_DROPPED_MS
                    : seat->doing == ASKING  ? SEATS_ASK_MS
                                             : SEATS_IDLE_MS;
    return sits(seat) && now_ms - seat->since_ms > most_ms;
}

/* ---- a connection ---- */

struct seat *seats_take(struct seats *seats, int fd, int64_t now_ms)
{
    struct seat *seat = NULL;
    pthread_mutex_lock(&seats->lock);
    struct seat *idle = count_of(seats) >= SEATS ? oldest_idle(seats) : NULL;
    if (idle)
        give_way(idle);
    for (unsigned i = 0; i < SEATS_CONNECTIONS && !seat && count_of(seats) < SEATS; i++)
        seat = seats->seat[i].taken ? NULL : &seats->seat[i];
    if (seat) /* no byte has come yet: it is expected to ask */
        *seat = (struct seat){
            .taken = true, .fd = fd, .doing = ASKING, .since_ms = now_ms, .number = seats->came++};
    pthread_mutex_unlock(&seats->lock);
    return seat;
}

void seats_leave(struct seats *seats, struct seat *seat)
{
    if (!seat)
        return;
    pthread_mutex_lock(&seats->lock);
    *seat = (struct seat){0};
    pthread_mutex_unlock(&seats->lock);
}

void seats_ask(struct seats *seats, struct seat *seat, bool token, int64_t now_ms)
{
    pthread_mutex_lock(&seats->lock);
    seat->token = token;
    /* a first request has been coming since the connection began */
    if (seat->doing != ASKING || token)
        seat->since_ms = now_ms;
    seat->doing = ASKING;
    pthread_mutex_unlock(&seats->lock);
}

void seats_answered(struct seats *seats, struct seat *seat, int64_t now_ms)
{
    pthread_mutex_lock(&seats->lock);
    seat->token = false;
    seat->doing = NOTHING;
    seat->since_ms = now_ms;
    pthread_mutex_unlock(&seats->lock);
}

bool seats_read(struct seats *seats, struct seat *seat, int64_t now_ms)
{
    pthread_mutex_lock(&seats->lock);
    bool full = readers_of(seats, seat->token) >= (seat->token ? SEATS_OWN_READERS : SEATS_READERS);
    struct seat *gives = full ? most_stalled(seats, seat->token, now_ms - SEATS_STALLED_MS) : NULL;
    if (full && !gives && seat->token)
        gives = oldest_own_reader(seats);
    if (gives)
        give_way(gives);
    bool may = !seat->leaving && (!full || gives);
    if (may) {
        seat->doing = READING;
        seat->since_ms = now_ms;
    }
    pthread_mutex_unlock(&seats->lock);
    return may;
}

bool seats_taken(struct seats *seats, struct seat *seat, int64_t now_ms)
{
    pthread_mutex_lock(&seats->lock);
    seat->since_ms = now_ms;
    bool stays = !seat->leaving;
    pthread_mutex_unlock(&seats->lock);
    return stays;
}

void seats_sweep(struct seats *seats, int64_t now_ms)
{
    pthread_mutex_lock(&seats->lock);
    for (unsigned i = 0; i < SEATS_CONNECTIONS; i++) {
        if (overdue(&seats->seat[i], now_ms))
            give_way(&seats->seat[i]);
    }
    pthread_mutex_unlock(&seats->lock);
}
