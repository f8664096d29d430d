/* Internal data of the collector. collect_links.c processes links and frames, collect_landing.c
 * landings, collect_message.c the content of messages. */
#ifndef MATRIG_HOST_COLLECT_STATE_H
#define MATRIG_HOST_COLLECT_STATE_H

#include "common/catalogue.h"
#include "common/fault.h"
#include "common/framing.h"
#include "common/proof.h"
#include "common/risk.h"
#include "common/runway.h"
#include "host/board/config_client.h"
#include "host/board/health_client.h"
#include "host/collect/loss_tracker.h"
#include "host/collect/timebase.h"
#include "host/link/timemap.h"

struct collector;
struct collector_event;

/* A landing that is in progress or ended recently. */
struct landing_slot {
    struct store_landing row; /* row.id 0: the slot is free */
    bool link_entered[LINK_KINDS];
    bool link_left[LINK_KINDS];
    bool is_finished;
    int64_t state_block;     /* block of the newest change of state */
    int64_t end_block;       /* block at which the first link left the landing; -1: in progress */
    int64_t begin_frame_row; /* row of a frame received some seconds before the landing began */
    bool was_interrupted;    /* the board restarted during the landing, which ended it */
    /* row of the newest CAN frame before the restart; 0: none yet */
    int64_t interruption_frame_row;
    unsigned edge_count;
    double first_edge_us;      /* board time of the first edge, us; 0: no edge yet */
    int64_t newest_film_frame; /* number of the newest frame, unwrapped */
};
#define LANDING_SLOT_COUNT 4u

/* Number of hellos and identities of another board, without one of the known board between them,
 * that prove a change of boards. A board sends each about once a second. */
#define COLLECT_OTHER_BOARD_MESSAGES_MIN 3u

/* A frame that waits until the boot of the board to which it belongs is known: a CAN frame, or a
 * serial frame with its type as identifier. A clock message arrives within 0.1 s, and there are at
 * most 9 frames/ms. */
struct held_frame {
    struct link_frame frame;
    uint16_t seq;
};
#define COLLECT_HELD_FRAMES_MAX 2048u

/* State of the collector for one link. */
struct link_state {
    enum link_kind kind;
    /* CAN only: the newest landing message with state ARMED, and its time of reception in
     * armed_us */
    struct mr_landing armed_landing;
    uint64_t armed_us;
    /* blocks of the newest accepted clock message and of the first one */
    int64_t newest_clock_block, first_clock_block;
    /* CAN only: rows of two frames. [1] is at most FRAME_MARK_PERIOD_BLOCKS old, [0] is the one
     * before it */
    int64_t marked_frame_row[2], frame_mark_block;
    const char *link_spec; /* NULL: the link is not used */
    bool has_ended;
    struct loss_tracker loss_tracker;
    struct timebase timebase;
    struct timebase_candidate time_candidate;
    struct timemap time_map;
    /* the newest sync message, which waits for its sync_at message, and its time of reception; 0:
     * none */
    struct mr_sync sync;
    uint64_t sync_host_us;
    int64_t boot;
    /* frames that wait for a board time, after a hello on CAN or a loss on serial */
    struct held_frame held_frames[COLLECT_HELD_FRAMES_MAX];
    size_t held_frame_count;
    struct landing_slot *current_landing;
    struct landing_slot *last_landing; /* the landing left most recently */
    struct mr_deframer deframer;
    /* First half of a zone or motion, waiting for the message with its second half.
     * partial_zone_block16 and partial_motion_block16 are the low 16 bits of its block. */
    struct store_zone partial_zone;
    struct store_motion partial_motion;
    int32_t partial_zone_block16, partial_motion_block16;
    struct store_shunt shunt; /* the shunt calibration in progress; number 0: none */
    struct store_shunt shunt_result;
    /* row of the slow log being assembled, its number, and the number of gages received for it */
    struct store_slow slow_row;
    unsigned slow_row_number, slow_gage_count;
    struct mr_predictor_state runway;          /* runway state that is being assembled from parts */
    unsigned runway_part_count;                /* number of the runway's parts received in order */
    struct mr_runway_store runway_store;       /* newest report of the stored runway */
    uint64_t counted_faults[LINK_FAULT_COUNT]; /* errors that the link has counted */
    /* Errors that were counted but not recorded yet. They belong to landing pending_faults_run and
     * began at pending_faults_us. */
    uint64_t pending_faults[LINK_FAULT_COUNT];
    int64_t pending_faults_run;
    int64_t pending_faults_us; /* board time */
    bool has_pending_faults;
    uint64_t received_us; /* time of reception of the newest message */
    uint32_t state_block; /* block of the newest accepted landing state */
    /* hellos and identities of another board since the last one of this board */
    unsigned other_board_message_count;
    bool own_board_seen;   /* an identity of this board was received */
    uint32_t other_uid[2]; /* words 0 and 1 of the other board's identity */
    struct config_words config;
};

/* Identical answers to one command are counted for a second and then reported together. */
#define COLLECT_ANSWERS_MAX  8u
#define REPEATED_ANSWERS_MAX 32u
struct repeated_answer {
    bool has_answer, is_own;
    int8_t status;
    uint8_t code;
    uint32_t block; /* block of the last answer reported */
    unsigned repeat_count;
};

/* Newest values that the board reported about itself, on request or not. */
struct board_report {
    bool hello_known;
    bool landing_known;
    struct mr_landing landing;     /* newest landing state on either link */
    struct store_landing identity; /* facts about the board: uid, firmware, CRCs, clock, site */
    uint32_t uid[3];
    uint32_t uid_parts;      /* bit 0: words 0 and 1 are known; bit 1: word 2 is known */
    bool is_uid_from_serial; /* the identity was received on serial */
    bool key_known, nonce_known;
    struct mr_bus_key key;         /* state of the board's key: whether commands need a proof */
    uint8_t nonce[MR_PROOF_BYTES]; /* nonce for the next proof */
    bool channel_known[MR_CHANNELS];
    bool zero_known[MR_CHANNELS];
    struct mr_channel_config channel[MR_CHANNELS];
    uint32_t items_known[MR_CHANNELS]; /* bit mask by enum mr_calibration_item */
    bool switch_known[STORE_SWITCHES_MAX];
    struct store_switch switch_place[STORE_SWITCHES_MAX];
    bool segment_known[MR_SEGMENTS];
    struct store_segment segment[MR_SEGMENTS];
    bool predict_known[MR_PREDICT_ITEM_COUNT];
    float predict_item[MR_PREDICT_ITEM_COUNT];
    bool risk_known[MR_RISK_REPORT_ITEM_COUNT];
    float risk_item[MR_RISK_REPORT_ITEM_COUNT];
};

struct collector {
    struct store *store;
    struct collector *saved_state; /* state saved by collector_save_state; NULL: not saved */
    int64_t session;
    struct link_state side[LINK_KINDS];
    uint16_t can_base;
    const struct collector_listener *listener; /* NULL: no listener */
    struct board_report reported;
    struct landing_slot slot[LANDING_SLOT_COUNT];
    int64_t finished_runs[LANDING_SLOT_COUNT]; /* RUNs not read yet */
    size_t finished_run_count;

    uint16_t fault_count[MR_FAULT_COUNT];
    struct mr_runway_store stored_runway; /* newest report of the stored runway, from either link */
    /* stored_runway_changed: a new report has arrived that the caller has not read */
    bool stored_runway_known, stored_runway_changed;
    bool config_stored; /* the database has the configuration with CRC config_stored_crc */
    uint32_t config_stored_crc;
    struct crash_report crash[LINK_KINDS]; /* reports being assembled, one per link */
    struct crash_report stored_crash;      /* the newest stored processor fault */
    /* `stored_crash` has not been passed to the caller yet */
    bool crash_unread;
    struct mr_can_alarm alarm; /* newest state from either link */
    bool alarm_unread;
    /* commands of this program; NULL: not known */
    struct collector_own_commands *own_commands;
    struct collector_answer answer[COLLECT_ANSWERS_MAX];
    /* total numbers of answers, and of those that the caller has read */
    unsigned answer_add_count, read_answer_count;
    struct repeated_answer
        /* identical answers; the index is the code of the command modulo REPEATED_ANSWERS_MAX */
        repeated_answers[REPEATED_ANSWERS_MAX];
};

/* Adds a row to the landing in progress on this side. */
#define COLLECT_PUT(table, value) \
    store_##table##_put(collector->store, side->current_landing->row.id, value, error)

/* Returns the newest block known on a link; -1: none. */
int64_t collect_newest_block(const struct link_state *side);
/* Returns the board time of a message: that of its block if it has one, otherwise the newest known
 * time. `message` NULL: a frame that is not a message. */
int64_t collect_board_time(const struct link_state *side, const struct mr_message *message);
/* Returns the block of the event that a message reports, if the event is recent; -1: not known, or
 * the message has no block. */
int64_t collect_event_block(struct link_state *side, const struct mr_message *message);
/* Returns the bit of the side's link in `links` of a row. */
int64_t collect_link_bit(const struct link_state *side);
/* Adds an event; it belongs to the landing in progress on this side, if there is one. */
enum mr_status collect_put_event(struct collector *collector, const struct link_state *side,
                                 const char *kind, int64_t block, int64_t code, int64_t detail,
                                 int64_t value, uint64_t host_us, struct error *error);

/* ---- collect_links.c ---- */

/* Processes the held frames when the link has ended, with the most likely boot. */
enum mr_status collect_release_held_frames(struct collector *collector, struct link_state *side,
                                           struct error *error);
/* Stores the gaps that the account has found, with the landing in which they occurred. */
enum mr_status collect_store_gaps(struct collector *collector, struct link_state *side,
                                  struct error *error);

/* Processes an accepted message. The file of each topic has a function of this type. */
typedef enum mr_status collect_message_handler(struct collector *collector, struct link_state *side,
                                               const struct collector_event *event,
                                               struct error *error);
collect_message_handler collect_message;
/* collect_reprocess_message processes a message again, for the landing to which it belongs: events,
 * gear, predictor and bands. */
collect_message_handler collect_reprocess_message, collect_identity_message;
/* Stores a change of the landing's state as an event of the landing in progress on this side. */
enum mr_status collect_put_state_event(struct collector *collector, const struct link_state *side,
                                       const struct mr_landing *message, uint64_t host_us,
                                       struct error *error);
/* Stores the known parameters of the predictor with a landing that begins. */
enum mr_status collect_write_parameters(struct collector *collector,
                                        const struct landing_slot *slot, struct error *error);
/* Stores the known parts of the configuration with a landing that begins. */
enum mr_status collect_write_configuration(struct collector *collector,
                                           const struct landing_slot *slot, struct error *error);

/* Pairs of board and host time, and film frames. collect_put_time_map stores the time map of a
 * landing that has ended (`slot` NULL: of a boot that has ended). */
void collect_handle_sync(struct link_state *side, const struct mr_sync *sync, uint64_t host_us);
void collect_handle_sync_at(struct link_state *side, const struct mr_sync_at *sync_at);
void collect_handle_clock(struct link_state *side, const struct mr_clock *clock, uint64_t host_us);
/* Discards the pairs, because this computer's clock was set. */
void collect_discard_time_map(struct link_state *side);
enum mr_status collect_put_time_map(struct collector *collector, const struct link_state *side,
                                    const struct landing_slot *slot, struct error *error);
enum mr_status collect_handle_film_frame(struct collector *collector, struct link_state *side,
                                         const struct mr_film_frame *frame, struct error *error);

/* Handles a state of a landing that the side reports: begins, updates or ends the landing for this
 * side. `*believed` false: the state cannot be current, and nothing was done. */
enum mr_status collect_handle_landing(struct collector *collector, struct link_state *side,
                                      const struct mr_landing *landing, uint64_t host_us,
                                      bool *believed, struct error *error);
/* Ends the side's landing, if there is one. */
void collect_leave_landing(struct link_state *side);
/* Finishes a landing: data that a link should have sent and that is missing becomes a gap. */
enum mr_status collect_finish_landing(struct collector *collector, struct landing_slot *slot,
                                      struct error *error);
/* Calls collect_finish_landing for each landing that is over on every link: the link has left it,
 * or ended during it, or is known to have missed it. */
enum mr_status collect_finish_ended_landings(struct collector *collector, struct error *error);

#endif
