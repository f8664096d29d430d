/* The collector: understands what comes over the links of one session and puts it into the campaign
 * database.
 *
 * CAN frames and serial bytes go in as they come; the two links need not be in step. A landing
 * begins when serial reports it armed (or, when logging joined late, later), or CAN where serial is
 * silent, and ends when it is reported done or given up. Before the first hello frames are kept but
 * not understood; a hello of another layout is refused.
 *
 * Serial is the record while it sent something within the last second of board time. CAN is kept
 * raw then, and fills what serial lost when the landing is over. Where serial is silent CAN is the
 * record; others may speak there by the board's identifiers, so what it says must go on from what
 * it said before.
 *
 * A board that begins again starts another boot of its links: a landing that was open ends there,
 * and the event `restart` names it, with the cause of the reset in `detail`. Frames after a hello
 * on CAN, or after a loss on serial, wait until a time says which boot they are of.
 *
 * The caller holds a store transaction open around every call that may write, and commits in
 * time. */
#ifndef MATRIG_HOST_COLLECT_H
#define MATRIG_HOST_COLLECT_H

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/health_client.h"
#include "host/link/link.h"
#include "host/store/store.h"

struct collector;

/* `can_spec`, `serial_spec`: the links as given, NULL when not used; they must outlive the
 * collector. `can_base`: where the board is on CAN (common/canbase.h); the campaign keeps frames by
 * the identifiers of the catalogue, and the base beside. Adds the session. */
enum mr_status collector_open(struct store *store, const char *can_spec, uint16_t can_base,
                              const char *serial_spec, struct collector **collector,
                              struct error *error);
void collector_close(struct collector *collector); /* NULL is allowed; writes nothing */

/* Frames as they are on the bus. MR_VERSION: a board of another layout; MR_IO: another board than
 * before, on serial, or on CAN and nobody else. Both ask for a new log. Broken and foreign frames
 * are counted, not errors. */
enum mr_status collector_frame(struct collector *collector, const struct link_frame *frame,
                               struct error *error);
enum mr_status collector_bytes(struct collector *collector, const uint8_t *bytes, size_t length,
                               uint64_t host_us, struct error *error);
/* What a link has counted so far, troubles above all: those that are new are accounted, and
 * recorded at the next collector_put_counts. Call it before what came after them goes in. */
enum mr_status collector_troubles(struct collector *collector, enum link_kind kind,
                                  const struct link_counters *counters, struct error *error);
/* This computer's clock was set, by `jump_us`: an event `clock-set`; where the board's clock is
 * against it is found anew. */
enum mr_status collector_clock_set(struct collector *collector, int64_t jump_us,
                                   struct error *error);
/* A link ended. MR_TRUNCATED: inside a serial frame. */
enum mr_status collector_link_end(struct collector *collector, enum link_kind kind,
                                  struct error *error);
/* Of one link: where the board's clock is against this computer's is found anew, from what comes
 * from now on. */
void collector_forget_time(struct collector *collector, enum link_kind kind);

/* Where a transaction begins, and back there when the store took back what was written since: the
 * same may then go in again. */
enum mr_status collector_mark(struct collector *collector, struct error *error);
void collector_back_to_mark(struct collector *collector);
/* From now on into this store, which has all that was committed to the one before. Between two
 * transactions. */
void collector_move(struct collector *collector, struct store *store);
/* A new session of the same links in another store; what came is put in again. Not `whole`: not
 * from the beginning on, so it begins with what the board has said of itself so far. `goes_on`:
 * nothing again, it begins within the frame that the one before ended in. */
enum mr_status collector_again(const struct collector *before, struct store *store, bool whole,
                               bool goes_on, struct collector **collector, struct error *error);
/* The session ends: landings still open are closed as they are, losses settled. `ended_by`: "end",
 * "time", "signal" ... */
enum mr_status collector_end(struct collector *collector, const char *ended_by,
                             struct error *error);

/* Write the session's counts and troubles so far. */
enum mr_status collector_put_counts(struct collector *collector, struct error *error);

/* The board has said by which configuration it works, that one is not in the database, and it may
 * be asked for it. */
bool collector_lacks_configuration(const struct collector *collector);

/* RUN of a landing that has ended since the last call; 0: none. */
int64_t collector_take_finished(struct collector *collector);
/* A processor fault that the board told of, since the last call; NULL: none. */
const struct crash_report *collector_take_crash(struct collector *collector);
/* The state of CAN as the board sees it, when it has changed since the last call; NULL: not. */
const struct mr_can_alarm *collector_take_alarm(struct collector *collector);
/* Commands that this program gave, by which the board's answers are known as its own or as those to
 * another. Kept by who gives them: the collector may go back to a mark. */
#define COLLECTOR_OWN 16u
struct collector_own {
    struct {
        uint8_t code;
        uint16_t tag;
        int64_t block; /* of the answer; -1: none yet. A second answer is to another's repetition */
    } order[COLLECTOR_OWN];
    unsigned next;
};
void collector_own_put(struct collector_own *own, const struct mr_command *command);
/* Without it, as of what was recorded before, nobody knows who gave them: nothing is told, and the
 * events have no value. */
void collector_set_own(struct collector *collector, struct collector_own *own);

/* An answer of the board to a command that does more than read: obeyed, or refused by ack.status.
 * Each is an event `order`, its value 1 own, 0 another's. The same answer again within a second is
 * counted. */
struct collector_order {
    struct mr_ack ack;
    bool own;
    unsigned more; /* of the same before, that were only counted */
};
/* The oldest that nobody has asked for yet, of the newest eight; false: none. */
bool collector_take_order(struct collector *collector, struct collector_order *order);

struct collector_progress {
    bool hello;     /* a board of the right layout has spoken */
    int64_t run;    /* landing going on; 0: none */
    unsigned state; /* last state reported */
    int64_t block;  /* newest on either link; -1: none */
    unsigned edges; /* of the landing going on */
    /* what the board says of itself; "": not yet; NULL: not yet */
    const char *board_uid, *firmware;
    const struct mr_landing *landing;
    const struct mr_bus_key *key; /* whether orders need a proof, */
    const uint8_t *nonce;         /* what that is made of; MR_PROOF_BYTES */
    const uint32_t *uid;
    struct store_link_counts counts[LINK_KINDS];
    int64_t missing[LINK_KINDS][MR_PLACES]; /* of each message, by the board's counts */
    int64_t before_first; /* CAN frames sent before logging began; -1: not known */
    bool other_on_can; /* on CAN at this base is another board than on serial, and this one never */
    char can_uid[17], serial_uid[17]; /* words 0 and 1 of their identities, then */
};
void collector_progress(const struct collector *collector, struct collector_progress *progress);

/* A message of the board, as it is told to who listens. */
struct collector_event {
    enum link_kind link;
    const struct mr_message *message;
    uint64_t host_us;
    int64_t board_us; /* STORE_NONE: not known */
};
/* Who else wants to know what comes, as it comes: messages, and block records with the time of this
 * computer. The campaign listens in any case. `listener` must outlive the collector; NULL:
 * nobody. */
struct collector_listener {
    void (*message)(void *context, const struct collector_event *event);
    void (*record)(void *context, const struct mr_block *block, uint64_t host_us);
    void *context;
};
void collector_listen(struct collector *collector, const struct collector_listener *listener);

/* The link that is behind the other in board time, its starts counted. */
enum link_kind collector_behind(const struct collector *collector);
int64_t collector_session(const struct collector *collector);

#endif
