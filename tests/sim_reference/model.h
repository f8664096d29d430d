/* The mat models a second time, plainly: what host/sim is checked against.
 *
 * Shares no code with host/sim: not its laws (host/sim/elements), its table of elements, its reader
 * of scenes nor its integrators. What is added there as an element is written here once more.
 * Formulated with explicit dense matrices: joint openings, joint angles and node heights are matrix
 * products, joint forces return through the transposes, and the consistent model's mass matrix is
 * assembled from every mat's own motion and solved by elimination. N is small (128 mats at most),
 * so nothing is done to be fast. Equations: host/sim/README.md.
 *
 * Coordinates q, 2N + 1 of them, and their rates v:
 *   report       q[0] = q1, q[1..N] = u, q[N+1..2N] = theta
 *   consistent   q[0..N] = Y of nodes 1..N+1, q[N+1..2N] = u
 * Units ft, lb, s, slug, rad. Mats, joints and nodes count from 0 here: joint j is the left end of
 * mat j. */
#ifndef MATRIG_TESTS_SIM_REFERENCE_MODEL_H
#define MATRIG_TESTS_SIM_REFERENCE_MODEL_H

#include <stdbool.h>

#define REF_MATS        128
#define REF_NODES       (REF_MATS + 1)
#define REF_COORDINATES (2 * REF_MATS + 1)
#define REF_OUTPUTS     16

enum ref_model { REF_REPORT, REF_CONSISTENT };
enum ref_friction { REF_STICK, REF_TANH, REF_NO_FRICTION };
enum ref_shear { REF_NONE, REF_FOLLOWING, REF_RISING, REF_BOTH };

/* A scene, by the keys of a scene file. */
struct ref_scene {
    char name[80];
    enum ref_model model;
    int mats;
    double L, W, g, I, KV, CV, KL, CL, KT, CT, TAD;
    bool switched; /* tad_mode */
    bool full;     /* profile */
    double slack;
    double gap0[REF_NODES];
    bool left_fixed, right_fixed, left_torsion_fixed, right_torsion_fixed;
    double F, Vac, s0, F_tstop;
    bool linear; /* thrust */
    double wheel_load;
    double f, veps;
    double c; /* ground_damping */
    enum ref_friction friction;
    bool soil_normal; /* friction_normal */
    double V;
    enum ref_shear shear;
    double Q1;
    double bump[REF_NODES]; /* by node */
    double v0;
    int v0_mat; /* 0: under the wheel; else counted from 1, as in the file */
    double tend;
    double t_out[REF_OUTPUTS];
    int outputs;
};

/* What holds between two switches; frozen during a step, so that every step sees smooth
 * equations. */
struct ref_regime {
    signed char contact[REF_NODES];
    signed char pushes[REF_NODES]; /* consistent: KV Y + CV Y' > 0 */
    signed char tad[REF_NODES];    /* -1, 0, 1: beyond -TAD, within, beyond TAD */
    signed char slack[REF_NODES];  /* -1, 0, 1: pressed, free, hooked */
    signed char slip[REF_MATS];    /* -1, 0, 1: way the mat slides; 0: stuck */
    int apex;
};

/* What the wheel does between two breakpoints. */
struct ref_wheel {
    int mat;      /* under the wheel, from 0; mats or more: gone */
    int pair;     /* thrust linear: i, the left mat of the two, from 0; -1: all on the first */
    bool pushing; /* before F_tstop */
};

void ref_defaults(struct ref_scene *scene);

/* Reads a scene file. On failure prints why on stderr and returns false. */
bool ref_load(struct ref_scene *scene, const char *path);

void ref_start(const struct ref_scene *scene, double *q, double *v);

/* Joint forces (tension), joint moments, and node heights with rates. Arrays of mats + 1. */
void ref_joints(const struct ref_scene *scene, const struct ref_regime *regime, const double *q,
                const double *v, double *tension, double *moment);
void ref_heights(const struct ref_scene *scene, const double *q, const double *v, double *y,
                 double *y_rate);
void ref_angles(const struct ref_scene *scene, const double *q, const double *v, double *th,
                double *rate);

/* Force on each mat along the runway without friction, and its Coulomb limit. */
void ref_pushes(const struct ref_scene *scene, const struct ref_regime *regime,
                const struct ref_wheel *wheel, double t_s, const double *q, const double *v,
                double *x, double *limit);

void ref_accelerations(const struct ref_scene *scene, const struct ref_regime *regime,
                       const struct ref_wheel *wheel, double t_s, const double *q, const double *v,
                       double *a);

/* The regime a state is in; `slip` is kept for mats that move, decided anew for those at rest. */
void ref_regime_of(const struct ref_scene *scene, const struct ref_wheel *wheel, double t_s,
                   const double *q, const double *v, struct ref_regime *regime);

/* The wheel between two neighbouring breakpoints. */
struct ref_wheel ref_wheel_between(const struct ref_scene *scene, double t0_s, double t1_s);

int ref_u(const struct ref_scene *scene, int mat); /* index of u of a mat in q */

/* A finished run. */
struct ref_output {
    double t_s, lift_ft;
    int lift_node; /* from 1 */
    double u_ft[REF_MATS];
};
struct ref_run {
    struct ref_output output[REF_OUTPUTS];
    double max_lift_ft;
    unsigned long steps, switches;
};

/* Fourth-order Runge-Kutta at fixed steps of at most h_s; a step in which the regime changes is cut
 * by bisection at the change. Prints on stderr and returns false when a mat folds or switches never
 * end. */
bool ref_march(const struct ref_scene *scene, double h_s, struct ref_run *run);

#endif
