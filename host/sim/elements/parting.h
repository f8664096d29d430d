/* Parting: mats that come apart in a planar landing. MODIFICATIONS.md, "Joints that come apart".
 *
 * A joint parts when it is turned downwards (v) by `unhinge_deg` or torn in tension (`tear`).
 * Before that it turns freely downwards. The mats' ends are then two: the node stays the left end
 * of the mat on the right; the end of the mat on the left has a height of its own, here. Neither
 * tension nor moment passes; compression does while the ends are as high as each other to within
 * `unhinge_lap`. Once they are not they pass over each other (lap), until the joint is open again.
 * Lapped mats do not bear on each other: each lies on the ground. A mat apart from a neighbour
 * that stands upright (85 degrees) is pushed over: it lies flat, and passes nothing on either
 * side.
 *
 * Mats, nodes and joints count from 0; heights as in model.h, Y down. One owner; parting_make
 * allocates, parting_free releases. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_PARTING_H
#define MATRIG_HOST_SIM_ELEMENTS_PARTING_H

#include <stdbool.h>

#include "host/base/error.h"
#include "host/sim/scene/scene.h"

struct parting {
    size_t joints; /* that there is room for */
    double unhinge_rad, lap_ft;
    int count;  /* of joints apart */
    int *joint; /* those, in the order in which they came apart */
    /* per joint; of the left mat's end: */
    bool *apart, *lapped, *contact;
    bool *gone; /* a mat beside it was pushed over: nothing passes any more */
    double *y_ft, *v_ft_s, *accel;
    double *down_lb; /* what presses it down beside its mat's weight */
    double *storage;
};

/* NULL when the joints of the scene do not turn apart. */
struct parting *parting_make(const struct sim_scene *scene);
void parting_free(struct parting *parting);

/* Nothing is apart. */
void parting_reset(struct parting *parting);

/* Joint j comes apart: the end moves on as the node does. */
void parting_part(struct parting *parting, int joint, double y_ft, double v_ft_s);

/* Whether joint j at opening g passes compression on; the right end is at y_ft. */
bool parting_abuts(struct parting *parting, int joint, double g_ft, double y_ft);

/* Height of the right end of mat n, and its rate, in a model whose heights are p and rates v. */
static inline double parting_right_y_ft(const struct parting *parting, const double *p, int n)
{
    return parting && parting->apart[n + 1] ? parting->y_ft[n + 1] : p[2 * n + 2];
}

static inline double parting_right_v_ft_s(const struct parting *parting, const double *v, int n)
{
    return parting && parting->apart[n + 1] ? parting->v_ft_s[n + 1] : v[2 * n + 2];
}

#endif
