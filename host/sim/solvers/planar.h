/* Planar: running a scene of the report or the consistent model with any solver, and checking the
 * answer.
 *
 * Every scene is run twice. A solver that chooses its step: at its tolerance, and at 30 times that;
 * the answer is the finer one. A fixed step: at dt and at dt/1.9; the answer is the one at dt when
 * dt was given, else the finer. (Not dt/2: ends of steps that fall together sample switches alike.)
 * The error estimate is the largest difference of the two, over all mats at 64 even times and t_out
 * for u, over the same and the run's largest lift for lift; never less than the tolerance times L
 * for what moves at all. Two runs can agree by chance, and share what their solver does wrong:
 * planar.c has what joins them.
 *
 * The first two have to agree within a fifth (of the largest movement, of the lift) and on whether
 * there is a bow wave; else a chosen tolerance is tightened a hundredfold, twice at most, and then
 * the run is `unpredictable`; `unstable` when the step or tolerance was given.
 * A fixed step beyond the stability limit of the equations with every node on the ground is
 * refused before it runs: what it would return can look right.
 *
 * auto: where its first solver makes no progress the other one takes over, then hamming, which
 * samples what piles up, then moreau, which settles it; together they have a minute, and what they
 * have not answered then is refused for what the first one said. A landing that no step of fixed
 * decides goes to event and implicit, where they have its laws. */
#ifndef MATRIG_HOST_SIM_SOLVERS_PLANAR_H
#define MATRIG_HOST_SIM_SOLVERS_PLANAR_H

#include "host/sim/models/model.h"
#include "host/sim/scene/result.h"
#include "host/sim/solvers/pass.h"

/* Wall time that solvers which auto tries after its first one may take, together. */
#define PLANAR_OTHERS_S 60.0

/* Whether sim_run has a solver of this name for planar models ("auto" included). */
bool planar_has_solver(const char *name);

/* Run a checked scene. MR_OK: look at result->status. The caller frees the result in every case. */
enum mr_status planar_run(const struct sim_scene *scene, const struct sim_options *options,
                          struct sim_result *result, struct error *error);

/* Deadline: options that stop a run after a while on the clock. Solvers ask them as they ask the
 * caller whether to go on (sim_options.go_on), who is asked too. */
struct deadline {
    const struct sim_options *asked;
    struct sim_options options; /* for the solver: those asked for, but stopped in time */
    double until_s;             /* on the clock */
    bool late;                  /* it stopped the run */
};

/* From now on for limit_s of asked->clock_s; 0: no limit, the options are those asked for. The
 * deadline is referred to while its options are in use; `asked` stays the caller's. */
void deadline_begin(struct deadline *deadline, const struct sim_options *asked, double limit_s);

#endif
