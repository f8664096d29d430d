#include "host/landing_series/draw.h"

#include <math.h>
#include <stdlib.h>

#include "common/splitmix.h"
#include "host/base/xmalloc.h"

/* of the integration of the path, with mats as long as the rig's; else by the root of the scale, */
#define NODE_S       1e-3
#define NODE_FT      (2.0 / 7.0) /* so that a scaled series is the same one */
#define NODE_G_FT_S2 32.174
#define ROW_NODES    10
#define MOST_S       600.0

struct draw draw_from(uint64_t seed, unsigned stream)
{
    uint64_t state = seed;
    state = mr_splitmix64(&state) + 0x632be59bd9b4e019u * (stream + 1u);
    return (struct draw){mr_splitmix64(&state)};
}

double draw_uniform(struct draw *draw)
{
    return mr_splitmix64_uniform(&draw->state);
}

double draw_between(struct draw *draw, struct series_range range)
{
    return range.low + (range.high - range.low) * draw_uniform(draw);
}

static double profile_ft_s2(const struct series_landing *landing, double drawn_ft_s2,
                            double station_ft)
{
    const struct series_knot *k = landing->profile;
    size_t count = landing->profile_count;
    if (count == 0)
        return drawn_ft_s2;
    if (station_ft <= k[0].station_ft)
        return k[0].deceleration_ft_s2;
    for (size_t i = 1; i < count; i++) {
        if (station_ft < k[i].station_ft)
            return k[i - 1].deceleration_ft_s2 +
                   (k[i].deceleration_ft_s2 - k[i - 1].deceleration_ft_s2) *
                       (station_ft - k[i - 1].station_ft) / (k[i].station_ft - k[i - 1].station_ft);
    }
    return k[count - 1].deceleration_ft_s2;
}

static enum mr_status add_row(struct draw_path *path, struct sim_path_row row, struct error *error)
{
    if (!list_grow(&path->rows, path->count, sizeof row))
        return error_set(error, MR_FULL,
                         "out of memory: a path beyond %zu rows; give a shorter landing",
                         path->count);
    path->rows[path->count++] = row;
    return MR_OK;
}

enum mr_status draw_landing(const struct landing_series *series,
                            const struct series_landing *landing, uint64_t seed, size_t index,
                            struct draw_path *path, struct error *error)
{
    struct draw draw = draw_from(seed, DRAW_LANDING + (unsigned)index);
    double lb_per_ft_s2 = series->weight_lb / (series->axles * landing->scene.g_ft_s2);
    double at_ft = draw_between(&draw, landing->touchdown_ft),
           v_ft_s = draw_between(&draw, landing->speed_ft_s);
    double drawn_ft_s2 = draw_between(&draw, landing->deceleration_ft_s2), from_ft_s = v_ft_s;
    double runway_ft = landing->scene.mats * landing->scene.length_ft, t_s = 0.0, force_lb = 0.0;
    double node_s =
        NODE_S * sqrt(landing->scene.length_ft / NODE_FT * (NODE_G_FT_S2 / landing->scene.g_ft_s2));
    draw_path_free(path);
    path->touchdown_ft = at_ft;
    for (size_t k = 0; v_ft_s > 0.0 && at_ft < runway_ft; k++) {
        t_s = node_s * (double)k;
        double onset = series->onset_s > 0.0 ? fmin(t_s / series->onset_s, 1.0) : 1.0;
        /* towed: the speed is kept from outside */
        double share = onset * onset * (3.0 - 2.0 * onset), a_ft_s2 = 0.0;
        if (!(landing->tow_lb > 0.0))
            a_ft_s2 = share * profile_ft_s2(landing, drawn_ft_s2, at_ft);
        force_lb = landing->tow_lb > 0.0 ? share * landing->tow_lb : lb_per_ft_s2 * a_ft_s2;
        if (k % ROW_NODES == 0 &&
            add_row(path, (struct sim_path_row){t_s, at_ft, force_lb}, error) != MR_OK)
            return error->status;
        if (t_s > MOST_S)
            return error_set(
                error, MR_USAGE,
                "no stop: %s: landing %zu still rolls after %g s; give more deceleration",
                series->name, index + 1, MOST_S);
        double rest_s = a_ft_s2 > 0.0 ? fmin(node_s, v_ft_s / a_ft_s2) : node_s;
        at_ft += rest_s * (v_ft_s - 0.5 * a_ft_s2 * rest_s);
        v_ft_s = rest_s < node_s ? 0.0 : v_ft_s - a_ft_s2 * rest_s;
        t_s += rest_s;
    }
    if (t_s <= path->rows[path->count - 1].t_s)
        t_s = path->rows[path->count - 1].t_s + node_s;
    path->stop_ft = at_ft;
    path->mean_ft_s2 = (from_ft_s * from_ft_s - v_ft_s * v_ft_s) /
                       (2.0 * fmax(at_ft - path->touchdown_ft, 1e-9));
    if (add_row(path, (struct sim_path_row){t_s, at_ft, force_lb}, error) != MR_OK)
        return error->status;
    return add_row(path, (struct sim_path_row){t_s, at_ft, 0.0}, error);
}

void draw_path_free(struct draw_path *path)
{
    free(path->rows);
    *path = (struct draw_path){0};
}
