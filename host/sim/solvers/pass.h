/* Pass: one run of a planar model from start to end with one stepper: time, events, outputs.
 * PLANAR.md, "Events". */
#ifndef MATRIG_HOST_SIM_SOLVERS_PASS_H
#define MATRIG_HOST_SIM_SOLVERS_PASS_H

#include "host/sim/scene/result.h"
#include "host/sim/solvers/stepper.h"

#define PASS_STEPS_PER_CALLBACK 32 /* steps between calls of may_continue */

struct pass_request {
    const struct stepper_kind *kind;
    double rtol; /* tolerance of a stepper that chooses its step */
    double dt_s; /* step of a stepper with a fixed step */
    uint64_t max_steps;
    int number; /* number of this pass, for options->may_continue */
    /* For a stepper that halves and doubles its step: the first step as a share of the usual first
     * step; 0: the usual one. Two runs with similar starts have steps that are powers of two of
     * each other and end at the same times. For a stepper with a fixed step: the largest step as a
     * share of a span; 0: no limit. In a span shorter than their steps, two runs would use the same
     * single step and agree even if it is wrong. */
    double first_part;
};

struct pass_outcome {
    enum sim_status status;
    int mat; /* mat of a failure, from 1 */
    double t_s;
    const char *reason; /* reason why it made no progress */
    uint64_t evaluations, steps, rejected, events;
    /* a sum over all switches: passes with different sums switched differently */
    uint64_t switch_sum;
    unsigned max_flips; /* largest number of flips of one contact, torsion or joint */
    /* number of modes that changed between steps, for a stepper that samples modes */
    uint64_t sampled_changes;
    double ms;
    double max_lift_ft;
    double speed_end_ft_s;
    double longest_s; /* longest step */
    double clock_ft;  /* resolution of positions due to the resolution of the clock */
    int mats_max;
    double mats_mean;
    struct sim_record record;
    double *z; /* state at the end, 2 size values */
};

/* Runs a pass; the model is started again. The caller frees the outcome in every case. */
void pass_run(struct pass_outcome *outcome, struct model *model, const struct pass_request *request,
              const struct sim_options *options);
void pass_outcome_free(struct pass_outcome *outcome);

/* Lift above which a rise is a bow wave: twice the height of the bump, or 0.05 ft if that is
 * more. */
double pass_bow_threshold_ft(const struct sim_scene *scene);

/* Writes the results of a run to `result`: peaks, bow wave, displacements and openings at the end
 * (state z), and the record, which the result then owns. */
void pass_fill_outputs(const struct model *model, const double *z, struct sim_record *record,
                       double max_lift_ft, double speed_end_ft_s, struct sim_result *result);

/* Like pass_fill_outputs, for a pass. Adds the cost of `other`, a shorter or longer pass. */
void pass_fill_result(const struct model *model, struct pass_outcome *pass,
                      const struct pass_outcome *other, struct sim_result *result);

/* share of the largest movement or lift; passes that differ by more contradict each other */
#define PASS_DISAGREEMENT 0.2

/* The difference of two complete passes of a scene. */
struct pass_difference {
    struct sim_difference u;
    double lift_ft;
};

struct pass_difference pass_compare(const struct pass_outcome *a, const struct pass_outcome *b);

/* Returns false if two passes contradict each other: by a fifth of the largest movement or lift, or
 * in whether there is a bow wave. */
bool passes_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                  const struct pass_outcome *b, struct pass_difference apart);

/* Finds the first time at which two records differ by more than these limits. Increases the
 * estimates of the result, and sets its t_s and mat if this time is earlier. */
void divergence_find(struct sim_result *result, const struct sim_record *given,
                     const struct sim_record *other, double most_u_ft, double most_lift_ft);

#endif
