#include "host/push/path.h"

#include <math.h>
#include <string.h>

/* Two readings of one force differ by more only once in 40,000. */
#define TURNS 4.2 /* 3 sqrt 2, times the gage's standard error */

/* The direction in which the force went to each reading: 1 or -1. */
static void find_directions(struct push_path *path, const struct push_series *series,
                            double turn_lb, int *direction)
{
    const double *force = series->force_lb;
    size_t n = series->count, first = 0, extreme = 0;
    bool turned = false;
    while (first + 1 < n && fabs(force[first] - force[0]) <= turn_lb)
        first++;
    int way = force[first] < force[0] ? -1 : 1;
    for (size_t i = 0; i < n; i++) {
        double ahead = (force[i] - force[extreme]) * way;
        direction[i] = way;
        if (ahead >= 0.0)
            extreme = i;
        if (ahead >= -turn_lb)
            continue;
        if (!turned) {
            path->top = extreme;
            path->plateau = i - 1;
        }
        turned = true;
        way = -way;
        for (size_t k = extreme + 1; k <= i; k++)
            direction[k] = way;
        extreme = i;
    }
    if (!turned) {
        path->top = extreme;
        path->plateau = n - 1;
    }
}

/* From force F_p (p < 0: none) to F_i. */
static void add_step(struct push_path *path, const struct push_series *series, double turn_lb,
                     int direction, size_t i)
{
    double to = series->force_lb[i], from = i > 0 ? series->force_lb[i - 1] : 0.0;
    bool through_0 = from * to < 0.0 && fabs(from) > turn_lb && fabs(to) > turn_lb;
    double side = fabs(to) > fabs(from) ? to : from;
    bool grows = i == 0 || direction * side >= 0.0;
    if (i > 0) {
        memcpy(path->grows[i], path->grows[i - 1], sizeof path->grows[i]);
        memcpy(path->falls[i], path->falls[i - 1], sizeof path->falls[i]);
        (through_0 || !grows ? path->falls : path->grows)[i][i - 1] -= 1.0;
    }
    (through_0 || grows ? path->grows : path->falls)[i][i] += 1.0;
    path->falling += !grows || through_0;
}

bool push_path_make(struct push_path *path, const struct push_series *series, double force_error_lb)
{
    int direction[PUSH_READINGS_MAX];
    double turn_lb = TURNS * force_error_lb, most_lb = 0.0;
    *path = (struct push_path){.count = series->count};
    for (size_t i = 0; i < series->count; i++)
        most_lb = fmax(most_lb, fabs(series->force_lb[i]));
    if (series->count == 0 || !(most_lb > turn_lb))
        return false;
    find_directions(path, series, turn_lb, direction);
    for (size_t i = 0; i < series->count; i++)
        add_step(path, series, turn_lb, direction[i], i);
    return true;
}
