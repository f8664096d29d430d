/* The onboard predictor (common/predictor.h) at several costs: error against the chain in double
 * precision at 25 us, and cycles on the board, over the five landings of the standard series (28
 * ft/s at 4, 4, 4.3, 4.6 ft/s2; 35.5 ft/s at 6.6 to 9.2).
 *
 * Two runways. `own`: openings and closing resistances are the ones that the predictor assumes,
 * each landing begins with the fine chain's openings, no transducers: what its step, its single
 * precision and its grouping do. `other`: a runway of other openings and resistances, of which it
 * knows a survey before the first landing and eight transducers at 40 to 110 ft; it carries its own
 * state: what a rig would see.
 *
 * A solver of the simulator (`staggered`, single passes in double precision) runs the same landings
 * on `own` at three steps: what the same time buys there.
 *
 * Cycles: what the predictor counts times the instructions measured on the emulated board
 * (predictor_cost.h). Units in, s. */
#ifndef MATRIG_TESTS_ERROR_REPORT_PREDICTOR_STUDY_H
#define MATRIG_TESTS_ERROR_REPORT_PREDICTOR_STUDY_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

#define PREDICTOR_STUDY_LANDINGS 5
#define PREDICTOR_STUDY_VARIANTS 10
#define PREDICTOR_STUDY_SOLVERS  3
#define PREDICTOR_STUDY_LIMIT    0.60 /* of 168 MHz, over any second */

struct predictor_error {
    double rms_in, most_in; /* of u, over every tenth mat and all milliseconds */
};

struct predictor_run {
    struct predictor_error own, other;
    double updates, visits, blocks; /* of `other` */
    double cycles;                  /* of the landing */
    double ms;                      /* processor time of this computer, of `own` */
    double share;                   /* of 168 MHz over the worst second */
};

struct predictor_variant {
    const char *name;
    unsigned level; /* enum mr_predictor_level */
    double step_s;  /* of single mats */
    bool refused;   /* beyond the stability limit: no runs */
    struct predictor_run run[PREDICTOR_STUDY_LANDINGS];
};

/* Solver `staggered` on `own`. */
struct predictor_solver {
    double step_s;
    struct {
        struct predictor_error own;
        double ms; /* processor time of this computer */
    } run[PREDICTOR_STUDY_LANDINGS];
};

struct predictor_study {
    double step_limit_s;                      /* what a step must not exceed */
    double peak_in[PREDICTOR_STUDY_LANDINGS]; /* largest true movement, `other` */
    size_t count;
    struct predictor_variant variant[PREDICTOR_STUDY_VARIANTS];
    struct predictor_solver solver[PREDICTOR_STUDY_SOLVERS];
};

/* MR_OK, or what the fine chain says. Takes some seconds. */
enum mr_status predictor_study_run(struct predictor_study *study, struct error *error);

#endif
