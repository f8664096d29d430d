/* Restraints: springs with dampers at every n-th mat or joint of a runway. MODIFICATIONS.md,
 * "Restraints". One row of the table in restraint.c describes a kind.
 *
 * A restraint exerts k (x - zero) + c x', at most its grip. x is the movement of a mat (anchor),
 * the rise of its middle above the settled mat (tie-down), or the opening of a joint (absorber),
 * ft. Anchors and tie-downs are pulled out beyond their grip: zero follows x. Tie-downs only pull.
 *
 * The functions are parts of mods.h, which calls them; its scheme of units, counting and ownership
 * applies. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_RESTRAINT_H
#define MATRIG_HOST_SIM_ELEMENTS_RESTRAINT_H

#include "host/sim/scene/scene.h"

/* The restraints of one kind: pointers into the arrays of the state (mods_state). */
struct restraints {
    int kind;                         /* enum sim_restraint_kind */
    const struct sim_restraint *made; /* in the scene */
    int count;
    double *zero_ft, *load_lb, *at; /* load_lb: largest load so far; at: mat or joint */
    double *stretch_ft;             /* present x - zero */
};

/* Returns to t = 0. */
void restraints_reset(struct restraints *r, const struct sim_scene *scene);

/* Force of the i-th restraint at x, with rate x'. */
double restraint_lb(struct restraints *r, int i, double x_ft, double rate_ft_s);

/* The restraint of joint or mat `at`; -1: none. */
int restraint_of(const struct restraints *r, int at);

double restraints_energy_lb_ft(const struct restraints *r);

/* Row sums of stiffness and damping that a kind adds to a mat, for the longest stable step. */
double restraints_stiffness_lb_ft(const struct restraints *r);
double restraints_damping_lb_s_ft(const struct restraints *r);

#endif
