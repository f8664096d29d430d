/* Whose a frame on CAN is. What the board sends on both links waits for serial to say the same
 * (witness.h); where serial cannot, frames are looked at for what is plausible (collect_landing.c,
 * timebase.h, account.h). A stranger's frame is kept, counted and told, and not obeyed. */
#include <string.h>

#include "host/collect/collect_state.h"

#define ALIVE_BLOCKS 300 /* who watches waits for serial no longer than this */

static int64_t run_of(const struct side *side)
{
    const struct slot *slot = side->current;
    int64_t newest = collect_newest_block(side);
    /* of a landing that has just ended */
    if (!slot && side->last && newest >= 0 && newest <= side->last->end_block + ALIVE_BLOCKS)
        slot = side->last;
    return slot ? slot->row.id : STORE_NONE;
}

/* One event for each kind of doubt that is not recorded yet. */
enum mr_status collect_record_doubts(struct collector *collector, struct side *side,
                                     struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < side->doubts && status == MR_OK; i++) {
        struct doubted *doubted = &side->doubt[i];
        struct store_event event = {.session = collector->session,
                                    .boot = side->boot,
                                    .run = side->doubt_run,
                                    .board_us = side->doubt_us,
                                    .host_us = (int64_t)link_now_us(),
                                    .kind = STORE_DOUBT_KIND,
                                    .code = doubted->cause + DOUBT_ID * doubted->id,
                                    .detail = doubted->pending,
                                    .value = doubted->count,
                                    .links = collect_link_bit(side)};
        if (doubted->pending > 0)
            status = store_event_put(collector->store, &event, error);
        doubted->pending = 0;
    }
    side->doubts_pending = false;
    return status;
}

enum mr_status collect_doubt(struct collector *collector, struct side *side, enum doubt cause,
                             uint16_t id, int64_t count, struct error *error)
{
    int64_t run = run_of(side);
    enum mr_status status = MR_OK;
    size_t i = 0;
    if (side->doubts_pending && side->doubt_run != run)
        status = collect_record_doubts(collector, side, error);
    if (!side->doubts_pending) {
        side->doubts_pending = true;
        side->doubt_run = run;
        side->doubt_us = side->time.known ? timebase_now_us(&side->time) : STORE_NONE;
    }
    while (i < side->doubts && (side->doubt[i].cause != cause || side->doubt[i].id != id) &&
           i + 1 < DOUBTED_KINDS)
        i++; /* with no room left the last one counts for all others */
    if (i == side->doubts)
        side->doubt[side->doubts++] = (struct doubted){.cause = cause, .id = id};
    side->doubt[i].count += count;
    side->doubt[i].pending += count;
    if (cause == DOUBT_LENGTH)
        side->others_length += count;
    else if (cause == DOUBT_EXCESS || !doubt_obeyed(cause))
        side->strangers[cause == DOUBT_EXCESS] += count;
    if (cause != DOUBT_ALONE && (cause != DOUBT_EXCESS || side->newest_doubt.count == 0))
        side->newest_doubt = side->doubt[i];
    return status;
}

/* Frames in excess are among those that were recognised, or are more. Those of another length are
 * not counted as the board's. */
int64_t collect_strangers(const struct side *side)
{
    int64_t recognised = side->strangers[0], excess = side->strangers[1];
    return side->others_length + (excess > recognised ? excess : recognised);
}

bool collect_witnessed(const struct collector *collector, const struct side *side)
{
    return side->kind == LINK_CAN && !collector->side[LINK_SERIAL].ended;
}

static struct collector_event event_of(const struct side *side, const struct witness_message *heard)
{
    return (struct collector_event){.link = side->kind,
                                    .message = &heard->message,
                                    .host_us = heard->host_us,
                                    .board_us = collect_board_time(side, &heard->message)};
}

/* Tells who listens beside the campaign. */
static void publish(const struct collector *collector, const struct collector_event *event)
{
    if (collector->listener)
        collector->listener->message(collector->listener->context, event);
}

/* The raw frames that came while a message of the landing's state waited were taken for those of
 * the landing before. */
static enum mr_status move_frames(struct collector *collector, const struct side *side,
                                  const struct slot *before, int64_t mark, struct error *error)
{
    const struct slot *now = side->current;
    if (mark < 0 || now == before)
        return MR_OK;
    return store_frames_move(collector->store, collector->session, (int)side->kind,
                             now ? mark : mark + 1, before ? before->row.id : STORE_NONE,
                             now ? now->row.id : STORE_NONE, error);
}

static enum mr_status obey(struct collector *collector, struct side *side,
                           const struct collector_event *event, int64_t mark, struct error *error)
{
    struct slot *before = side->current;
    enum mr_status status = collect_message(collector, side, event, error);
    return status == MR_OK ? move_frames(collector, side, before, mark, error) : status;
}

/* Who a stranger says that it is: where the board itself never speaks on CAN it is the board there,
 * and the serial line another's. */
static void note_identity(struct side *side, const struct mr_message *message)
{
    if (message->place != MR_PLACE_BOARD_UID)
        return;
    side->others++;
    side->other_uid[0] = message->as.board_uid.uid0;
    side->other_uid[1] = message->as.board_uid.uid1;
}

enum mr_status collect_settle(struct collector *collector, bool over, struct error *error)
{
    struct side *side = &collector->side[LINK_CAN];
    struct witness_message message;
    enum mr_status status = MR_OK;
    while (status == MR_OK) {
        enum witness_verdict verdict = witness_take(&collector->witness, collect_newest_block(side),
                                                    over, &message);
        if (verdict == WITNESS_WAIT)
            break;
        if (verdict == WITNESS_STRANGER) {
            note_identity(side, &message.message);
            status = collect_doubt(collector, side, DOUBT_UNSAID, message.message.info->id, 1,
                                   error);
            continue;
        }
        const struct collector_event event = event_of(side, &message);
        if (!message.shown)
            publish(collector, &event);
        side->unheard = verdict == WITNESS_UNHEARD;
        if (side->unheard)
            status = collect_doubt(collector, side, DOUBT_ALONE, 0, 1, error);
        if (status == MR_OK)
            status = obey(collector, side, &event, message.mark, error);
        side->unheard = false;
    }
    return status;
}

/* Waits for serial; who watches does not when serial is behind. */
static enum mr_status wait_for_serial(struct collector *collector, struct side *side,
                                      struct witness_message *message, struct error *error)
{
    enum mr_status status = MR_OK;
    if (message->message.place == MR_PLACE_LANDING)
        status = store_frames_mark(collector->store, &message->mark, error);
    message->shown = collect_newest_block(side) >
                     collect_newest_block(&collector->side[LINK_SERIAL]) + ALIVE_BLOCKS;
    const struct collector_event event = event_of(side, message);
    if (message->shown)
        publish(collector, &event);
    if (status == MR_OK && collector->witness.count == WITNESS_WAITING)
        status = collect_settle(collector, false, error);
    witness_can(&collector->witness, message);
    return status;
}

enum mr_status collect_hear(struct collector *collector, struct side *side,
                            const struct collector_event *event, struct error *error)
{
    const struct mr_message *message = event->message;
    bool understood = collector->hello || message->place == MR_PLACE_HELLO;
    enum mr_status status = MR_OK;
    if (side->kind == LINK_SERIAL)
        witness_serial(&collector->witness, message, collect_newest_block(side));
    /* The first hello is obeyed whoever says it: nobody is known yet. */
    if (collector->hello && collect_witnessed(collector, side) && witness_covers(message)) {
        struct witness_message waiting = {.message = *message,
                                          .host_us = event->host_us,
                                          .block = collect_newest_block(side),
                                          .mark = -1};
        status = wait_for_serial(collector, side, &waiting, error);
    } else {
        publish(collector, event);
        side->unheard = side->kind == LINK_CAN;
        if (understood)
            status = obey(collector, side, event, -1, error);
        side->unheard = false;
    }
    return status == MR_OK ? collect_settle(collector, false, error) : status;
}
