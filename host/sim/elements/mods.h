/* Mods: bands, cleats, stiffeners, a diagonal lay and torn joints, as forces that the chain
 * (chain.c) and the planar landing (landing.c) add to their own. MODIFICATIONS.md has the physics,
 * the parameters and where they come from.
 *
 * A scene without any has no struct mods: the engines test one pointer a step. All of it is
 * explicit, for fixed steps. Units ft, s, lb, rad. Mats 1..N, joints 1..N+1, as in scene.h.
 * Segments of a band count from 0 (segment c ends at connection c; the last one at the far anchor),
 * connections and cleats from 0 too.
 *
 * One owner, one thread; mods_make allocates, mods_free releases. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_MODS_H
#define MATRIG_HOST_SIM_ELEMENTS_MODS_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"
#include "host/sim/scene/scene.h"
#include "host/sim/elements/wheel.h"

struct sim_result;

/* Where an engine keeps mats and joints: u of mat n at u[n * stride + offset], v likewise, tension
 * of joint j at tension[j - joint_offset]. */
struct mods_view {
    const double *u_ft, *v_ft_s;
    int stride, offset;
    double *tension_lb;
    int joint_offset;
};

/* What a run leaves behind, per band; the second group's segments and connections follow the
 * first's. A tension below 0 is that of a slack segment: it hangs loose by -T l/(A E). */
struct mods_state {
    size_t segments, connections, cleats, joints;
    double *band_lb;       /* per segment, at the end */
    double *band_least_lb; /* in the whole run */
    double *band_most_lb;
    /* per connection: how far the band has slid through it, both ways added up */
    double *band_slip_ft;
    double *band_load_lb; /* most it has carried */
    double *band_out;     /* 1: rivets pulled out, else 0 */
    double *band_mat;     /* the mat it is riveted to */
    double *cleat_left;   /* share of its hold */
    double *cleat_mat;
    /* per joint 1..N+1, [0] unused: opening at which stiffeners pull nothing */
    double *stiff_gap_ft;
    double *torn; /* likewise: 1 when torn in tension, else 0 */
    /* largest difference of band_lb, band_least_lb or band_most_lb to the run it was checked
     * against; landings: twice */
    double error_lb;
    size_t count;    /* of all values together */
    double values[]; /* that the pointers above point into */
};

/* The bands of a group: parts of the arrays of mods and of its state. */
struct mods_bands {
    const struct sim_bands *made; /* as the scene has them */
    int segments;                 /* connections + 1; 0: none */
    /* of each connection: its mat, and that mat's place among the braced ones */
    int *mat, *brace;
    double *k_lb_ft, *stretch_ft; /* per segment: stiffness; stretch while u = 0 */
    double *lb;                   /* present tension, negative: slack */
    double *least_lb, *most_lb;
    double *slip_ft, *load_lb, *out, *riveted; /* per connection, as in mods_state */
};

struct mods {
    const struct sim_scene *scene;
    bool banded, cleated, jointed, stiffened, laid, tears;
    int mats;
    struct mods_bands band[SIM_BAND_GROUPS];
    double *band_lb;    /* tensions of all groups */
    int braces;         /* mats that bands are riveted to */
    int *brace_mat;     /* in order */
    double *carried_lb; /* what all bands push each with */
    double *saved_lb;   /* for the engine */
    int cleats;
    double *spring_lb_ft, *spring_gap_ft, *cap_lb; /* per joint: elastic-plastic spring across it */
    double *raised_ft; /* per cleat: most since the wheel was on it; planar */
    double *hull;      /* spare: points of a band's line */
    /* per joint: the same in bending; planar */
    double *turn_lb_ft_rad, *turn_yield_lb_ft, *turn_rad;
    struct mods_state *state; /* kept up to date; band_lb at mods_finish */
    void *storage;
};

/* NULL when the scene has none. */
struct mods *mods_make(const struct sim_scene *scene);
void mods_reset(struct mods *mods); /* back to t = 0 */
void mods_free(struct mods *mods);

/* Bands over one step: tensions at the present displacements, then slip where a connection holds no
 * more, then what they push each riveted mat with (carried_lb). Rivets under the wheel may pull
 * out. */
void mods_pull_bands(struct mods *mods, const struct mods_view *view, const struct sim_touch *touch,
                     int count);

/* Hold of the cleat on a mat, beyond its friction; 0 on a mat without. */
double mods_cleat_lb(const struct mods *mods, int mat);
/* Wear of the cleats on mats first..last over a step. */
void mods_wear_cleats(struct mods *mods, const struct mods_view *view, double h_s, int first,
                      int last);

/* Add what stiffeners and sliding joints transmit to the tensions of joints first..last; tear what
 * is too weak. */
void mods_pull_joints(struct mods *mods, const struct mods_view *view, int first, int last);

bool mods_is_torn(const struct mods *mods, int joint);

/* The part of a planar model that heaves: mats first..last from 0, heights as in model.h. */
struct mods_heave {
    const double *z;
    const double *tilt_ft, *ground_ft; /* of uneven ground (model.h, scene.h); NULL: level */
    int mats;
    double length_ft, rest_y_ft;
    int first, last;
    double *down_lb;      /* out, per node: what presses it down */
    double *moment_lb_ft; /* out, per joint: moment of the stiffeners */
};
void mods_brace_heave(struct mods *mods, const struct mods_heave *heave);

/* Hold of a mat's cleat where its ends are at heights Y (down): less of it is in the ground when it
 * has risen. And what the wheel does to those that had. */
double mods_raised_cleat_lb(struct mods *mods, int mat, double left_y_ft, double right_y_ft);
void mods_press_cleats(struct mods *mods, const struct sim_touch *touch, int count);

/* Square of the fastest rate that the modifications add to the planar model: for the longest stable
 * step. */
double mods_rate2(const struct mods *mods, double mass_slug, double inertia_slug_ft2);

/* Elastic energy of the bands and of the springs across the joints. */
double mods_energy_lb_ft(const struct mods *mods, const struct mods_view *view);

/* What the modifications add to the row sum of a mat's stiffness (Gershgorin): for the longest
 * stable step. */
double mods_stiffness_lb_ft(const struct mods *mods);

/* Copy of the state at the end, with tensions at the displacements shown; NULL when memory is
 * short. */
struct mods_state *mods_finish(struct mods *mods, const struct mods_view *view);

/* Largest difference of the tensions of two runs. */
double mods_difference_lb(const struct mods_state *a, const struct mods_state *b);

/* Notes for the reader of a result. */
void mods_describe(const struct mods *mods, struct sim_result *result);

/* Make the state that a landing left the start of the next one in `scene`: tensions, slips and
 * rivets of the bands, cleats, stiffeners, torn joints; band_dT becomes 0, as the tensions hold it.
 * Gaps are the caller's. Nothing happens when the result has none. */
void mods_carry(struct sim_scene *scene, const struct sim_result *result);

#endif
