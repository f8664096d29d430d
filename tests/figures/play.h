/* The scenes behind the text's numbers, played by a reading of its unknown inputs (inputs.h). */
#ifndef MATRIG_TESTS_FIGURES_PLAY_H
#define MATRIG_TESTS_FIGURES_PLAY_H

#include "host/base/error.h"
#include "host/sim/scene/scene.h"
#include "tests/figures/inputs.h"

enum run_id {
    RUN_36,
    RUN_37,
    RUN_38_STIFF,
    RUN_38_MIDDLE,
    RUN_38_SOFT,
    RUN_39_F05,
    RUN_39_F09,
    RUN_310_F05,
    RUN_310_F09,
    RUN_311_6,
    RUN_311_12,
    RUN_311_24,
    RUN_311_TIGHT,
    RUN_312_TAD10,
    RUN_312_TAD1,
    RUN_FULL_144,
    RUN_FULL_40,
    RUN_FULL_36,
    RUN_FLAT,
    RUN_SOIL_SOFT,
    RUN_SOIL_HARD,
    RUN_SOIL_LOOSE,
    RUN_SOIL_DULL,
    RUN_WIDE,
    RUN_SLOW,
    RUN_FAST,
    RUNS
};

#define PLAY_TIMES 4
#define PLAY_MATS  20 /* whose displacements are kept */

struct played {
    bool done, ok; /* ok: it came to its end */
    int times;
    double u_ft[PLAY_TIMES][PLAY_MATS + 1]; /* by mat from 1 */
    double last_ft[PLAY_TIMES];             /* of the last mat */
    double lift_ft[PLAY_TIMES];
    double peak_ft;
    double threshold_ft; /* from which a lift is a bow wave (solvers/planar.h) */
    double rise_s;       /* when the lift first reached 0.05 ft; INFINITY: never */
};

/* Runs are played when they are asked for, once. */
struct playing {
    struct reading reading;
    bool fine; /* an accurate method; else classical Runge-Kutta near its longest step */
    struct played run[RUNS];
};

/* Loads the scenes of host/scenes; play_free releases them. */
enum mr_status play_load(struct error *error);
/* MR_LIMIT when R* applied to a scene changes it: then inputs.c or the scene is wrong. */
enum mr_status play_check_rstar(struct error *error);
void play_free(void);

/* The scene of a run by a reading. Its lists stay those of the loaded scene and of `room`. */
struct play_room {
    double bump_ft[3], t_out_s[PLAY_TIMES];
};
struct sim_scene play_scene(enum run_id id, const struct reading *reading, struct play_room *room);

const struct played *play_run(struct playing *playing, enum run_id id);

/* Heights of the nodes and displacements of the mats at the run's time `at` (from 0), for drawing.
 * MR_NUMERICS when it does not get there. */
#define PLAY_NODES 162
struct profile {
    double t_s, wheel_ft;
    int mats;
    double x_ft[PLAY_NODES], height_ft[PLAY_NODES];  /* by node */
    double station_ft[PLAY_NODES], u_ft[PLAY_NODES]; /* by mat: its centre */
};
enum mr_status play_profile(struct profile *profile, enum run_id id, const struct reading *reading,
                            int at, struct error *error);

#endif
