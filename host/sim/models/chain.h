/* Chain: the horizontal equations of a whole runway. README.md, "Common pieces" with theta = 0, and
 * "Chain and landings".
 *
 * The laws are elements/joint.h (all three kinds of joints) and elements/friction.h.
 *
 * State arrays: mats 1..N with the ground at 0 and N+1 (always 0), joints 1..N+1. Units ft, s, lb,
 * slug. One owner, one thread; chain_make allocates, chain_free releases. */
#ifndef MATRIG_HOST_SIM_MODELS_CHAIN_H
#define MATRIG_HOST_SIM_MODELS_CHAIN_H

#include <stdbool.h>
#include <stdint.h>

#include "host/sim/elements/element.h"
#include "host/sim/elements/gear.h"
#include "host/sim/elements/joint.h"
#include "host/sim/elements/mods.h"
#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"
#include "host/sim/elements/wheel.h"

struct chain {
    int mats;
    enum joint_law joints;
    struct joint joint;
    bool damped;
    bool left_free;
    bool right_free;
    enum sim_friction friction;
    bool sticks; /* friction stick, and nothing else that depends on a mat's speed */
    double veps_ft_s;
    double mass_slug;
    double weight_limit_lb; /* Coulomb limit of a mat without the wheel, f W */
    double load_limit_lb;   /* added under the wheel, f wheel_load */
    double v0_ft_s;
    int v0_mat;
    double *storage; /* all arrays below, with padding around each */
    size_t length;   /* of one of them */
    double *u_ft;
    double *v_ft_s;
    double *gap0_ft;
    double *hold_lb; /* tension down to which grit holds an open joint: minus its grit */
    double *reach_ft;
    double *thrust_lb;
    double *limit_lb;    /* Coulomb limit */
    double *give_ft;     /* grit/KL */
    double *tension_lb;  /* of the last kick */
    double *before_ft_s; /* speeds before it */
    double *push_lb;     /* largest compression and tension that chain_note has seen */
    double *pull_lb;
    struct mods *mods; /* NULL when the scene has none */
    struct element_set elements;
    struct gear *gear; /* NULL: the wheel has one axle, and its ground slides or holds */
};

/* first_mat: under the wheel at t = 0. */
void chain_make(struct chain *chain, const struct sim_scene *scene, int first_mat);

/* Back to t = 0. */
void chain_reset(struct chain *chain, const struct sim_scene *scene);

/* Put the wheel's parts on the mats; chain_release takes the same parts away. */
void chain_touch(struct chain *chain, const struct sim_touch *touch, int count);
void chain_release(struct chain *chain, const struct sim_touch *touch, int count);

/* Modifications (with mods only): before a kick of mats first..last over h_s, after chain_touch,
 * and after it. chain_brace puts the pull of the bands on the riveted mats and wears cleats; first
 * and last grow so that a riveted mat which now moves is among them. */
void chain_brace(struct chain *chain, double h_s, const struct sim_touch *touch, int count,
                 int *first, int *last);
void chain_unbrace(struct chain *chain);
struct mods_view chain_view(const struct chain *chain);

/* Change the speeds of mats first..last over h_s with the forces at the present openings; exact
 * stick: a mat at rest whose force is within its limit stays at exactly 0, one whose speed would
 * cross 0 stops there and is tested again. Mats outside must be at rest and stay so. Returns how
 * many mats stopped. */
unsigned chain_kick(struct chain *chain, double h_s, int first, int last);

/* Move mats first..last at their speeds for h_s. */
void chain_drift(struct chain *chain, double h_s, int first, int last);

/* Opening of a joint now: its gap0 and what the two mats have moved apart. */
double chain_opening_ft(const struct chain *chain, int joint);

/* Keep the largest tensions of the last kick, of joints first..last + 1. */
void chain_note(struct chain *chain, int first, int last);

/* Kinetic energy and elastic energy of mats first..last and their joints, lb ft. */
double chain_energy_lb_ft(const struct chain *chain, int first, int last);

/* Longest stable step of the explicit scheme in staggered.c; INFINITY when nothing limits it. */
double chain_step_limit_s(const struct chain *chain);

/* What this scene does not need, and what its reader should know. */
void chain_describe(const struct chain *chain, const struct sim_scene *scene,
                    struct sim_result *result);

void chain_free(struct chain *chain);

#endif
