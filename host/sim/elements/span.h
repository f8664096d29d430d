/* Span: what the aircraft does to the mats, cut at every hard breakpoint. PLANAR.md, "The wheel".
 *
 * Within one span the position is linear in time, the thrust force too, and the mats it acts on do
 * not change; the breakpoints (hops, rows of the path, end of thrust) are computed, not found. Mats
 * count from 0; -1: none. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_SPAN_H
#define MATRIG_HOST_SIM_ELEMENTS_SPAN_H

#include "host/sim/scene/scene.h"

struct span {
    double t0_s, t1_s;
    double x0_ft, speed_ft_s;
    double force_lb, force_rate; /* at t0, per s */
    int mat;                     /* takes the thrust (jump) and carries the wheel */
    /* thrust `linear`: first of the two mats, else -2 (may be -1: all on mat 0) */
    int share;
};

struct span_list {
    struct span *spans;
    size_t count;
};

/* MR_FULL when memory is short; MR_USAGE when the aircraft makes more than 1e6 hops. */
enum mr_status span_list_make(struct span_list *list, const struct sim_scene *scene,
                              struct error *error);
void span_list_free(struct span_list *list);

/* Thrust on a mat at t, and its rate. */
static inline double span_thrust_lb(const struct span *span, double length_ft, double t_s, int mat,
                                    double *rate)
{
    double dt = t_s - span->t0_s;
    double force = span->force_lb + span->force_rate * dt;
    *rate = 0.0;
    if (span->share == -2) {
        if (mat != span->mat)
            return 0.0;
        *rate = span->force_rate;
        return force;
    }
    if (span->share == -1) {
        if (mat != 0)
            return 0.0;
        *rate = span->force_rate;
        return force;
    }
    double right = (span->x0_ft + span->speed_ft_s * dt) / length_ft - 0.5 - span->share;
    double part = mat == span->share ? 1.0 - right : mat == span->share + 1 ? right : 0.0;
    double part_rate = mat == span->share ? -1.0 : mat == span->share + 1 ? 1.0 : 0.0;
    *rate = part * span->force_rate + part_rate * span->speed_ft_s / length_ft * force;
    return part * force;
}

#endif
