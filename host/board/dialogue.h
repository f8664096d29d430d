/* The dialogue with one board: its identity, commands and answers, waiting, and its other messages.
 *
 *     struct dialogue dialogue;
 *     struct mr_ack answer;
 *     const struct dialogue_command state = {.code = MR_COMMAND_STATE, .answer_timeout_s = 2,
 *                                            .tries_max = 3};
 *     status = dialogue_open(&dialogue, NULL, "serial:/dev/ttyUSB0", error);
 *     dialogue_subscribe(&dialogue, handle_message, client);
 *     status = dialogue_wait_for_hello(&dialogue, NULL, NULL, error);
 *     status = dialogue_send_command(&dialogue, &state, &answer, error);
 *     dialogue_close(&dialogue);
 *
 * Links. The dialogue owns its links from dialogue_open or dialogue_begin on; dialogue_close closes
 * them. Commands are sent over serial if there is a serial link, otherwise over CAN. Only the hello
 * and the answers on that link are used; messages of the other link go to subscribers. If a device
 * disappears, the link waits for its return (host/link/link.h).
 *
 * Time. Deadlines are in seconds of a monotonic clock. Received data is read before a deadline
 * applies, so that a suspended computer does not make the board appear silent.
 *
 * Errors. A function that returns MR_TIMEOUT leaves `error` unchanged, and the caller reports what
 * is missing. Only dialogue_wait_for_hello and the functions for error messages at the end of this
 * file set `error` for MR_TIMEOUT too. Every other failure sets `error`: MR_VERSION (a board with
 * another layout), MR_CLOSED (the board ended the link), MR_IO, or the status that a subscriber
 * returned.
 *
 * Threads. Only one thread at a time may use a dialogue. All waits are bounded. */
#ifndef MATRIG_HOST_BOARD_DIALOGUE_H
#define MATRIG_HOST_BOARD_DIALOGUE_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/framing.h"
#include "common/image.h"
#include "common/proof.h"
#include "host/base/error.h"
#include "host/link/link.h"

#define DIALOGUE_HELLO_TIMEOUT_S \
    10.0 /* time limit for a hello, which a board sends once a second */
/* time limit for an answer; the slowest command, a shunt calibration, takes 0.9 s */
#define DIALOGUE_ANSWER_TIMEOUT_S 10.0
/* upper limit for the duration of one call of dialogue_receive */
#define DIALOGUE_RECEIVE_MAX_S    0.1
#define DIALOGUE_SUBSCRIBERS_MAX  4u

/* Identity of a board and its image, from the hello and the messages that follow it once a
 * second. */
#define IDENTITY_UID_SIZE 25 /* 24 hexadecimal digits and the terminating zero */

struct identity {
    bool hello_known;
    struct mr_hello hello;
    uint32_t uid[3];
    bool image_known;   /* uid and image_crc are complete (their last words were received) */
    uint32_t image_crc; /* CRC of the program, as the board computed it at start */
    bool commit_known;  /* commit and header are known */
    struct mr_image_commit commit;
    struct mr_image_header header;
    bool board_known;
    /* type of the board (common/boards.def); received a little later than the other fields */
    uint8_t board_type;
    bool key_known;
    struct mr_bus_key key; /* states whether commands need a proof; received last */
    bool nonce_known;
    uint8_t nonce[MR_PROOF_BYTES]; /* newest nonce of the board, for the next proof */
};

/* Updates the identity from a message; messages of other kinds change nothing. */
void identity_receive(struct identity *identity, uint32_t id, const uint8_t *bytes, size_t length);
/* Returns MR_OK if the board uses this matrig's layout, otherwise MR_VERSION. `spec`: its link, for
 * the error. */
enum mr_status identity_check_layout(const struct identity *identity, const char *spec,
                                     struct error *error);
void identity_uid_text(const struct identity *identity, char out[IDENTITY_UID_SIZE]);
/* Returns true if the board runs this image and the image is complete. Otherwise `why` describes
 * the difference. */
bool identity_is_running(const struct identity *identity, const struct mr_image *image, char *why,
                         size_t size);

/* One message of a board: a serial frame or a CAN data frame. */
struct dialogue_message {
    enum link_kind kind;    /* the link on which it arrived */
    uint32_t id;            /* MR_ID_... */
    uint16_t seq;           /* number of a serial frame; 0 on CAN */
    const uint8_t *payload; /* valid until the subscriber returns */
    size_t length;
    uint64_t host_us; /* Unix time of reception, microseconds */
};

/* Receives one message. A status other than MR_OK ends the current wait with that status; the
 * function must have set `error`. It must not wait or send commands. */
typedef enum mr_status dialogue_handler(void *context, const struct dialogue_message *message,
                                        struct error *error);

/* Returns true when the awaited data has arrived. Called after each reception; it must not have
 * side effects. */
typedef bool dialogue_condition(const void *context);

struct dialogue {
    /* built from the board's messages about itself, since the beginning or since dialogue_reset */
    struct identity identity;
    /* set while flashing: a board with another message layout is accepted too */
    bool accepts_any_layout;
    double (*now_s)(void); /* the monotonic clock; a test may replace it */

    /* the next fields are private */
    struct link *link[LINK_KINDS];
    enum link_kind kind; /* link over which commands are sent */
    struct mr_deframer deframer;
    uint16_t seq, tag;
    struct {
        dialogue_handler *handle;
        void *context;
    } subscriber[DIALOGUE_SUBSCRIBERS_MAX];
    unsigned subscriber_count;
    bool is_awaiting_answer, is_answered;
    /* before the answer arrives: code and tag of the command; then the answer */
    struct mr_ack answer;
};

/* Opens the links. `can` and `serial` are LINK texts; NULL: not used; at least one is required.
 * After a failure nothing is open. */
enum mr_status dialogue_open(struct dialogue *dialogue, const char *can, const char *serial,
                             struct error *error);
/* As dialogue_open, for a command that needs one dialogue until the program ends: any failure ends
 * the program, and the dialogue is closed at exit. */
struct dialogue *dialogue_open_for_command(const char *can, const char *serial);
/* As dialogue_open, with open links; the dialogue takes ownership of them. */
void dialogue_begin(struct dialogue *dialogue, struct link *can, struct link *serial);
/* Closes the links. Does nothing if the dialogue is all zero or closed. */
void dialogue_close(struct dialogue *dialogue);

/* Return the link over which commands are sent, and its name. The dialogue owns both. */
struct link *dialogue_link(const struct dialogue *dialogue);
const char *dialogue_spec(const struct dialogue *dialogue);
/* Returns the time of the clock that deadlines use, s. */
double dialogue_now_s(const struct dialogue *dialogue);

/* Calls `handle` for every later message, after the dialogue has processed it and after earlier
 * subscribers. `context` belongs to the caller and must exist as long as the dialogue is used. At
 * most DIALOGUE_SUBSCRIBERS_MAX subscribers. */
void dialogue_subscribe(struct dialogue *dialogue, dialogue_handler *handle, void *context);
/* Resets the identity, which the board must then send again. Call it when the board restarts or
 * another board is expected. */
void dialogue_reset(struct dialogue *dialogue);

/* Sets the CAN base that the board uses from now on (common/canbase.h). */
void dialogue_set_base(struct dialogue *dialogue, uint16_t base);

/* Reads messages for at most `timeout_s`, and never longer than DIALOGUE_RECEIVE_MAX_S. Returns
 * MR_OK even if no message arrives. For callers that also wait for other inputs. */
enum mr_status dialogue_receive(struct dialogue *dialogue, double timeout_s, struct error *error);
/* Reads the board's messages until `done` returns true, for at most `within_s`. MR_TIMEOUT: it did
 * not return true in time. */
enum mr_status dialogue_wait_until(struct dialogue *dialogue, dialogue_condition *done,
                                   const void *context, double within_s, struct error *error);
/* As dialogue_wait_until, but the limit `within_s` starts again whenever `*progress` has changed.
 * For answers that consist of many messages. */
enum mr_status dialogue_wait_while_receiving(struct dialogue *dialogue, dialogue_condition *done,
                                             const void *context, const size_t *progress,
                                             double within_s, struct error *error);
/* A `done` function for a `bool` that a subscriber sets. */
bool dialogue_is_flag_set(const void *flag);
/* Reads messages until the board's hello has arrived and `done` returns true (NULL: only the
 * hello), for at most DIALOGUE_HELLO_TIMEOUT_S. MR_TIMEOUT or MR_IO: no hello; `error` describes
 * what was received instead, with advice. */
enum mr_status dialogue_wait_for_hello(struct dialogue *dialogue, dialogue_condition *done,
                                       const void *context, struct error *error);
/* Reads messages until the board has sent its identity and that of its image, for at most
 * `within_s`. Returns MR_OK also without the commit, which older firmware does not send.
 * MR_TIMEOUT: not received in time. */
enum mr_status dialogue_wait_for_identity(struct dialogue *dialogue, double within_s,
                                          struct error *error);

/* A command to the board: one message `command` (common/command.h). Its answer is the ack with the
 * same code and tag. Each command has a new tag, so that a command of another program is unlikely
 * to have the same one. The first answer is used; later answers are ignored.
 *
 * If no answer arrives, either the command or the answer was lost. A command that may be executed
 * twice (dialogue_is_repeatable_command) is sent again with the same tag, and an answer to either
 * copy is accepted. Any other command is sent once, whatever `tries_max` is, because the board
 * would refuse, for example, to arm a second time. Instead, `was_executed` decides from the board's
 * state whether the command was executed. */
struct dialogue_command {
    uint8_t code; /* MR_COMMAND_... */
    uint8_t index;
    int32_t argument;
    double answer_timeout_s; /* time limit for the answer to each try */
    unsigned tries_max;      /* 0: one try */
    /* NULL: the board's state does not show whether the command was executed */
    dialogue_condition *was_executed;
    const void *context; /* context of `was_executed` */
};

/* Sends a command and waits for its answer. MR_OK: `answer->status` is the board's answer; it is
 * MR_OK too if `was_executed` shows that the command was executed. MR_TIMEOUT: the answer was lost,
 * and it is not known whether the command was executed. */
enum mr_status dialogue_send_command(struct dialogue *dialogue,
                                     const struct dialogue_command *request, struct mr_ack *answer,
                                     struct error *error);
/* True if executing the command twice has the same effect as once, so that it may be sent again. */
bool dialogue_is_repeatable_command(unsigned code);
/* Returns the tag of the last command, for messages that refer to it. */
uint16_t dialogue_tag(const struct dialogue *dialogue);
/* Makes a new tag, for messages that are not commands. */
uint16_t dialogue_next_tag(struct dialogue *dialogue);
/* Sends a message that the board does not answer. */
enum mr_status dialogue_send(struct dialogue *dialogue, uint16_t id, const uint8_t *payload,
                             size_t length, struct error *error);

/* Standard error messages and their statuses: no board answered (MR_TIMEOUT, MR_IO); the board did
 * not answer a command (MR_TIMEOUT); the board refused a command. `not_now` is the advice for
 * MR_NOT_NOW; NULL: the general advice. */
enum mr_status dialogue_set_no_hello_error(const struct dialogue *dialogue, struct error *error);
enum mr_status dialogue_set_no_answer_error(const struct dialogue *dialogue, unsigned code,
                                            struct error *error);
enum mr_status dialogue_set_refusal_error(const struct dialogue *dialogue,
                                          const struct mr_ack *answer, const char *not_now,
                                          struct error *error);
/* Sends a command and sets one of the standard error messages if it fails. MR_OK: the board
 * executed the command. */
enum mr_status dialogue_execute(struct dialogue *dialogue, const struct dialogue_command *request,
                                const char *not_now, struct error *error);

#endif
