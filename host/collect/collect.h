/* The collector: decodes the data from the links of one session and stores it in the campaign
 * database.
 *
 * CAN frames and serial bytes are passed in as they arrive; the two links need not be synchronous.
 * A landing begins when serial reports it as armed (or in a later state, if logging started late).
 * If serial is silent, CAN is used instead. It ends when it is reported as done or aborted. Frames
 * before the first hello are stored but not decoded; a hello with another layout is refused.
 *
 * Serial is the record as long as it has sent data within the last second of board time. CAN is
 * then only stored as raw frames, which are used after the landing to fill gaps in the serial data.
 * If serial is silent, CAN is the record. Other nodes may use the board's identifiers on CAN, so
 * CAN data must continue from earlier CAN data.
 *
 * When a board restarts, a new boot of its links begins. An open landing ends there, and the event
 * `restart` has the landing and, in `detail`, the cause of the reset. Frames after a hello on CAN,
 * or after a loss on serial, wait until a board time shows to which boot they belong.
 *
 * The caller holds a store transaction open around every call that may write, and commits it in
 * time. */
#ifndef MATRIG_HOST_COLLECT_H
#define MATRIG_HOST_COLLECT_H

#include "common/block.h"
#include "common/catalogue.h"
#include "host/board/health_client.h"
#include "host/link/link.h"
#include "host/store/store.h"

struct collector;

/* Adds a session. `can_spec`, `serial_spec`: LINK texts as given, NULL if not used; they must
 * outlive the collector. `can_base`: the board's base on CAN (common/canbase.h); the campaign
 * stores frames with the identifiers of the catalogue, and the base separately. */
enum mr_status collector_open(struct store *store, const char *can_spec, uint16_t can_base,
                              const char *serial_spec, struct collector **collector,
                              struct error *error);
void collector_close(struct collector *collector); /* does not write anything; NULL is allowed */

/* Process received frames. MR_VERSION: a board with another layout. MR_IO: another board than
 * before sends on serial, or on CAN while the known board is silent. Both statuses require a new
 * log. Damaged frames and frames of other nodes are counted and are not errors. */
enum mr_status collector_receive_frame(struct collector *collector, const struct link_frame *frame,
                                       struct error *error);
enum mr_status collector_receive_bytes(struct collector *collector, const uint8_t *bytes,
                                       size_t length, uint64_t host_us, struct error *error);
/* Reads the error counters of a link; new errors are recorded at the next collector_store_counts.
 * Call it before passing in data that was received after the errors. */
enum mr_status collector_count_link_faults(struct collector *collector, enum link_kind kind,
                                           const struct link_counters *counters,
                                           struct error *error);
/* Handles a change of this computer's clock by `jump_us`: records an event `clock-set` and starts a
 * new estimate of the offset between the board's clock and this computer's. */
enum mr_status collector_handle_clock_jump(struct collector *collector, int64_t jump_us,
                                           struct error *error);
/* Handles the end of a link. MR_TRUNCATED: the link ended inside a serial frame. */
enum mr_status collector_end_link(struct collector *collector, enum link_kind kind,
                                  struct error *error);
/* Discards the estimated clock offset of one link between board and computer; it is estimated again
 * from later data. */
void collector_discard_clock_offset(struct collector *collector, enum link_kind kind);

/* collector_save_state saves the state at the start of a transaction. collector_restore_state
 * restores it after the store has rolled the transaction back, so that the same data can be passed
 * in again. */
enum mr_status collector_save_state(struct collector *collector, struct error *error);
void collector_restore_state(struct collector *collector);
/* Continues with another store, which contains everything that was committed to the previous one.
 * Call it between two transactions. */
void collector_set_store(struct collector *collector, struct store *store);
/* Opens a new session of the same links in another store. `has_all_data`: all data since the
 * beginning is passed in again; otherwise the session starts with the identity and state that the
 * board has reported so far. `continues_frame`: no data is passed in again, and the session starts
 * within the frame in which the previous one ended. */
enum mr_status collector_reopen(const struct collector *before, struct store *store,
                                bool has_all_data, bool continues_frame,
                                struct collector **collector, struct error *error);
/* Ends the session: landings in progress end in their current state, and suspected losses are
 * counted. `ended_by`: "end", "time", "signal", ... */
enum mr_status collector_end(struct collector *collector, const char *ended_by,
                             struct error *error);

/* Stores the session's counts and link errors up to now. */
enum mr_status collector_store_counts(struct collector *collector, struct error *error);

/* True if the configuration that the board reports is not in the database and may be requested
 * now. */
bool collector_needs_configuration(const struct collector *collector);

/* Returns the RUN of a landing that has ended since the last call; 0: none. Call it until it
 * returns 0. */
int64_t collector_pop_finished_run(struct collector *collector);
/* Returns the processor fault that the board reported since the last call; NULL: none. */
const struct crash_report *collector_pop_crash(struct collector *collector);
/* Returns the board's CAN state if it has changed since the last call; NULL: it has not. */
const struct mr_can_alarm *collector_pop_alarm(struct collector *collector);
/* Commands that this program sent, to distinguish their answers from answers to other programs. The
 * caller owns the list, so that collector_restore_state does not change it. */
#define COLLECTOR_OWN_COMMANDS_MAX 16u
struct collector_own_commands {
    struct {
        uint8_t code;
        uint16_t tag;
        /* block of the answer; -1: not answered yet. A further answer belongs to another program's
         * command */
        int64_t block;
    } command[COLLECTOR_OWN_COMMANDS_MAX];
    unsigned next_index;
};
void collector_add_own_command(struct collector_own_commands *own,
                               const struct mr_command *command);
/* Sets the list of this program's commands. Without it, for example for a recording, the sender of
 * a command is not known: commands are not reported, and their events have no value. */
void collector_set_own_commands(struct collector *collector, struct collector_own_commands *own);

/* The board's answer to a command that changes something: executed, or refused with ack.status.
 * Each answer is stored as an event `order`, with value 1 for this program's command and 0 for
 * another's. Identical answers within a second are only counted. */
struct collector_answer {
    struct mr_ack ack;
    bool is_own;
    /* number of identical answers that were only counted since the previous one */
    unsigned repeat_count;
};
/* Removes and returns the oldest answer that was not read; at most eight are stored. Returns false
 * if there is none. */
bool collector_pop_answer(struct collector *collector, struct collector_answer *answer);

struct collector_progress {
    bool hello_received;    /* a board with the right layout has sent a hello */
    int64_t run;            /* landing in progress; 0: none */
    unsigned landing_state; /* last reported state of the landing */
    int64_t newest_block;   /* newest block on either link; -1: none */
    unsigned edge_count;    /* number of edges of the landing in progress */
    /* the next fields are reported by the board; "" or NULL: not reported yet */
    const char *board_uid, *firmware;
    const struct mr_landing *landing;
    const struct mr_bus_key *key; /* state of the board's key: whether commands need a proof */
    const uint8_t *nonce;         /* nonce for the next proof, MR_PROOF_BYTES bytes */
    const uint32_t *uid;
    struct store_link_counts counts[LINK_KINDS];
    /* number of missing frames of each message, by the board's counts */
    int64_t missing_count[LINK_KINDS][MR_MESSAGE_COUNT];
    int64_t frames_before_log; /* number of CAN frames sent before logging began; -1: not known */
    /* CAN has the messages of another board at this base, but none of the board on serial */
    bool is_other_board_on_can;
    /* words 0 and 1 of the two identities if is_other_board_on_can is true */
    char can_uid[17], serial_uid[17];
};
void collector_get_progress(const struct collector *collector, struct collector_progress *progress);

/* A message of the board, as passed to listeners. */
struct collector_event {
    enum link_kind link;
    const struct mr_message *message;
    uint64_t host_us;
    int64_t board_us; /* board time of the message; STORE_NONE: not known */
};
/* A listener that receives each message, and each block record with this computer's time, in
 * addition to their storage. `listener` must outlive the collector; NULL: no listener. */
struct collector_listener {
    void (*message)(void *context, const struct collector_event *event);
    void (*record)(void *context, const struct mr_block *block, uint64_t host_us);
    void *context;
};
void collector_set_listener(struct collector *collector, const struct collector_listener *listener);

/* Returns the link whose newest board time is earlier, counting restarts of the board. */
enum link_kind collector_get_lagging_link(const struct collector *collector);
int64_t collector_get_session(const struct collector *collector);

#endif
