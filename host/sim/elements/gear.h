/* Gear: an aircraft with weight on ground that gives way elastically along the runway. README.md,
 * "Gear on elastic ground".
 *
 * An axle loads a foot of gear_foot_ft evenly, its middle where the path is: `share` is the sum
 * over the axles of what each has on this mat, `touching` counts those that have anything on it, as
 * a mat is a plate that brings all of its ground to bear. Without foot both are the share of the
 * step that the axle is on the mat. Axle lines stand gear_lines_ft behind the lead axle with
 * gear_axles each.
 *
 * Steps are implicit in the ground alone (backward Euler with the return to the limit solved
 * exactly): no stiffness sets a limit to the step, and an infinite one is Coulomb's stick. Fixed
 * steps only. Units ft, lb, s, slug. One owner, one thread: gear_make allocates, gear_free
 * releases; the scene must outlive it. Mats count from 1. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_GEAR_H
#define MATRIG_HOST_SIM_ELEMENTS_GEAR_H

#include "host/sim/elements/element.h"
#include "host/sim/elements/wheel.h"

struct gear {
    const struct sim_scene *scene;
    double mass_slug;
    double drift_s; /* in which the mats move at the speeds of a kick */
    int lines;
    struct sim_wheel line[SIM_GEAR_LINES_MAX]; /* line[0] is the lead axle */
    double axles[SIM_GEAR_LINES_MAX];
    struct sim_path_row *rows; /* of all lines, one after the other */
    size_t row_count;
    double *share, *touching;                /* per mat, in this step; [0] and [N + 1] have none */
    double *hold_lb;                         /* per mat, q */
    int loaded[SIM_TOUCH_MAX], loaded_count; /* mats with a share, each once */
    int lead_mat;                            /* under the lead axle; 0: none */
    double *storage;
};

/* Of a mat that so many axles touch. */
double gear_stiffness_lb_ft(const struct sim_scene *scene, double touching);

/* NULL when the scene has none. */
struct gear *gear_make(const struct sim_scene *scene);
void gear_free(struct gear *gear);

/* Back to t = 0: a run in which mats drift for drift_s after each kick. */
void gear_start(struct gear *gear, double drift_s);

/* As sim_wheel_span, of all lines; the lead axle's parts come first. Sets the mats' shares. */
int gear_span(struct gear *gear, double t0_s, double t1_s, struct sim_touch *touch);

/* So many axles touch the mat now. What leaves takes its part of q along; what comes is fresh.
 * gear_span does. */
void gear_press(struct gear *gear, int mat, double touching);

/* Speed of a loaded mat after a kick: from v under the force x for as_if_s (element_step), with
 * `limit_lb` the most that the ground holds. Takes q along. */
double gear_speed_ft_s(struct gear *gear, int mat, double v_ft_s, double x_lb, double limit_lb,
                       double as_if_s);

#endif
