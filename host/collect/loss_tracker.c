#include "host/collect/loss_tracker.h"

#include <stdio.h>
#include <string.h>

#include "common/catalogue.h"

/* A jump of more than half the range means that the sender restarted, not that frames were lost. */
#define SEQ_JUMP_MAX 0x8000u
#define SEQ_RANGE    0x10000

/* Maximum number of CAN frames per block: at 1 Mbit/s an empty frame takes 47 bit times, so 21
 * frames fit into 1 ms. */
#define CAN_FRAMES_PER_BLOCK_MAX    21
/* blocks between two readings of an idle board (firmware/schedule.def) */
#define IDLE_READING_PERIOD_BLOCKS  100
/* Clock messages are sent every 100 blocks; several of them may be lost. */
#define CLOCK_LOSS_TOLERANCE_BLOCKS 1000

void loss_tracker_start(struct loss_tracker *loss_tracker, enum link_kind kind)
{
    memset(loss_tracker, 0, sizeof *loss_tracker);
    loss_tracker->kind = kind;
    loss_tracker->frames_before_log = -1;
    loss_tracker->last_frame_block = -1;
    loss_tracker->sent_count_block = -1;
    loss_tracker->dropped_block = -1;
    loss_tracker_reset_series_steps(loss_tracker);
}

void loss_tracker_expect_first_frame(struct loss_tracker *loss_tracker)
{
    loss_tracker->logged_since_start = loss_tracker->seq_known = true;
    loss_tracker->next_seq = 0;
}

void loss_tracker_add_message(struct loss_tracker *loss_tracker, unsigned place)
{
    if (place < MR_MESSAGE_COUNT)
        loss_tracker->received_count[place]++;
}

void loss_tracker_confirm_board_time(struct loss_tracker *loss_tracker)
{
    loss_tracker->is_time_unconfirmed = false;
}

/* True if `frames` frames fit between the two blocks. If a block is not known (-1), any number
 * fits. */
static bool is_can_frame_count_possible(int64_t frames, int64_t from_block, int64_t to_block)
{
    return frames >= 0 && (from_block < 0 || to_block < 0 ||
                           frames <= CAN_FRAMES_PER_BLOCK_MAX *
                                         (to_block - from_block + CLOCK_LOSS_TOLERANCE_BLOCKS));
}

static int64_t get_newest_block(const struct loss_tracker *loss_tracker)
{
    return loss_tracker->kind == LINK_CAN ? loss_tracker->sent_count_block
                                          : loss_tracker->last_frame_block;
}

bool loss_tracker_apply_message_count(struct loss_tracker *loss_tracker,
                                      const struct mr_message_count *count)
{
    unsigned place = mr_message_index(count->id);
    if (place >= MR_MESSAGE_COUNT || loss_tracker->is_time_unconfirmed ||
        (loss_tracker->is_board_count_known[place] &&
         count->count < loss_tracker->board_count[place]))
        return false;
    if (loss_tracker->is_board_count_known[place] &&
        !is_can_frame_count_possible((int64_t)(count->count - loss_tracker->board_count[place]),
                                     loss_tracker->board_count_block[place],
                                     get_newest_block(loss_tracker)))
        return false;
    /* The board counts a message_count only after sending it, so the count in it excludes
     * itself. */
    int64_t received = loss_tracker->received_count[place] - (place == MR_INDEX_MESSAGE_COUNT);
    if (loss_tracker->is_board_count_known[place] || loss_tracker->logged_since_start) {
        bool known = loss_tracker->is_board_count_known[place];
        uint32_t sent = count->count - (known ? loss_tracker->board_count[place] : 0);
        int64_t missing = (int64_t)sent -
                          (received - (known ? loss_tracker->received_count_at_report[place] : 0));
        if (missing > 0)
            loss_tracker->missing_count[place] += missing;
        else
            loss_tracker->repeated_count[place] -= missing;
    }
    loss_tracker->is_board_count_known[place] = true;
    loss_tracker->board_count[place] = count->count;
    loss_tracker->board_count_block[place] = get_newest_block(loss_tracker);
    loss_tracker->received_count_at_report[place] = received;
    return true;
}

void loss_tracker_reset_series_steps(struct loss_tracker *loss_tracker)
{
    for (size_t i = 0; i < MR_SERIES_PACK_COUNT; i++)
        loss_tracker->last_series_block[i] = -1;
    loss_tracker->block_known = false;
}

static struct store_gap make_gap(const struct loss_tracker *loss_tracker, const char *message,
                                 const char *channels, const char *cause, int64_t count,
                                 int64_t from_block, int64_t to_block)
{
    struct store_gap gap = {.link = (int)loss_tracker->kind,
                            .count = count,
                            .from_block = from_block < 0 ? STORE_NONE : from_block,
                            .to_block = to_block < 0 ? STORE_NONE : to_block};
    snprintf(gap.message, sizeof gap.message, "%s", message);
    snprintf(gap.channels, sizeof gap.channels, "%s", channels);
    snprintf(gap.cause, sizeof gap.cause, "%s", cause);
    return gap;
}

/* Adds a gap to the list, which the collector empties after every frame. If the list is full, the
 * row is lost, but the total remains correct. */
static void add_gap(struct loss_tracker *loss_tracker, struct store_gap gap)
{
    if (loss_tracker->gap_count < LOSS_TRACKER_GAPS_MAX)
        loss_tracker->gap[loss_tracker->gap_count++] = gap;
}

/* Estimates how many frames were in the bytes that this computer lost before the board restarted,
 * from the mean frame size so far. Sequence numbers do not show this loss. */
static void add_lost_bytes(struct loss_tracker *loss_tracker)
{
    int64_t lost = loss_tracker->received_bytes > 0
                     ? loss_tracker->lost_bytes * loss_tracker->counts.received /
                           loss_tracker->received_bytes
                     : 0;
    lost = lost > 0 ? lost : 1;
    loss_tracker->counts.lost += lost;
    add_gap(loss_tracker, make_gap(loss_tracker, "frame", "all",
                                   loss_tracker->loss_cause ? loss_tracker->loss_cause : "link",
                                   lost, loss_tracker->last_frame_block, -1));
    loss_tracker->loss_cause = NULL;
    loss_tracker->lost_bytes = 0;
}

void loss_tracker_restart(struct loss_tracker *loss_tracker, bool whole)
{
    if (loss_tracker->lost_bytes > 0)
        add_lost_bytes(loss_tracker);
    loss_tracker->seq_known = false;
    loss_tracker->sent_count_known = false;
    loss_tracker->unconfirmed_count_known = false;
    loss_tracker->dropped_count_known = false;
    loss_tracker->suspected_gap_count = 0;
    loss_tracker->suspected_frames = 0;
    loss_tracker->received_since_health = 0;
    loss_tracker->last_frame_block = loss_tracker->sent_count_block = -1;
    loss_tracker->logged_since_start = whole;
    loss_tracker->is_time_unconfirmed = false;
    memset(loss_tracker->received_count, 0, sizeof loss_tracker->received_count);
    memset(loss_tracker->is_board_count_known, 0, sizeof loss_tracker->is_board_count_known);
    loss_tracker_reset_series_steps(loss_tracker);
}

/* Returns the number of lost frames for a jump of the sequence number; 0: none. If this computer
 * also lost bytes, the number may have wrapped: the number of wraps is the best fit to the mean
 * frame size so far. */
static int64_t count_lost_frames(const struct loss_tracker *loss_tracker, uint16_t jump)
{
    int64_t frames = loss_tracker->counts.received - 1;
    if (loss_tracker->lost_bytes == 0 || frames <= 0 || loss_tracker->received_bytes <= 0)
        return jump < SEQ_JUMP_MAX ? jump : 0;
    int64_t about = loss_tracker->lost_bytes * frames / loss_tracker->received_bytes;
    int64_t wraps = (about - jump + SEQ_RANGE / 2) / SEQ_RANGE;
    return jump + (wraps > 0 ? wraps * SEQ_RANGE : 0);
}

void loss_tracker_add_serial_frame(struct loss_tracker *loss_tracker, uint16_t seq, int64_t block)
{
    uint16_t jump = (uint16_t)(seq - loss_tracker->next_seq);
    loss_tracker->counts.received++;
    int64_t lost = loss_tracker->seq_known ? count_lost_frames(loss_tracker, jump) : 0;
    loss_tracker->is_time_unconfirmed |= loss_tracker->seq_known && (jump > 0 || lost > 0);
    if (lost > 0) {
        loss_tracker->counts.lost += lost;
        loss_tracker->lost_since_last_block = true;
        add_gap(loss_tracker, make_gap(loss_tracker, "frame", "all",
                                       loss_tracker->loss_cause ? loss_tracker->loss_cause : "link",
                                       lost, loss_tracker->last_frame_block, block));
        loss_tracker->loss_cause = NULL;
        loss_tracker->lost_bytes = 0;
    }
    if (!loss_tracker->seq_known && seq == 0)
        loss_tracker->logged_since_start = true;
    loss_tracker->last_frame_block = block;
    loss_tracker->seq_known = true;
    loss_tracker->next_seq = (uint16_t)(seq + 1);
}

void loss_tracker_add_can_frame(struct loss_tracker *loss_tracker)
{
    loss_tracker->counts.received++;
    loss_tracker->received_since_health++;
    loss_tracker->received_since_unconfirmed++;
}

/* Handles the suspected gaps since the last can_health: records them if they are `believed`,
 * otherwise discards them. */
static void resolve_suspected_gaps(struct loss_tracker *loss_tracker, bool believed)
{
    for (size_t i = 0; believed && i < loss_tracker->suspected_gap_count; i++)
        add_gap(loss_tracker, loss_tracker->suspected_gap[i]);
    loss_tracker->suspected_gap_count = 0;
    loss_tracker->suspected_frames = 0;
}

/* cause of a gap for each receive queue of this computer */
static const struct {
    enum link_fault fault;
    const char *cause;
} loss_queues[LOSS_TRACKER_QUEUE_COUNT] = {{LINK_QUEUE_LOST, "queue"},
                                           {LINK_LOST_LOCK, "lock"},
                                           {LINK_LOST_SLOW_DISK, "slow disk"},
                                           {LINK_LOST_FULL_DISK, "full disk"},
                                           {LINK_LOST_PROCESSOR, "processor"}};

static int64_t sum_queue_losses(const struct loss_tracker *loss_tracker)
{
    int64_t sum = 0;
    for (size_t i = 0; i < LOSS_TRACKER_QUEUE_COUNT; i++)
        sum += loss_tracker->queue_lost_frames[i];
    return sum;
}

/* Records the lost CAN frames that this computer's queues counted; returns the number of lost
 * frames that remain. */
static int64_t add_queue_gaps(struct loss_tracker *loss_tracker, int64_t lost, int64_t block)
{
    for (size_t i = 0; i < LOSS_TRACKER_QUEUE_COUNT; i++) {
        int64_t in_queue = loss_tracker->queue_lost_frames[i] < lost
                             ? loss_tracker->queue_lost_frames[i]
                             : lost;
        if (in_queue > 0)
            add_gap(loss_tracker, make_gap(loss_tracker, "frame", "all", loss_queues[i].cause,
                                           in_queue, loss_tracker->sent_count_block, block));
        lost -= in_queue > 0 ? in_queue : 0;
        loss_tracker->queue_lost_frames[i] = 0;
    }
    return lost;
}

void loss_tracker_add_link_fault(struct loss_tracker *loss_tracker, enum link_fault fault,
                                 int64_t count)
{
    for (size_t i = 0; i < LOSS_TRACKER_QUEUE_COUNT; i++) {
        if (loss_queues[i].fault == fault && loss_tracker->kind == LINK_CAN)
            loss_tracker->queue_lost_frames[i] += count;
        else if (loss_queues[i].fault == fault) {
            loss_tracker->lost_bytes += count;
            loss_tracker->loss_cause = loss_queues[i].cause;
        }
    }
    if (fault == LINK_BUS_OFF)
        loss_tracker->loss_cause = "bus-off";
    else if ((fault == LINK_RX_OVERFLOW || fault == LINK_UART_OVERRUN) && !loss_tracker->loss_cause)
        loss_tracker->loss_cause = "adapter";
    else if (fault == LINK_AWAY)
        loss_tracker->loss_cause = "away";
}

/* Records the frames lost between two can_health messages: those that this computer's queues
 * counted under the queues' causes, the others under the cause that the link reported, or
 * "link". */
static void add_lost_frames(struct loss_tracker *loss_tracker, int64_t lost, int64_t block)
{
    const char *cause = loss_tracker->loss_cause ? loss_tracker->loss_cause : "link";
    loss_tracker->counts.lost += lost;
    int64_t elsewhere = add_queue_gaps(loss_tracker, lost, block);
    if (elsewhere > 0)
        add_gap(loss_tracker, make_gap(loss_tracker, "frame", "all", cause, elsewhere,
                                       loss_tracker->sent_count_block, block));
}

/* True if the count of the message continues the last accepted one. Otherwise the message is
 * doubted until a later one continues from it. */
static bool is_sent_count_plausible(struct loss_tracker *loss_tracker,
                                    const struct mr_can_health *health, int64_t block)
{
    if (!loss_tracker->sent_count_known ||
        is_can_frame_count_possible((int32_t)(health->sent - loss_tracker->sent_count),
                                    loss_tracker->sent_count_block, block)) {
        loss_tracker->unconfirmed_count_known = false;
        return true;
    }
    if (loss_tracker->unconfirmed_count_known &&
        is_can_frame_count_possible((int32_t)(health->sent - loss_tracker->unconfirmed_sent_count),
                                    loss_tracker->unconfirmed_count_block, block)) {
        /* the board restarted without a hello being received */
        loss_tracker->sent_count = loss_tracker->unconfirmed_sent_count;
        loss_tracker->sent_count_block = loss_tracker->unconfirmed_count_block;
        loss_tracker->received_since_health = loss_tracker->received_since_unconfirmed;
        loss_tracker->unconfirmed_count_known = false;
        return true;
    }
    loss_tracker->unconfirmed_count_known = true;
    loss_tracker->unconfirmed_sent_count = health->sent;
    loss_tracker->unconfirmed_count_block = block;
    loss_tracker->received_since_unconfirmed = 1;
    return false;
}

void loss_tracker_apply_can_health(struct loss_tracker *loss_tracker,
                                   const struct mr_can_health *health, int64_t block)
{
    if (!is_sent_count_plausible(loss_tracker, health, block))
        return;
    if (loss_tracker->sent_count_known) {
        /* This can_health is already counted as received, but its `sent` does not include
         * itself. */
        int64_t lost = (int64_t)(uint32_t)(health->sent - loss_tracker->sent_count) -
                       (loss_tracker->received_since_health - 1);
        resolve_suspected_gaps(loss_tracker, lost > 0);
        if (lost > 0)
            add_lost_frames(loss_tracker, lost, block);
    } else {
        /* The queues lost these frames before this message arrived. Frames that they lost before
         * logging began do not count. */
        if (loss_tracker->frames_before_log < 0) {
            int64_t before = (int64_t)health->sent - (loss_tracker->received_since_health - 1);
            int64_t in_queue = sum_queue_losses(loss_tracker);
            int64_t lost = in_queue < before ? in_queue : before;
            loss_tracker->frames_before_log = before - lost;
            loss_tracker->logged_since_start = loss_tracker->frames_before_log == 0;
            if (lost > 0)
                add_lost_frames(loss_tracker, lost, block);
            /* the board restarted, which reset its counter */
        } else if (sum_queue_losses(loss_tracker) > 0) {
            add_lost_frames(loss_tracker, sum_queue_losses(loss_tracker), block);
        }
        resolve_suspected_gaps(loss_tracker, false);
    }
    memset(loss_tracker->queue_lost_frames, 0, sizeof loss_tracker->queue_lost_frames);
    loss_tracker->loss_cause = NULL;
    loss_tracker->sent_count_known = true;
    loss_tracker->sent_count = health->sent;
    loss_tracker->sent_count_block = block;
    loss_tracker->received_since_health = 1;
    loss_tracker_apply_dropped_count(loss_tracker, health->dropped, block);
}

void loss_tracker_apply_dropped_count(struct loss_tracker *loss_tracker, uint16_t dropped,
                                      int64_t block)
{
    uint16_t more = (uint16_t)(dropped - loss_tracker->dropped_count);
    if (loss_tracker->dropped_count_known && more > 0) {
        loss_tracker->counts.dropped += more;
        add_gap(loss_tracker, make_gap(loss_tracker, "frame", "all", "board", more,
                                       loss_tracker->dropped_block, block));
    }
    loss_tracker->dropped_count_known = true;
    loss_tracker->dropped_count = dropped;
    loss_tracker->dropped_block = block;
}

/* Writes the channels of a message, for example "d1-d3". */
static void write_channels(const struct mr_series_pack *pack, char letter, char *out, size_t size)
{
    snprintf(out, size, "%c%u-%c%u", letter, (unsigned)pack->first_reading, letter,
             (unsigned)(pack->first_reading + pack->reading_count - 1));
}

void loss_tracker_add_series_message(struct loss_tracker *loss_tracker, unsigned number,
                                     int64_t block)
{
    const struct mr_series_pack *pack = mr_series_pack_at(number);
    const struct mr_series *series = mr_series_at(pack->series);
    int64_t last = loss_tracker->last_series_block[number];
    int64_t missing = (block - last) / series->averaged_blocks - 1;
    loss_tracker->last_series_block[number] = block;
    /* A step of IDLE_READING_PERIOD_BLOCKS may be due to an idle board: serial may not have
     * confirmed yet that it is armed. */
    if (last < 0 || block < 0 || missing <= 0 || block - last == IDLE_READING_PERIOD_BLOCKS)
        return;
    char channels[16];
    write_channels(pack, series->letter, channels, sizeof channels);
    loss_tracker->suspected_frames += missing;
    if (loss_tracker->suspected_gap_count < MR_SERIES_PACK_COUNT)
        loss_tracker->suspected_gap[loss_tracker->suspected_gap_count++] =
            make_gap(loss_tracker, mr_message_find(pack->id)->name, channels, "link", missing,
                     last + series->averaged_blocks, block - series->averaged_blocks);
}

void loss_tracker_add_block(struct loss_tracker *loss_tracker, uint32_t index)
{
    if (loss_tracker->block_known && index > loss_tracker->next_block)
        add_gap(loss_tracker, make_gap(loss_tracker, "block", "all",
                                       loss_tracker->lost_since_last_block ? "link" : "board",
                                       (int64_t)index - loss_tracker->next_block,
                                       loss_tracker->next_block, (int64_t)index - 1));
    loss_tracker->lost_since_last_block = false;
    loss_tracker->block_known = true;
    loss_tracker->next_block = index + 1;
}

void loss_tracker_end(struct loss_tracker *loss_tracker)
{
    /* frames missing between readings are part of the losses in the queues */
    int64_t in_queue = sum_queue_losses(loss_tracker) - loss_tracker->suspected_frames;
    if (in_queue > 0) {
        loss_tracker->counts.lost += in_queue;
        (void)add_queue_gaps(loss_tracker, in_queue, STORE_NONE);
    } else if (loss_tracker->suspected_frames == 0 && loss_tracker->loss_cause &&
               loss_tracker->kind == LINK_CAN) {
        add_gap(loss_tracker, make_gap(loss_tracker, "frame", "all", loss_tracker->loss_cause,
                                       STORE_NONE, loss_tracker->sent_count_block, STORE_NONE));
    }
    loss_tracker->counts.lost += loss_tracker->suspected_frames;
    resolve_suspected_gaps(loss_tracker, true);
    memset(loss_tracker->queue_lost_frames, 0, sizeof loss_tracker->queue_lost_frames);
    loss_tracker->loss_cause = NULL;
}
