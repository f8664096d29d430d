/* Gear: the weight of an aircraft on ground that is elastic along the runway. README.md, "Gear on
 * elastic ground".
 *
 * An axle loads a length of gear_foot_ft (the foot) uniformly; the middle of this length follows
 * the path. `share` is the sum, over the axles, of the part of each axle's load on this mat.
 * `touching` is the number of axles with any load on the mat, because the ground under a mat acts
 * over its whole length. Without a foot, both are the share of the step during which the axle is on
 * the mat. Axle lines are gear_lines_ft behind the lead axle, with gear_axles axles each.
 *
 * A step is implicit in the ground force only (backward Euler; a return to the limit of the force
 * is solved exactly). Therefore no stiffness limits the step, and an infinite stiffness gives
 * Coulomb sticking. For solvers with fixed steps only. Units are ft, lb, s and slug. One owner, one
 * thread: gear_make allocates, gear_free releases; the scene must outlive the gear. Mats are
 * counted from 1. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_GEAR_H
#define MATRIG_HOST_SIM_ELEMENTS_GEAR_H

#include "host/sim/elements/element.h"
#include "host/sim/elements/wheel.h"

struct gear {
    const struct sim_scene *scene;
    double mass_slug;
    double drift_s; /* time for which the mats then move at the speeds that a kick gave them */
    int line_count;
    struct sim_wheel line[SIM_GEAR_LINES_MAX]; /* line[0] is the line of the lead axle */
    double axle_counts[SIM_GEAR_LINES_MAX];
    struct sim_path_row *rows; /* path rows of all lines, one line after the other */
    size_t row_count;
    double *load_share, *touching_axles; /* for each mat in this step; [0] and [N + 1] are 0 */
    double *ground_force_lb;             /* ground force q on each mat */
    int loaded_mats[SIM_TOUCH_MAX], loaded_count; /* mats with a load share, each listed once */
    int lead_mat;                                 /* mat under the lead axle; 0: none */
    double *storage;
};

/* Returns the stiffness of the ground under a mat that `touching` axles touch. */
double gear_stiffness_lb_ft(const struct sim_scene *scene, double touching);

/* Makes the gear of a scene; NULL if the scene has no elastic ground under the gear. */
struct gear *gear_make(const struct sim_scene *scene);
void gear_free(struct gear *gear);

/* Resets the gear to t = 0, for a run in which mats move for drift_s after each kick. */
void gear_reset(struct gear *gear, double drift_s);

/* Computes the forces of all lines on the mats, as sim_wheel_compute_action does for one wheel. The
 * lead axle comes first. Also sets `load_share` and `touching_axles` of the mats. */
int gear_compute_action(struct gear *gear, double t0_s, double t1_s, struct sim_touch *touch);

/* Sets the number of axles that touch the mat; gear_compute_action calls it. An axle that leaves
 * the mat takes its part of q away; an arriving axle adds none. */
void gear_set_touching_axles(struct gear *gear, int mat, double touching);

/* Returns the speed of a loaded mat after a kick that lasts equivalent_s (element_step). v is the
 * speed before the kick, and x is the sum of all other forces. `limit_lb` is the largest force that
 * the ground can exert. Updates q. */
double gear_solve_mat_speed_ft_s(struct gear *gear, int mat, double v_ft_s, double x_lb,
                                 double limit_lb, double equivalent_s);

#endif
