/* Insides of the collector: collect_links.c (what comes), collect_landing.c (landings) and
 * collect_message.c with its topics (what each message does). */
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
#include "host/collect/account.h"
#include "host/collect/timebase.h"
#include "host/link/timemap.h"

struct collector;
struct collector_event;

/* One landing that is open, or was lately. */
struct slot {
    struct store_landing row; /* row.id 0: free */
    bool entered[LINK_KINDS];
    bool left[LINK_KINDS];
    bool finished;
    int64_t state_block; /* of the newest change of state reported */
    int64_t end_block;   /* where the first link left it; -1: still going on */
    int64_t begun_mark;  /* a frame of some seconds before it began */
    bool broken_off;     /* the board began again in it; the newest frame before that on CAN, */
    int64_t broken_mark; /* 0: not there yet */
    unsigned edges;
    double first_edge_us; /* board time; 0: none yet */
    int64_t film_frames;  /* number of the newest, unwrapped */
};
#define SLOTS 4u

/* Hellos and identities of another board, and none of this one: about once a second each. */
#define COLLECT_OTHERS_IN_ROW 3u

/* A frame that waits until it is known which start of the board it is of: of CAN, or of serial with
 * its type in place of the identifier. A start takes 0.1 s until its second clock, 9 frames/ms. */
struct held {
    struct link_frame frame;
    uint16_t seq;
};
#define COLLECT_HELD 2048u

/* One link. */
struct side {
    enum link_kind kind;
    struct mr_landing armed; /* CAN: the newest state ARMED, and its own stamp */
    uint64_t armed_us;
    int64_t clock_block, first_clock; /* of the newest clock that was believed; of the first */
    int64_t mark[2], mark_block; /* CAN: rows of frames, of MARK_BLOCKS ago at most, and before */
    const char *spec;            /* NULL: not used */
    bool ended;
    struct account account;
    struct timebase time;
    struct timebase_doubt time_doubt;
    struct timemap map;
    struct mr_sync sync; /* the newest, and when it came; 0: none waits for its sync_at */
    uint64_t sync_host_us;
    int64_t boot;
    struct held held[COLLECT_HELD]; /* since a hello on CAN, since a loss on serial */
    size_t held_count;
    struct slot *current;
    struct slot *last; /* the one left most recently */
    struct mr_deframer deframer;
    /* that its second half is to follow; this and the next are of the block zone16, motion16 */
    struct store_zone zone;
    struct store_motion motion;
    int32_t zone16, motion16;
    struct store_shunt shunt; /* the calibration whose results come; number 0: none */
    struct store_shunt shunt_result;
    struct store_slow slow; /* being put together: its number, gages that came */
    unsigned slow_number, slow_gages;
    struct mr_predictor_state runway;    /* being put together */
    unsigned runway_parts;               /* of it, that came in a row */
    struct mr_runway_store runway_store; /* newest */
    uint64_t told[LINK_TROUBLES];        /* what the link has counted */
    /* and is not recorded yet: in landing pending_run, from pending_us on */
    uint64_t pending[LINK_TROUBLES];
    int64_t pending_run;
    int64_t pending_us; /* board time */
    bool any_pending;
    uint64_t heard_us;     /* when the newest message came */
    uint32_t state_block;  /* of the newest state of a landing that was believed */
    unsigned others;       /* hellos and identities of another board since one of this board */
    bool own_heard;        /* an identity of this board came */
    uint32_t other_uid[2]; /* of the other one, words 0 and 1 */
    struct configwords config;
};

/* Answers to one code that are the same within a second: a flood is told once a second. */
#define COLLECT_ORDERS 8u
#define REPEATED       32u
struct repeated {
    bool known, own;
    int8_t status;
    uint8_t code;
    uint32_t block; /* of the last one told */
    unsigned more;
};

/* What the board last said about itself, once or when it is asked. */
struct told {
    bool hello;
    bool landing_known;
    struct mr_landing landing;     /* the newest of either link */
    struct store_landing identity; /* uid, firmware, CRCs, clock, site */
    uint32_t uid[3];
    uint32_t uid_parts; /* bit 0: words 0 and 1 are known, bit 1: word 2; */
    bool uid_vouched;   /* serial said so */
    bool key_known, nonce_known;
    struct mr_bus_key key;         /* whether orders need a proof */
    uint8_t nonce[MR_PROOF_BYTES]; /* of the next one */
    bool channel_known[MR_CHANNELS];
    bool zero_known[MR_CHANNELS];
    struct mr_channel_config channel[MR_CHANNELS];
    uint32_t items_known[MR_CHANNELS]; /* bit: enum mr_calibration_item */
    bool switch_known[STORE_SWITCHES_MAX];
    struct store_switch place[STORE_SWITCHES_MAX];
    bool segment_known[MR_SEGMENTS];
    struct store_segment segment[MR_SEGMENTS];
    bool predict_known[MR_PREDICT_ITEMS];
    float predict_item[MR_PREDICT_ITEMS];
    bool risk_known[MR_RISK_TOLD];
    float risk_item[MR_RISK_TOLD];
};

struct collector {
    struct store *store;
    struct collector *mark; /* what it was at collector_mark; NULL: never */
    int64_t session;
    struct side side[LINK_KINDS];
    uint16_t can_base;
    const struct collector_listener *listener; /* NULL: nobody */
    struct told told;
    struct slot slot[SLOTS];
    int64_t finished[SLOTS]; /* RUNs not taken yet */
    size_t finished_count;

    uint16_t fault_count[MR_FAULT_COUNT];
    struct mr_runway_store stored;  /* newest, of either link */
    bool stored_known, stored_news; /* and nobody has asked for yet */
    bool config_kept;               /* a whole configuration is in the database: */
    uint32_t config_kept_crc;
    struct crash_report crash[LINK_KINDS]; /* being put together */
    struct crash_report crashed;           /* the newest that is stored */
    bool crash_news;                       /* and nobody has asked for yet */
    struct mr_can_alarm alarm;             /* newest; of either link */
    bool alarm_news;
    struct collector_own *own; /* NULL: not known */
    struct collector_order order[COLLECT_ORDERS];
    unsigned orders, orders_taken;      /* ever */
    struct repeated repeated[REPEATED]; /* by code modulo their number */
};

/* Puts a row of the landing that the side is in. */
#define COLLECT_PUT(table, value) \
    store_##table##_put(collector->store, side->current->row.id, value, error)

/* Newest block known on a link; -1: none. */
int64_t collect_newest_block(const struct side *side);
/* Board time of a message: that of its own block where it has one, else the newest known; NULL: of
 * what is no message. */
int64_t collect_board_time(const struct side *side, const struct mr_message *message);
/* Block in which happened what a message tells, which is not long past; -1: not known, or it says
 * none. */
int64_t collect_block(struct side *side, const struct mr_message *message);
/* The side's, among those that brought a row. */
int64_t collect_link_bit(const struct side *side);
/* An event, of the landing that the side is in, if any. */
enum mr_status collect_put_event(struct collector *collector, const struct side *side,
                                 const char *kind, int64_t block, int64_t code, int64_t detail,
                                 int64_t value, uint64_t host_us, struct error *error);

/* ---- collect_links.c ---- */

/* The link ended: what is held is taken for what it most likely is. */
enum mr_status collect_release(struct collector *collector, struct side *side, struct error *error);
/* Stores the gaps the account has found, with the landing they fall in. */
enum mr_status collect_store_gaps(struct collector *collector, struct side *side,
                                  struct error *error);

/* Does what a message says that is believed: each topic takes its own, in the file of that name. */
typedef enum mr_status collect_topic(struct collector *collector, struct side *side,
                                     const struct collector_event *event, struct error *error);
collect_topic collect_message;
/* Once more, for the landing that the message turns out to be of: events, and what gear, predictor
 * and bands did. */
collect_topic collect_message_again, collect_identity_message;
/* A change of a landing's state, as an event of the landing that the side is in. */
enum mr_status collect_state_event(struct collector *collector, const struct side *side,
                                   const struct mr_landing *message, uint64_t host_us,
                                   struct error *error);
/* Writes the predictor's parameters, as far as they are known, for a landing that begins. */
enum mr_status collect_write_parameters(struct collector *collector, const struct slot *slot,
                                        struct error *error);
/* Writes all that is known of the configuration for a landing that begins. */
enum mr_status collect_write_configuration(struct collector *collector, const struct slot *slot,
                                           struct error *error);

/* Pairs of board and host time; what they come to, written for a
 * landing that is over (NULL: of the boot that is); film frames. */
void collect_sync(struct side *side, const struct mr_sync *sync, uint64_t host_us);
void collect_sync_at(struct side *side, const struct mr_sync_at *sync_at);
void collect_clock(struct side *side, const struct mr_clock *clock, uint64_t host_us);
/* of this computer's clock, which is another one now */
void collect_forget_time(struct side *side);
enum mr_status collect_put_time_map(struct collector *collector, const struct side *side,
                                    const struct slot *slot, struct error *error);
enum mr_status collect_film_frame(struct collector *collector, struct side *side,
                                  const struct mr_film_frame *frame, struct error *error);

/* The side reports a landing: enter, follow or leave it. */
/* Not `*believed`: it cannot be of now, and nothing was done. */
enum mr_status collect_landing(struct collector *collector, struct side *side,
                               const struct mr_landing *landing, uint64_t host_us, bool *believed,
                               struct error *error);
/* The side's landing, if any, is over for it. */
void collect_leave(struct side *side);
/* A landing is over: what a link should have brought of it and did not becomes a gap. */
enum mr_status collect_finish(struct collector *collector, struct slot *slot, struct error *error);
/* The same for each landing that every link has left, has ended in, or is known to have missed. */
enum mr_status collect_finish_what_is_over(struct collector *collector, struct error *error);

#endif
