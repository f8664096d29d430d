#include "hil/board/canbus.h"

#include <stdlib.h>
#include <string.h>

#include "hil/board/board.h"
#include "hil/board/parts.h"
#include "hil/periph/canbits.h"

#define BIT_PS      (HIL_SECOND_PS / HIL_CAN_HOST_RATE)
#define HOST        HIL_CANBUS_BOARDS /* as a sender, behind the boards */
#define NOBODY      (HOST + 1u)
#define SENDERS     (HOST + 1u)
/* What listeners see of a sender that is reset: six recessive bits, then their own error frame. */
#define BROKEN_BITS (6u + HIL_CAN_ERROR_BITS)

/* Where a board is plugged in. */
struct port {
    struct hil_canbus *bus;
    struct hil_board *board;
    unsigned number;
};

/* A frame that is ready, since when. */
struct claim {
    bool is;
    uint64_t since_ps;
    struct hil_can_frame frame;
};

struct hil_canbus {
    struct port port[HIL_CANBUS_BOARDS];
    unsigned boards;
    uint64_t now_ps;
    uint64_t free_ps;   /* end of the last frame and its intermission */
    uint64_t end_ps;    /* of the last frame */
    uint64_t unread_ps; /* until then no board acknowledged, and the host could not begin */
    unsigned sender;    /* of the last frame */
    bool spoiled;       /* it is bad */
    bool broken;        /* its sender has just been reset, at broken_ps */
    uint64_t broken_ps;
    struct hil_can_frame queue[HIL_CAN_QUEUE]; /* of the host */
    uint64_t ready_ps[HIL_CAN_QUEUE];
    unsigned waiting;
    struct hil_canbus_counts counts;
};

struct hil_canbus *hil_canbus_create(void)
{
    struct hil_canbus *bus = calloc(1, sizeof *bus);
    if (!bus)
        abort();
    bus->sender = NOBODY;
    return bus;
}

void hil_canbus_destroy(struct hil_canbus *bus)
{
    free(bus);
}

/* Behind those that are ready no later. */
static bool inject(void *who, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct hil_canbus *bus = ((struct port *)who)->bus;
    unsigned i = bus->waiting;
    if (i == HIL_CAN_QUEUE)
        return false;
    for (; i && bus->ready_ps[i - 1] > t_ps; i--) {
        bus->queue[i] = bus->queue[i - 1];
        bus->ready_ps[i] = bus->ready_ps[i - 1];
    }
    bus->queue[i] = *frame;
    bus->ready_ps[i] = t_ps;
    bus->waiting++;
    return true;
}

static void broke_off(void *who, uint64_t t_ps)
{
    const struct port *port = who;
    struct hil_canbus *bus = port->bus;
    bus->broken = port->number == bus->sender && t_ps < bus->end_ps;
    bus->broken_ps = t_ps;
}

enum mr_status hil_canbus_join(struct hil_canbus *bus, struct hil_board *board)
{
    if (bus->boards == HIL_CANBUS_BOARDS)
        return MR_FULL;
    for (unsigned i = 0; i < bus->boards; i++) {
        if (memcmp(bus->port[i].board->options.uid, board->options.uid,
                   sizeof board->options.uid) == 0)
            return MR_USAGE;
    }
    struct port *port = &bus->port[bus->boards];
    *port = (struct port){bus, board, bus->boards};
    board->mcu.can.shared = (struct hil_can_shared){port, inject, broke_off};
    bus->boards++;
    return MR_OK;
}

static struct hil_can_device *can_of(struct hil_canbus *bus, unsigned i)
{
    return &bus->port[i].board->mcu.can;
}

static uint64_t later(uint64_t a_ps, uint64_t b_ps)
{
    return a_ps > b_ps ? a_ps : b_ps;
}

static uint64_t sooner(uint64_t a_ps, uint64_t b_ps)
{
    return a_ps < b_ps ? a_ps : b_ps;
}

static void take_host(struct hil_canbus *bus)
{
    bus->waiting--;
    memmove(bus->queue, bus->queue + 1, bus->waiting * sizeof bus->queue[0]);
    memmove(bus->ready_ps, bus->ready_ps + 1, bus->waiting * sizeof bus->ready_ps[0]);
}

/* Who has a frame ready; when the first of them begins. */
static bool claims_of(struct hil_canbus *bus, struct claim claim[SENDERS], uint64_t *first_ps)
{
    bool heard = false, any = false;
    *first_ps = HIL_NEVER;
    for (unsigned i = 0; i < bus->boards; i++) {
        heard |= hil_can_acknowledges(can_of(bus, i));
        claim[i].is = hil_can_asks(can_of(bus, i), &claim[i].since_ps, &claim[i].frame);
    }
    if (!heard)
        bus->unread_ps = bus->now_ps;
    claim[HOST].is = heard && bus->waiting;
    if (claim[HOST].is)
        claim[HOST] = (struct claim){true, later(bus->ready_ps[0], bus->unread_ps), bus->queue[0]};
    for (unsigned i = 0; i < SENDERS; i++) {
        if (i >= bus->boards && i != HOST)
            continue;
        claim[i].since_ps = later(claim[i].since_ps, bus->free_ps);
        if (claim[i].is && claim[i].since_ps < *first_ps)
            *first_ps = claim[i].since_ps;
        any |= claim[i].is;
    }
    return any;
}

/* Order on the wire of two frames, bit by bit: negative where a wins. */
static int compare(const struct hil_can_frame *a, const struct hil_can_frame *b)
{
    uint32_t of_a = hil_can_arbitration(a), of_b = hil_can_arbitration(b);
    if (of_a != of_b)
        return of_a < of_b ? -1 : 1;
    if (a->length != b->length)
        return a->length < b->length ? -1 : 1;
    return a->remote ? 0 : memcmp(a->data, b->data, a->length);
}

/* Of those that begin with the first: the winner. A board's frame goes before the host's with the
 * same identifier. */
static unsigned winner_of(const struct hil_canbus *bus, const struct claim claim[SENDERS],
                          uint64_t first_ps)
{
    unsigned winner = NOBODY;
    for (unsigned i = 0; i < SENDERS; i++) {
        if ((i >= bus->boards && i != HOST) || !claim[i].is ||
            claim[i].since_ps - first_ps >= BIT_PS)
            continue;
        bool wins = winner == NOBODY ||
                    (i == HOST ? hil_can_arbitration(&claim[i].frame) <
                                     hil_can_arbitration(&claim[winner].frame)
                               : compare(&claim[i].frame, &claim[winner].frame) < 0);
        winner = wins ? i : winner;
    }
    return winner;
}

/* The same identifier as the winner's from another board, with other bits after it. */
static bool collides(const struct claim *claim, const struct claim *won, uint64_t first_ps)
{
    return claim->is && claim->since_ps - first_ps < BIT_PS &&
           hil_can_arbitration(&claim->frame) == hil_can_arbitration(&won->frame) &&
           compare(&claim->frame, &won->frame) != 0;
}

static bool suffers_corruption(struct hil_can_device *can, enum hil_line line, uint32_t id)
{
    return can->wire.suffers(can->wire.who, line, HIL_CORRUPT, "frame", id);
}

/* What ends a frame badly for all: a fault at any of its ends, or another with its identifier. */
static bool is_spoiled(struct hil_canbus *bus, const struct claim claim[SENDERS], unsigned winner,
                       uint64_t first_ps)
{
    const struct claim *won = &claim[winner];
    bool spoiled = false, collision = false;
    for (unsigned i = 0; i < bus->boards; i++) {
        struct hil_can_device *can = can_of(bus, i);
        if (i == winner) {
            spoiled |= suffers_corruption(can, HIL_CAN_OUT, won->frame.id);
        } else if (winner != HOST && collides(&claim[i], won, first_ps)) {
            collision = true;
            spoiled |= can->state->tec <= 127; /* its error flag is one of dominant bits */
            hil_trace(can->core, "CAN: another board sends identifier 0x%x too, with other data",
                      (unsigned)won->frame.id);
        } else if (hil_can_hears(can)) {
            spoiled |= suffers_corruption(can, HIL_CAN_IN, won->frame.id);
        }
    }
    bus->counts.collisions += collision;
    return spoiled;
}

static void begin(struct hil_canbus *bus, const struct claim claim[SENDERS], uint64_t first_ps)
{
    unsigned winner = winner_of(bus, claim, first_ps);
    const struct claim *won = &claim[winner];
    uint64_t end_ps, bit_ps = BIT_PS;
    bus->spoiled = is_spoiled(bus, claim, winner, first_ps);
    unsigned bits = hil_can_frame_bits(&won->frame).length -
                    (bus->spoiled ? HIL_CAN_TAIL_BITS - HIL_CAN_ERROR_BITS : 0u);
    if (winner == HOST) {
        end_ps = first_ps + bits * BIT_PS;
        if (!bus->spoiled)
            take_host(bus);
    } else {
        end_ps = hil_can_begin(can_of(bus, winner), first_ps, bits, bus->spoiled);
        bit_ps = (end_ps - first_ps) / bits;
    }
    for (unsigned i = 0; i < bus->boards; i++) {
        if (i == winner)
            continue;
        bool beside = claim[i].is && claim[i].since_ps - first_ps < BIT_PS;
        if (winner != HOST && collides(&claim[i], won, first_ps))
            hil_can_collide(can_of(bus, i), end_ps);
        else if (hil_can_hears(can_of(bus, i)))
            hil_can_listen(can_of(bus, i), &won->frame, end_ps, bus->spoiled,
                           beside && compare(&claim[i].frame, &won->frame) > 0);
    }
    bus->sender = winner;
    bus->end_ps = end_ps;
    bus->free_ps = end_ps + HIL_CAN_INTERMISSION_BITS * bit_ps;
    bus->counts.frames++;
    bus->counts.bad += bus->spoiled;
    bus->counts.busy_ps += end_ps - first_ps;
}

/* Begin what has begun by now; until when all boards can run before the next is decided. */
static uint64_t decide(struct hil_canbus *bus)
{
    struct claim claim[SENDERS];
    uint64_t first_ps;
    while (claims_of(bus, claim, &first_ps)) {
        if (first_ps + BIT_PS > bus->now_ps) /* another may begin with it yet */
            return first_ps + BIT_PS;
        begin(bus, claim, first_ps);
    }
    return later(bus->now_ps, bus->free_ps) + HIL_CANBUS_LOOK_PS;
}

/* The sender was reset: its listeners, which have not run that far, see an error. */
static void break_off(struct hil_canbus *bus)
{
    uint64_t end_ps = bus->broken_ps + BROKEN_BITS * BIT_PS;
    bus->broken = false;
    for (unsigned i = 0; i < bus->boards; i++)
        hil_can_listen_cut(can_of(bus, i), end_ps);
    bus->counts.bad += !bus->spoiled;
    bus->counts.busy_ps += end_ps - bus->end_ps;
    bus->spoiled = true;
    bus->end_ps = end_ps;
    bus->free_ps = end_ps + HIL_CAN_INTERMISSION_BITS * BIT_PS;
}

/* The sender first: what befalls it is known before the others see it. They run less far when the
 * bus is free earlier for that. */
static enum mr_status run_boards(struct hil_canbus *bus, uint64_t t_ps, unsigned *stopped)
{
    unsigned first = bus->sender < bus->boards ? bus->sender : 0;
    for (unsigned k = 0; k < bus->boards; k++) {
        unsigned i = k == 0 ? first : k <= first ? k - 1 : k;
        enum mr_status status = hil_board_run_until(bus->port[i].board, t_ps);
        if (status != MR_OK) {
            *stopped = i;
            return status;
        }
        if (bus->broken) {
            break_off(bus);
            t_ps = sooner(t_ps, bus->free_ps + HIL_CANBUS_LOOK_PS);
        }
    }
    bus->now_ps = t_ps;
    return MR_OK;
}

enum mr_status hil_canbus_run_until(struct hil_canbus *bus, uint64_t t_ps, unsigned *stopped)
{
    while (bus->now_ps < t_ps) {
        enum mr_status status = run_boards(bus, sooner(decide(bus), t_ps), stopped);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}

uint64_t hil_canbus_now_ps(const struct hil_canbus *bus)
{
    return bus->now_ps;
}

const struct hil_canbus_counts *hil_canbus_counts(const struct hil_canbus *bus)
{
    return &bus->counts;
}
