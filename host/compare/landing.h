/* Comparison of landings with a model: one landing, stored in the campaign, or a series. */
#ifndef MATRIG_HOST_COMPARE_LANDING_H
#define MATRIG_HOST_COMPARE_LANDING_H

#include "host/compare/figures.h"
#include "host/compare/limits.h"
#include "host/landing_series/series.h"
#include "host/sim/scene/scene.h"
#include "host/sim/sim.h"
#include "host/survey/survey.h"

/* landing weight of the model aircraft (report 2.3: 1220 to 1500) */
#define COMPARE_AIRCRAFT_LB 1300.0
/* The chain is a strip 12/7 ft wide, so the rig's 12 strips share the thrust. */
#define COMPARE_RIG_STRIPS  12.0
#define COMPARE_PATH_STEP_S 0.02

/* Sets the run's motion (path) and survey (gap0) in a scene that contains everything else. The path
 * has the station of the fitted motion and thrust = (aircraft / strips) a / g. MR_TOO_FEW: the
 * motion is not known. MR_TRUNCATED: the record ends before the stop. */
enum mr_status compare_prepare_scene(const struct measured_landing *measured,
                                     const struct zones_slack *survey, struct sim_scene *scene,
                                     struct error *error);

/* The model with which a landing is compared: a scene, or an ensemble of runways of a campaign. It
 * is simulated with the measured motions.
 *
 * Each runway of an ensemble has the openings and closing resistances that `matrig study` draws
 * from its seed. A survey scales the openings of each surveyed segment to the surveyed sum, but no
 * opening beyond the slack. In a scene the joints of a segment share the sum equally. Each landing
 * of a series begins with the openings at the end of the previous simulation, unless there is a new
 * survey. The state of modifications does not carry over: each landing begins with the state in the
 * file. Only the chain model is simulated, which has no waves. Units are in the names; stations are
 * measured from the runway's upfield edge. */

#define COMPARE_SAMPLE_STEP_S  0.002
#define COMPARE_SEGMENT_STEP_S 0.02

struct compare_model {
    char name[120]; /* file name without folder */
    bool is_ensemble;
    struct sim_scene scene;
    struct landing_series series;
    size_t seed_count;
    size_t joint_count;
    /* state of the runway by seed and joint; NULL before the first landing */
    double *gap_ft, *closing_lb;
    float previous_survey_in[MR_SEGMENTS]; /* survey of the previous landing */
    bool is_storing_disabled;              /* comparisons are not stored in the campaign */
};

/* Loads a model. `seeds` 0: the number in the file. MR_USAGE: the scale is not that of the rig.
 * Other statuses are those of sim_scene_load and series_load. */
enum mr_status compare_model_load(struct compare_model *model, const char *path, size_t seeds,
                                  struct error *error);
void compare_model_free(struct compare_model *model);

/* A simulated landing, all seeds combined. */
struct compare_simulated {
    /* scene of the last seed; path and end time are the same for all seeds */
    struct sim_scene scene;
    size_t station_count, row_count;
    double dt_s;
    /* arrays of row_count x station_count values; movement_spread_in: standard deviation over the
     * seeds (0 for one seed) */
    double *mean_movement_in, *movement_spread_in;
    size_t segment_row_count;
    /* Remaining openings of each segment every COMPARE_SEGMENT_STEP_S, mean over the seeds: rows x
     * MR_SEGMENTS. */
    float *remaining_in;
    const char *solver;
    double solver_dt_s, simulation_ms; /* simulation_ms: computing time for all seeds */
    /* largest error estimate of the solver over all mats and times, for the first seed */
    double solver_error_in;
    size_t seed_count;
};

/* Simulates landing `index` (from 0) of the model's series. The model's runways keep the resulting
 * state. The caller frees `simulated`, also after an error. */
enum mr_status compare_simulate(struct compare_model *model, size_t index,
                                const struct measured_landing *measured,
                                const struct zones_slack *survey, const double *station_ft,
                                size_t stations, struct compare_simulated *simulated,
                                struct error *error);
void compare_simulated_free(struct compare_simulated *simulated);

/* One landing compared with a model; the comparison is stored in the campaign. */

struct compare_landing {
    struct compare_figures figures;
    struct measured_landing measured;
    struct store_simulation_summary head;
    struct store_simulation row[MR_TRANSDUCERS];
    size_t row_count;
};

/* Simulates, compares and stores RUN as landing `index` (from 0) of the model's series. Earlier
 * comparisons are kept. MR_TOO_FEW, MR_TRUNCATED: there is no data to compare (no motion, no
 * transducers); the model is unchanged. The caller frees `landing`, also after an error. */
enum mr_status compare_run_landing(struct store *store, int64_t run, struct compare_model *model,
                                   size_t index, struct compare_landing *landing,
                                   struct error *error);
void compare_landing_free(struct compare_landing *landing);

/* A series of landings compared with one model in order: the results of each landing, and of all
 * landings together. */

struct compare_series_landing {
    int64_t run;
    bool is_compared;
    char reason[600]; /* reason why the landing was not compared */
    struct compare_figures figures;
    struct compare_verdict verdict;
};

/* Results over all landings of a series. */
struct compare_pooled {
    double within_limits_share; /* share of landings within their limits; NaN: not judged */
    double bias_in, rms_in;
};

struct compare_series {
    /* the model's file; the name of the series, empty for all landings */
    char model_file[120], name[80];
    struct compare_series_landing *landing;
    size_t landing_count, compared_count;
    /* Results of each transducer, by its number: means over all landings, weighted by the number of
     * samples. compared_landings 0: no data. */
    struct {
        int64_t number;
        double station_ft;
        size_t compared_landings;
        double sample_count, bias_in, rms_in;
    } channel_means[MR_TRANSDUCERS];
    struct compare_pooled pooled;
    /* simulation_ms: sum of the computing times of all simulations */
    double simulation_ms, worst_solver_error_in;
    /* result of all landings and of the series against the limits */
    struct compare_verdict verdict;
};

/* Compares the landings of series `name` (NULL: of the campaign) that are not void, in order. A
 * landing that cannot be compared is listed with the reason (no motion, a failed simulation). Its
 * effect on the runway is then missing in the later landings until the next survey. MR_TOO_FEW: no
 * landing could be compared. MR_UNKNOWN: there is no such series. `progress` may be NULL. The
 * caller frees `set`, also after an error. */
enum mr_status compare_series_run(struct store *store, const char *name,
                                  struct compare_model *model,
                                  void (*progress)(void *ctx, size_t done, size_t total), void *ctx,
                                  struct compare_series *set, struct error *error);
void compare_series_free(struct compare_series *set);

#endif
