/* Wheel: the aircraft's action on the mats over a span of time. README.md, "The wheel" and "Chain
 * and landings" (path).
 *
 * Thrust is averaged exactly over the span (the rows are linear in time), so the impulse does not
 * depend on where the steps begin and end. If the wheel moves from one mat to the next within the
 * span, the span is divided between the mats by time, at the span's constant speed. Before the
 * first row the aircraft is in the air and causes neither thrust nor load. After the last row it is
 * at rest and causes load but no thrust. Off the runway it causes neither.
 *
 * Successive spans must not go back in time, because a cursor moves along the rows. sim_wheel_start
 * resets it. Units are ft, s and lb. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_WHEEL_H
#define MATRIG_HOST_SIM_ELEMENTS_WHEEL_H

#include "host/sim/scene/scene.h"

#define SIM_WHEEL_TOUCHES_MAX 6 /* largest number of mats that one axle line loads in a span */
/* Largest number of entries for a whole gear. */
#define SIM_TOUCH_MAX         (SIM_WHEEL_TOUCHES_MAX * SIM_GEAR_LINES_MAX)

/* The action of the aircraft on one mat. If a mat has several entries, they are added. */
struct sim_touch {
    int mat;
    double thrust_lb;
    /* share of the wheel load, 0 to 1; with axle lines, as a multiple of the load of one axle */
    double load_share;
};
struct sim_wheel {
    const struct sim_path_row *rows; /* rows of the scene's path, or `straight_path` */
    size_t row_count;
    size_t cursor;
    double length_ft;
    int mats;
    double force_stop_s;
    enum sim_thrust thrust;
    double span_end_s; /* end of the last span, and the position of the wheel at that time */
    double span_end_ft;
    /* mat found last; the wheel is still on it while it is strictly between from_ft and to_ft */
    int mat;
    double from_ft;
    double to_ft;
    /* path made from the keys Vac, s0 and F of a scene without path */
    struct sim_path_row straight_path[2];
    double airborne_until_s; /* the aircraft is in the air until this time */
};

/* Starts a wheel at the beginning of its path. Neither the scene nor the wheel may move in memory
 * while the wheel is used, because it contains pointers to itself. */
void sim_wheel_start(struct sim_wheel *wheel, const struct sim_scene *scene);

/* Computes the action of the wheel on the mats over t0..t1 (t0 < t1). Returns the number of entries
 * in `touch`, at most SIM_WHEEL_TOUCHES_MAX. The aircraft must travel less than one mat in that
 * time. */
int sim_wheel_compute_action(struct sim_wheel *wheel, double t0_s, double t1_s,
                             struct sim_touch *touch);

/* Returns true if t_s is after the last row of the path, so that nothing changes any more. */
bool sim_wheel_is_past_path(const struct sim_wheel *wheel, double t_s);

/* Largest speed on the path; INFINITY if the path jumps. */
double sim_wheel_max_speed_ft_s(const struct sim_wheel *wheel);

/* Mat under the wheel at t = 0, 1..N; 1 or N if the wheel is off the runway. */
int sim_wheel_first_mat(const struct sim_wheel *wheel);

/* Span: the aircraft's forces on the mats between two breakpoints, at which they change abruptly.
 * README.md, "The wheel".
 *
 * Within one span, position and thrust force are linear in time, and the mats on which the aircraft
 * acts do not change. The breakpoints (moves to the next mat, rows of the path, end of thrust) are
 * computed in advance. Mats are counted from 0; -1: none. */
struct span {
    double t0_s, t1_s;
    double x0_ft, speed_ft_s;
    double force_lb, force_lb_per_s; /* thrust at t0, lb, and its rate of change, lb/s */
    int mat; /* mat under the wheel; with thrust `jump` it takes the whole thrust */
    /* Thrust `linear`: the first of the two mats that share the thrust (-1: mat 0 takes all of it).
     * Thrust `jump`: -2. */
    int first_sharing_mat;
};

struct span_list {
    struct span *spans;
    size_t count;
};

/* Makes the list of spans of a scene. MR_FULL: not enough memory. MR_USAGE: the aircraft crosses
 * more than 1e6 joints. */
enum mr_status span_list_make(struct span_list *list, const struct sim_scene *scene,
                              struct error *error);
void span_list_free(struct span_list *list);

/* Thrust on a mat at time t, and its rate of change. */
static inline double span_thrust_lb(const struct span *span, double length_ft, double t_s, int mat,
                                    double *rate)
{
    double dt = t_s - span->t0_s;
    double force = span->force_lb + span->force_lb_per_s * dt;
    *rate = 0.0;
    if (span->first_sharing_mat == -2) {
        if (mat != span->mat)
            return 0.0;
        *rate = span->force_lb_per_s;
        return force;
    }
    if (span->first_sharing_mat == -1) {
        if (mat != 0)
            return 0.0;
        *rate = span->force_lb_per_s;
        return force;
    }
    double right = (span->x0_ft + span->speed_ft_s * dt) / length_ft - 0.5 -
                   span->first_sharing_mat;
    double part = mat == span->first_sharing_mat     ? 1.0 - right
                : mat == span->first_sharing_mat + 1 ? right
                                                     : 0.0;
    double part_rate = mat == span->first_sharing_mat     ? -1.0
                     : mat == span->first_sharing_mat + 1 ? 1.0
                                                          : 0.0;
    *rate = part * span->force_lb_per_s + part_rate * span->speed_ft_s / length_ft * force;
    return part * force;
}

#endif
