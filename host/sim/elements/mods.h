/* Mods: bands, cleats, stiffeners, a diagonal lay and torn joints, as forces that the chain
 * (chain.c) and the planar landing (landing.c) add to theirs. MODIFICATIONS.md has the physics, the
 * parameters and their sources.
 *
 * A scene without modifications has no struct mods: the engines test one pointer per step. All
 * forces are explicit, for fixed steps. Units are ft, s, lb and rad. Mats 1..N, joints 1..N+1, as
 * in scene.h. Segments of a band, connections and cleats are counted from 0. Segment c ends at
 * connection c; the last segment ends at the far anchor.
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

/* Location of mats and joints in an engine's arrays: u of mat n is u[n * stride + offset], v is
 * indexed in the same way, and the tension of joint j is tension[j - joint_offset]. */
struct mods_view {
    const double *u_ft, *v_ft_s;
    int stride, offset;
    double *tension_lb;
    int joint_offset;
};

/* State at the end of a run, per band; segments and connections of the second group follow those of
 * the first. A negative tension T means a slack segment, which is too long by -T l/(A E). */
struct mods_state {
    size_t segments, connections, cleats, joints;
    size_t restraints[SIM_RESTRAINTS], restraint_count; /* of each kind, and of all */
    double *band_lb;                                    /* per segment, at the end of the run */
    double *band_min_lb; /* per segment: minimum and (band_max_lb) maximum over the whole run */
    double *band_max_lb;
    /* Per connection: total distance, in both directions, by which the band has slid through it. */
    double *band_slip_ft;
    double *band_load_lb;    /* largest load so far */
    double *band_pulled_out; /* 1: rivets pulled out, otherwise 0 */
    double *band_mat;        /* number of the mat to which it is riveted */
    double *cleat_left;      /* remaining share of the cleat's hold */
    double *cleat_mat;
    /* Per restraint, kind after kind: position without force, largest load, mat or joint. */
    double *restraint_zero_ft, *restraint_load_lb, *restraint_at;
    /* Per joint 1..N+1, [0] unused: opening at which stiffeners exert no force. */
    double *stiff_gap_ft;
    double *torn; /* per joint: 1 if torn in tension, otherwise 0 */
    /* Largest difference of band_lb, band_min_lb or band_max_lb from the check run; for landings,
     * twice that difference. */
    double error_lb;
    size_t count;    /* number of all values */
    double values[]; /* storage to which the pointers point */
};

/* The bands of a group: pointers into the arrays of mods and of its state. */
struct mods_bands {
    const struct sim_bands *scene; /* the group in the scene */
    int segments;                  /* connections + 1; 0: no bands */
    int *mat;                      /* per connection */
    double *k_lb_ft, *stretch_ft;  /* per segment: stiffness; stretch at u = 0 */
    double *lb;                    /* present tension; negative: slack */
    double *min_lb, *max_lb;
    double *slip_ft, *load_lb, *pulled_out, *riveted; /* per connection, as in mods_state */
};

/* The restraints of one kind: pointers into the arrays of the state. A restraint exerts
 * k (x - zero) + c x', at most its grip. x is the movement of a mat (anchor), the rise of its
 * middle above the settled mat (tie-down), or the opening of a joint (absorber), ft. */
struct restraints {
    int kind;                         /* enum sim_restraint_kind */
    const struct sim_restraint *made; /* in the scene */
    int count;
    double *zero_ft, *load_lb, *at; /* load_lb: largest load so far; at: mat or joint */
    double *stretch_ft;             /* present x - zero */
};

struct mods {
    const struct sim_scene *scene;
    bool has_bands; /* bands or anchors push on mats */
    bool has_cleats, has_joint_springs, has_stiffeners, has_diagonal_lay, can_tear;
    bool acts_vertically; /* some act on nodes or bend joints of the planar model */
    int mats;
    struct mods_bands band[SIM_BAND_GROUPS];
    struct restraints restraint[SIM_RESTRAINTS];
    double *restraint_ft; /* work space: present stretch of all restraints */
    double *band_lb;      /* tensions of all groups */
    int braces;           /* number of mats to which bands are riveted, or that have anchors */
    int *brace_mat;       /* numbers of these mats, in order */
    double *carried_lb;   /* per mat: force of all bands and anchors */
    double *saved_lb;     /* per mat: work space of the engine */
    int cleats;
    double *spring_lb_ft, *spring_gap_ft, *cap_lb; /* per joint: elastic-plastic spring across it */
    double *raised_ft; /* per cleat: largest rise since the wheel was on it; planar model only */
    double *hull;      /* work space: points of a band's line */
    /* Per joint: elastic-plastic spring in bending; planar model only. */
    double *turn_lb_ft_rad, *turn_yield_lb_ft, *turn_rad;
    struct mods_state *state; /* updated in each step; band_lb only in mods_finish */
    void *storage;
};

/* NULL if the scene has no modifications. */
struct mods *mods_make(const struct sim_scene *scene);
void mods_reset(struct mods *mods); /* returns to t = 0 */
void mods_free(struct mods *mods);

/* Updates bands and anchors for one step: tensions at the present displacements, then slip at
 * connections whose hold is exceeded, then the force on each riveted mat (carried_lb). Rivets under
 * the wheel may pull out. */
void mods_pull_bands(struct mods *mods, const struct mods_view *view, const struct sim_touch *touch,
                     int count);

/* Hold of the cleat on a mat, in addition to its friction; 0 for a mat without a cleat. */
double mods_cleat_lb(const struct mods *mods, int mat);
/* Wears the cleats on mats first..last over a step. */
void mods_wear_cleats(struct mods *mods, const struct mods_view *view, double h_s, int first,
                      int last);

/* Adds the forces of stiffeners, sliding joints, absorbers and end springs to the tensions of
 * joints first..last, and tears joints whose strength is exceeded. */
void mods_pull_joints(struct mods *mods, const struct mods_view *view, int first, int last);

bool mods_is_torn(const struct mods *mods, int joint);

/* The part of a planar model that heaves: mats first..last, counted from 0, with heights as in
 * model.h. */
struct mods_heave {
    const double *z;
    const double *tilt_ft, *ground_ft; /* uneven ground (model.h, scene.h); NULL: level */
    int mats;
    double length_ft;
    const double *rest_ft;      /* per node: depth at rest */
    const double *rest_tilt_ft; /* per mat: tilt at rest */
    int first, last;
    double *down_lb;      /* output, per node: downward force */
    double *moment_lb_ft; /* output, per joint: moment of the stiffeners */
};
void mods_brace_heave(struct mods *mods, const struct mods_heave *heave);

/* mods_raised_cleat_hold_lb is the hold of a mat's cleat with the mat's ends at heights Y (positive
 * down): a raised cleat is less deep in the ground. mods_press_cleats applies the wheel to raised
 * cleats: when a cleat is pressed back, the part that was out of the ground bends, which reduces
 * the hold. */
double mods_raised_cleat_hold_lb(struct mods *mods, int mat, double left_y_ft, double right_y_ft);
void mods_press_cleats(struct mods *mods, const struct sim_touch *touch, int count);

/* Square of the fastest rate that the modifications add to the planar model, for the longest stable
 * step. */
double mods_rate2(const struct mods *mods, double mass_slug, double inertia_slug_ft2);

/* Elastic energy of the bands and of the springs across the joints. */
double mods_energy_lb_ft(const struct mods *mods, const struct mods_view *view);

/* Increase of the row sum of a mat's stiffness by the modifications (Gershgorin), for the longest
 * stable step. */
double mods_stiffness_lb_ft(const struct mods *mods);
/* The same of its damping. */
double mods_damping_lb_s_ft(const struct mods *mods);

/* Returns a copy of the state at the end, with tensions at the final displacements; NULL if memory
 * is short. */
struct mods_state *mods_finish(struct mods *mods, const struct mods_view *view);

/* Largest difference between the tensions of two runs. */
double mods_difference_lb(const struct mods_state *a, const struct mods_state *b);

/* Adds a note to a result for each kind of modification in use. */
void mods_describe(const struct mods *mods, struct sim_result *result);

/* Sets the state at the end of a landing in `scene`, as the start of the next landing: tensions,
 * slips and rivets of the bands, cleats, stiffeners, torn joints. band_dT becomes 0, because the
 * tensions include it. The caller sets the gaps. Does nothing if the result has no
 * modifications. */
void mods_carry_over(struct sim_scene *scene, const struct sim_result *result);

#endif
