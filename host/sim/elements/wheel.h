/* Wheel: what the aircraft does to the mats over a span of time. README.md, "The wheel" and "Chain
 * and landings" (path).
 *
 * Thrust is averaged over the span exactly (the rows are linear in time), so an impulse never
 * depends on where a step falls. A hop from one mat to the next within the span divides it between
 * them by time (at the span's constant speed): this is how a fixed step honours the hard
 * breakpoint. Before the first row the aircraft is in the air: no thrust, no load. After the last
 * it stands where it is: no thrust, load stays. Off the runway it does neither.
 *
 * Spans must follow each other in time (a cursor moves along the rows); sim_wheel_start begins
 * again. Units ft, s, lb. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_WHEEL_H
#define MATRIG_HOST_SIM_ELEMENTS_WHEEL_H

#include "host/sim/scene/scene.h"

#define SIM_WHEEL_TOUCHES 6                                        /* of one axle line */
#define SIM_TOUCH_MAX     (SIM_WHEEL_TOUCHES * SIM_GEAR_LINES_MAX) /* of a gear */

/* One mat's part. A mat can appear more than once: parts add up. */
struct sim_touch {
    int mat;
    double thrust_lb;
    double load_share; /* of the wheel load, 0..1; with axle lines in loads of one axle */
};
struct sim_wheel {
    const struct sim_path_row *rows; /* the scene's, or `straight` */
    size_t count;
    size_t cursor;
    double length_ft;
    int mats;
    double force_stop_s;
    enum sim_thrust thrust;
    double at_s; /* end of the last span, and where the wheel was then */
    double at_ft;
    int mat; /* found last; it is this one while strictly between these stations */
    double from_ft;
    double to_ft;
    struct sim_path_row straight[2]; /* Vac, s0, F as a path */
    double from_s;                   /* until then it is in the air */
};

/* The scene must stay in place while the wheel is used, and so must the wheel itself (it points
 * into itself). */
void sim_wheel_start(struct sim_wheel *wheel, const struct sim_scene *scene);

/* The parts over t0..t1 (t0 < t1); returns how many, at most SIM_WHEEL_TOUCHES. The aircraft must
 * cross less than one mat in that time. */
int sim_wheel_span(struct sim_wheel *wheel, double t0_s, double t1_s, struct sim_touch *touch);

/* From t_s on nothing changes: the path's last row is past. */
bool sim_wheel_is_over(const struct sim_wheel *wheel, double t_s);

/* Fastest it ever goes; INFINITY when the path jumps. */
double sim_wheel_fastest_ft_s(const struct sim_wheel *wheel);

/* The mat under the wheel at t = 0, 1..N; 1 or N when it is off the runway. */
int sim_wheel_first_mat(const struct sim_wheel *wheel);

/* Span: what the aircraft does to the mats, cut at every hard breakpoint. PLANAR.md, "The wheel".
 *
 * Within one span the position is linear in time, the thrust force too, and the mats it acts on do
 * not change; the breakpoints (hops, rows of the path, end of thrust) are computed, not found. Mats
 * count from 0; -1: none. */
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
