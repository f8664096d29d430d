/* Modifications of a runway: bands, cleats, stiffeners, diagonal lay and torn joints. The solvers
 * for the chain (chain.c) and for the planar landing (landing.c) add their forces to those of the
 * mats. MODIFICATIONS.md has the physics, the parameters and their sources.
 *
 * A scene without modifications has no struct mods, so it costs only the test of a pointer per
 * step. All forces are computed explicitly, which requires fixed steps. Units are ft, s, lb and
 * rad. Mats 1..N, joints 1..N+1, as in scene.h. Segments of a band, connections and cleats are
 * counted from 0. Segment c ends at connection c; the last segment ends at the far anchor.
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

/* Layout of the arrays of an engine: the displacement of mat n is u[n * stride +
 * offset], its speed v has the same index, and the tension of joint j is tension[j -
 * joint_offset]. */
struct mods_view {
    const double *u_ft, *v_ft_s;
    int stride, offset;
    double *tension_lb;
    int joint_offset;
};

/* State at the end of a run, per band; segments and connections of the second group follow those of
 * the first. A slack segment that is too long by s is stored with the negative tension T = -A E
 * s/l. */
struct mods_state {
    size_t segment_count, connection_count, cleat_count, joint_count;
    /* number of restraints of each kind, and of all kinds */
    size_t restraint_counts[SIM_RESTRAINT_KIND_COUNT], restraint_count;
    double *band_lb;     /* tension of each segment at the end of the run */
    double *band_min_lb; /* smallest and (band_max_lb) largest tension of each segment in the run */
    double *band_max_lb;
    /* Per connection: total distance, in both directions, by which the band has slid through it. */
    double *band_slip_ft;
    double *band_load_lb;    /* largest load on each connection so far */
    double *band_pulled_out; /* for each connection: 1 if its rivets are pulled out, otherwise 0 */
    double *band_mat; /* for each connection: number of the mat to which the band is riveted */
    double *cleat_remaining_share; /* for each cleat: share of its hold that remains */
    double *cleat_mat;
    /* For each restraint, ordered by kind: position at which its force is 0, largest load, number
     * of its mat or joint. */
    double *restraint_zero_ft, *restraint_load_lb, *restraint_places;
    /* For joints 1..N+1 ([0] unused): opening at which the stiffeners exert no force. */
    double *stiffener_gap_ft;
    double *torn; /* for each joint: 1 if it is torn, otherwise 0 */
    /* Largest difference of band_lb, band_min_lb or band_max_lb from those of the second run that
     * checks the first; for landings, twice that difference. */
    double band_error_lb;
    size_t value_count; /* number of all values */
    double values[];    /* memory for the arrays above */
};

/* The bands of a group: pointers into the arrays of mods and of its state. */
struct mods_bands {
    const struct sim_bands *scene_bands; /* parameters of the group in the scene */
    int segment_count;                   /* number of connections + 1; 0: no bands */
    int *connection_mat;                 /* mat of each connection */
    double *k_lb_ft, *stretch_ft;        /* for each segment: stiffness, and stretch at u = 0 */
    double *tension_lb;                  /* present tension of each segment; negative: slack */
    double *min_lb, *max_lb;
    /* arrays by connection, as in mods_state */
    double *slip_ft, *load_lb, *is_pulled_out, *is_riveted;
};

/* The restraints of one kind: pointers into the arrays of the state. A restraint exerts
 * k (x - zero) + c x', at most its grip. x is the movement of a mat (anchor), the rise of its
 * middle above the settled mat (tie-down), or the opening of a joint (absorber), ft. */
struct restraints {
    int kind;                               /* enum sim_restraint_kind */
    const struct sim_restraint *parameters; /* parameters in the scene */
    int count;
    /* stiffness and damping that the restraints add to a mat's row of the matrices, which limit the
     * step */
    double row_k_lb_ft, row_c_lb_s_ft;
    /* load_lb: largest load so far; at: number of mat or joint */
    double *zero_ft, *load_lb, *place;
    double *stretch_ft; /* present x - zero */
};

struct mods {
    const struct sim_scene *scene;
    bool has_bands; /* the scene has bands or anchors, which act on mats */
    bool has_cleats, has_joint_springs, has_stiffeners, has_diagonal_lay, can_tear;
    /* the scene has modifications that act on nodes or joints of the planar model */
    bool acts_vertically;
    int mats;
    struct mods_bands band[SIM_BAND_GROUPS];
    struct restraints restraint[SIM_RESTRAINT_KIND_COUNT];
    double *restraint_stretch_ft; /* present stretch of all restraints */
    double *band_lb;              /* tensions of all groups */
    int brace_count;              /* number of mats with anchors or riveted bands */
    int *brace_mat;               /* numbers of these mats, ascending */
    double *brace_force_lb;       /* for each mat: force of all bands and anchors */
    /* for each mat: thrust saved by the engine while braces are applied */
    double *saved_thrust_lb;
    int cleat_count;
    /* for each joint: elastic-plastic spring across it */
    double *spring_lb_ft, *spring_gap_ft, *spring_cap_lb;
    /* for each cleat: largest rise since the wheel was on it; planar model only */
    double *cleat_rise_ft;
    double *hull_points; /* memory for the points of a band's path */
    /* For each joint: elastic-plastic spring that resists bending; planar model only. */
    double *bending_stiffness_lb_ft_rad, *bending_yield_lb_ft, *bending_zero_rad;
    struct mods_state
        *state; /* updated in each step, except band_lb, which mods_copy_end_state sets */
    void *storage;
};

/* Makes the modifications of a scene; NULL if it has none. */
struct mods *mods_make(const struct sim_scene *scene);
void mods_reset(struct mods *mods); /* resets the modifications to the start of the scene */
void mods_free(struct mods *mods);

/* Updates bands and anchors for one step: computes the tensions at the present displacements, the
 * slip of connections whose grip is exceeded, and the force on each mat with a brace. The wheel can
 * pull rivets out. */
void mods_apply_bands(struct mods *mods, const struct mods_view *view,
                      const struct sim_touch *touch, int count);

/* Returns the hold of the cleat on a mat, which is added to the limit of friction; 0 for a mat
 * without a cleat. */
double mods_cleat_hold_lb(const struct mods *mods, int mat);
/* Reduces the hold of the cleats on mats first..last that move in a step. */
void mods_wear_cleats(struct mods *mods, const struct mods_view *view, double h_s, int first,
                      int last);

/* Adds the forces of stiffeners, sliding joints, absorbers and end springs to the tensions of
 * joints first..last. A joint whose strength is exceeded is torn. */
void mods_add_joint_forces(struct mods *mods, const struct mods_view *view, int first, int last);

bool mods_is_torn(const struct mods *mods, int joint);

/* The heaving part of a planar model (the mats that move vertically): mats first..last, counted
 * from 0, with heights as in model.h. */
struct mods_heaving_part {
    const double *z;
    /* ground heights (model.h, scene.h); NULL: the ground is level */
    const double *tilt_ft, *ground_ft;
    int mats;
    double length_ft;
    const double *rest_ft;      /* depth of each node at rest */
    const double *rest_tilt_ft; /* tilt of each mat at rest */
    int first, last;
    double *down_lb;      /* output: downward force on each node */
    double *moment_lb_ft; /* output: moment of the stiffeners at each joint */
};
void mods_compute_vertical_forces(struct mods *mods, const struct mods_heaving_part *heave);

/* mods_raised_cleat_hold_lb returns the hold of the cleat on a mat whose ends are at depths Y
 * (positive down): the hold of a raised cleat is smaller. mods_bend_raised_cleats applies the wheel
 * to raised cleats: the part of the cleat that was out of the ground bends, which reduces the
 * hold. */
double mods_raised_cleat_hold_lb(struct mods *mods, int mat, double left_y_ft, double right_y_ft);
void mods_bend_raised_cleats(struct mods *mods, const struct sim_touch *touch, int count);

/* Square of the largest rate that the modifications add to the planar model, for the longest stable
 * step. */
double mods_rate_squared(const struct mods *mods, double mass_slug, double inertia_slug_ft2);

/* Elastic energy of the bands and of the springs across the joints. */
double mods_energy_lb_ft(const struct mods *mods, const struct mods_view *view);

/* Stiffness that the modifications add to the row of a mat in the stiffness matrix (Gershgorin
 * bound), for the longest stable step. */
double mods_stiffness_lb_ft(const struct mods *mods);
/* Damping that the modifications add to the row of a mat, for the longest stable step. */
double mods_damping_lb_s_ft(const struct mods *mods);

/* Returns a copy of the state at the end of a run, with the tensions at the final displacements.
 * NULL: not enough memory. */
struct mods_state *mods_copy_end_state(struct mods *mods, const struct mods_view *view);

/* Largest difference between the band tensions of two runs. */
double mods_difference_lb(const struct mods_state *a, const struct mods_state *b);

/* Adds a note to a result for each kind of modification in the scene. */
void mods_describe(const struct mods *mods, struct sim_result *result);

/* Copies the state at the end of a landing into `scene`, as the start of the next landing:
 * tensions, slips and rivets of the bands, cleats, stiffeners, torn joints. band_dT (the warming of
 * the bands) becomes 0, because the tensions already include it. The caller sets the gaps. Does
 * nothing if the result has no modifications. */
void mods_carry_over(struct sim_scene *scene, const struct sim_result *result);

#endif
