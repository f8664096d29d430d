/* Model: the planar equations of one scene, report model or consistent model, as the solvers see
 * them. PLANAR.md, "Models".
 *
 * Coordinates of both models: node heights Y_1..Y_{N+1} (down positive) and mat displacements
 * u_1..u_N, interleaved: p[2(j-1)] = Y_j, p[2n-1] = u_n, size = 2N+1. The state is z = (p, v), 2
 * size values, v the rates. The report model's q1 and theta_n are functions of the heights (Y_1 =
 * q1 - h sin theta_1, sin theta_n = (Y_{n+1} - Y_n)/L), so both models are banded alike.
 *
 * Inside, mats, nodes and joints count from 0 (mat n spans nodes n and n+1; joint j is the left end
 * of mat j); everything that leaves counts from 1. Units ft, lb, s, slug, rad.
 *
 * Every law with a switch (contact, torsion, slack, stick-slip, lift shear) is evaluated in its
 * present mode. A mode holds while its margin is >= 0 (model_margin): a solver that locates
 * switches sees smooth right-hand sides between them; one that samples them calls model_sample
 * before every evaluation.
 *
 * One owner, one thread; the scene must outlive the model. */
#ifndef MATRIG_HOST_SIM_MODELS_MODEL_H
#define MATRIG_HOST_SIM_MODELS_MODEL_H

#include <stdbool.h>
#include <stdint.h>

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"
#include "host/sim/elements/element.h"
#include "host/sim/elements/wheel.h"

#define MODEL_BAND 4 /* half-bandwidth of mass matrix and Jacobians in p */
#define MODEL_ROW  (2 * MODEL_BAND + 1)
#define MODEL_TAIL 3e-8

enum model_switch_kind {
    MODEL_CONTACT,
    MODEL_TORSION,
    MODEL_SLACK,
    MODEL_SLIDE,
    MODEL_STICK,
    MODEL_APEX,
    MODEL_HOLD
};

struct model_switch {
    enum model_switch_kind kind;
    int index; /* node, joint or mat; MODEL_APEX: the new apex */
};

struct model {
    const struct sim_scene *scene;
    bool consistent;
    int mats;
    int size;
    double length_ft, half_ft, mass_slug, inertia, weight_lb, wheel_load_lb;
    double kv, cv, kl, cl, kt, ct, tad_rad, slack_ft;
    double friction, weight_limit_lb, veps_ft_s, shear_lb, q1_lb;
    bool full;  /* profile */
    bool jumps; /* torsion `switched` */
    bool soil_normal;
    bool left_free, right_free;
    bool left_turns, right_turns; /* no moment at that end */
    enum sim_friction law;        /* SIM_NONE when f = 0 */
    enum sim_lift_shear shear;    /* SIM_NO_SHEAR when V = 0 or the model has none */
    struct element_set elements;
    struct span_list spans;
    struct span span; /* the present one */

    /* modes */
    signed char *contact; /* per node: soil acts */
    signed char *torsion; /* per joint: -1, 0 (free), 1 */
    signed char *joint;   /* per joint: -1 pressed, 0 open, 1 hooked; 0 throughout without slack */
    signed char *slide;   /* per mat: -1, 0 (stuck), 1; law stick only */
    signed char *lift;    /* per mat: sign of the lift shear */
    int lifted;           /* nodes out of contact */
    int apex;             /* node; meant only while lifted > 0 */

    /* Report model: the lift shear of a mat acts only while its right end is off the ground, and
     * may press it down again at once. Such a node bounces ever faster and then stays at the edge
     * of contact; its height is held until the shear is too little, or the ground not needed. What
     * bouncing ever faster comes to: the node is up for a share of the time, and the mats on both
     * sides get that share of the lift they have while it is up. -1: none. */
    int held;
    signed char held_lift[2]; /* lift of the mats before and after it, were it up */

    /* The window: mats integrated. The rest is flat, at rest, and its displacements constant
     * (model.c). */
    bool prunes; /* whether mats are left out; set before model_start */
    int first, last;
    double *rest_u_ft; /* per mat: displacement of those outside */
    double rest_y_ft;  /* height of a settled node */
    /* consistent: mats over which what a sudden load does to the heights falls by MODEL_TAIL */
    int tail;
    int quiet_steps;
    double *storage;
    double *spare;      /* size */
    double *mass_upper; /* consistent: work of the tridiagonal solve */
    double *tanh;       /* per mat: of its speed over veps */
    /* Set by an engine that takes fixed steps, has the joints' tensions itself and gives the model
     * the vertical motion alone (consistent_heave; solvers/planar_engine.c). Heights in z are then
     * above the ground under each node, and a mat at rest is turned by its tilt: how much lower the
     * ground is under its right end than under its left. */
    const double *tilt_ft; /* per mat; NULL: level ground */
    double tilt_most_ft;
    const double *given_lb;               /* tension per joint */
    const double *brace_lb, *brace_lb_ft; /* per node and joint; NULL: none */
    uint64_t rhs;
};

/* MR_USAGE when the scene asks for something this model does not have. Grit is a law with a memory,
 * for fixed steps only: `grit` says that it will be used so. */
enum mr_status model_make(struct model *model, const struct sim_scene *scene, bool grit,
                          struct error *error);
void model_free(struct model *model);

/* State and modes at t = 0. */
void model_start(struct model *model, double *z);

/* Make `at` the present span of the aircraft (wheel.h) and set the modes that depend on it. */
void model_enter(struct model *model, size_t at, double *z);

/* Choose the first window; model_start does. */
void model_prune(struct model *model, double t_s, const double *z);

/* After a step or an event: take in the mats that begin to move, leave those behind that have come
 * to rest. True when the window has changed: what a stepper remembers no longer fits. */
bool model_follow(struct model *model, double *z);

/* Write the mats outside the window into z, for those who look at all mats. */
void model_fill(const struct model *model, double *z);

/* Accelerations p'' at (t, z) in the present modes. Stuck mats: 0. An angle of 90 degrees or more
 * gives NaN. */
void model_rates(struct model *model, double t_s, const double *z, double *accel);

/* Linearisation at (t, z) with accelerations `accel`: rows of M, dR/dp and dR/dv for the residual R
 * = force(t, p, v) - M(p) accel; entry (i, k) at [i * MODEL_ROW + k - i + MODEL_BAND]. dR/dt goes
 * to `drift`. */
void model_linearise(struct model *model, double t_s, const double *z, const double *accel,
                     double *mass, double *by_p, double *by_v, double *drift);

/* Mat n (from 0) as elements see it. */
struct element_mat model_element_mat(const struct model *model, const double *z, int mat);

/* Horizontal force X_n and friction limit C_n of mat n (from 0). */
double model_push_lb(const struct model *model, double t_s, const double *z, int mat);
double model_limit_lb(const struct model *model, const double *z, int mat);

/* Present margin of one switch: negative when its mode no longer fits the state. */
double model_margin(const struct model *model, double t_s, const double *z, struct model_switch s);

/* All switches whose margin is negative, at most `room`; returns how many there are. */
int model_violations(const struct model *model, double t_s, const double *z,
                     struct model_switch *found, int room);

/* Whether a switch may come and go within a step that has none at its ends: from states and their
 * rates (v, p'') there. False says that no margin can reach zero, as far as cubics tell, with a
 * factor of two. */
bool model_may_switch(const struct model *model, double t0_s, const double *z0, const double *rate0,
                      double t1_s, const double *z1, const double *rate1);

/* Index range of p that margins of this switch read. */
void model_reach(const struct model *model, struct model_switch s, int *low, int *high);

/* Flip the mode (a stopping mat gets exactly rest), then everything that depends on it. */
void model_flip(struct model *model, double t_s, double *z, struct model_switch s);

/* After flips: mats at rest are tested for sticking again; lift shear and counts are brought up to
 * date. */
void model_settle(struct model *model, double t_s, const double *z);

/* Set every mode but stick-slip from the state alone. */
void model_sample_shape(struct model *model, const double *z);

/* Set every mode from the state alone. */
void model_sample(struct model *model, double t_s, const double *z);

/* Outputs. Angle in degrees. */
double model_lift_ft(const struct model *model, const double *z, int *node_from_1);
double model_worst_angle_deg(const struct model *model, const double *z, int *mat_from_1);

/* Largest rate of the linearised equations with every node in contact, /s (power iteration): what
 * limits explicit steps. MODEL_STAGGERED leaves out what staggered steps take implicitly or
 * exactly: the soil's dampers and the elements of the table. MODEL_SWINGS: of the springs alone,
 * with every joint and hinge engaged: nothing that hits another swings back any sooner. */
enum model_steps { MODEL_EXPLICIT, MODEL_STAGGERED, MODEL_SWINGS };
double model_fastest_rate(struct model *model, const double *z, enum model_steps steps);

void model_describe(const struct model *model, struct sim_result *result);

/* Solving with the banded matrices of a model, half-bandwidth MODEL_BAND: pivoting, O(n). */

#define BAND_WIDTH (3 * MODEL_BAND + 1) /* room for what pivoting moves up */

/* a = x mass + y by_p + z by_v, rows spread out for band_factor: entry (i, k) at [i BAND_WIDTH + k
 * - i + MODEL_BAND]. */
void band_load(int size, double x, const double *mass, double y, const double *by_p, double z,
               const double *by_v, double *a);

/* Factor in place. False when singular or not finite. */
bool band_factor(int size, double *a, int *pivot);
void band_solve(int size, const double *a, const int *pivot, double *x);

/* y = rows (of model_linearise) times x. */
void band_multiply(int size, const double *rows, const double *x, double *y);

/* The right-hand sides of both models. */
void report_rates(const struct model *model, double t_s, const double *z, double *accel);
void consistent_rates(const struct model *model, double t_s, const double *z, double *accel);

#endif
