/* Model: the planar equations of a scene (report model or consistent model), as the solvers use
 * them. PLANAR.md, "Models".
 *
 * Coordinates of both models: node heights Y_1..Y_{N+1} (down positive) and mat displacements
 * u_1..u_N, interleaved: p[2(j-1)] = Y_j, p[2n-1] = u_n, size = 2N+1. The state is z = (p, v), 2
 * size values, with v the rates. The report model's q1 and theta_n are functions of the heights
 * (Y_1 = q1 - h sin theta_1, sin theta_n = (Y_{n+1} - Y_n)/L), so both models have the same
 * bandwidth.
 *
 * Internally, mats, nodes and joints are counted from 0 (mat n spans nodes n and n+1; joint j is
 * the left end of mat j); all outputs count from 1. Units are ft, lb, s, slug and rad.
 *
 * Every law with a switch (contact, torsion, slack, stick-slip, lift shear) is evaluated in its
 * present mode. A mode is valid while its margin is >= 0 (model_margin). For a solver that locates
 * switches, the right-hand sides are smooth between switches. A solver that samples them calls
 * model_sample_modes before every evaluation.
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

#define MODEL_HALF_BANDWIDTH 4 /* half-bandwidth of mass matrix and Jacobians in p */
#define MODEL_ROW_LENGTH     (2 * MODEL_HALF_BANDWIDTH + 1)
#define MODEL_TAIL_RATIO     3e-8

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
    int index; /* number of a node, joint or mat; for MODEL_APEX the new highest node */
};

struct model {
    const struct sim_scene *scene;
    bool is_consistent;
    int mats;
    int coordinate_count;
    double length_ft, half_ft, mass_slug, inertia_slug_ft2, weight_lb, wheel_load_lb;
    double kv_lb_ft, cv_lb_s_ft, kl_lb_ft, cl_lb_s_ft, kt_lb_ft_rad, ct_lb_ft_s_rad, tad_rad,
        slack_ft;
    double friction_coefficient, weight_friction_lb, veps_ft_s, lift_shear_lb, q1_lb;
    bool has_full_profile; /* true: the key profile of the scene is full */
    bool has_torsion_jump; /* true: the key torsion of the scene is `switched` */
    bool has_soil_normal;
    bool is_left_free, is_right_free;
    /* false: the joint at that end of the runway transmits no moment */
    bool has_left_torsion, has_right_torsion;
    enum sim_friction friction_law; /* friction law; SIM_FRICTION_NONE if f = 0 */
    enum sim_lift_shear lift_shear; /* lift shear; SIM_SHEAR_NONE if V = 0 or the model has none */
    struct element_set elements;
    struct span_list spans;
    struct span span; /* present span */

    /* Modes. */
    signed char *contact; /* for each node: true if the soil acts on it */
    /* for each joint: -1 or 1 if it transmits a moment, 0 if it turns freely */
    signed char *torsion;
    /* for each joint: -1 pressed, 0 open, 1 hooked; always 0 without slack */
    signed char *joint_mode;
    /* for each mat: direction of sliding -1 or 1, or 0 if it sticks; law stick only */
    signed char *slide_direction;
    signed char *lift_shear_sign; /* for each mat: sign of its lift shear */
    int lifted_nodes;             /* number of nodes that are off the ground */
    int apex_node;                /* number of the highest node; valid while lifted_nodes > 0 */

    /* Node that is held at the edge of contact (report model); -1: none. The lift shear of a mat
     * acts only while its right end is off the ground, and may press the end down again at once.
     * Such a node bounces with ever shorter intervals and then stays at the edge of contact. From
     * then on its height is held, until the shear is too small or the node lifts off. During this
     * time the node is treated as off the ground for a fraction of the time, and the mats on both
     * sides get that fraction of the lift that they have while it is off the ground. */
    int held_node;
    signed char held_lift_shear_signs
        [2]; /* lifts of the mats on both sides of the held node while it is off the ground */

    /* The window: the mats that are integrated. The other mats are flat, at rest, and have constant
     * displacements (model.c). */
    bool can_omit_mats; /* true: mats may be left out; set before model_start */
    int first_mat, last_mat;
    double *rest_u_ft; /* for each mat outside the window: its constant displacement */
    double rest_y_ft;  /* height of a node at rest under the weight of its mats */
    /* Consistent model: number of mats over which the effect of a sudden load on the heights falls
     * by the factor MODEL_TAIL_RATIO. */
    int load_tail_mats;
    int rest_steps;
    double *storage;
    double *scratch;       /* `coordinate_count` values, for temporary use */
    double *mass_upper;    /* consistent model: upper diagonal of the factored mass matrix */
    double *friction_tanh; /* for each mat: tanh of its speed over veps */
    /* The next fields are set by an engine with fixed steps that computes the joints' tensions and
     * uses the model only for the vertical motion (consistent_heave_rates;
     * solvers/planar_engine.c). Heights in z are then relative to the ground under each node, and a
     * mat at rest has a tilt: the height of the ground under its left end minus that under its
     * right end. */
    const double *tilt_ft; /* for each mat: tilt; NULL: level ground */
    double max_tilt_ft;
    /* For each mat: tilt at rest, including the settlement of soft nodes. NULL: level. */
    const double *rest_tilt_ft;
    /* Soil of each node, hinge of each joint, and mass of each mat divided by mass_slug. NULL: the
     * same everywhere. */
    const double *node_kv_lb_ft, *node_cv_lb_s_ft, *joint_kt_lb_ft_rad, *mass_ratio;
    const double *given_tension_lb; /* tension of each joint */
    /* force of the modifications on each node and moment on each joint; NULL: none */
    const double *brace_force_lb, *brace_moment_lb_ft;
    uint64_t evaluations;
};

/* Makes the model of a scene. MR_USAGE: the scene needs a feature that this model does not have.
 * `grit`: the model will be used with fixed steps, so the scene may have grit. (The law of the grit
 * has a memory, which only fixed steps support.) */
enum mr_status model_make(struct model *model, const struct sim_scene *scene, bool grit,
                          struct error *error);
void model_free(struct model *model);

/* Sets state and modes to t = 0. */
void model_start(struct model *model, double *z);

/* Enters the span `at` of the aircraft's motion (wheel.h), and sets the modes that depend on it. */
void model_enter_span(struct model *model, size_t at, double *z);

/* Chooses the first window. Called by model_start. */
void model_choose_window(struct model *model, double t_s, const double *z);

/* Call after a step or an event: adds mats that begin to move to the window, and removes mats that
 * have come to rest. Returns true if the window has changed; the stored history of a stepper is
 * then not valid. */
bool model_update_window(struct model *model, double *z);

/* Writes the mats outside the window into z, for callers that use all mats. */
void model_fill_outside_window(const struct model *model, double *z);

/* Accelerations p'' at (t, z) in the present modes; 0 for stuck mats, NaN for an angle of 90
 * degrees or more. */
void model_rates(struct model *model, double t_s, const double *z, double *accel);

/* Linearises at (t, z) with accelerations `accel`: writes the rows of M, dR/dp and dR/dv for the
 * residual R = force(t, p, v) - M(p) accel; entry (i, k) is at [i * MODEL_ROW_LENGTH + k - i +
 * MODEL_HALF_BANDWIDTH]. dR/dt is written to `drift`. */
void model_linearise(struct model *model, double t_s, const double *z, const double *accel,
                     double *mass, double *dr_dp, double *dr_dv, double *drift);

/* State of mat n (from 0) for the elements. */
struct element_mat model_element_mat(const struct model *model, const double *z, int mat);

/* Horizontal force X_n and friction limit C_n on mat n (from 0). */
double model_driving_force_lb(const struct model *model, double t_s, const double *z, int mat);
double model_friction_limit_lb(const struct model *model, const double *z, int mat);

/* Returns the present margin of a switch. It is negative if the mode no longer fits the state. */
double model_margin(const struct model *model, double t_s, const double *z, struct model_switch s);

/* Lists the switches with a negative margin, at most `room`. Returns their total number. */
int model_find_violations(const struct model *model, double t_s, const double *z,
                          struct model_switch *found, int room);

/* Returns true if a mode may change and change back within a step, which cannot be seen from the
 * states at its ends. Uses cubics through the states and rates (v, p'') at both ends, with a safety
 * factor of two. Returns false if no margin can reach zero. */
bool model_can_switch(const struct model *model, double t0_s, const double *z0, const double *rate0,
                      double t1_s, const double *z1, const double *rate1);

/* Gets the range of indexes in p of the coordinates on which the margin of a switch depends. */
void model_switch_range(const struct model *model, struct model_switch s, int *low, int *high);

/* Changes the mode of a switch, and updates everything that depends on it. The speed of a mat that
 * stops becomes exactly 0. */
void model_apply_switch(struct model *model, double t_s, double *z, struct model_switch s);

/* Call after modes have changed. Tests again whether mats at rest stick, and updates the lift shear
 * and the counts. */
void model_update_modes(struct model *model, double t_s, const double *z);

/* Sets all modes except those of sliding from the state. */
void model_sample_shape_modes(struct model *model, const double *z);

/* Sets all modes from the state. */
void model_sample_modes(struct model *model, double t_s, const double *z);

/* Outputs. Angles are in degrees. */
double model_lift_ft(const struct model *model, const double *z, int *node_from_1);
double model_largest_angle_deg(const struct model *model, const double *z, int *mat_from_1);

/* Largest rate of the linearised equations with every node in contact, 1/s (power iteration), which
 * limits explicit steps. MODEL_RATE_STAGGERED leaves out the parts that staggered steps treat
 * implicitly or exactly: the soil's dampers and the elements of the table. MODEL_RATE_SPRINGS_ONLY:
 * only the springs, with every joint and hinge engaged, which gives the shortest time in which a
 * colliding part can rebound. */
enum model_rate_kind { MODEL_RATE_EXPLICIT, MODEL_RATE_STAGGERED, MODEL_RATE_SPRINGS_ONLY };
double model_fastest_rate(struct model *model, const double *z, enum model_rate_kind steps);

void model_describe(const struct model *model, struct sim_result *result);

/* Solution of linear systems with the banded matrices of a model, half-bandwidth
 * MODEL_HALF_BANDWIDTH, by elimination with pivoting, in O(n). */

/* length of a row, including the elements that pivoting adds */
#define BANDED_ROW_LENGTH (3 * MODEL_HALF_BANDWIDTH + 1)

/* Computes a = x mass + y dr_dp + z dr_dv, with rows in the layout of banded_factor: entry (i, k)
 * is at [i BANDED_ROW_LENGTH + k - i + MODEL_HALF_BANDWIDTH]. */
void banded_combine(int size, double x, const double *mass, double y, const double *dr_dp, double z,
                    const double *dr_dv, double *a);

/* Factors in place. Returns false if the matrix is singular or not finite. */
bool banded_factor(int size, double *a, int *pivot);
void banded_solve(int size, const double *a, const int *pivot, double *x);

/* Computes y = rows times x; `rows` as written by model_linearise. */
void banded_multiply(int size, const double *rows, const double *x, double *y);

/* Right-hand sides of the report model and of the consistent model. */
void report_rates(const struct model *model, double t_s, const double *z, double *accel);
void consistent_rates(const struct model *model, double t_s, const double *z, double *accel);

#endif
