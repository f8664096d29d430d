/* Strips: the chain of the strip beside, which moves in lock step with the first one's, and the
 * ties between them (elements/ties.h). README.md, "Two strips".
 *
 * Both chains have the same mats awake, as a mat that moves pulls the one beside it. Forces of ties
 * lie in thrust_lb, where they stay what they were while both mats of a tie rest.
 *
 * Order in a step: strips_release after chain_release of the first strip; strips_span; the mats
 * under both wheels are taken in; strips_tie; chain_touch of both; chain_brace of both; the kicks.
 * One owner, one thread: strips_make allocates, strips_free releases; the scene must outlive it. */
#ifndef MATRIG_HOST_SIM_MODELS_STRIPS_H
#define MATRIG_HOST_SIM_MODELS_STRIPS_H

#include "host/sim/elements/ties.h"
#include "host/sim/models/chain.h"

struct strips {
    const struct sim_scene *scene; /* of the strip beside */
    struct chain chain;
    struct sim_wheel wheel;
    struct sim_touch touch[SIM_TOUCH_MAX];
    int count;
    struct ties *ties; /* NULL: nothing holds the strips together */
};

/* *strips is NULL for a scene of one strip. `first` is its chain, and learns what ties add to its
 * stiffness. MR_FULL. */
enum mr_status strips_make(struct strips **strips, struct chain *first,
                           const struct sim_scene *scene, struct error *error);
void strips_free(struct strips *strips);

/* Back to t = 0 of a run in steps of h_s. */
void strips_start(struct strips *strips, struct chain *first, double h_s);

/* Take away what the wheels put on their mats; what ties pull these with is there again. */
void strips_release(struct strips *strips, struct chain *first, const struct sim_touch *touch,
                    int count);
/* What the wheel beside touches from now on. */
void strips_span(struct strips *strips, double from_s, double to_s);
/* Ties of mats first..last at the present places. */
void strips_tie(struct strips *strips, struct chain *first, int from_mat, int to_mat);

/* Of the chain beside and the ties. */
double strips_energy_lb_ft(const struct strips *strips, int first, int last);
double *strips_stretch_ft(const struct strips *strips, const struct chain *first);

#endif
