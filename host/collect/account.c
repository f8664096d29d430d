#include "host/collect/account.h"

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

void account_start(struct account *account, enum link_kind kind)
{
    memset(account, 0, sizeof *account);
    account->kind = kind;
    account->frames_before_log = -1;
    account->last_frame_block = -1;
    account->sent_count_block = -1;
    account->dropped_block = -1;
    account_reset_series_steps(account);
}

void account_expect_first_frame(struct account *account)
{
    account->logged_since_start = account->seq_known = true;
    account->next_seq = 0;
}

void account_add_message(struct account *account, unsigned place)
{
    if (place < MR_MESSAGE_COUNT)
        account->received_count[place]++;
}

void account_confirm_board_time(struct account *account)
{
    account->is_time_unconfirmed = false;
}

/* True if `frames` frames fit between the two blocks. If a block is not known (-1), any number
 * fits. */
static bool is_can_frame_count_possible(int64_t frames, int64_t from_block, int64_t to_block)
{
    return frames >= 0 && (from_block < 0 || to_block < 0 ||
                           frames <= CAN_FRAMES_PER_BLOCK_MAX *
                                         (to_block - from_block + CLOCK_LOSS_TOLERANCE_BLOCKS));
}

static int64_t get_newest_block(const struct account *account)
{
    return account->kind == LINK_CAN ? account->sent_count_block : account->last_frame_block;
}

bool account_apply_message_count(struct account *account, const struct mr_message_count *count)
{
    unsigned place = mr_message_index(count->id);
    if (place >= MR_MESSAGE_COUNT || account->is_time_unconfirmed ||
        (account->board_count_known[place] && count->count < account->board_count[place]))
        return false;
    if (account->board_count_known[place] &&
        !is_can_frame_count_possible((int64_t)(count->count - account->board_count[place]),
                                     account->board_count_block[place], get_newest_block(account)))
        return false;
    /* The board counts a message_count only after sending it, so the count in it excludes
     * itself. */
    int64_t received = account->received_count[place] - (place == MR_INDEX_MESSAGE_COUNT);
    if (account->board_count_known[place] || account->logged_since_start) {
        bool known = account->board_count_known[place];
        uint32_t sent = count->count - (known ? account->board_count[place] : 0);
        int64_t missing = (int64_t)sent -
                          (received - (known ? account->received_at_board_count[place] : 0));
        if (missing > 0)
            account->missing_count[place] += missing;
        else
            account->repeated_count[place] -= missing;
    }
    account->board_count_known[place] = true;
    account->board_count[place] = count->count;
    account->board_count_block[place] = get_newest_block(account);
    account->received_at_board_count[place] = received;
    return true;
}

void account_reset_series_steps(struct account *account)
{
    for (size_t i = 0; i < MR_SERIES_PACK_COUNT; i++)
        account->last_series_block[i] = -1;
    account->block_known = false;
}

static struct store_gap make_gap(const struct account *account, const char *message,
                                 const char *channels, const char *cause, int64_t count,
                                 int64_t from_block, int64_t to_block)
{
    struct store_gap gap = {.link = (int)account->kind,
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
static void add_gap(struct account *account, struct store_gap gap)
{
    if (account->gap_count < ACCOUNT_GAPS_MAX)
        account->gap[account->gap_count++] = gap;
}

/* Estimates how many frames were in the bytes that this computer lost before the board restarted,
 * from the mean frame size so far. Sequence numbers do not show this loss. */
static void add_lost_bytes(struct account *account)
{
    int64_t lost = account->received_bytes > 0
                     ? account->lost_bytes * account->counts.received / account->received_bytes
                     : 0;
    lost = lost > 0 ? lost : 1;
    account->counts.lost += lost;
    add_gap(account,
            make_gap(account, "frame", "all", account->loss_cause ? account->loss_cause : "link",
                     lost, account->last_frame_block, -1));
    account->loss_cause = NULL;
    account->lost_bytes = 0;
}

void account_restart(struct account *account, bool whole)
{
    if (account->lost_bytes > 0)
        add_lost_bytes(account);
    account->seq_known = false;
    account->sent_count_known = false;
    account->doubted_count_known = false;
    account->dropped_count_known = false;
    account->suspected_gap_count = 0;
    account->suspected_frames = 0;
    account->received_since_health = 0;
    account->last_frame_block = account->sent_count_block = -1;
    account->logged_since_start = whole;
    account->is_time_unconfirmed = false;
    memset(account->received_count, 0, sizeof account->received_count);
    memset(account->board_count_known, 0, sizeof account->board_count_known);
    account_reset_series_steps(account);
}

/* Returns the number of lost frames for a jump of the sequence number; 0: none. If this computer
 * also lost bytes, the number may have wrapped: the number of wraps is the best fit to the mean
 * frame size so far. */
static int64_t count_lost_frames(const struct account *account, uint16_t jump)
{
    int64_t frames = account->counts.received - 1;
    if (account->lost_bytes == 0 || frames <= 0 || account->received_bytes <= 0)
        return jump < SEQ_JUMP_MAX ? jump : 0;
    int64_t about = account->lost_bytes * frames / account->received_bytes;
    int64_t wraps = (about - jump + SEQ_RANGE / 2) / SEQ_RANGE;
    return jump + (wraps > 0 ? wraps * SEQ_RANGE : 0);
}

void account_add_serial_frame(struct account *account, uint16_t seq, int64_t block)
{
    uint16_t jump = (uint16_t)(seq - account->next_seq);
    account->counts.received++;
    int64_t lost = account->seq_known ? count_lost_frames(account, jump) : 0;
    account->is_time_unconfirmed |= account->seq_known && (jump > 0 || lost > 0);
    if (lost > 0) {
        account->counts.lost += lost;
        account->lost_since_last_block = true;
        add_gap(account, make_gap(account, "frame", "all",
                                  account->loss_cause ? account->loss_cause : "link", lost,
                                  account->last_frame_block, block));
        account->loss_cause = NULL;
        account->lost_bytes = 0;
    }
    if (!account->seq_known && seq == 0)
        account->logged_since_start = true;
    account->last_frame_block = block;
    account->seq_known = true;
    account->next_seq = (uint16_t)(seq + 1);
}

void account_add_can_frame(struct account *account)
{
    account->counts.received++;
    account->received_since_health++;
    account->received_since_doubt++;
}

/* Handles the suspected gaps since the last can_health: records them if they are `believed`,
 * otherwise discards them. */
static void settle_suspected_gaps(struct account *account, bool believed)
{
    for (size_t i = 0; believed && i < account->suspected_gap_count; i++)
        add_gap(account, account->suspected_gap[i]);
    account->suspected_gap_count = 0;
    account->suspected_frames = 0;
}

/* cause of a gap for each receive queue of this computer */
static const struct {
    enum link_fault fault;
    const char *cause;
} loss_queues[ACCOUNT_QUEUE_COUNT] = {{LINK_QUEUE_LOST, "queue"},
                                      {LINK_LOST_LOCK, "lock"},
                                      {LINK_LOST_SLOW_DISK, "slow disk"},
                                      {LINK_LOST_FULL_DISK, "full disk"},
                                      {LINK_LOST_PROCESSOR, "processor"}};

static int64_t sum_queue_losses(const struct account *account)
{
    int64_t sum = 0;
    for (size_t i = 0; i < ACCOUNT_QUEUE_COUNT; i++)
        sum += account->queue_lost_frames[i];
    return sum;
}

/* Records the lost CAN frames that this computer's queues counted; returns the number of lost
 * frames that remain. */
static int64_t add_queue_gaps(struct account *account, int64_t lost, int64_t block)
{
    for (size_t i = 0; i < ACCOUNT_QUEUE_COUNT; i++) {
        int64_t in_queue = account->queue_lost_frames[i] < lost ? account->queue_lost_frames[i]
                                                                : lost;
        if (in_queue > 0)
            add_gap(account, make_gap(account, "frame", "all", loss_queues[i].cause, in_queue,
                                      account->sent_count_block, block));
        lost -= in_queue > 0 ? in_queue : 0;
        account->queue_lost_frames[i] = 0;
    }
    return lost;
}

void account_add_link_fault(struct account *account, enum link_fault fault, int64_t count)
{
    for (size_t i = 0; i < ACCOUNT_QUEUE_COUNT; i++) {
        if (loss_queues[i].fault == fault && account->kind == LINK_CAN)
            account->queue_lost_frames[i] += count;
        else if (loss_queues[i].fault == fault) {
            account->lost_bytes += count;
            account->loss_cause = loss_queues[i].cause;
        }
    }
    if (fault == LINK_BUS_OFF)
        account->loss_cause = "bus-off";
    else if ((fault == LINK_RX_OVERFLOW || fault == LINK_UART_OVERRUN) && !account->loss_cause)
        account->loss_cause = "adapter";
    else if (fault == LINK_AWAY)
        account->loss_cause = "away";
}

/* Records the frames lost between two can_health messages: those that this computer's queues
 * counted under the queues' causes, the others under the cause that the link reported, or
 * "link". */
static void add_lost_frames(struct account *account, int64_t lost, int64_t block)
{
    const char *cause = account->loss_cause ? account->loss_cause : "link";
    account->counts.lost += lost;
    int64_t elsewhere = add_queue_gaps(account, lost, block);
    if (elsewhere > 0)
        add_gap(account, make_gap(account, "frame", "all", cause, elsewhere,
                                  account->sent_count_block, block));
}

/* True if the count of the message continues the last accepted one. Otherwise the message is
 * doubted until a later one continues from it. */
static bool is_sent_count_plausible(struct account *account, const struct mr_can_health *health,
                                    int64_t block)
{
    if (!account->sent_count_known ||
        is_can_frame_count_possible((int32_t)(health->sent - account->sent_count),
                                    account->sent_count_block, block)) {
        account->doubted_count_known = false;
        return true;
    }
    if (account->doubted_count_known &&
        is_can_frame_count_possible((int32_t)(health->sent - account->doubted_sent_count),
                                    account->doubted_count_block, block)) {
        /* the board restarted without a hello being received */
        account->sent_count = account->doubted_sent_count;
        account->sent_count_block = account->doubted_count_block;
        account->received_since_health = account->received_since_doubt;
        account->doubted_count_known = false;
        return true;
    }
    account->doubted_count_known = true;
    account->doubted_sent_count = health->sent;
    account->doubted_count_block = block;
    account->received_since_doubt = 1;
    return false;
}

void account_apply_can_health(struct account *account, const struct mr_can_health *health,
                              int64_t block)
{
    if (!is_sent_count_plausible(account, health, block))
        return;
    if (account->sent_count_known) {
        /* This can_health is already counted as received, but its `sent` does not include
         * itself. */
        int64_t lost = (int64_t)(uint32_t)(health->sent - account->sent_count) -
                       (account->received_since_health - 1);
        settle_suspected_gaps(account, lost > 0);
        if (lost > 0)
            add_lost_frames(account, lost, block);
    } else {
        /* The queues lost these frames before this message arrived. Frames that they lost before
         * logging began do not count. */
        if (account->frames_before_log < 0) {
            int64_t before = (int64_t)health->sent - (account->received_since_health - 1);
            int64_t in_queue = sum_queue_losses(account);
            int64_t lost = in_queue < before ? in_queue : before;
            account->frames_before_log = before - lost;
            account->logged_since_start = account->frames_before_log == 0;
            if (lost > 0)
                add_lost_frames(account, lost, block);
            /* the board restarted, which reset its counter */
        } else if (sum_queue_losses(account) > 0) {
            add_lost_frames(account, sum_queue_losses(account), block);
        }
        settle_suspected_gaps(account, false);
    }
    memset(account->queue_lost_frames, 0, sizeof account->queue_lost_frames);
    account->loss_cause = NULL;
    account->sent_count_known = true;
    account->sent_count = health->sent;
    account->sent_count_block = block;
    account->received_since_health = 1;
    account_apply_dropped_count(account, health->dropped, block);
}

void account_apply_dropped_count(struct account *account, uint16_t dropped, int64_t block)
{
    uint16_t more = (uint16_t)(dropped - account->dropped_count);
    if (account->dropped_count_known && more > 0) {
        account->counts.dropped += more;
        add_gap(account,
                make_gap(account, "frame", "all", "board", more, account->dropped_block, block));
    }
    account->dropped_count_known = true;
    account->dropped_count = dropped;
    account->dropped_block = block;
}

/* Writes the channels of a message, for example "d1-d3". */
static void write_channels(const struct mr_series_pack *pack, char letter, char *out, size_t size)
{
    snprintf(out, size, "%c%u-%c%u", letter, (unsigned)pack->first, letter,
             (unsigned)(pack->first + pack->count - 1));
}

void account_add_series_message(struct account *account, unsigned number, int64_t block)
{
    const struct mr_series_pack *pack = mr_series_pack_at(number);
    const struct mr_series *series = mr_series_at(pack->series);
    int64_t last = account->last_series_block[number];
    int64_t missing = (block - last) / series->blocks - 1;
    account->last_series_block[number] = block;
    /* A step of IDLE_READING_PERIOD_BLOCKS may be due to an idle board: serial may not have
     * confirmed yet that it is armed. */
    if (last < 0 || block < 0 || missing <= 0 || block - last == IDLE_READING_PERIOD_BLOCKS)
        return;
    char channels[16];
    write_channels(pack, series->letter, channels, sizeof channels);
    account->suspected_frames += missing;
    if (account->suspected_gap_count < MR_SERIES_PACK_COUNT)
        account->suspected_gap[account->suspected_gap_count++] =
            make_gap(account, mr_message_find(pack->id)->name, channels, "link", missing,
                     last + series->blocks, block - series->blocks);
}

void account_add_block(struct account *account, uint32_t index)
{
    if (account->block_known && index > account->next_block)
        add_gap(account,
                make_gap(account, "block", "all", account->lost_since_last_block ? "link" : "board",
                         (int64_t)index - account->next_block, account->next_block,
                         (int64_t)index - 1));
    account->lost_since_last_block = false;
    account->block_known = true;
    account->next_block = index + 1;
}

void account_end(struct account *account)
{
    /* frames missing between readings are part of the losses in the queues */
    int64_t in_queue = sum_queue_losses(account) - account->suspected_frames;
    if (in_queue > 0) {
        account->counts.lost += in_queue;
        (void)add_queue_gaps(account, in_queue, STORE_NONE);
    } else if (account->suspected_frames == 0 && account->loss_cause && account->kind == LINK_CAN) {
        add_gap(account, make_gap(account, "frame", "all", account->loss_cause, STORE_NONE,
                                  account->sent_count_block, STORE_NONE));
    }
    account->counts.lost += account->suspected_frames;
    settle_suspected_gaps(account, true);
    memset(account->queue_lost_frames, 0, sizeof account->queue_lost_frames);
    account->loss_cause = NULL;
}
