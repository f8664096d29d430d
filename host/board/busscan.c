#include "host/board/busscan.h"

#include <stdio.h>
#include <string.h>

#define ROUND_US    100000u /* a board says the three within a millisecond or two of a free bus */
#define TWINS_US    10000u  /* a board that restarts says hello again after more */
#define TWINS_LEAST 2u
#define VOTES_LEAST 2u
#define LAYOUT_MOST 255u  /* versions count by ones */
#define BASE_STEP   0x10u /* of bases that are offered first */
#define TEXT_MOST   3u    /* identifiers named one by one */
#define FREE_MOST   4u

/* ---- what comes ---- */

static bool plausible(const struct mr_hello *hello)
{
    return hello->layout > 0 && hello->layout <= LAYOUT_MOST && hello->major < UINT8_MAX &&
           hello->clock_source <= MR_CLOCK_INTERNAL && hello->state <= MR_LANDING_DONE &&
           hello->reset_cause < 2 * MR_RESET_BROWN_OUT;
}

/* Of boards that speak at the same time a board_image may stand beside another's board_uid: words 0
 * and 1 tell chips apart, and a board that speaks `alone` says word 2. */
static void learn_uid(struct busscan_place *place, const uint32_t uid[3], bool alone)
{
    for (unsigned i = 0; i < place->uids; i++) {
        if (memcmp(place->uid[i], uid, sizeof place->said_uid[0]) != 0)
            continue;
        if (alone)
            place->uid[i][2] = uid[2];
        return;
    }
    if (place->uids < BUSSCAN_UIDS)
        memcpy(place->uid[place->uids++], uid, sizeof place->uid[0]);
}

static void learn_said(struct busscan_place *place, const uint32_t words[2])
{
    for (unsigned i = 0; i < place->said; i++) {
        if (memcmp(place->said_uid[i], words, sizeof place->said_uid[i]) == 0)
            return;
    }
    if (place->said < BUSSCAN_UIDS)
        memcpy(place->said_uid[place->said++], words, sizeof place->said_uid[0]);
}

/* A round is whole when each of the three came as often: then they belong together in order. What
 * else looks like a hello comes more often, and is followed by something else. */
static void close_round(struct busscan_place *place)
{
    const struct busscan_round *round = &place->round;
    if (round->hellos == 0 || round->hellos > BUSSCAN_UIDS || round->uids != round->hellos ||
        round->images != round->hellos)
        return;
    for (unsigned i = 0; i < round->hellos; i++)
        learn_uid(place, round->uid[i], round->hellos == 1);
}

static bool is_over(const struct busscan_round *round, uint64_t now_us)
{
    return now_us < round->last_us || now_us - round->last_us > ROUND_US;
}

static struct busscan_round *round_now(struct busscan_place *place, uint64_t now_us)
{
    if (is_over(&place->round, now_us)) {
        close_round(place);
        place->round = (struct busscan_round){0};
    }
    place->round.last_us = now_us;
    return &place->round;
}

static struct busscan_place *place_of(struct busscan *scan, uint16_t id, uint16_t message)
{
    return id >= message && id - message <= (int)MR_CAN_BASE_MOST ? &scan->place[id - message]
                                                                  : NULL;
}

static void take_hello(struct busscan_place *place, const struct link_frame *frame)
{
    struct mr_hello hello;
    if (!place || mr_hello_get(&hello, frame->data, frame->length) != MR_OK || !plausible(&hello))
        return;
    round_now(place, frame->host_us)->hellos++;
    place->twins += place->followed == 1 && frame->host_us >= place->hello_us &&
                    frame->host_us - place->hello_us < TWINS_US;
    place->hello = hello;
    place->hello_us = frame->host_us;
    place->followed = 1;
}

static void take_uid(struct busscan_place *place, const struct link_frame *frame)
{
    struct mr_board_uid uid;
    if (!place || mr_board_uid_get(&uid, frame->data, frame->length) != MR_OK)
        return;
    const uint32_t words[2] = {uid.uid0, uid.uid1};
    struct busscan_round *round = round_now(place, frame->host_us);
    if (round->uids < BUSSCAN_UIDS)
        memcpy(round->uid[round->uids], words, sizeof words);
    round->uids++;
    learn_said(place, words);
    if (place->followed == 1) {
        memcpy(place->following, words, sizeof words);
        place->followed = 2;
    }
}

/* The commonest stay: what another board says there is not the same each time. */
static void count_vote(struct busscan_place *place)
{
    struct busscan_vote *least = &place->vote[0];
    for (unsigned i = 0; i < BUSSCAN_VOTES; i++) {
        struct busscan_vote *vote = &place->vote[i];
        if (vote->votes && memcmp(vote->uid, place->following, sizeof vote->uid) == 0) {
            vote->votes++;
            return;
        }
        if (vote->votes < least->votes)
            least = vote;
    }
    memcpy(least->uid, place->following, sizeof least->uid);
    least->votes = 1;
}

static void take_image(struct busscan_place *place, const struct link_frame *frame)
{
    struct mr_board_image image;
    if (!place || mr_board_image_get(&image, frame->data, frame->length) != MR_OK)
        return;
    struct busscan_round *round = round_now(place, frame->host_us);
    if (round->images < BUSSCAN_UIDS)
        round->uid[round->images][2] = image.uid2;
    round->images++;
    if (place->followed == 2 && frame->host_us - place->hello_us <= ROUND_US) {
        place->following[2] = image.uid2;
        count_vote(place);
    }
    place->followed = 0;
}

void busscan_frame(struct busscan *scan, const struct link_frame *frame)
{
    if (frame->id & LINK_ID_ERROR) {
        scan->errors++;
        return;
    }
    if (scan->frames + scan->extended == 0)
        scan->first_us = frame->host_us;
    scan->last_us = frame->host_us;
    if (frame->id & LINK_ID_EXTENDED) {
        scan->extended++;
        return;
    }
    uint32_t id = frame->id & MR_CAN_ID_MOST;
    bool remote = (frame->id & LINK_ID_REMOTE) != 0;
    scan->frames++;
    scan->remote += remote;
    scan->heard[id][remote || frame->length > 8 ? BUSSCAN_REMOTE : frame->length]++;
    if (remote)
        return;
    take_hello(place_of(scan, (uint16_t)id, MR_ID_HELLO), frame);
    take_uid(place_of(scan, (uint16_t)id, MR_ID_BOARD_UID), frame);
    take_image(place_of(scan, (uint16_t)id, MR_ID_BOARD_IMAGE), frame);
}

double busscan_heard_s(const struct busscan *scan)
{
    return scan->last_us > scan->first_us ? (double)(scan->last_us - scan->first_us) / 1e6 : 0.0;
}

/* ---- who is there ---- */

/* What follows the hello of every board was heard of this one: what only looks like three messages
 * of a board lacks it. */
static bool is_followed(const struct busscan *scan, uint16_t base)
{
    static const uint16_t follow[] = {MR_ID_BOARD_CONFIG, MR_ID_CONFIG_STATE};
    for (size_t i = 0; i < sizeof follow / sizeof follow[0]; i++) {
        if (!scan->heard[mr_can_to_bus(follow[i], base)][mr_message_find(follow[i])->length])
            return false;
    }
    return true;
}

static void add_board(struct busscan_found *found, uint16_t base, struct busscan_place place)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);
    if (is_over(&place.round, found->scan->last_us))
        close_round(&place);
    for (unsigned i = 0; place.uids == 0 && i < BUSSCAN_VOTES; i++) {
        if (place.vote[i].votes >= VOTES_LEAST)
            learn_uid(&place, place.vote[i].uid, true);
    }
    if (place.uids == 0 || !is_followed(found->scan, base) || found->count == BUSSCAN_BOARDS)
        return;
    struct busscan_board *board = &found->board[found->count++];
    *board = (struct busscan_board){.base = base, .hello = place.hello, .uids = place.uids};
    for (unsigned i = 0; i < place.uids; i++)
        memcpy(board->who[i].uid, place.uid[i], sizeof place.uid[i]);
    for (size_t m = 0; m < count; m++) {
        uint16_t id = mr_can_to_bus(messages[m].id, base);
        board->frames += found->scan->heard[id][messages[m].length];
    }
}

/* Whether another board's messages have the identifier of hello or board_uid of this one. */
static bool is_mixed(const struct busscan_found *found, const struct busscan_board *self)
{
    for (unsigned i = 0; i < found->count; i++) {
        const struct busscan_board *other = &found->board[i];
        uint16_t hello = mr_can_to_bus(MR_ID_HELLO, self->base),
                 uid = mr_can_to_bus(MR_ID_BOARD_UID, self->base);
        if (other != self && (mr_message_find(mr_can_from_bus(hello, other->base)) ||
                              mr_message_find(mr_can_from_bus(uid, other->base))))
            return true;
    }
    return false;
}

/* Boards that speak at the same time spoil each other's messages, so that few rounds are whole:
 * a second board_uid, or two hellos at once, are of another board all the same. */
static void look_for_more(struct busscan_found *found, struct busscan_board *board)
{
    const struct busscan_place *place = &found->scan->place[board->base];
    bool several = place->said > 1 || place->twins >= TWINS_LEAST;
    board->more = !is_mixed(found, board) &&
                  (place->said > board->uids || (several && board->uids == 1) ||
                   place->said == BUSSCAN_UIDS);
}

bool busscan_is_shared(const struct busscan_board *board)
{
    return board->uids > 1 || board->more;
}

/* Whether a frame of this length is what a board that was found says, or is told. */
static bool is_of_board(const struct busscan_found *found, uint16_t id, unsigned length)
{
    for (unsigned i = 0; i < found->count; i++) {
        const struct mr_message_info *message =
            mr_message_find(mr_can_from_bus(id, found->board[i].base));
        if (message && message->length == length)
            return true;
    }
    return false;
}

void busscan_find(const struct busscan *scan, struct busscan_found *found)
{
    *found = (struct busscan_found){.scan = scan};
    for (unsigned base = 0; base <= MR_CAN_BASE_MOST; base++)
        add_board(found, (uint16_t)base, scan->place[base]);
    for (unsigned i = 0; i < found->count; i++)
        look_for_more(found, &found->board[i]);
    for (unsigned id = 0; id <= MR_CAN_ID_MOST; id++) {
        for (unsigned length = 0; length <= BUSSCAN_REMOTE; length++) {
            if (scan->heard[id][length] && !is_of_board(found, (uint16_t)id, length))
                found->stray[id] += scan->heard[id][length];
        }
    }
}

void busscan_leave(struct busscan_found *found, uint16_t base, const struct identity *who)
{
    for (unsigned i = 0; i < found->count; i++) {
        struct busscan_board *board = &found->board[i];
        board->leaving = board->base == base && !busscan_is_shared(board) &&
                         memcmp(board->who[0].uid, who->uid, sizeof who->uid) == 0;
    }
}

/* ---- who is in whose way ---- */

static bool is_in_the_way(const struct busscan_found *found, const struct busscan_board *self,
                          uint16_t id, struct busscan_conflict *conflict)
{
    conflict->id = id;
    conflict->board = NULL;
    conflict->frames = found->stray[id];
    for (unsigned i = 0; i < found->count && !conflict->board; i++) {
        const struct busscan_board *board = &found->board[i];
        conflict->other = mr_can_from_bus(id, board->base);
        if (board != self && !board->leaving && mr_message_find(conflict->other))
            conflict->board = board;
    }
    return conflict->board || conflict->frames > 0;
}

static size_t list_conflicts(const struct busscan_found *found, const struct busscan_board *self,
                             uint16_t base, struct busscan_conflict *list, size_t most)
{
    size_t count, there = 0;
    const struct mr_message_info *messages = mr_catalogue(&count);
    for (size_t m = 0; m < count; m++) {
        struct busscan_conflict conflict = {.message = messages[m].id};
        if (!is_in_the_way(found, self, mr_can_to_bus(messages[m].id, base), &conflict))
            continue;
        if (there < most)
            list[there] = conflict;
        there++;
    }
    return there;
}

size_t busscan_conflicts(const struct busscan_found *found, uint16_t base,
                         struct busscan_conflict *list, size_t most)
{
    return list_conflicts(found, NULL, base, list, most);
}

size_t busscan_conflicts_of(const struct busscan_found *found, const struct busscan_board *board,
                            struct busscan_conflict *list, size_t most)
{
    return list_conflicts(found, board, board->base, list, most);
}

void busscan_conflicts_text(const struct busscan_conflict *list, size_t count, size_t there,
                            char *out, size_t size)
{
    size_t used = 0, named = count < TEXT_MOST ? count : TEXT_MOST;
    out[0] = '\0';
    for (size_t i = 0; i < named && used < size; i++) {
        const struct busscan_conflict *c = &list[i];
        used += (size_t)snprintf(out + used, size - used, "%s0x%03x %s ", i ? ", " : "", c->id,
                                 mr_message_text(mr_message_place(c->message)));
        if (used < size && c->board)
            used += (size_t)snprintf(out + used, size - used, "(%s of the board at 0x%03x)",
                                     mr_message_text(mr_message_place(c->other)), c->board->base);
        else if (used < size)
            used += (size_t)snprintf(out + used, size - used, "(%u frame%s of no board)",
                                     (unsigned)c->frames, c->frames == 1 ? "" : "s");
    }
    if (there > named && used < size)
        snprintf(out + used, size - used, " and %zu more", there - named);
}

size_t busscan_free(const struct busscan_found *found, uint16_t *bases, size_t most)
{
    size_t there = 0;
    for (int first = 1; first >= 0; first--) {
        for (unsigned base = 0; base <= MR_CAN_BASE_MOST && there < most; base++) {
            if ((base % BASE_STEP == 0) == first &&
                busscan_conflicts(found, (uint16_t)base, NULL, 0) == 0)
                bases[there++] = (uint16_t)base;
        }
    }
    return there;
}

void busscan_free_text(const struct busscan_found *found, char *out, size_t size)
{
    uint16_t bases[FREE_MOST];
    size_t count = busscan_free(found, bases, FREE_MOST), used = 0;
    snprintf(out, size, "none");
    for (size_t i = 0; i < count && used < size; i++)
        used += (size_t)snprintf(out + used, size - used, "%s0x%03x", i ? ", " : "", bases[i]);
}
