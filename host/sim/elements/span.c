#include "host/sim/elements/span.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/xmalloc.h"

#define EDGE 1e-12 /* a wheel at x = n L is on mat n + 1 */
#define MOST 1000000u

static enum mr_status push(struct span_list *list, const struct span *span, struct error *error)
{
    if (!(span->t1_s > span->t0_s))
        return MR_OK;
    if (list->count >= MOST)
        return error_set(
            error, MR_USAGE,
            "too many hops: the aircraft crosses more than %u mats; give an earlier tend", MOST);
    xlist_grow(&list->spans, list->count, sizeof *list->spans);
    list->spans[list->count++] = *span;
    return MR_OK;
}

/* The next x beyond `x` (in the direction of motion) where a mat changes; *cell counts mats, or
 * halves shifted. */
static double next_edge(double x_ft, double speed, double length_ft, double shift)
{
    double w = x_ft / length_ft - shift;
    double edge = speed > 0.0 ? floor(w + EDGE) + 1.0 : ceil(w - EDGE) - 1.0;
    return (edge + shift) * length_ft;
}

/* One stretch of constant speed and linear force, cut at its hops. */
static enum mr_status stretch(struct span_list *list, const struct sim_scene *scene,
                              struct span whole, bool airborne, struct error *error)
{
    double length = scene->length_ft;
    while (whole.t1_s > whole.t0_s && error->status == MR_OK) {
        struct span part = whole;
        double speed = whole.speed_ft_s;
        double runway = scene->mats * length;
        if (speed != 0.0) {
            double edge = next_edge(whole.x0_ft, speed, length, 0.0);
            if (scene->thrust == SIM_LINEAR) {
                double other = next_edge(whole.x0_ft, speed, length, 0.5);
                edge = speed > 0.0 ? fmin(edge, other) : fmax(edge, other);
            }
            if (speed > 0.0 && whole.x0_ft >= runway * (1.0 - EDGE))
                edge = (double)INFINITY; /* gone */
            if (speed < 0.0 && whole.x0_ft <= 0.0)
                edge = -(double)INFINITY;
            double t = whole.t0_s + (edge - whole.x0_ft) / speed;
            if (t < whole.t1_s) {
                part.t1_s = t;
                whole.x0_ft = edge;
            } else {
                whole.x0_ft += speed * (whole.t1_s - whole.t0_s);
            }
        }
        double middle = part.x0_ft + 0.5 * speed * (part.t1_s - part.t0_s);
        if (speed == 0.0)
            middle = part.x0_ft + EDGE * length;
        double mat = floor(middle / length);
        part.mat = airborne || mat < 0.0 || mat >= scene->mats ? -1 : (int)mat;
        part.share = -2;
        if (scene->thrust == SIM_LINEAR && part.mat >= 0)
            part.share = (int)floor(middle / length - 0.5);
        whole.force_lb += whole.force_rate * (part.t1_s - part.t0_s);
        whole.t0_s = part.t1_s;
        push(list, &part, error);
    }
    return error->status;
}

/* A stretch may end when the thrust does. */
static enum mr_status with_stop(struct span_list *list, const struct sim_scene *scene,
                                struct span whole, bool airborne, struct error *error)
{
    double stop = scene->force_stop_s;
    if (stop > whole.t0_s && stop < whole.t1_s) {
        struct span before = whole;
        before.t1_s = stop;
        stretch(list, scene, before, airborne, error);
        whole.x0_ft += whole.speed_ft_s * (stop - whole.t0_s);
        whole.t0_s = stop;
    }
    if (stop <= whole.t0_s)
        whole.force_lb = whole.force_rate = 0.0;
    return stretch(list, scene, whole, airborne, error);
}

enum mr_status span_list_make(struct span_list *list, const struct sim_scene *scene,
                              struct error *error)
{
    double end = sim_scene_end_s(scene);
    *list = (struct span_list){0};
    if (scene->path_count == 0) {
        struct span whole = {0.0, end, scene->s0_ft, scene->vac_ft_s, scene->force_lb, 0.0, -1, -2};
        with_stop(list, scene, whole, false, error);
    } else {
        const struct sim_path_row *row = scene->path;
        const struct sim_path_row *last = row + scene->path_count - 1;
        struct span air = {0.0, fmin(row->t_s, end), row->x_ft, 0.0, 0.0, 0.0, -1, -2};
        with_stop(list, scene, air, true, error);
        for (; row < last && row->t_s < end; row++) {
            double length_s = row[1].t_s - row[0].t_s;
            if (length_s <= 0.0)
                continue;
            struct span part = {row[0].t_s,
                                fmin(row[1].t_s, end),
                                row[0].x_ft,
                                (row[1].x_ft - row[0].x_ft) / length_s,
                                row[0].force_lb,
                                (row[1].force_lb - row[0].force_lb) / length_s,
                                -1,
                                -2};
            with_stop(list, scene, part, false, error);
        }
        struct span stands = {last->t_s, end, last->x_ft, 0.0, 0.0, 0.0, -1, -2};
        with_stop(list, scene, stands, false, error);
    }
    if (error->status != MR_OK)
        span_list_free(list);
    return error->status;
}

void span_list_free(struct span_list *list)
{
    free(list->spans);
    *list = (struct span_list){0};
}
