#include "host/analyse/measured_moments.h"

#include <stdlib.h>

#include "host/base/xmalloc.h"

#define BLOCKS_PER_S 1000
#define SHARE        100u /* less than a hundredth of the largest group is none of the landing, */
#define LEAST        100u /* but with edges in it so many are enough: the link was down before */
#define BOARD_S      4294968.0 /* a board counts blocks in 32 bits */

static void add(struct moments *moments, int64_t second, size_t count, size_t edges)
{
    struct moments_group *last = moments->groups ? &moments->group[moments->groups - 1] : NULL;
    if (last && second >= last->from_s && second <= last->to_s + 1) {
        last->to_s = second > last->to_s ? second : last->to_s;
        last->count += count;
        last->edges += edges;
        return;
    }
    if (list_grow(&moments->group, moments->groups, sizeof *moments->group))
        moments->group[moments->groups++] = (struct moments_group){second, second, count, edges};
    else
        moments->full = true;
}

void moments_add(struct moments *moments, int64_t block)
{
    add(moments, block / BLOCKS_PER_S, 1, 0);
}

static bool on_board(double board_s)
{
    return board_s >= 0.0 && board_s < BOARD_S;
}

void moments_add_edge(struct moments *moments, double board_s)
{
    if (on_board(board_s))
        add(moments, (int64_t)board_s, 0, 1);
}

static int by_time(const void *a, const void *b)
{
    int64_t x = ((const struct moments_group *)a)->from_s,
            y = ((const struct moments_group *)b)->from_s;
    return (x > y) - (x < y);
}

/* In order, those without a pause between them as one. */
static void join(struct moments *moments)
{
    size_t made = 0;
    if (moments->groups)
        qsort(moments->group, moments->groups, sizeof *moments->group, by_time);
    for (size_t g = 0; g < moments->groups; g++) {
        const struct moments_group next = moments->group[g];
        struct moments_group *last = made ? &moments->group[made - 1] : NULL;
        if (last && next.from_s - MOMENTS_PAUSE_S <= last->to_s) {
            last->to_s = next.to_s > last->to_s ? next.to_s : last->to_s;
            last->count += next.count;
            last->edges += next.edges;
        } else {
            moments->group[made++] = next;
        }
    }
    moments->groups = made;
}

enum mr_status moments_judge(struct moments *moments)
{
    size_t most = 0, left = 0;
    join(moments);
    for (size_t g = 0; g < moments->groups; g++)
        most = moments->group[g].count > most ? moments->group[g].count : most;
    for (size_t g = 0; g < moments->groups; g++) {
        const struct moments_group group = moments->group[g];
        if (group.count && (group.count > most / SHARE || group.count == most ||
                            (group.edges && group.count >= LEAST)))
            moments->group[left++] = group;
    }
    moments->groups = left;
    return moments->full ? MR_FULL : MR_OK;
}

static bool holds(const struct moments *moments, int64_t second)
{
    for (size_t g = 0; g < moments->groups; g++) {
        if (second >= moments->group[g].from_s && second <= moments->group[g].to_s)
            return true;
    }
    return moments->groups == 0;
}

bool moments_hold(const struct moments *moments, int64_t block)
{
    return holds(moments, block / BLOCKS_PER_S);
}

bool moments_hold_edge(const struct moments *moments, double board_s)
{
    return moments->groups == 0 || (on_board(board_s) && holds(moments, (int64_t)board_s));
}

void moments_free(struct moments *moments)
{
    free(moments->group);
    *moments = (struct moments){0};
}
