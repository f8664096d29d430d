/* Ties: what holds neighbouring mats of two strips together along the runway: end connectors, and
 * the brickwork in which a row of mats lies. README.md, "Two strips".
 *
 * A tie is an elastic-plastic spring on what the strips have moved apart at one mat:
 *
 *     q = k (u - u_beside - rest), |q| <= most; what is beyond moves the rest: the tie slips
 *     the strip is pushed with -q, the strip beside with +q
 *
 * It is explicit, for fixed steps, like bands (mods.h). What a slip takes is lost, and nothing is
 * ever given back that was not stored: k stretch^2/2.
 *
 * Units ft, lb. Mats 1..N. One owner, one thread: ties_make allocates, ties_free releases; the
 * scene must outlive them. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_TIES_H
#define MATRIG_HOST_SIM_ELEMENTS_TIES_H

#include "host/base/error.h"
#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

struct ties {
    int mats;
    double k_lb_ft, most_lb;
    const struct sim_scene *scene; /* of the first strip */
    double *rest_ft;               /* per mat, [0] unused: how far apart a tie pulls nothing */
    double *lb;                    /* likewise: q, as last computed */
};

/* Where a strip keeps its mats: u of mat n at u[n * stride + offset]. */
struct ties_view {
    const double *u_ft;
    int stride, offset;
};

/* *ties is NULL where nothing holds the strips together, or there is one. MR_FULL. */
enum mr_status ties_make(struct ties **ties, const struct sim_scene *scene, struct error *error);
void ties_reset(struct ties *ties); /* back to t = 0 */
void ties_free(struct ties *ties);

/* q of mats first..last at the present places; what is beyond `most` slips. */
void ties_pull(struct ties *ties, struct ties_view strip, struct ties_view beside, int first,
               int last);

/* What ties add to the row sum of a mat's stiffness, of either strip (Gershgorin): for the longest
 * stable step. 0 for NULL. */
double ties_row_lb_ft(const struct ties *ties);

/* Notes for the reader of a result, of any scene. */
void ties_describe(const struct sim_scene *scene, struct sim_result *result);

double ties_energy_lb_ft(const struct ties *ties);

/* Stretch of the ties now: N + 1 values by mat, [0] unused, that the caller frees; NULL when memory
 * is short. */
double *ties_stretch_ft(const struct ties *ties, struct ties_view strip, struct ties_view beside);

#endif
