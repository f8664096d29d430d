/* Loss accounting of one link: frames sent by the board compared with frames received.
 *
 * Serial: every frame has a number; a jump in the numbers is the number of lost frames. CAN: frames
 * have no numbers. `can_health.sent` counts the frames queued before that can_health, and its
 * increase is compared with the frames received since the previous can_health. While a landing is
 * recorded, the block numbers of the messages of a series (common/catalogue.h) increase in fixed
 * steps; a larger step shows which frames may be missing. They count as lost when the next
 * can_health confirms a loss, or when the link ends.
 *
 * Causes of losses, as far as the link detected them: queue (the receive queue of this computer);
 * lock, slow disk, full disk, processor (the queue to the campaign had no room, for that reason);
 * adapter (its buffers or its serial line); bus-off; otherwise link. On CAN, an error that the link
 * reports does not prove a loss. It is recorded as the cause when a loss is found, or when losses
 * can no longer be counted.
 *
 * The lost messages are identified by message_count, in which the board reports how many of each
 * message it sent on the link. It is compared with the number of those messages received when the
 * count arrives. Losses after the last count before a restart cannot be determined.
 *
 * On CAN, any node may have sent a can_health or message_count. A count is ignored if the bus
 * cannot have carried that many frames since the last one. Such a can_health is accepted later if
 * the next one continues from it.
 *
 * Frames that the board itself dropped are reported in can_health and serial_health and counted
 * separately. Pure functions; gaps are stored in `gap` until the caller takes them. */
#ifndef MATRIG_HOST_ACCOUNT_H
#define MATRIG_HOST_ACCOUNT_H

#include "common/catalogue.h"
#include "host/link/link.h"
#include "host/store/store.h"

#define LOSS_TRACKER_GAPS_MAX    32u
/* number of causes: one for the kernel's queue, four for the queue to the campaign */
#define LOSS_TRACKER_QUEUE_COUNT 5u

struct loss_tracker {
    enum link_kind kind;
    struct store_link_counts counts;
    struct store_gap gap[LOSS_TRACKER_GAPS_MAX];
    size_t gap_count; /* number of gaps found that the caller has not stored yet */

    bool seq_known;
    uint16_t next_seq;
    int64_t last_frame_block;   /* newest block known at the last serial frame */
    bool lost_since_last_block; /* frames were lost since the last block record */

    bool sent_count_known;
    uint32_t sent_count; /* count of the last accepted can_health */
    int64_t sent_count_block;
    /* frames received from that can_health on, including it */
    int64_t received_since_health;
    /* An implausible can_health, which is accepted if a second one continues from it, and the
     * number of frames received from it on, including it. */
    bool unconfirmed_count_known;
    uint32_t unconfirmed_sent_count;
    int64_t unconfirmed_count_block, received_since_unconfirmed;
    /* CAN frames that the board sent before logging began; -1: not known yet */
    int64_t frames_before_log;
    struct store_gap suspected_gap[MR_SERIES_PACK_COUNT];
    size_t suspected_gap_count;
    /* number of frames missing since the last can_health, according to the steps of the series */
    int64_t suspected_frames;
    /* block of the last message of each series; -1: none */
    int64_t last_series_block[MR_SERIES_PACK_COUNT];

    /* logging began before the board started, so that all its frames since then count */
    bool logged_since_start;
    /* number of frames of each message received since the board started, or since logging began */
    int64_t received_count[MR_MESSAGE_COUNT];
    bool is_board_count_known[MR_MESSAGE_COUNT];
    /* newest count of each message that the board reported */
    uint32_t board_count[MR_MESSAGE_COUNT];
    /* block at which that count arrived, according to the last can_health or serial frame */
    int64_t board_count_block[MR_MESSAGE_COUNT];
    /* number of frames of the message received by the time the board's count arrived */
    int64_t received_count_at_report[MR_MESSAGE_COUNT];
    /* number of missing frames according to all counts, over all starts of the board, including
     * frames that the board dropped */
    int64_t missing_count[MR_MESSAGE_COUNT];
    /* number of frames received more often than they were sent */
    int64_t repeated_count[MR_MESSAGE_COUNT];

    /* number of frames that queues of this computer lost since the last can_health, by cause */
    int64_t queue_lost_frames[LOSS_TRACKER_QUEUE_COUNT];
    /* for serial: number of bytes received, and of bytes that the full queue lost since the last
     * frame */
    int64_t received_bytes, lost_bytes;
    /* cause of losses since the last frame, as detected by the link; NULL: none */
    const char *loss_cause;

    bool dropped_count_known;
    uint16_t dropped_count;
    int64_t dropped_block;
    bool block_known;
    uint32_t next_block;
    bool is_time_unconfirmed; /* frames were lost, so the board may have restarted */
};

void loss_tracker_start(struct loss_tracker *loss_tracker, enum link_kind kind);
/* Resets the counters after a restart of the board. `whole`: logging continued during the restart,
 * so no frame of this start is missed. */
void loss_tracker_restart(struct loss_tracker *loss_tracker, bool whole);
/* Call after loss_tracker_restart if the first serial frames of this start may be lost. Frames
 * missing from number 0 on then count as lost. */
void loss_tracker_expect_first_frame(struct loss_tracker *loss_tracker);
/* Call when a landing begins or ends on this link: block numbers before and after this moment are
 * not compared. */
void loss_tracker_reset_series_steps(struct loss_tracker *loss_tracker);

/* loss_tracker_add_message adds a received message, already counted as a frame;
 * loss_tracker_apply_message_count applies the board's count of one message. The latter returns
 * false if it ignored the count, because the board may have restarted without notice: the count
 * decreased, or frames were lost before it and no board time has arrived since. Nothing is lost by
 * that, because the next count includes the ignored one. */
void loss_tracker_add_message(struct loss_tracker *loss_tracker,
                              unsigned place); /* enum mr_message_index */
bool loss_tracker_apply_message_count(struct loss_tracker *loss_tracker,
                                      const struct mr_message_count *count);
/* Call when a board time has arrived that continues the earlier times, which shows that the board
 * has not restarted. */
void loss_tracker_confirm_board_time(struct loss_tracker *loss_tracker);

/* Adds a received frame. `block`: newest block known on the link, including that of this frame; -1:
 * none. Call it before the functions for the content of the frame. */
void loss_tracker_add_serial_frame(struct loss_tracker *loss_tracker, uint16_t seq, int64_t block);
void loss_tracker_add_can_frame(struct loss_tracker *loss_tracker);
/* Applies the content of the frame that was just added: a can_health on CAN; the count of dropped
 * frames of a serial_health; during a landing, a message of a series
 * (loss_tracker_add_series_message) or a block record (loss_tracker_add_block). */
void loss_tracker_apply_can_health(struct loss_tracker *loss_tracker,
                                   const struct mr_can_health *health, int64_t block);
void loss_tracker_apply_dropped_count(struct loss_tracker *loss_tracker, uint16_t dropped,
                                      int64_t block);
/* `pack`: an enum mr_series_pack_number. */
void loss_tracker_add_series_message(struct loss_tracker *loss_tracker, unsigned pack,
                                     int64_t block);
void loss_tracker_add_block(struct loss_tracker *loss_tracker, uint32_t index);

/* Counts an error that the link reported `count` times. */
void loss_tracker_add_link_fault(struct loss_tracker *loss_tracker, enum link_fault fault,
                                 int64_t count);

/* Counts suspected losses as losses, when the link has ended or become silent. */
void loss_tracker_end(struct loss_tracker *loss_tracker);

#endif
