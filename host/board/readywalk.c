#include "host/board/readywalk.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static uint32_t bit(unsigned n)
{
    return n >= 1 && n <= WALK_ITEMS ? 1u << (n - 1) : 0u;
}

static uint32_t answered(const struct walk_order *order)
{
    uint32_t seen = 0;
    for (unsigned i = 0; i < order->count; i++)
        seen |= bit(order->order[i]);
    return seen;
}

unsigned walk_next(const struct walk_order *order)
{
    uint32_t open = order->fitted & ~answered(order) & ~order->passed;
    for (unsigned n = 1; n <= WALK_ITEMS; n++) {
        if (open & bit(n))
            return n;
    }
    return 0;
}

bool walk_over(const struct walk_order *order)
{
    return (order->fitted & ~answered(order)) == 0;
}

enum walk_answer walk_take(struct walk_order *order, unsigned n)
{
    unsigned next = walk_next(order);
    if (!(order->fitted & bit(n)))
        return WALK_NOT_FITTED;
    if (answered(order) & bit(n)) {
        order->again[n - 1] =
            (uint8_t)(order->again[n - 1] + (order->again[n - 1] < UINT8_MAX ? 1 : 0));
        return WALK_AGAIN;
    }
    if (next && n > next && order->count && order->order[order->count - 1] > next)
        order->passed |= bit(next);
    order->order[order->count++] = (uint8_t)n;
    return n == next ? WALK_NEXT : WALK_ANOTHER;
}

/* Those that answered, in the order in which they stand, or the other way round when most of the
 * walk went so. */
static void expected_order(const struct walk_order *order, uint8_t expected[WALK_ITEMS])
{
    unsigned down = 0, up = 0, k = 0;
    uint32_t seen = answered(order);
    for (unsigned i = 1; i < order->count; i++)
        *(order->order[i] < order->order[i - 1] ? &down : &up) += 1;
    for (unsigned n = 1; n <= WALK_ITEMS; n++) {
        if (seen & bit(n)) {
            expected[down > up ? order->count - 1 - k : k] = (uint8_t)n;
            k++;
        }
    }
}

static unsigned place_of(const uint8_t *list, unsigned count, unsigned n)
{
    unsigned i = 0;
    while (i < count && list[i] != n)
        i++;
    return i;
}

static void judge_order(const struct walk_order *order, const char *what, const char *verb,
                        struct ready_report *report)
{
    uint8_t expected[WALK_ITEMS];
    char name[20];
    expected_order(order, expected);
    for (unsigned i = 0; i < order->count; i++) {
        unsigned answers = order->order[i], meant = expected[i];
        unsigned j = place_of(expected, order->count, answers);
        struct ready_check *c;
        if (answers == meant)
            continue;
        snprintf(name, sizeof name, "%.10s %u", what, meant);
        if (order->order[j] != meant)
            c = ready_add(report, READY_NO_GO, name, "%s %u answered when %u was next", what,
                          answers, meant);
        else if (j > i)
            c = ready_add(report, READY_NO_GO, name,
                          "%s %u answered when %u was next, and %u when %u was: swapped", what,
                          answers, meant, meant, answers);
        else
            continue; /* the other half of a pair that was told */
        snprintf(c->limit, sizeof c->limit, "in order");
        snprintf(c->advice, sizeof c->advice,
                 "were they %s in that order? else change their leads, or their places in the "
                 "configuration",
                 verb);
    }
}

void walk_judge(const struct walk_order *order, const char *what, const char *verb,
                struct ready_report *report)
{
    char name[20];
    uint32_t seen = answered(order);
    unsigned before = report->count, fitted = 0;
    for (unsigned n = 1; n <= WALK_ITEMS; n++) {
        fitted += (order->fitted & bit(n)) != 0;
        if (!(order->fitted & ~seen & bit(n)))
            continue;
        snprintf(name, sizeof name, "%.10s %u", what, n);
        struct ready_check *c = ready_add(report, READY_NO_GO, name, "did not answer");
        snprintf(c->limit, sizeof c->limit, "answers once");
        snprintf(c->advice, sizeof c->advice, "was it %s? else look at its lead and contact", verb);
    }
    judge_order(order, what, verb, report);
    if (report->count == before && fitted) {
        snprintf(name, sizeof name, "%.10s walk", what);
        ready_add(report, READY_GO, name, "all %u answered, in order", fitted);
    }
}

/* ---- movements ---- */

void walk_motion_start(struct walk_motion *motion, unsigned channels, float limit)
{
    memset(motion, 0, sizeof *motion);
    motion->channels = channels < WALK_CHANNELS ? channels : WALK_CHANNELS;
    motion->limit = limit;
}

/* Half a second in which nothing moved by half the limit; `mean` of it. */
static bool still(const struct walk_motion *motion, float mean[WALK_CHANNELS])
{
    if (motion->rows < WALK_ROWS)
        return false;
    for (unsigned c = 0; c < motion->channels; c++) {
        float least = INFINITY, most = -INFINITY, sum = 0.0f;
        unsigned count = 0;
        for (unsigned i = 0; i < WALK_ROWS; i++) {
            float v = motion->row[i][c];
            if (isnan(v))
                continue;
            least = fminf(least, v);
            most = fmaxf(most, v);
            sum += v;
            count++;
        }
        if (count && most - least > 0.5f * motion->limit)
            return false;
        mean[c] = count ? sum / (float)count : NAN;
    }
    return true;
}

unsigned walk_motion_take(struct walk_motion *motion, const float *value)
{
    float mean[WALK_CHANNELS];
    unsigned most = 0;
    memcpy(motion->row[motion->rows++ % WALK_ROWS], value, motion->channels * sizeof *value);
    for (unsigned c = 0; motion->at_rest && c < motion->channels; c++) {
        float moved = fabsf(value[c] - motion->rest[c]); /* NaN compares false */
        if (moved > motion->limit)
            motion->moving = true;
        if (moved > motion->peak[c])
            motion->peak[c] = moved;
    }
    if (!still(motion, mean))
        return 0;
    for (unsigned c = 1; c < motion->channels; c++) {
        if (motion->peak[c] > motion->peak[most])
            most = c;
    }
    unsigned moved = motion->moving ? most + 1 : 0;
    memcpy(motion->rest, mean, sizeof motion->rest);
    memset(motion->peak, 0, sizeof motion->peak);
    motion->at_rest = true;
    motion->moving = false;
    return moved;
}
