/* Pass: one run of a planar model from start to end with one stepper, including its events and
 * outputs. PLANAR.md, "Events". */
#ifndef MATRIG_HOST_SIM_SOLVERS_PASS_H
#define MATRIG_HOST_SIM_SOLVERS_PASS_H

#include "host/sim/scene/result.h"
#include "host/sim/solvers/stepper.h"

#define PASS_STEPS_PER_CALLBACK 32 /* number of steps between calls of may_continue */

struct pass_request {
    const struct stepper_kind *kind;
    double rtol; /* tolerance, for a stepper that chooses its step */
    double dt_s; /* step, for a stepper with a fixed step */
    uint64_t max_steps;
    int pass_number; /* number of the pass, an argument of options->may_continue */
    /* For a stepper that halves and doubles its step: first step divided by the usual first step
     * (0: the usual one). With an unusual ratio, the steps of two runs do not end at the same
     * times. For a stepper with a fixed step: largest step divided by the duration of a span (0: no
     * limit). Without a limit, two runs would use the same single step in a short span and agree
     * even if it is wrong. */
    double first_step_factor;
};

struct pass_outcome {
    enum sim_status status;
    int mat; /* mat at which the pass failed, from 1 */
    double t_s;
    const char *reason; /* reason why the pass made no progress */
    uint64_t evaluations, steps, rejected_steps, events;
    /* sum of switch_hash (pass.c) over all switches: two passes with different sums had different
     * switches */
    uint64_t switch_hash_sum;
    unsigned max_flips; /* largest number of mode changes of one contact, torsion or joint */
    /* number of modes that changed between steps, for a stepper that samples modes */
    uint64_t sampled_change_count;
    double ms;
    double max_lift_ft;
    double speed_end_ft_s;
    double longest_step_s; /* longest step */
    double clock_error_ft; /* error of positions due to the resolution of the clock */
    int active_mats_max;
    double active_mats_mean;
    struct sim_record record;
    double *end_z; /* state at the end: an array of 2 x size values */
};

/* Runs a pass. The model is set to t = 0 first. The caller frees the outcome in every case. */
void pass_run(struct pass_outcome *outcome, struct model *model, const struct pass_request *request,
              const struct sim_options *options);
void pass_outcome_free(struct pass_outcome *outcome);

/* Returns the lift above which a rise counts as a bow wave: twice the height of the bump, but at
 * least 0.05 ft. */
double pass_bow_threshold_ft(const struct sim_scene *scene);

/* Writes the outputs of a run to `result`: peaks, bow wave, displacements and openings at the end
 * (state z), and the record, which the result then owns. */
void pass_fill_outputs(const struct model *model, const double *z, struct sim_record *record,
                       double max_lift_ft, double speed_end_ft_s, struct sim_result *result);

/* As pass_fill_outputs, for a pass. Also adds the cost of `other`, the pass with which it was
 * compared. */
void pass_fill_result(const struct model *model, struct pass_outcome *pass,
                      const struct pass_outcome *other, struct sim_result *result);

/* Two passes contradict each other if difference / (largest movement or lift) exceeds this. */
#define PASS_DISAGREEMENT_MAX 0.2

/* The difference of two complete passes of a scene. */
struct pass_difference {
    struct sim_difference u;
    double lift_ft;
};

struct pass_difference pass_compare(const struct pass_outcome *a, const struct pass_outcome *b);

/* False if two passes contradict each other: they differ by more than a fifth of the largest
 * movement or lift, or only one of them has a bow wave. */
bool passes_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                  const struct pass_outcome *b, struct pass_difference difference);

/* Finds the first time at which two records differ by more than the given limits. Increases the
 * error estimates of the result. If the time is earlier than that of the result, sets time and mat
 * of the result. */
void pass_find_divergence(struct sim_result *result, const struct sim_record *given,
                          const struct sim_record *other, double limit_u_ft, double limit_lift_ft);

#endif
