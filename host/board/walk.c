#include "host/board/walk.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "host/board/config_text.h"

const char *const walk_names[WALK_KINDS] = {"switch", "transducer", "gage"};
static const char *const verbs[WALK_KINDS] = {"tripped", "pushed", "pulled"};

/* ---- movements ---- */

void walk_motion_start(struct walk_motion *motion, unsigned channels, float limit)
{
    memset(motion, 0, sizeof *motion);
    motion->channels = channels < WALK_CHANNELS ? channels : WALK_CHANNELS;
    motion->limit = limit;
}

/* Half a second in which nothing moved by half the limit; `mean` of it. */
static bool is_still(const struct walk_motion *motion, float mean[WALK_CHANNELS])
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
    if (!is_still(motion, mean))
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

/* ---- answers ---- */

void walk_start(struct walk *walk, const struct mr_config *config)
{
    memset(walk, 0, sizeof *walk);
    walk->config = config;
    walk_motion_start(&walk->transducers, MR_TRANSDUCERS, WALK_PUSH_IN);
    walk_motion_start(&walk->gages, MR_GAGES, WALK_PULL_LB);
}

static bool is_fitted(const struct walk *walk, enum walk_kind kind, unsigned n)
{
    unsigned first = kind == WALK_GAGE ? MR_TRANSDUCERS : 0,
             count = kind == WALK_GAGE ? MR_GAGES : MR_TRANSDUCERS;
    if (kind == WALK_SWITCH)
        return n >= 1 && n <= MR_CONFIG_SWITCHES && walk->config->gate[n - 1].step_codes;
    for (unsigned i = first; i < first + count; i++) {
        if (mr_channel_measures(&walk->config->channel[i]) && walk->config->channel[i].number == n)
            return true;
    }
    return false;
}

static unsigned fitted_count(const struct walk *walk, enum walk_kind kind)
{
    unsigned count = 0;
    for (unsigned n = 1; n <= WALK_ITEMS; n++)
        count += is_fitted(walk, kind, n);
    return count;
}

static bool add(struct walk *walk, enum walk_kind kind, struct walk_answer answer)
{
    if (walk->count[kind] == WALK_ANSWERS)
        return false;
    walk->answer[kind][walk->count[kind]++] = answer;
    return true;
}

bool walk_take_edge(struct walk *walk, const struct mr_edge *edge)
{
    if (!((double)edge->step_codes >= MR_CONFIG_STEP_CODES))
        return false;
    return add(walk, WALK_SWITCH,
               (struct walk_answer){.number = edge->position,
                                    .edge = (uint8_t)edge->count,
                                    .codes = (double)edge->step_codes});
}

void walk_take_event(struct walk *walk, const struct mr_switch_event *event)
{
    unsigned *count = &walk->count[WALK_SWITCH];
    if (event->reason == MR_SWITCH_BOUNCE && *count &&
        walk->answer[WALK_SWITCH][*count - 1].edge == event->count)
        --*count;
    walk->strange += event->reason == MR_SWITCH_NO_STEP || event->reason == MR_SWITCH_OTHER_STEP ||
                     event->reason == MR_SWITCH_TOO_NEAR;
}

bool walk_take_reading(struct walk *walk, const struct mr_block *block, enum walk_kind *kind)
{
    const struct mr_channel_config *channel = walk->config->channel;
    float value[MR_TRANSDUCERS + MR_GAGES],
        ratio = mr_channels_ratio(&channel[MR_REFERENCE], block);
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++)
        value[i] = mr_channel_read(&channel[i], block, i, ratio).value;
    unsigned pushed = walk_motion_take(&walk->transducers, value),
             pulled = walk_motion_take(&walk->gages, value + MR_TRANSDUCERS), moved = 0;
    walk->gage_disturbed |= walk->gages.moving && walk->transducers.moving;
    if (pushed)
        moved = pushed;
    else if (pulled && !walk->gage_disturbed)
        moved = MR_TRANSDUCERS + pulled;
    if (!walk->gages.moving && !walk->transducers.moving)
        walk->gage_disturbed = false;
    *kind = moved > MR_TRANSDUCERS ? WALK_GAGE : WALK_TRANSDUCER;
    return moved && add(walk, *kind, (struct walk_answer){.number = channel[moved - 1].number});
}

/* ---- the table ---- */

/* The numbers that are fitted and answered, in the order in which they did, each once. */
static unsigned in_order(const struct walk *walk, enum walk_kind kind, unsigned order[WALK_ITEMS])
{
    unsigned count = 0;
    for (unsigned i = 0; i < walk->count[kind]; i++) {
        unsigned n = walk->answer[kind][i].number, k = 0;
        while (k < count && order[k] != n)
            k++;
        if (k == count && count < WALK_ITEMS && is_fitted(walk, kind, n))
            order[count++] = n;
    }
    return count;
}

static int by_number(const void *a, const void *b)
{
    return (int)*(const unsigned *)a - (int)*(const unsigned *)b;
}

static int by_number_down(const void *a, const void *b)
{
    return by_number(b, a);
}

bool walk_is_over(const struct walk *walk, bool learns)
{
    unsigned order[WALK_ITEMS];
    if (learns)
        return walk->count[WALK_SWITCH] >= fitted_count(walk, WALK_SWITCH);
    for (enum walk_kind kind = 0; kind < WALK_KINDS; kind++) {
        if (in_order(walk, kind, order) < fitted_count(walk, kind))
            return false;
    }
    return true;
}

static void judge_one(enum walk_kind kind, unsigned n, bool answered, unsigned meant,
                      struct ready_report *report)
{
    char name[20];
    snprintf(name, sizeof name, "%s %u", walk_names[kind], n);
    struct ready_check *c = answered ? ready_add(report, READY_NO_GO, name,
                                                 "answered when %u was next", meant)
                                     : ready_add(report, READY_NO_GO, name, "did not answer");
    snprintf(c->limit, sizeof c->limit, answered ? "in order" : "answers once");
    snprintf(c->advice, sizeof c->advice,
             answered ? "were they %s in that order? else swap their leads, or their places in the "
                        "configuration"
                      : "was it %s? else look at its lead and contact",
             verbs[kind]);
}

static void judge_kind(const struct walk *walk, enum walk_kind kind, struct ready_report *report)
{
    unsigned order[WALK_ITEMS], meant[WALK_ITEMS], down = 0, count = in_order(walk, kind, order),
                                                   fitted = fitted_count(walk, kind);
    unsigned before = report->count;
    char name[20];
    snprintf(name, sizeof name, "%s walk", walk_names[kind]);
    if (!fitted)
        return;
    if (!count) {
        ready_add(report, READY_NOT_DONE, name, "none of %u answered", fitted);
        return;
    }
    /* sorted, the other way round when most of the walk went so */
    memcpy(meant, order, sizeof meant);
    for (unsigned i = 1; i < count; i++)
        down += order[i] < order[i - 1];
    qsort(meant, count, sizeof *meant, 2 * down >= count && count > 1 ? by_number_down : by_number);
    for (unsigned n = 1; n <= WALK_ITEMS; n++) {
        unsigned i = 0;
        while (i < count && order[i] != n)
            i++;
        if (is_fitted(walk, kind, n) && (i == count || meant[i] != n))
            judge_one(kind, n, i < count, i < count ? meant[i] : 0, report);
    }
    if (report->count == before)
        ready_add(report, READY_GO, name, "all %u answered, in order", fitted);
}

void walk_judge(const struct walk *walk, struct ready_report *report)
{
    for (enum walk_kind kind = 0; kind < WALK_KINDS; kind++)
        judge_kind(walk, kind, report);
    if (walk->strange) {
        struct ready_check *c = ready_add(report, READY_NO_GO, "edges",
                                          "%u edges of no switch of the table", walk->strange);
        snprintf(c->advice, sizeof c->advice,
                 "does a step of the configuration differ from its resistor? is a contact bad?");
    }
}

/* ---- learning ---- */

struct learning {
    unsigned count, position[WALK_ANSWERS]; /* of the n-th switch that is fitted */
    double furthest_codes, apart_codes;     /* from what is configured; of the nearest two */
    unsigned near, near_other;
    bool as_built; /* the configured steps are as far apart as they are built */
};

static void find_nearest(const struct walk *walk, struct learning *l)
{
    const struct walk_answer *a = walk->answer[WALK_SWITCH];
    l->apart_codes = (double)INFINITY;
    l->as_built = true;
    for (unsigned i = 1; i < l->count; i++) {
        for (unsigned k = 0; k < i; k++) {
            double apart = fabs(a[i].codes - a[k].codes);
            l->as_built &= abs((int)walk->config->gate[l->position[i] - 1].step_codes -
                               (int)walk->config->gate[l->position[k] - 1].step_codes) >=
                           (int)WALK_STEP_BUILT_CODES;
            if (apart >= l->apart_codes)
                continue;
            l->apart_codes = apart;
            l->near = l->position[k];
            l->near_other = l->position[i];
        }
    }
}

/* False: `why` names what is wrong. */
static bool find_steps(const struct walk *walk, struct mr_config *learned, struct learning *l,
                       char *why, size_t size)
{
    unsigned answers = walk->count[WALK_SWITCH];
    for (unsigned n = 1; n <= MR_CONFIG_SWITCHES; n++) {
        if (is_fitted(walk, WALK_SWITCH, n))
            l->position[l->count++] = n;
    }
    if (answers != l->count) {
        snprintf(why, size, "%u steps of %u switches: trip each once, upfield first", answers,
                 l->count);
        return false;
    }
    for (unsigned i = 0; i < l->count; i++) {
        double codes = walk->answer[WALK_SWITCH][i].codes,
               configured = walk->config->gate[l->position[i] - 1].step_codes,
               off = fabs(codes - configured);
        if (off >= WALK_STEP_FAR_CODES) {
            snprintf(why, size,
                     "switch %u: a step of %.1f codes, configured %.0f: was it tripped in its "
                     "turn? is its resistor the right one?",
                     l->position[i], codes, configured);
            return false;
        }
        l->furthest_codes = fmax(l->furthest_codes, off);
        learned->gate[l->position[i] - 1].step_codes = (uint16_t)lround(codes);
    }
    return true;
}

static bool learn(const struct walk *walk, struct mr_config *learned, struct learning *l, char *why,
                  size_t size)
{
    struct mr_config_reason reason;
    if (!find_steps(walk, learned, l, why, size))
        return false;
    find_nearest(walk, l);
    if (l->apart_codes < MR_CONFIG_STEP_APART_CODES) {
        if (l->furthest_codes > WALK_STEP_CURVE_CODES || !l->as_built) {
            snprintf(why, size,
                     "switches %u and %u: their steps are %.1f codes apart, %u are needed to tell "
                     "them apart: walk once more; else change a resistor, or keep the configured "
                     "steps",
                     l->near, l->near_other, l->apart_codes, MR_CONFIG_STEP_APART_CODES);
            return false;
        }
        *learned = *walk->config;
    }
    if (mr_config_check(learned, &reason) == MR_OK)
        return true;
    config_text_reason(learned, &reason, why, size);
    return false;
}

bool walk_learn(const struct walk *walk, struct mr_config *learned, struct ready_report *report)
{
    struct learning l = {0};
    char why[300];
    *learned = *walk->config;
    if (!learn(walk, learned, &l, why, sizeof why)) {
        struct ready_check *c = ready_add(report, READY_NO_GO, "steps", "%s", why);
        snprintf(c->limit, sizeof c->limit, "each once, in order, %u codes apart",
                 MR_CONFIG_STEP_APART_CODES);
        snprintf(c->advice, sizeof c->advice, "nothing is written");
        return false;
    }
    ready_add(report, READY_GO, "steps",
              "%u learned%s, at most %.1f codes from those configured; nearest to each other are "
              "%u and %u, %.1f codes apart",
              l.count,
              l.apart_codes < MR_CONFIG_STEP_APART_CODES
                  ? ", too close to each other; the configured steps stay"
                  : "",
              l.furthest_codes, l.near, l.near_other, l.apart_codes);
    return true;
}
