/* Landings of a campaign compared with a model: one, kept in the campaign, or a series. */
#ifndef MATRIG_HOST_COMPARE_LANDING_H
#define MATRIG_HOST_COMPARE_LANDING_H

#include "host/compare/figures.h"
#include "host/compare/limits.h"
#include "host/landing_series/series.h"
#include "host/sim/scene/scene.h"
#include "host/sim/sim.h"
#include "host/survey/survey.h"

/* The scene that a landing is simulated with: its own motion (path) and survey (gaps), the rest of
 * a scene that is given. */

#define COMPARE_AIRCRAFT_LB 1300.0 /* model aircraft as landed (report 2.3: 1220 to 1500) */
/* the chain is a strip 12/7 ft wide; it carries a twelfth of the thrust */
#define COMPARE_STRIPS      12.0
#define COMPARE_PATH_STEP_S 0.02

/* Puts the run's motion (path) and survey (gap0) into a scene that holds everything else.
 * MR_TOO_FEW: the motion is not known; MR_TRUNCATED: the record ends before the stop. Path: station
 * of the fitted motion, thrust = (aircraft / strips) a / g. */
enum mr_status compare_scene(const struct measured *measured, const struct zones_closure *survey,
                             struct sim_scene *scene, struct error *error);

/* What a landing is compared with: a scene, or the ensemble of runways of a campaign, played
 * through the measured motions.
 *
 * A runway of an ensemble has the openings and closing resistances that `matrig study` draws from
 * its seed. A survey scales the openings of each surveyed segment to its sum (none beyond the
 * slack, whatever the survey says); in a scene each joint gets its share. From one landing of a
 * series to the next the openings stay as the simulation left them, unless there is a new survey.
 * What modifications remember is not carried: each landing begins with them as the
 * file has them. The chain is computed, never waves. Units as named; stations from the runway's
 * upfield edge. */

#define COMPARE_SAMPLE_S   0.002
#define COMPARE_SEGMENTS_S 0.02

struct compare_model {
    char name[120]; /* the file's, without its folder */
    bool ensemble;
    struct sim_scene scene;
    struct landing_series series;
    size_t seeds;
    size_t joints;
    /* per seed and joint: as the runway is now; NULL before the first landing */
    double *gap_ft, *closing_lb;
    float survey_in[MR_SEGMENTS]; /* that of the landing before */
};

/* `seeds` 0: as many as the campaign has. MR_USAGE: of another scale; else as sim_scene_load and
 * series_load. */
enum mr_status compare_model_load(struct compare_model *model, const char *path, size_t seeds,
                                  struct error *error);
void compare_model_free(struct compare_model *model);

/* A landing as simulated, all seeds together. */
struct compare_simulated {
    struct sim_scene scene; /* of the last seed: path and end are those of all */
    size_t stations, rows;
    double dt_s;
    /* rows x stations; spread: standard deviation over the seeds, 0 of one */
    double *mean_in, *spread_in;
    size_t segment_rows;
    /* what is left of each segment's openings every COMPARE_SEGMENTS_S, mean over the seeds: rows x
     * MR_SEGMENTS */
    float *remaining_in;
    const char *solver;
    double solver_dt_s, run_ms; /* all seeds */
    /* the solver's own estimate, of the first seed: largest of all mats and times */
    double error_in;
    size_t seeds;
};

/* Landing `index` (from 0) of the model's series. The model keeps what became of its runways. The
 * caller frees, also after an error. */
enum mr_status compare_simulate(struct compare_model *model, size_t index,
                                const struct measured *measured, const struct zones_closure *survey,
                                const double *station_ft, size_t stations,
                                struct compare_simulated *simulated, struct error *error);
void compare_simulated_free(struct compare_simulated *simulated);

/* One landing of a campaign compared with a model, and the comparison kept in the campaign. */

struct compare_landing {
    struct compare_figures figures;
    struct measured measured;
    struct store_simulation_head head;
    struct store_simulation row[MR_TRANSDUCERS];
    size_t rows;
};

/* RUN as landing `index` (from 0) of the model's series: simulated, compared and kept; it replaces
 * no earlier comparison. MR_TOO_FEW, MR_TRUNCATED: nothing to compare with (no motion, no
 * transducers), the model is as before. The caller frees, also after an error. */
enum mr_status compare_landing(struct store *store, int64_t run, struct compare_model *model,
                               size_t index, struct compare_landing *landing, struct error *error);
void compare_landing_free(struct compare_landing *landing);

/* A series of landings compared with one model, in order: each landing, and all together. */

struct compare_series_landing {
    int64_t run;
    bool compared;
    char why[600]; /* not compared: why */
    struct compare_figures figures;
    struct compare_verdict verdict;
};

/* All landings of a series together. */
struct compare_pooled {
    double within; /* share of landings within their limits; NaN: not judged */
    double bias_in, rms_in;
};

struct compare_series {
    char against[120], name[80]; /* the model's file; the series' name, or empty: all landings */
    struct compare_series_landing *landing;
    size_t count, compared;
    struct {
        int64_t number;
        double station_ft;
        size_t landings;
        double samples, bias_in, rms_in;
    } channel
        [MR_TRANSDUCERS]; /* by number, pooled over the landings by samples; landings 0: none */
    struct compare_pooled pooled;
    double run_ms, error_in;        /* all simulations; the largest of their estimates */
    struct compare_verdict verdict; /* landings and series */
};

/* Landings of series `name` (NULL: of the campaign) that are not void, in order. A landing that
 * cannot be compared is there with its reason (no motion, a simulation that fails), and what it did
 * to the runway is unknown to those after it until the next survey. MR_TOO_FEW: none could be;
 * MR_UNKNOWN: no such series. `progress` may be NULL. The caller frees, also after an error. */
enum mr_status compare_series_run(struct store *store, const char *name,
                                  struct compare_model *model,
                                  void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                                  struct compare_series *set, struct error *error);
void compare_series_free(struct compare_series *set);

#endif
