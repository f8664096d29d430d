#include "host/compare/align.h"

#include <math.h>

#include "host/base/ordered.h"

/* where the stop has no error: as much as the last edges before it are apart, about */
#define STOP_UNKNOWN_S 0.1

/* When the simulated wheel is at a station; NaN: never. */
static double reach_s(const struct sim_scene *scene, double station_ft)
{
    for (size_t i = 1; i < scene->path_count; i++) {
        const struct sim_path_row *from = &scene->path[i - 1], *to = &scene->path[i];
        if (from->x_ft <= station_ft && station_ft < to->x_ft)
            return from->t_s +
                   (to->t_s - from->t_s) * (station_ft - from->x_ft) / (to->x_ft - from->x_ft);
    }
    return (double)NAN;
}

static void find_offset(struct compare_alignment *a)
{
    double late_s[MR_GATES_MAX], squares = 0.0;
    for (size_t i = 0; i < a->edges; i++)
        late_s[i] = a->simulated_s[i] - a->measured_s[i];
    order_numbers(late_s, a->edges);
    a->offset_s = 0.5 * (late_s[(a->edges - 1) / 2] + late_s[a->edges / 2]);
    for (size_t i = 0; i < a->edges; i++)
        squares += (late_s[i] - a->offset_s) * (late_s[i] - a->offset_s);
    a->scatter_s = sqrt(squares / (double)a->edges);
}

enum mr_status compare_align(const struct measured *measured, const struct sim_scene *scene,
                             struct compare_alignment *a, struct error *error)
{
    a->edges = 0;
    for (size_t g = 0; g < measured->gates; g++) {
        double simulated_s = reach_s(scene, measured->gate[g].station_ft);
        bool alien = measured->summary.alien >> g & 1u;
        if (alien || isnan(simulated_s) ||
            (a->edges > 0 && simulated_s <= a->simulated_s[a->edges - 1]))
            continue;
        a->measured_s[a->edges] = measured->gate[g].t_s;
        a->simulated_s[a->edges++] = simulated_s;
    }
    if (a->edges < 2)
        return error_set(error, MR_TOO_FEW,
                         "nothing to align by: RUN %lld has %zu switch edges on the way of the "
                         "simulated wheel; 2 are needed",
                         (long long)measured->landing.id, a->edges);
    find_offset(a);
    return MR_OK;
}

double compare_simulated_time(const struct compare_alignment *a, double t_s)
{
    size_t last = a->edges - 1, k = 0;
    if (t_s <= a->measured_s[0])
        return t_s + a->simulated_s[0] - a->measured_s[0];
    if (t_s >= a->measured_s[last])
        return t_s + a->simulated_s[last] - a->measured_s[last];
    while (a->measured_s[k + 1] < t_s)
        k++;
    double share = (t_s - a->measured_s[k]) / (a->measured_s[k + 1] - a->measured_s[k]);
    return a->simulated_s[k] + share * (a->simulated_s[k + 1] - a->simulated_s[k]);
}

void compare_clock_make(const struct measured *measured, struct compare_clock *clock)
{
    struct track track;
    double unused;
    track_make(measured, &track);
    clock->stop_s = measured->summary.stop_t_s.value;
    clock->stop_error_s = measured->summary.stop_t_s.error;
    if (!(clock->stop_error_s >= 0.0))
        clock->stop_error_s = STOP_UNKNOWN_S;
    for (size_t i = 0; i <= COMPARE_CLOCK_POINTS; i++) {
        double t_s = clock->stop_s * (double)i / COMPARE_CLOCK_POINTS,
               speed_ft_s = measured_speed_ft_s(measured, t_s, &unused);
        struct mr_estimate station_ft = track_at(&track, t_s);
        double error_ft = isnan(station_ft.error) ? measured->landing.switch_error_ft
                                                  : station_ft.error;
        clock->error_s[i] = speed_ft_s > 0.0 ? fmin(error_ft / speed_ft_s, clock->stop_error_s)
                                             : clock->stop_error_s;
    }
}

double compare_time_error(const struct compare_clock *clock, double t_s)
{
    double k = t_s / clock->stop_s * COMPARE_CLOCK_POINTS;
    if (!(k > 0.0))
        return clock->error_s[0];
    if (k >= COMPARE_CLOCK_POINTS)
        return clock->stop_error_s;
    size_t i = (size_t)k;
    return clock->error_s[i] + (k - (double)i) * (clock->error_s[i + 1] - clock->error_s[i]);
}
