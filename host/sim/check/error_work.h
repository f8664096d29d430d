/* Error study, inside: the reference, and what its parts share. Private to host/sim/error_*.c. */
#ifndef MATRIG_HOST_SIM_CHECK_ERROR_WORK_H
#define MATRIG_HOST_SIM_CHECK_ERROR_WORK_H

#include "host/sim/check/error_study.h"
#include "host/sim/solvers/record.h"

struct error_reference {
    bool found;
    double rtol;
    double u_ft, lift_ft, rms_u_ft; /* how far the two methods are apart */
    double max_lift_ft;
    struct sim_record record; /* of the first method; freed by whoever asked */
};

/* Two methods on a planar scene; writes study->method. MR_NUMERICS when they fail or disagree. */
enum mr_status error_reference_planar(struct error_reference *reference, struct error_study *study,
                                      const struct sim_scene *scene, struct error *error);

/* Rms difference of u over all mats and the set times of two complete records of the same scene. */
double error_rms_ft(const struct sim_record *a, const struct sim_record *b);

/* Copies what the study says of its reference. */
void error_study_take(struct error_study *study, const struct error_reference *reference);

/* The whole study of a chain. */
enum mr_status error_study_chain(struct error_study *study, const struct sim_scene *scene,
                                 struct error *error);

/* A new run, failed until filled in; NULL when there is no room. */
struct error_run *error_add(struct error_study *study);

void error_note(struct error_study *study, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
