#include "host/collect/account.h"

#include <stdio.h>
#include <string.h>

#include "common/catalogue.h"

/* A jump of more than half the range is a restarted sender, not a loss. */
#define SEQ_JUMP_MAX 0x8000u
#define SEQ_RANGE    0x10000

/* Upper limit: at 1 Mbit/s an empty frame takes 47 bit times, so 21 fit into a block. */
#define FRAMES_PER_BLOCK 21
#define IDLE_BLOCKS      100  /* between two readings of an idle board (firmware/schedule.def) */
#define SLACK_BLOCKS     1000 /* tolerance: clocks are sent every 100 blocks and can be lost */

void account_start(struct account *account, enum link_kind kind)
{
    memset(account, 0, sizeof *account);
    account->kind = kind;
    account->before_first = -1;
    account->frame_block = -1;
    account->sent_block = -1;
    account->dropped_block = -1;
    account_break(account);
}

void account_complete_from_start(struct account *account)
{
    account->whole = account->seq_known = true;
    account->seq_next = 0;
}

void account_message(struct account *account, unsigned place)
{
    if (place < MR_MESSAGES)
        account->received_of[place]++;
}

void account_settle(struct account *account)
{
    account->doubtful = false;
}

/* True: that many frames fit between the two blocks. An unknown block (-1) excludes nothing. */
static bool is_possible(int64_t frames, int64_t from_block, int64_t to_block)
{
    return frames >= 0 && (from_block < 0 || to_block < 0 ||
                           frames <= FRAMES_PER_BLOCK * (to_block - from_block + SLACK_BLOCKS));
}

static int64_t time_of(const struct account *account)
{
    return account->kind == LINK_CAN ? account->sent_block : account->frame_block;
}

bool account_message_count(struct account *account, const struct mr_message_count *count)
{
    unsigned place = mr_message_index(count->id);
    if (place >= MR_MESSAGES || account->doubtful ||
        (account->count_known[place] && count->count < account->count_of[place]))
        return false;
    if (account->count_known[place] &&
        !is_possible((int64_t)(count->count - account->count_of[place]),
                     account->count_block[place], time_of(account)))
        return false;
    /* A message_count does not count its own frame. */
    int64_t received = account->received_of[place] - (place == MR_INDEX_MESSAGE_COUNT);
    if (account->count_known[place] || account->whole) {
        bool known = account->count_known[place];
        uint32_t sent = count->count - (known ? account->count_of[place] : 0);
        int64_t missing = (int64_t)sent -
                          (received - (known ? account->received_at_count[place] : 0));
        if (missing > 0)
            account->missing_of[place] += missing;
        else
            account->repeated_of[place] -= missing;
    }
    account->count_known[place] = true;
    account->count_of[place] = count->count;
    account->count_block[place] = time_of(account);
    account->received_at_count[place] = received;
    return true;
}

void account_break(struct account *account)
{
    for (size_t i = 0; i < MR_SERIES_PACKS; i++)
        account->step_block[i] = -1;
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

/* If the list is full, the total is still correct and only the row is missing. The collector
 * empties the list after every frame. */
static void add_gap(struct account *account, struct store_gap gap)
{
    if (account->gaps < ACCOUNT_GAPS)
        account->gap[account->gaps++] = gap;
}

/* Estimates the frames in the bytes that this computer lost before a restart of the board, by
 * the mean frame size so far: no sequence number covers them. */
static void add_bytes_lost(struct account *account)
{
    int64_t lost = account->bytes > 0
                     ? account->bytes_lost * account->counts.received / account->bytes
                     : 0;
    lost = lost > 0 ? lost : 1;
    account->counts.lost += lost;
    add_gap(account,
            make_gap(account, "frame", "all", account->other_cause ? account->other_cause : "link",
                     lost, account->frame_block, -1));
    account->other_cause = NULL;
    account->bytes_lost = 0;
}

void account_restart(struct account *account, bool whole)
{
    if (account->bytes_lost > 0)
        add_bytes_lost(account);
    account->seq_known = false;
    account->sent_known = false;
    account->doubt_known = false;
    account->dropped_known = false;
    account->suspects = 0;
    account->suspect_count = 0;
    account->received_since = 0;
    account->frame_block = account->sent_block = -1;
    account->whole = whole;
    account->doubtful = false;
    memset(account->received_of, 0, sizeof account->received_of);
    memset(account->count_known, 0, sizeof account->count_known);
    account_break(account);
}

/* Number of lost frames for a jump of the sequence number; 0: none. If this computer also lost
 * bytes, the number may have wrapped: the number of wraps is the best fit to the mean frame size
 * so far. */
static int64_t frames_lost(const struct account *account, uint16_t jump)
{
    int64_t frames = account->counts.received - 1;
    if (account->bytes_lost == 0 || frames <= 0 || account->bytes <= 0)
        return jump < SEQ_JUMP_MAX ? jump : 0;
    int64_t about = account->bytes_lost * frames / account->bytes;
    int64_t wraps = (about - jump + SEQ_RANGE / 2) / SEQ_RANGE;
    return jump + (wraps > 0 ? wraps * SEQ_RANGE : 0);
}

void account_serial_frame(struct account *account, uint16_t seq, int64_t block)
{
    uint16_t jump = (uint16_t)(seq - account->seq_next);
    account->counts.received++;
    int64_t lost = account->seq_known ? frames_lost(account, jump) : 0;
    account->doubtful |= account->seq_known && (jump > 0 || lost > 0);
    if (lost > 0) {
        account->counts.lost += lost;
        account->lost_since_block = true;
        add_gap(account, make_gap(account, "frame", "all",
                                  account->other_cause ? account->other_cause : "link", lost,
                                  account->frame_block, block));
        account->other_cause = NULL;
        account->bytes_lost = 0;
    }
    if (!account->seq_known && seq == 0)
        account->whole = true;
    account->frame_block = block;
    account->seq_known = true;
    account->seq_next = (uint16_t)(seq + 1);
}

void account_can_frame(struct account *account)
{
    account->counts.received++;
    account->received_since++;
    account->doubt_since++;
}

/* Records or drops the suspected gaps since the last can_health. */
static void settle_suspects(struct account *account, bool believed)
{
    for (size_t i = 0; believed && i < account->suspects; i++)
        add_gap(account, account->suspect[i]);
    account->suspects = 0;
    account->suspect_count = 0;
}

/* Cause of a gap for each receive queue of this computer. */
static const struct {
    enum link_event trouble;
    const char *cause;
} queues[ACCOUNT_QUEUES] = {{LINK_QUEUE_LOST, "queue"},
                            {LINK_LOST_LOCK, "lock"},
                            {LINK_LOST_SLOW_DISK, "slow disk"},
                            {LINK_LOST_FULL_DISK, "full disk"},
                            {LINK_LOST_PROCESSOR, "processor"}};

static int64_t queues_lost(const struct account *account)
{
    int64_t sum = 0;
    for (size_t i = 0; i < ACCOUNT_QUEUES; i++)
        sum += account->queue_lost[i];
    return sum;
}

/* CAN: records the lost frames that the queues counted; returns the remaining number. */
static int64_t add_queue_gaps(struct account *account, int64_t lost, int64_t block)
{
    for (size_t i = 0; i < ACCOUNT_QUEUES; i++) {
        int64_t in_queue = account->queue_lost[i] < lost ? account->queue_lost[i] : lost;
        if (in_queue > 0)
            add_gap(account, make_gap(account, "frame", "all", queues[i].cause, in_queue,
                                      account->sent_block, block));
        lost -= in_queue > 0 ? in_queue : 0;
        account->queue_lost[i] = 0;
    }
    return lost;
}

void account_trouble(struct account *account, enum link_event trouble, int64_t count)
{
    for (size_t i = 0; i < ACCOUNT_QUEUES; i++) {
        if (queues[i].trouble == trouble && account->kind == LINK_CAN)
            account->queue_lost[i] += count;
        else if (queues[i].trouble == trouble) {
            account->bytes_lost += count;
            account->other_cause = queues[i].cause;
        }
    }
    if (trouble == LINK_BUS_OFF)
        account->other_cause = "bus-off";
    else if ((trouble == LINK_RX_OVERFLOW || trouble == LINK_UART_OVERRUN) && !account->other_cause)
        account->other_cause = "adapter";
    else if (trouble == LINK_AWAY)
        account->other_cause = "away";
}

/* Adds the frames lost between two can_health messages: those that the queues counted under the
 * queues' causes, the rest under the cause that the link reported, or "link". */
static void add_loss(struct account *account, int64_t lost, int64_t block)
{
    const char *cause = account->other_cause ? account->other_cause : "link";
    account->counts.lost += lost;
    int64_t elsewhere = add_queue_gaps(account, lost, block);
    if (elsewhere > 0)
        add_gap(account,
                make_gap(account, "frame", "all", cause, elsewhere, account->sent_block, block));
}

/* True: the message continues the last accepted one. Otherwise the message is doubtful until a
 * later one continues it. */
static bool is_believable(struct account *account, const struct mr_can_health *health,
                          int64_t block)
{
    if (!account->sent_known ||
        is_possible((int32_t)(health->sent - account->sent), account->sent_block, block)) {
        account->doubt_known = false;
        return true;
    }
    if (account->doubt_known &&
        is_possible((int32_t)(health->sent - account->doubt_sent), account->doubt_block, block)) {
        account->sent = account->doubt_sent; /* an unnoticed restart of the board */
        account->sent_block = account->doubt_block;
        account->received_since = account->doubt_since;
        account->doubt_known = false;
        return true;
    }
    account->doubt_known = true;
    account->doubt_sent = health->sent;
    account->doubt_block = block;
    account->doubt_since = 1;
    return false;
}

void account_can_health(struct account *account, const struct mr_can_health *health, int64_t block)
{
    if (!is_believable(account, health, block))
        return;
    if (account->sent_known) {
        /* This frame is counted as received, but `sent` does not include it yet. */
        int64_t lost = (int64_t)(uint32_t)(health->sent - account->sent) -
                       (account->received_since - 1);
        settle_suspects(account, lost > 0);
        if (lost > 0)
            add_loss(account, lost, block);
    } else {
        /* The queue's losses so far were sent before this message, but not before logging began. */
        if (account->before_first < 0) {
            int64_t before = (int64_t)health->sent - (account->received_since - 1);
            int64_t in_queue = queues_lost(account);
            int64_t lost = in_queue < before ? in_queue : before;
            account->before_first = before - lost;
            account->whole = account->before_first == 0;
            if (lost > 0)
                add_loss(account, lost, block);
        } else if (queues_lost(account) > 0) { /* the board and its counter restarted */
            add_loss(account, queues_lost(account), block);
        }
        settle_suspects(account, false);
    }
    memset(account->queue_lost, 0, sizeof account->queue_lost);
    account->other_cause = NULL;
    account->sent_known = true;
    account->sent = health->sent;
    account->sent_block = block;
    account->received_since = 1;
    account_dropped(account, health->dropped, block);
}

void account_dropped(struct account *account, uint16_t dropped, int64_t block)
{
    uint16_t more = (uint16_t)(dropped - account->dropped);
    if (account->dropped_known && more > 0) {
        account->counts.dropped += more;
        add_gap(account,
                make_gap(account, "frame", "all", "board", more, account->dropped_block, block));
    }
    account->dropped_known = true;
    account->dropped = dropped;
    account->dropped_block = block;
}

/* "d1-d3" */
static void channels_text(const struct mr_series_pack *pack, char letter, char *out, size_t size)
{
    snprintf(out, size, "%c%u-%c%u", letter, (unsigned)pack->first, letter,
             (unsigned)(pack->first + pack->count - 1));
}

void account_step(struct account *account, unsigned number, int64_t block)
{
    const struct mr_series_pack *pack = mr_series_pack_at(number);
    const struct mr_series *series = mr_series_at(pack->series);
    int64_t last = account->step_block[number];
    int64_t missing = (block - last) / series->blocks - 1;
    account->step_block[number] = block;
    /* a step of IDLE_BLOCKS may come from an idle board that serial has not confirmed yet */
    if (last < 0 || block < 0 || missing <= 0 || block - last == IDLE_BLOCKS)
        return;
    char channels[16];
    channels_text(pack, series->letter, channels, sizeof channels);
    account->suspect_count += missing;
    if (account->suspects < MR_SERIES_PACKS)
        account->suspect[account->suspects++] =
            make_gap(account, mr_message_find(pack->id)->name, channels, "link", missing,
                     last + series->blocks, block - series->blocks);
}

void account_block(struct account *account, uint32_t index)
{
    if (account->block_known && index > account->block_next)
        add_gap(account,
                make_gap(account, "block", "all", account->lost_since_block ? "link" : "board",
                         (int64_t)index - account->block_next, account->block_next,
                         (int64_t)index - 1));
    account->lost_since_block = false;
    account->block_known = true;
    account->block_next = index + 1;
}

void account_end(struct account *account)
{
    /* frames missing between readings are part of the queue's losses */
    int64_t in_queue = queues_lost(account) - account->suspect_count;
    if (in_queue > 0) {
        account->counts.lost += in_queue;
        (void)add_queue_gaps(account, in_queue, STORE_NONE);
    } else if (account->suspect_count == 0 && account->other_cause && account->kind == LINK_CAN) {
        add_gap(account, make_gap(account, "frame", "all", account->other_cause, STORE_NONE,
                                  account->sent_block, STORE_NONE));
    }
    account->counts.lost += account->suspect_count;
    settle_suspects(account, true);
    memset(account->queue_lost, 0, sizeof account->queue_lost);
    account->other_cause = NULL;
}
