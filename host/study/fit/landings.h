/* Landings for a fit: statistics of the measured landings, and the same statistics of simulated
 * landings.
 *
 * The simulation is the chain (host/sim/README.md, "Chain and landings") with the measured path of
 * the gear. Random values of each simulated data set:
 * - Joints: gaps are uniform over 0 to twice their mean, limited to the slack. A joint that is open
 * by its whole slack is called hooked. Gaps of a surveyed segment are scaled to its sum, which has
 * the survey's error. A landing without changes since the previous landing keeps its gaps, scaled
 * to the sums. Closing resistances are uniform over 0 to twice their mean, and each joint has the
 * same one in all landings.
 * - Instruments: noise of each sample, error of the baseline, a gain error per transducer and
 * landing, the error of the thrust.
 *
 * Statistics, in inches: for each transducer the mean movement while the wheel was in certain
 * ranges of distance behind or ahead of it (edges_ft), and over the last 0.2 s; for each segment
 * the sum of the gaps after the landing, if it was surveyed then, and also before the landing or in
 * a later one. A movement u is transformed to u0 asinh(u/u0), because the scatter of movements is
 * proportional to their size. The mean over a window is one number, however many samples it has,
 * and its scatter is taken from the ensemble: neighbouring samples are never treated as
 * independent. A window in which fewer than half of the samples are valid is not used. */
#ifndef MATRIG_HOST_STUDY_FIT_LANDINGS_H
#define MATRIG_HOST_STUDY_FIT_LANDINGS_H

#include "common/catalogue.h"
#include "common/closure.h"
#include "host/base/units.h"
#include "host/sim/models/chains.h"
#include "host/sim/sim.h"
#include "host/store/store.h"
#include "host/study/fit/fit.h"

enum fit_key { FIT_GAP, FIT_GRIT, FIT_FRICTION, FIT_THRUST_SHARE, FIT_STIFFNESS, FIT_KEYS };

/* A parameter of the fit. Its logarithm has a normal prior about ln(value). */
struct fit_parameter {
    bool is_fitted; /* false: the parameter keeps its value */
    double value;
    double spread; /* standard deviation of the logarithm; 0.1 means 10 % */
};
extern const struct fit_parameter_name {
    const char *key, *description;
    enum unit_kind unit;
} fit_parameter_names[FIT_KEYS];

/* Movement of a transducer from the baseline, inches; NaN: not valid. Sample i is at t0_s + i dt_s
 * since touchdown. */
struct fit_series {
    double station_ft;
    double t0_s, dt_s;
    const double *value_in;
    size_t count;
    double noise_in;          /* standard deviation of the noise of one sample */
    double baseline_error_in; /* standard error of the baseline */
    double gain_error;        /* relative standard error of a movement */
};

struct fit_window {
    /* index of the channel; SIZE_MAX: the statistic is the sum of segment `segment` after the
     * landing */
    size_t channel;
    size_t segment;
    double from_s, to_s;
    double valid_samples; /* number of valid samples */
};

#define FIT_WINDOWS_MAX (MR_TRANSDUCERS * 8u + MR_SEGMENTS)

struct fit_landing {
    int64_t run;
    /* owned by the list; the thrust in its path is that of the whole aircraft: weight a/g */
    struct sim_scene scene;
    double thrust_error; /* relative standard error of the thrust in the path */
    bool is_consecutive; /* nothing changed on the runway since the previous landing of the list */
    /* sums of the gaps surveyed before and after the landing; NaN: not surveyed */
    double survey_in[MR_SEGMENTS], survey_after_in[MR_SEGMENTS];
    /* standard error of a sum; 0: the error of the list applies */
    double before_error_in, after_error_in;
    /* the board recorded earlier landings on this runway; only for output */
    bool has_earlier_landings;
    /* number of segments in survey_in that were read at gage points after the previous
     * landing; only for output */
    size_t gage_segment_count;
    struct {
        double station_ft, noise_in, baseline_error_in, gain_error;
    } channel[MR_TRANSDUCERS];
    size_t channels;
    struct fit_window window[FIT_WINDOWS_MAX];
    size_t window_count;
    size_t first_statistic; /* index of the landing's first statistic in the list */
};

struct fit_landings {
    struct fit_parameter parameter[FIT_KEYS];
    double survey_error_in; /* standard error of a surveyed sum, for landings without their own */
    struct fit_landing *landing;
    size_t count;
    double *measured; /* statistics of all landings */
    size_t statistics;
};

/* Sets all values and spreads to their defaults, without landings. */
void fit_landings_begin(struct fit_landings *list, const struct sim_scene *scene);
/* Adds a landing whose scene, survey, errors and samples are set. The list takes ownership of the
 * scene. MR_TOO_FEW: no window has enough valid samples. */
enum mr_status fit_landings_add(struct fit_landings *list, struct fit_landing *landing,
                                const struct fit_series *series, size_t count, struct error *error);
void fit_landings_free(struct fit_landings *list);

/* Lists the fitted parameters in order. Returns their number. */
size_t fit_landings_list_keys(const struct fit_landings *list, enum fit_key key[FIT_KEYS]);
/* Computes the values of all parameters from z. */
void fit_landings_values(const struct fit_landings *list, const double *z, double value[FIT_KEYS]);
/* Returns the fit.h model of this list. The list must not change while the model is used. */
struct fit_model fit_landings_model(const struct fit_landings *list);
/* Sets the joints of a scene to those of one draw at the start of the first landing. The scene must
 * have the same number of mats. `share` is set to the thrust factor of that draw. */
void fit_landings_sample_joints(const struct fit_landings *list, const double *z, uint64_t draw,
                                struct sim_scene *scene, double *share);

/* Parallel simulation of the landing of a scene on eight runways (sim/models/chains), which differ
 * in joints, friction, stiffness and share of the thrust. Like the predictor on the board, it uses
 * single precision and no second pass that checks the error; the error is far smaller than the
 * scatter due to unknown joints. host/sim computes the same landing in double precision with a
 * check and takes ten times as long; tests/host/test_fit.c compares the two. */

struct parallel_lane {
    /* openings of joints 0 to `mats`, all at least 0: before the landing on input, after it on
     * output */
    double *gap_ft;
    const double *grit_lb;
    double friction, kl_lb_ft;
    double thrust_factor; /* factor on the thrust of the scene */
    double *sample_u_ft;  /* `samples` rows of movements, one column per station */
    bool is_valid;        /* output: false if the simulation diverged */
};

/* Returns true if the parallel simulation supports the scene: only mats, slack, grit, dry friction
 * under the weight of the mats, fixed ends, and a path whose thrust jumps from mat to mat. */
bool parallel_is_supported(const struct sim_scene *scene);

/* Misfit: a posterior predictive check that shows whether the fitted model can explain the data.
 *
 * The measured data set and its replicas are rows of residuals. The misfit of a row is the square
 * of its Mahalanobis distance, by the covariance of all rows (shrunk as in Ledoit and Wolf, 2004).
 * If every segment was surveyed before the runway's first landing, the square of a second term is
 * added: how far the spread of these sums exceeds that of randomly laid gaps, in standard
 * deviations. If the model is right, the measured row behaves like another replica. `p_value` is
 * the share of rows, including the measured one, whose misfit is at least as large as that of the
 * measured row. The check rejects a right model with probability MISFIT_LEVEL. */

#define MISFIT_LEVEL        0.05
#define MISFIT_REPLICAS_MIN 39u /* smallest number of replicas for the check */

struct misfit {
    bool is_checked;  /* true: there were enough replicas for the check */
    bool is_rejected; /* the model cannot explain the data: p_value <= MISFIT_LEVEL */
    double p_value;
    size_t replica_count;
};

/* Checks a fit with its replicas. `seed` is for the random sums of a survey. */
struct misfit misfit_check(const struct fit_landings *list, const struct fit_result *answer,
                           uint64_t seed);

/* ---- from a campaign ---- */

/* Adds landing `run`: path of the gear, survey before it, displacements with their errors. The
 * runway is that of the scene file. If the landing follows the previously added landing (same
 * board, next number), it begins with the gaps at the end of that landing; if the runway was
 * surveyed between the two, this survey also counts as the survey after the earlier landing.
 * MR_TOO_FEW: the motion is not known, or no transducer is valid. */
enum mr_status fit_campaign_add(struct store *store, int64_t run, const char *scene_path,
                                struct fit_landings *list, struct error *error);
/* Sets the mean gap and its uncertainty from the surveys; the uncertainty is their systematic
 * error. Call after all landings are added. Returns the number of segments surveyed before the
 * first landing. */
size_t fit_campaign_set_gap(struct fit_landings *list);

/* Surveyed sums of the gaps of each segment, before or after a landing. Readings at gage points
 * between two landings (`matrig survey`) are preferred. A segment without such a reading has the
 * value that the board had when the landing was armed. */

struct fit_survey {
    double sum_in[MR_SEGMENTS]; /* sum of each segment, in; NaN: not surveyed */
    /* standard error of a sum, in, between gage points; 0: no gage points were read */
    double error_in;
    /* number of segments with a sum, and number of those that were read at gage points */
    size_t segment_count, gage_segment_count;
};

/* Loads the survey before landing `run`; with `after`, the one between this landing and the arming
 * of the next. `board`: landing whose sums, as stored on the board, are also used; STORE_NONE:
 * none. */
enum mr_status fit_load_survey(struct store *store, int64_t run, bool after, int64_t board,
                               struct fit_survey *surveyed, struct error *error);

#endif
