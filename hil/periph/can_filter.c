/* Acceptance filters of bxCAN (RM0090 32.7.4): 14 banks of CAN1, mask or list of 32 bits. */
#include "hil/periph/can.h"

#define FMR_FINIT 1u

struct best {
    bool any;
    unsigned rank; /* lower wins: list before mask */
    unsigned fifo;
    unsigned match;
};

static uint32_t image32(const struct hil_can_frame *f)
{
    uint32_t id = f->extended ? f->id << 3 | 4u : f->id << 21;
    return id | (uint32_t)f->remote << 1;
}

static void offer(struct best *best, bool matches, unsigned rank, unsigned fifo, unsigned match)
{
    if (matches && (!best->any || rank < best->rank))
        *best = (struct best){true, rank, fifo, match};
}

bool hil_can_filter(const struct hil_can *can, const struct hil_can_frame *frame, unsigned *fifo,
                    unsigned *match)
{
    unsigned number[2] = {0, 0}; /* filters so far, per FIFO; inactive banks count too */
    unsigned banks = can->fmr >> 8 & 0x3fu;
    struct best best = {0};
    if (can->fmr & FMR_FINIT) /* nothing is received while filters are written */
        return false;
    uint32_t wide = image32(frame);
    for (unsigned i = 0; i < banks && i < HIL_CAN_BANKS; i++) {
        unsigned to = can->ffa1r >> i & 1u;
        bool list = (can->fm1r >> i & 1u) != 0;
        bool active = (can->fa1r >> i & 1u) != 0;
        uint32_t a = can->filter[i][0], b = can->filter[i][1];
        unsigned n = number[to];
        if (list) {
            offer(&best, active && (wide & ~1u) == (a & ~1u), 0, to, n);
            offer(&best, active && (wide & ~1u) == (b & ~1u), 0, to, n + 1);
        } else {
            offer(&best, active && ((wide ^ a) & b & ~1u) == 0, 1, to, n);
        }
        number[to] += list ? 2 : 1;
    }
    *fifo = best.fifo;
    *match = best.match;
    return best.any;
}
