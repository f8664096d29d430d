/* Study: one scene solved by `auto` and by others, each in a process of its own with a limit on its
 * time. README.md. */
#ifndef MATRIG_TESTS_STABILITY_STUDY_H
#define MATRIG_TESTS_STABILITY_STUDY_H

#include <stdbool.h>
#include <stdint.h>

#include "host/sim/sim.h"
#include "tests/stability/draw.h"

#define STUDY_MATS 16

#define STUDY_OVERCONFIDENT 3.0 /* stated errors */
/* of both error estimates together: beyond that, two answers contradict each other */
#define STUDY_MULTIPLE      STUDY_OVERCONFIDENT
#define STUDY_PART          1e-6 /* and of the largest movement (of the largest lift) */
#define STUDY_LEAST_FT      1e-9 /* and this */

#define STUDY_TRUTH_RTOL    1e-11 /* of those that fixed is held against */
#define STUDY_DOUBT         1.0   /* beyond so many stated errors another method is asked too */
#define STUDY_FIXED_METHODS 3
#define STUDY_LATE_S        60.0 /* of processor time for auto */

enum study_method {
    STUDY_AUTO,
    STUDY_EVENT,
    STUDY_IMPLICIT,
    STUDY_CVODE,
    STUDY_REFERENCE,
    STUDY_METHODS
};
extern const char *const study_method_names[STUDY_METHODS];

/* How a method ended; the first four are those of sim_status. */
enum study_end {
    STUDY_OK,
    STUDY_UNSTABLE,
    STUDY_FOLDED,
    STUDY_UNDERFLOW,
    STUDY_SLOW,
    STUDY_CRASHED,
    STUDY_REFUSED,
    STUDY_NOT_RUN,
    STUDY_ENDS
};
extern const char *const study_end_names[STUDY_ENDS];

struct study_answer {
    enum study_end end;
    char solver[12];
    double t_s; /* where it failed */
    double cpu_s;
    double rate; /* fastest of the linearised equations, /s */
    uint64_t steps, events;
    double error_u_ft, error_lift_ft, peak_u_ft, max_lift_ft;
    double unsure_s; /* from then on the answer is said to be not predictable; 0: it is */
    bool bow_wave;
    bool alone; /* contradicts auto, which the remaining solver confirms */
    double u_ft[DRAW_OUTPUTS][STUDY_MATS + 1]; /* by mat, from 1 */
    double lift_ft[DRAW_OUTPUTS];
};

/* What another method makes of auto's answer; ratios: difference over both error estimates. */
struct study_difference {
    double u_ft, lift_ft;
    double ratio_u, ratio_lift;
    bool verdict; /* one says bow wave, the other none */
    bool contradicts;
};

struct study_limits {
    double auto_s, other_s; /* processor time */
};

/* Run `methods` of a scene as needed: auto; then others until one answers and agrees (all, when one
 * contradicts or when auto does not answer; when event was thought too slow it is given UMPIRE_S
 * then, to say which of the two is alone); then, for every third scene, the reference of
 * tests/sim_reference when it is quick enough. `answers` has to be memory shared between
 * processes. */
void study_scene(const struct sim_scene *scene, size_t index, const struct study_limits *limits,
                 struct study_answer *answers);

/* The same for a landing with solver staggered: answers[0]; then event in answers[1]; and, where
 * that does not answer or says something else, implicit in answers[2]. */
void study_fixed(const struct sim_scene *scene, const struct study_limits *limits,
                 struct study_answer *answers);

/* What study_bars leaves where. */
enum study_bar {
    STUDY_BARS_AUTO,
    STUDY_BARS_OTHER,
    STUDY_BARS_EVENT,
    STUDY_BARS_IMPLICIT,
    STUDY_BARS_REFERENCE
};

/* auto; another solver, taking turns; and, at a tolerance of 1e-11, event, and implicit where event
 * does not answer, was asked itself, or says something else. Where they leave an answer of event or
 * implicit without a second method: the reference of tests/sim_reference. */
void study_bars(const struct sim_scene *scene, size_t index, const struct study_limits *limits,
                struct study_answer *answers);
/* Whose turn it is. */
const char *study_bars_solver(const struct sim_scene *scene, size_t index);

/* The answer that says how it is: another method's than `of`; with two of them at odds the one that
 * sides with `of`. NULL: nobody knows. */
struct study_truth {
    const struct study_answer *is;
    bool other_alone; /* another one at odds with this and with `of` */
    bool contested;   /* `of`'s own method at a finer tolerance sides with `of` */
    bool by_itself;   /* the same method at a finer tolerance, as there is no other */
};
struct study_truth study_truth(const struct sim_scene *scene, const struct study_answer *answers,
                               const struct study_answer *of);

struct study_difference study_compare(const struct sim_scene *scene, const struct study_answer *a,
                                      const struct study_answer *b);

/* work(plan, shared) in so many processes at once. False: one of them did not end well. */
bool study_in_jobs(size_t jobs, void (*work)(const void *plan, void *shared), const void *plan,
                   void *shared);

/* Bins: ratios of a difference to what was stated, counted up to 0.1, 0.3, 1, 3, 10 and beyond. */
#define BINS 6

struct bins {
    size_t counts[BINS];
    double worst;
};

void bins_add(struct bins *bins, double ratio);

/* One line on standard output. */
void bins_print(const struct bins *bins, const char *what);

#endif
