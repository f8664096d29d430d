/* Pass: one run of a planar model from start to end with one stepper: time, events, outputs.
 * PLANAR.md, "Events". */
#ifndef MATRIG_HOST_SIM_SOLVERS_PASS_H
#define MATRIG_HOST_SIM_SOLVERS_PASS_H

#include "host/sim/scene/result.h"
#include "host/sim/solvers/stepper.h"

#define PASS_STEPS_BETWEEN_ASKING 32 /* whether to go on */

struct pass_request {
    const struct stepper_kind *kind;
    double rtol; /* of a stepper that chooses its step */
    double dt_s; /* of one that does not */
    uint64_t most_steps;
    int number; /* of this pass, for options->go_on */
    /* The first step of one that halves and doubles it, as a part of the usual; 0: that. Steps of
     * two runs that begin alike are powers of two of each other, and end together. Of one with a
     * fixed step the part of a span that a step may have at most; 0: all. In a span shorter than
     * their steps two runs would take the same single step, and agree however wrong that is. */
    double first_part;
};

struct pass_outcome {
    enum sim_status status;
    int mat; /* where it failed, from 1 */
    double t_s;
    const char *why; /* it made no progress */
    uint64_t rhs, steps, rejected, events;
    uint64_t switched;   /* a sum over all switches: passes that differ in it switched otherwise */
    unsigned flips_most; /* of one contact, torsion or joint */
    uint64_t sampled;    /* modes found changed from step to step, of a stepper that samples them */
    double ms;
    double max_lift_ft;
    double speed_end_ft_s;
    double longest_s; /* step */
    double clock_ft;  /* what moves is known to, for what its clock can show */
    int mats_max;
    double mats_mean;
    struct sim_record record;
    double *z; /* at the end, 2 size values */
};

/* The caller frees the outcome in every case. The model is started
 * anew. */
void pass_run(struct pass_outcome *outcome, struct model *model, const struct pass_request *request,
              const struct sim_options *options);
void pass_free(struct pass_outcome *outcome);

/* A lift beyond this is a bow wave: twice the bump's height, or 0.05 ft if that is more. */
double pass_bow_threshold_ft(const struct sim_scene *scene);

/* What a run has come to, whatever moved it: peaks, bow wave, displacements and openings at the end
 * (state z), and the record, which the result owns then. */
void pass_deliver(const struct model *model, const double *z, struct sim_record *record,
                  double max_lift_ft, double speed_end_ft_s, struct sim_result *result);

/* The same of a pass, with what another, shorter or longer one cost. */
void pass_answer(const struct model *model, struct pass_outcome *pass,
                 const struct pass_outcome *other, struct sim_result *result);

#define PASS_DISAGREEMENT 0.2 /* of the largest movement or lift: passes contradict each other */

/* How far two complete passes of a scene differ, and whether they contradict each other. */
struct pass_difference {
    struct sim_difference u;
    double lift_ft;
};

struct pass_difference pass_difference(const struct pass_outcome *a, const struct pass_outcome *b);

/* False when they contradict each other: by a fifth of the largest movement or lift, or in whether
 * there is a bow wave. */
bool passes_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                  const struct pass_outcome *b, struct pass_difference apart);

/* Take two records apart at the first time they differ by more than these: widens the estimates,
 * and t_s and mat when that is earlier than what the result has. */
void divergence_find(struct sim_result *result, const struct sim_record *given,
                     const struct sim_record *other, double most_u_ft, double most_lift_ft);

#endif
