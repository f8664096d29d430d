#include "host/import/stray.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/list.h"

#define FEW_ROWS 2u
#define SHARE    100u /* more than a hundredth of the largest group is a part of the record */

enum mr_status stray_add(struct stray *stray, double time_s, size_t line)
{
    struct stray_group *last = stray->groups ? &stray->group[stray->groups - 1] : NULL;
    if (last && time_s - last->last_s <= STRAY_PAUSE_S) {
        last->before_s = last->last_s;
        last->last_s = time_s;
        last->rows++;
        return MR_OK;
    }
    if (!list_grow(&stray->group, stray->groups, sizeof *stray->group))
        return MR_FULL;
    stray->group[stray->groups++] = (struct stray_group){time_s, time_s, time_s, line, 1};
    return MR_OK;
}

void stray_take_back(struct stray *stray)
{
    struct stray_group *last = stray->groups ? &stray->group[stray->groups - 1] : NULL;
    if (!last)
        return;
    last->last_s = last->before_s;
    if (--last->rows == 0)
        stray->groups--;
}

static void cut(struct series *series, const struct stray_group *group)
{
    size_t from = 0, to;
    while (from < series->count && series->time_s[from] < group->first_s)
        from++;
    for (to = from; to < series->count && series->time_s[to] <= group->last_s; to++)
        continue;
    size_t rest = series->count - to;
    if (to == from)
        return;
    memmove(series->time_s + from, series->time_s + to, rest * sizeof *series->time_s);
    memmove(series->value + from, series->value + to, rest * sizeof *series->value);
    series->count = from + rest;
}

size_t stray_cut(const struct stray *stray, struct mapping_channel *channel, size_t channels,
                 struct verdict *verdict)
{
    size_t most = 0, rows = 0;
    for (size_t g = 0; g < stray->groups; g++)
        most = stray->group[g].rows > most ? stray->group[g].rows : most;
    for (size_t g = 0; g < stray->groups; g++) {
        const struct stray_group *group = &stray->group[g];
        if (group->rows == most || (group->rows > FEW_ROWS && group->rows > most / SHARE))
            continue;
        for (size_t c = 0; c < channels; c++)
            cut(&channel[c].series, group);
        rows += group->rows;
        verdict_set(verdict, MR_MALFORMED, group->line, 1,
                    "the time lies more than a minute from the others");
    }
    verdict->bad_lines += rows;
    return rows;
}

void stray_free(struct stray *stray)
{
    free(stray->group);
    *stray = (struct stray){0};
}
