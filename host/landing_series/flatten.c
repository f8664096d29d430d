#include "host/landing_series/flatten.h"

#include <math.h>
#include <stdbool.h>

#define CLOSED_FT 1e-12

/* What lies on one side of a joint. */
struct side {
    size_t front;     /* the next joint that is open */
    double resist_lb; /* of the mats up to there, and of closing it */
};

static struct side side_of(const struct flat_runway *r, size_t joint, int step)
{
    struct side side = {joint, 0.0};
    while ((step < 0 && side.front > 0) || (step > 0 && side.front + 1 < r->joints)) {
        side.front = (size_t)((long)side.front + step);
        side.resist_lb += r->rub_lb;
        if (r->gap_ft[side.front] > CLOSED_FT) {
            side.resist_lb += r->closing_lb[side.front];
            return side;
        }
    }
    side.resist_lb = HUGE_VAL; /* the runway's end */
    return side;
}

/* Mats between the joints `low` and `high` move by so much. */
static void shift(const struct flat_runway *r, size_t low, size_t high, double by_ft)
{
    for (size_t mat = low + 1; mat <= high; mat++)
        r->u_ft[mat] += by_ft;
}

void flatten(const struct flat_runway *r)
{
    for (size_t j = 0; j < r->joints; j++) {
        while (r->gap_ft[j] < -CLOSED_FT) {
            struct side left = side_of(r, j, -1), right = side_of(r, j, 1);
            bool to_left = left.resist_lb < right.resist_lb;
            struct side *side = to_left ? &left : &right;
            double over_ft = -r->gap_ft[j] - side->resist_lb / r->kl_lb_ft;
            if (!(over_ft > CLOSED_FT))
                break;
            double by_ft = fmin(over_ft, r->gap_ft[side->front]);
            r->gap_ft[side->front] -= by_ft;
            r->gap_ft[j] += by_ft;
            if (to_left)
                shift(r, side->front, j, -by_ft);
            else
                shift(r, j, side->front, by_ft);
        }
    }
}
