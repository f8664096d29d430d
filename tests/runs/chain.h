/* Chain: the 420 mats of the runway as bodies that slide along it, joined end to end, for making
 * synthetic landings.
 *
 * Physics as host/sim/README.md says (flat mats, theta = 0; landings with initial gaps, slack and
 * grit). The method is this file's own, so that a simulation compared with these landings is
 * compared with something made differently: the state is joint gaps and mat speeds, displacement is
 * the running sum of gap changes, and each time step is implicit. Every law below is a rising
 * function of speed made of straight pieces, so the speeds at the end of a step are unique; they
 * are found by tridiagonal systems, one for each guess at which piece every law is on. Stick and
 * grit are such pieces too, steep ones over speeds below SYN_CREEP_FT_S: no case is switched from
 * step to step.
 *
 * Joint law, w the speed at which joint j opens, c its gap (0 closed, slack hooked):
 *   compression C = the largest of  0,  grit (while w < 0, up to that at w = 0),  -(KL c + CL w)
 *   force (tension positive)  = the larger of  KL (c - slack) + CL w  and  -C
 * A hooked joint lets go along its spring until the grit bears. A joint pulled open again offers
 * nothing to opening; to close again it needs its grit again. The damper of a closed joint never
 * pulls (where the model leaves the small force of CL in).
 *
 * Units ft, lb, s, slug. No heap; the caller owns the struct. Arrays: mats 1..420, joints 1..421
 * (joint j is the left end of mat j); mats 0 and 421 are the ground and stay at rest. */
#ifndef MATRIG_TESTS_RUNS_CHAIN_H
#define MATRIG_TESTS_RUNS_CHAIN_H

#include <stdbool.h>

#define SYN_MATS             420
#define SYN_JOINTS           421
#define SYN_MAT_FT           (2.0 / 7.0)
#define SYN_GRAVITY_FT_S2    32.174
#define SYN_STRIP_WEIGHT_LB  0.466 /* one mat of a strip 12/7 ft wide */
#define SYN_JOINT_KL_LB_FT   2.9e5
#define SYN_JOINT_CL_LB_S_FT 5.0
#define SYN_SLACK_FT         (0.030 / 12.0)
#define SYN_FRICTION         0.5  /* mat on vinyl, on the mat's own weight */
#define SYN_CREEP_FT_S       1e-7 /* stick: 7 s of it move a mat by less than 1e-5 in */

struct syn_chain {
    double gap_ft[SYN_JOINTS + 1];       /* now */
    double gap_start_ft[SYN_JOINTS + 1]; /* when displacement was 0 */
    double grit_lb[SYN_JOINTS + 1];
    double v_ft_s[SYN_MATS + 2];
    /* by the ground on all mats, upfield positive, since syn_chain_mark */
    double friction_impulse_lb_s;
    double end_impulse_lb_s; /* by the ground through joints 1 and 421, upfield positive */
    double thrust_impulse_lb_s;
    unsigned long steps;
    unsigned long iterations;
    unsigned long hard_steps; /* of them, those that took the slow way to a solution */
};

/* Thrust on the mats under a tyre's contact patch: downfield, shared by the length each mat has of
 * it. */
struct syn_thrust {
    double force_lb; /* 0: none */
    double centre_ft;
    double length_ft; /* > 0 */
};

/* Zero displacement and impulses here and now. */
void syn_chain_mark(struct syn_chain *chain);

#define SYN_RESIDUAL_LB 2e-5 /* of a mat's momentum equation; the ground's friction is 0.233 */

/* Advance by step_s. false: the step's equations were not solved to SYN_RESIDUAL_LB (a defect:
 * nothing may be used). */
bool syn_chain_step(struct syn_chain *chain, const struct syn_thrust *thrust, double step_s);

/* Displacements u_ft[1..420] since the mark, downfield positive; u_ft[0] = u_ft[421] = 0 (array of
 * SYN_MATS + 2). */
void syn_chain_displacement(const struct syn_chain *chain, double *u_ft);

/* Fastest mat, ft/s. */
double syn_chain_fastest(const struct syn_chain *chain);

/* The mat at a station: the one that begins there when it is a joint's station. */
int syn_chain_mat_at(double station_ft);

/* Longest zone of closed joints: the longest run from a closed joint to a closed joint in which no
 * ten consecutive joints have more than one open (closed: gap <= closed_ft). Its mats are those
 * between its first and last joint, so one closed joint alone makes no zone. On equal lengths the
 * one farthest upfield. Only joints at or beyond from_ft count. */
struct syn_zone {
    int mats; /* 0: no two closed joints near each other; stations are then 0 */
    double start_ft;
    double end_ft;
    int closed_joints; /* in all, alone or not */
};
void syn_chain_zone(const struct syn_chain *chain, double closed_ft, double from_ft,
                    struct syn_zone *zone);

#endif
