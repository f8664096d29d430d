/* Loss accounting of one link: frames sent by the board against frames received.
 *
 * Serial: every frame has a number; a jump is the number lost. CAN: frames have none, so
 * `can_health.sent`, which counts the frames queued before that one, is held against the frames
 * received since the one before; and the messages of a series (common/catalogue.h) step by its
 * blocks while a landing is recorded, which shows whose frames are missing. A step alone proves
 * nothing; it counts when the next can_health confirms that frames are lost, or when no more
 * arrive.
 *
 * Where frames were lost, as far as the link saw it: queue (the receive queue of this computer),
 * lock, slow disk, full disk, processor (the queue to the campaign had no room, for that reason),
 * adapter (its buffers or its serial line), bus-off; else link. A trouble alone proves no loss on
 * CAN; it names the cause of one that is found, or stands for it when nothing can be counted any
 * more.
 *
 * Which messages they were follows from message_count, the board's count of each message it meant
 * for the link: held against what was received of it, at the moment that count comes. What was lost
 * after the last count before a restart nobody can say.
 *
 * On CAN anybody may have sent a can_health or message_count. Counts that the bus cannot have
 * carried since the last ones are not taken; a can_health is when the next one goes on from it.
 *
 * What the board itself dropped it says in can_health and serial_health; that is counted apart.
 * Pure; gaps found wait in `gap` until they are taken. */
#ifndef MATRIG_HOST_ACCOUNT_H
#define MATRIG_HOST_ACCOUNT_H

#include "common/catalogue.h"
#include "host/link/link.h"
#include "host/store/store.h"

#define ACCOUNT_GAPS   32u
#define ACCOUNT_QUEUES 5u /* causes: the kernel's queue, and those of the queue to the campaign */

struct account {
    enum link_kind kind;
    struct store_link_counts counts;
    struct store_gap gap[ACCOUNT_GAPS];
    size_t gaps; /* found and not taken */

    bool seq_known;
    uint16_t seq_next;
    int64_t frame_block;   /* newest block known at the last frame */
    bool lost_since_block; /* frames are missing since the last block record */

    bool sent_known;
    uint32_t sent; /* of the last can_health */
    int64_t sent_block;
    int64_t received_since; /* frames since it, itself included */
    /* a can_health that cannot follow the last one, until a second one follows it */
    bool doubt_known;
    uint32_t doubt_sent;
    int64_t doubt_block, doubt_since; /* frames since it, itself included */
    int64_t before_first; /* CAN frames the board sent before logging began; -1: not known yet */
    struct store_gap suspect[MR_SERIES_PACKS];
    size_t suspects;
    /* frames that steps say are missing since the last can_health */
    int64_t suspect_count;
    int64_t step_block[MR_SERIES_PACKS]; /* last block of each; -1: none */

    bool whole; /* nothing of this boot was sent before logging began */
    /* frames of each message since the board began, or logging did */
    int64_t received_of[MR_PLACES];
    bool count_known[MR_PLACES];
    uint32_t count_of[MR_PLACES];         /* the board's last count of it */
    int64_t count_block[MR_PLACES];       /* when, by the last can_health or serial frame */
    int64_t received_at_count[MR_PLACES]; /* received when that came */
    /* found by counts so far, in all boots; dropped ones included */
    int64_t missing_of[MR_PLACES];
    int64_t repeated_of[MR_PLACES]; /* came more often than they were sent */

    /* frames that queues of this computer lost since the last can_health, by cause */
    int64_t queue_lost[ACCOUNT_QUEUES];
    int64_t bytes, bytes_lost; /* serial: received; lost by the full queue since the last frame */
    const char *other_cause;   /* of losses since it, by what the link saw; NULL: nothing */

    bool dropped_known;
    uint16_t dropped;
    int64_t dropped_block;
    bool block_known;
    uint32_t block_next;
    bool doubtful; /* frames were lost, perhaps because the board began again */
};

void account_start(struct account *account, enum link_kind kind);
/* The board began again: its counters too. `whole`: at the frame to come, so that nothing it sends
 * is missed. */
void account_restart(struct account *account, bool whole);
/* After it: the first serial frames of this start, from number 0 on, may be among those lost. */
void account_from_first(struct account *account);
/* A landing begins or ends on this link: no steps and no block numbers are expected across it. */
void account_break(struct account *account);

/* A message came, counted already as a frame; a message_count says what the board has sent of one.
 * False: nothing was taken from it, for it may be of a board that has begun again, which nobody has
 * noticed yet: its count went back, or frames were lost before it and no time has come since.
 * Counts only grow, so the next one makes up for it. */
void account_message(struct account *account, unsigned place); /* enum mr_message_place */
bool account_message_count(struct account *account, const struct mr_message_count *count);
/* A time of the board came that goes on from those before: it has not begun again. */
void account_goes_on(struct account *account);

/* A frame came. `block`: newest block known on the link, that of this frame included; -1: none.
 * Call it before what the frame says is accounted. */
void account_serial_frame(struct account *account, uint16_t seq, int64_t block);
void account_can_frame(struct account *account);
/* The frame just counted was this one: can_health on CAN; serial_health on serial (its count of
 * dropped frames); a message that may step by blocks, in a landing; a block record, in a
 * landing. */
void account_can_health(struct account *account, const struct mr_can_health *health, int64_t block);
void account_dropped(struct account *account, uint16_t dropped, int64_t block);
/* enum mr_series_pack_number */
void account_step(struct account *account, unsigned pack, int64_t block);
void account_block(struct account *account, uint32_t index);

/* The link saw a trouble `count` times. */
void account_trouble(struct account *account, enum link_trouble trouble, int64_t count);

/* The link ended, or fell silent for good: what is only suspected so far is taken as lost. */
void account_end(struct account *account);

#endif
