/* The dialogue with one board: its identity, orders and answers, waiting, and its other messages.
 *
 *     struct dialogue dialogue;
 *     struct mr_ack answer;
 *     const struct dialogue_order order = {.code = MR_COMMAND_STATE, .answer_s = 2.0, .tries = 3};
 *     status = dialogue_open(&dialogue, NULL, "serial:/dev/ttyUSB0", error);
 *     dialogue_subscribe(&dialogue, take, talk);
 *     status = dialogue_hello(&dialogue, NULL, NULL, error);
 *     status = dialogue_order(&dialogue, &order, &answer, error);
 *     dialogue_close(&dialogue);
 *
 * Links. The dialogue owns its links from dialogue_open or dialogue_begin on; dialogue_close closes
 * them. Orders go over serial when there is a serial link, else over CAN. Hello and answers count
 * on the link of the orders alone; messages of the other link go to subscribers. A lost device is
 * waited for, see host/link/link.h.
 *
 * Time. Deadlines are seconds of a clock that is never set. Received data is read before a deadline
 * applies, so that a suspended computer does not make the board look silent.
 *
 * Errors. A function that returns MR_TIMEOUT leaves `error` unchanged: the caller reports what is
 * missing. Only dialogue_hello, and the sentences at the end of this file, set `error` for
 * MR_TIMEOUT too. Every other failure sets `error`: MR_VERSION (a board of another layout),
 * MR_CLOSED (the board ended the link), MR_IO, or what a subscriber returned.
 *
 * Threads. One thread at a time uses a dialogue. No function waits without a bound. */
#ifndef MATRIG_HOST_BOARD_DIALOGUE_H
#define MATRIG_HOST_BOARD_DIALOGUE_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/framing.h"
#include "common/image.h"
#include "common/proof.h"
#include "host/base/error.h"
#include "host/link/link.h"

#define DIALOGUE_HELLO_S     10.0 /* a board sends a hello once a second */
#define DIALOGUE_ANSWER_S    10.0 /* the longest order, a shunt calibration, takes 0.9 s */
#define DIALOGUE_TURN_S      0.1  /* of one turn at most */
#define DIALOGUE_SUBSCRIBERS 4u

/* A board's messages about itself and its image: hello and those after it, once a second. */
#define IDENTITY_UID_TEXT 25 /* 24 hexadecimal digits */

struct identity {
    bool hello_known;
    struct mr_hello hello;
    uint32_t uid[3];
    bool image_known;   /* the last word of uid, and the next */
    uint32_t image_crc; /* of the program, as the board computed it at start */
    bool commit_known;  /* it sent these two as well */
    struct mr_image_commit commit;
    struct mr_image_header header;
    bool board_known;
    uint8_t board; /* common/boards.def; sent a little later than the rest */
    bool key_known;
    struct mr_bus_key key; /* whether orders need a proof; sent last */
    bool nonce_known;
    uint8_t nonce[MR_PROOF_BYTES]; /* the newest */
};

/* Takes a message in; those of other kinds change nothing. */
void identity_take(struct identity *identity, uint32_t id, const uint8_t *bytes, size_t length);
/* MR_OK: the board uses this matrig's layout; else MR_VERSION. `spec`: its link. */
enum mr_status identity_speaks(const struct identity *identity, const char *spec,
                               struct error *error);
void identity_uid_text(const struct identity *identity, char out[IDENTITY_UID_TEXT]);
/* Does the board run this image, complete? Otherwise `why` describes the difference. */
bool identity_runs(const struct identity *identity, const struct mr_image *image, char *why,
                   size_t size);

/* One message of a board: a frame of serial, or a data frame of CAN. */
struct dialogue_message {
    enum link_kind kind;    /* the link on which it arrived */
    uint32_t id;            /* MR_ID_... */
    uint16_t seq;           /* of a serial frame; 0 on CAN */
    const uint8_t *payload; /* until the subscriber returns */
    size_t length;
    uint64_t host_us; /* Unix time of reception */
};

/* Takes one message. Anything but MR_OK ends the wait that is under way, with that status; it sets
 * `error` then. It must not wait or order itself. */
typedef enum mr_status dialogue_take(void *context, const struct dialogue_message *message,
                                     struct error *error);

/* Whether what is waited for has come. Is asked after each turn: it has no effect. */
typedef bool dialogue_done(const void *context);

struct dialogue {
    /* the board's messages about itself since the beginning, or since dialogue_forget */
    struct identity identity;
    bool any_layout;       /* set by who flashes: a board of another layout is spoken with too */
    double (*now_s)(void); /* the clock; a test may put its own */

    /* private */
    struct link *link[LINK_KINDS];
    enum link_kind kind; /* over which orders go */
    struct mr_deframer deframer;
    uint16_t seq, tag;
    struct {
        dialogue_take *take;
        void *context;
    } subscriber[DIALOGUE_SUBSCRIBERS];
    unsigned subscribers;
    bool asking, answered;
    struct mr_ack answer; /* awaited: of this code and tag; then the answer */
};

/* Opens the links: LINK texts, NULL: not used, one at least. On failure nothing is open. */
enum mr_status dialogue_open(struct dialogue *dialogue, const char *can, const char *serial,
                             struct error *error);
/* The same for a command that runs once and has one dialogue: what fails ends the program, and the
 * dialogue is closed at its end. */
struct dialogue *dialogue_of_command(const char *can, const char *serial);
/* The same with links that are open, which it takes over. */
void dialogue_begin(struct dialogue *dialogue, struct link *can, struct link *serial);
/* Of a dialogue that is all zero, or closed, it does nothing. */
void dialogue_close(struct dialogue *dialogue);

/* The link over which orders go, and its name. The dialogue's. */
struct link *dialogue_link(const struct dialogue *dialogue);
const char *dialogue_spec(const struct dialogue *dialogue);
/* By the clock of the deadlines. */
double dialogue_now_s(const struct dialogue *dialogue);

/* From now on `take` is called for every message, after the dialogue itself and the subscribers
 * before. `context` is the caller's, and lives as long as the dialogue is used.
 * DIALOGUE_SUBSCRIBERS at most. */
void dialogue_subscribe(struct dialogue *dialogue, dialogue_take *take, void *context);
/* The board restarts, or another one is expected: its identity must be sent again. */
void dialogue_forget(struct dialogue *dialogue);

/* The board has another base on CAN from now on (common/canbase.h). */
void dialogue_move(struct dialogue *dialogue, uint16_t base);

/* Reads messages within `most_s`, and DIALOGUE_TURN_S; MR_OK also when there are none. For callers
 * that watch something else as well. */
enum mr_status dialogue_turn(struct dialogue *dialogue, double most_s, struct error *error);
/* Hears the board until `done`, at most `within_s`. MR_OK: done; MR_TIMEOUT. */
enum mr_status dialogue_until(struct dialogue *dialogue, dialogue_done *done, const void *context,
                              double within_s, struct error *error);
/* The same, and `within_s` begins again whenever `*progress` has changed: for answers of many
 * messages. */
enum mr_status dialogue_while_coming(struct dialogue *dialogue, dialogue_done *done,
                                     const void *context, const size_t *progress, double within_s,
                                     struct error *error);
/* `done` of a `bool` that a subscriber sets. */
bool dialogue_flag(const void *flag);
/* Reads messages until the board's hello and `done` (NULL: the hello alone), at most
 * DIALOGUE_HELLO_S. MR_TIMEOUT or MR_IO: no hello; `error` describes what was received instead,
 * with advice. */
enum mr_status dialogue_hello(struct dialogue *dialogue, dialogue_done *done, const void *context,
                              struct error *error);
/* Reads messages until the board has sent its identity and its image's, at most `within_s`. MR_OK
 * also without the commit, as from an older firmware; MR_TIMEOUT. */
enum mr_status dialogue_who(struct dialogue *dialogue, double within_s, struct error *error);

/* An order: one message `command` (common/command.h). Its answer is the ack of its code and its
 * tag; each order has a tag of its own, which the order of another program hardly has. The first
 * answer counts; later ones are ignored.
 *
 * When no answer comes, the order or the answer is lost. An order that may be carried out twice
 * (dialogue_repeats) is sent again, with the same tag: an answer to either is its answer. Any other
 * order is sent once, whatever `tries` says; a second arming would be refused because of the first.
 * The board's state is used instead: `taken` decides whether it shows that the order was carried
 * out. */
struct dialogue_order {
    uint8_t code; /* MR_COMMAND_... */
    uint8_t index;
    int32_t argument;
    double answer_s;      /* for the answer to each try */
    unsigned tries;       /* 0: one */
    dialogue_done *taken; /* NULL: the state does not show it */
    const void *context;  /* of `taken` */
};

/* MR_OK: `answer->status` is what the board answered, MR_OK too when `taken` shows it. MR_TIMEOUT:
 * lost, and not known to be done. */
enum mr_status dialogue_order(struct dialogue *dialogue, const struct dialogue_order *order,
                              struct mr_ack *answer, struct error *error);
/* Whether the order of this code, done twice, is the same as done once, so that it may be sent
 * again. */
bool dialogue_repeats(unsigned code);
/* The tag of the last order, for messages that name it. */
uint16_t dialogue_tag(const struct dialogue *dialogue);
/* A new one, for messages that are no order. */
uint16_t dialogue_next_tag(struct dialogue *dialogue);
/* Sends a message that the board does not answer. */
enum mr_status dialogue_send(struct dialogue *dialogue, uint16_t id, const uint8_t *payload,
                             size_t length, struct error *error);

/* The usual sentences, and their status: no board answered (MR_TIMEOUT, MR_IO); the board did not
 * answer an order (MR_TIMEOUT); the board refused it, where `not_now` is the advice for MR_NOT_NOW
 * (NULL: as for any other). */
enum mr_status dialogue_no_hello(const struct dialogue *dialogue, struct error *error);
enum mr_status dialogue_lost(const struct dialogue *dialogue, unsigned code, struct error *error);
enum mr_status dialogue_refused(const struct dialogue *dialogue, const struct mr_ack *answer,
                                const char *not_now, struct error *error);
/* An order and these sentences. MR_OK: the board did it. */
enum mr_status dialogue_obey(struct dialogue *dialogue, const struct dialogue_order *order,
                             const char *not_now, struct error *error);

#endif
