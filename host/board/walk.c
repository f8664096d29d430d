#include "host/board/walk.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"

const char *const walk_item_kind_names[WALK_ITEM_KIND_COUNT] = {"switch", "transducer", "gage"};
static const char *const item_kind_verbs[WALK_ITEM_KIND_COUNT] = {"tripped", "pushed", "pulled"};

/* ---- movements ---- */

void walk_motion_start(struct walk_motion *motion, unsigned channels, float limit)
{
    memset(motion, 0, sizeof *motion);
    motion->channel_count = channels < WALK_CHANNELS_MAX ? channels : WALK_CHANNELS_MAX;
    motion->movement_min = limit;
}

/* Returns true if for half a second no channel has moved by half the limit. Sets `mean` to the
 * means over that time. */
static bool is_motionless(const struct walk_motion *motion, float mean[WALK_CHANNELS_MAX])
{
    if (motion->reading_count < WALK_REST_READINGS)
        return false;
    for (unsigned c = 0; c < motion->channel_count; c++) {
        float least = INFINITY, most = -INFINITY, sum = 0.0f;
        unsigned count = 0;
        for (unsigned i = 0; i < WALK_REST_READINGS; i++) {
            float v = motion->reading[i][c];
            if (isnan(v))
                continue;
            least = fminf(least, v);
            most = fmaxf(most, v);
            sum += v;
            count++;
        }
        if (count && most - least > 0.5f * motion->movement_min)
            return false;
        mean[c] = count ? sum / (float)count : NAN;
    }
    return true;
}

unsigned walk_motion_add(struct walk_motion *motion, const float *value)
{
    float mean[WALK_CHANNELS_MAX];
    unsigned most = 0;
    memcpy(motion->reading[motion->reading_count++ % WALK_REST_READINGS], value,
           motion->channel_count * sizeof *value);
    for (unsigned c = 0; motion->is_at_rest && c < motion->channel_count; c++) {
        /* The comparison is false if either value is NaN. */
        float moved = fabsf(value[c] - motion->rest_mean[c]);
        if (moved > motion->movement_min)
            motion->is_moving = true;
        if (moved > motion->peak[c])
            motion->peak[c] = moved;
    }
    if (!is_motionless(motion, mean))
        return 0;
    for (unsigned c = 1; c < motion->channel_count; c++) {
        if (motion->peak[c] > motion->peak[most])
            most = c;
    }
    unsigned moved = motion->is_moving ? most + 1 : 0;
    memcpy(motion->rest_mean, mean, sizeof motion->rest_mean);
    memset(motion->peak, 0, sizeof motion->peak);
    motion->is_at_rest = true;
    motion->is_moving = false;
    return moved;
}

/* ---- responses ---- */

void walk_start(struct walk_test *walk, const struct mr_config *config)
{
    memset(walk, 0, sizeof *walk);
    walk->config = config;
    walk_motion_start(&walk->transducers, MR_TRANSDUCERS, WALK_PUSH_MIN_IN);
    walk_motion_start(&walk->gages, MR_GAGES, WALK_PULL_MIN_LB);
}

static bool is_installed(const struct walk_test *walk, enum walk_item_kind kind, unsigned n)
{
    unsigned first = kind == WALK_GAGE ? MR_TRANSDUCERS : 0,
             count = kind == WALK_GAGE ? MR_GAGES : MR_TRANSDUCERS;
    if (kind == WALK_SWITCH)
        return n >= 1 && n <= MR_CONFIG_SWITCHES && walk->config->gate[n - 1].step_codes;
    for (unsigned i = first; i < first + count; i++) {
        if (mr_channel_is_sensor(&walk->config->channel[i]) && walk->config->channel[i].number == n)
            return true;
    }
    return false;
}

static unsigned count_installed(const struct walk_test *walk, enum walk_item_kind kind)
{
    unsigned count = 0;
    for (unsigned n = 1; n <= WALK_ITEMS_MAX; n++)
        count += is_installed(walk, kind, n);
    return count;
}

static bool add_response(struct walk_test *walk, enum walk_item_kind kind,
                         struct walk_response answer)
{
    if (walk->response_count[kind] == WALK_RESPONSES_MAX)
        return false;
    walk->response[kind][walk->response_count[kind]++] = answer;
    return true;
}

bool walk_add_edge(struct walk_test *walk, const struct mr_edge *edge)
{
    if (!((double)edge->step_codes >= MR_CONFIG_STEP_MIN_CODES))
        return false;
    return add_response(walk, WALK_SWITCH,
                        (struct walk_response){.number = edge->position,
                                               .edge_count = (uint8_t)edge->count,
                                               .step_codes = (double)edge->step_codes});
}

void walk_add_event(struct walk_test *walk, const struct mr_switch_event *event)
{
    unsigned *count = &walk->response_count[WALK_SWITCH];
    if (event->reason == MR_SWITCH_BOUNCE && *count &&
        walk->response[WALK_SWITCH][*count - 1].edge_count == event->count)
        --*count;
    walk->unexpected_event_count += event->reason == MR_SWITCH_NO_STEP ||
                                    event->reason == MR_SWITCH_UNKNOWN_STEP ||
                                    event->reason == MR_SWITCH_TOO_SOON;
}

bool walk_add_reading(struct walk_test *walk, const struct mr_block *block,
                      enum walk_item_kind *kind)
{
    const struct mr_channel_config *channel = walk->config->channel;
    float value[MR_TRANSDUCERS + MR_GAGES],
        ratio = mr_reference_ratio(&channel[MR_REFERENCE], block);
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++)
        value[i] = mr_channel_read(&channel[i], block, i, ratio).value;
    unsigned pushed = walk_motion_add(&walk->transducers, value),
             pulled = walk_motion_add(&walk->gages, value + MR_TRANSDUCERS), moved = 0;
    walk->is_gage_disturbed |= walk->gages.is_moving && walk->transducers.is_moving;
    if (pushed)
        moved = pushed;
    else if (pulled && !walk->is_gage_disturbed)
        moved = MR_TRANSDUCERS + pulled;
    if (!walk->gages.is_moving && !walk->transducers.is_moving)
        walk->is_gage_disturbed = false;
    *kind = moved > MR_TRANSDUCERS ? WALK_GAGE : WALK_TRANSDUCER;
    return moved &&
           add_response(walk, *kind, (struct walk_response){.number = channel[moved - 1].number});
}

/* ---- the table ---- */

/* Lists the fitted switches or gages in the order of their first response. */
static unsigned sort_by_response(const struct walk_test *walk, enum walk_item_kind kind,
                                 unsigned order[WALK_ITEMS_MAX])
{
    unsigned count = 0;
    for (unsigned i = 0; i < walk->response_count[kind]; i++) {
        unsigned n = walk->response[kind][i].number, k = 0;
        while (k < count && order[k] != n)
            k++;
        if (k == count && count < WALK_ITEMS_MAX && is_installed(walk, kind, n))
            order[count++] = n;
    }
    return count;
}

static int compare_numbers(const void *a, const void *b)
{
    return (int)*(const unsigned *)a - (int)*(const unsigned *)b;
}

static int compare_numbers_descending(const void *a, const void *b)
{
    return compare_numbers(b, a);
}

bool walk_is_complete(const struct walk_test *walk)
{
    unsigned order[WALK_ITEMS_MAX];
    for (enum walk_item_kind kind = 0; kind < WALK_ITEM_KIND_COUNT; kind++) {
        if (sort_by_response(walk, kind, order) < count_installed(walk, kind))
            return false;
    }
    return true;
}

static void check_item(enum walk_item_kind kind, unsigned n, bool answered, unsigned meant,
                       struct ready_report *report)
{
    char name[20];
    snprintf(name, sizeof name, "%s %u", walk_item_kind_names[kind], n);
    char advice[160];
    snprintf(advice, sizeof advice, "%s %s%s", answered ? "if they were" : "if it was",
             item_kind_verbs[kind],
             answered ? " in that order, swap their leads, or their numbers in the configuration"
                      : ", check its wiring and contact");
    if (answered)
        ready_add_check(report, READY_NO_GO, name, "in order", advice,
                        "responded in the place of number %u", meant);
    else
        ready_add_check(report, READY_NO_GO, name, "responds once", advice, "did not respond");
}

static void check_item_kind(const struct walk_test *walk, enum walk_item_kind kind,
                            struct ready_report *report)
{
    unsigned order[WALK_ITEMS_MAX], meant[WALK_ITEMS_MAX],
        down = 0, count = sort_by_response(walk, kind, order), fitted = count_installed(walk, kind);
    unsigned before = report->count;
    char name[20];
    snprintf(name, sizeof name, "%s walk", walk_item_kind_names[kind]);
    if (!fitted)
        return;
    if (!count) {
        ready_add_check(report, READY_NOT_DONE, name, NULL, NULL, "none of %u responded", fitted);
        return;
    }
    /* use the ascending or the descending order, whichever agrees with more of the walk */
    memcpy(meant, order, sizeof meant);
    for (unsigned i = 1; i < count; i++)
        down += order[i] < order[i - 1];
    qsort(meant, count, sizeof *meant,
          2 * down >= count && count > 1 ? compare_numbers_descending : compare_numbers);
    for (unsigned n = 1; n <= WALK_ITEMS_MAX; n++) {
        unsigned i = 0;
        while (i < count && order[i] != n)
            i++;
        if (is_installed(walk, kind, n) && (i == count || meant[i] != n))
            check_item(kind, n, i < count, i < count ? meant[i] : 0, report);
    }
    if (report->count == before)
        ready_add_check(report, READY_GO, name, NULL, NULL, "all %u responded, in order", fitted);
}

void walk_check_responses(const struct walk_test *walk, struct ready_report *report)
{
    for (enum walk_item_kind kind = 0; kind < WALK_ITEM_KIND_COUNT; kind++)
        check_item_kind(walk, kind, report);
    if (walk->unexpected_event_count)
        ready_add_check(report, READY_NO_GO, "edges", NULL,
                        "compare the configured steps with the resistors, and check the contacts",
                        "%u signal edges match no configured switch", walk->unexpected_event_count);
}
