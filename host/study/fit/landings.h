/* Landings to fit: what was measured of them, as statistics, and the same statistics of simulated
 * ones.
 *
 * Simulated is the chain (host/sim/README.md, "Chain and landings") along the measured way of the
 * gear. Drawn anew each time:
 * - joints: gaps uniform over 0 to twice their mean, none beyond the slack (those lie hooked);
 * those of a surveyed segment
 *   given its sum, which is off by the survey's error. A landing that follows the one before keeps
 *   that one's gaps, scaled to the sums. Closing resistances uniform over 0 to twice their mean,
 *   the same joint's in all landings;
 * - instruments: noise of each sample, the baseline's error, a gain error per transducer and
 * landing, the thrust's.
 *
 * Statistics, in inches: of each transducer the mean movement while the wheel was so far ahead of
 * it or behind (FIT_EDGES), and over the last 0.2 s; of each segment surveyed after, and before or
 * in a landing that follows, the sum after. Of u only u0 asinh(u/u0) is used, as movements scale
 * with what causes them. A mean over a window is one number however many samples it has, and its
 * scatter comes from the ensemble: nothing takes neighbouring samples for independent. A window of
 * which less than half is valid is left out. */
#ifndef MATRIG_HOST_STUDY_FIT_LANDINGS_H
#define MATRIG_HOST_STUDY_FIT_LANDINGS_H

#include "common/catalogue.h"
#include "common/closure.h"
#include "host/base/units.h"
#include "host/sim/models/chains.h"
#include "host/sim/sim.h"
#include "host/store/store.h"
#include "host/study/fit/fit.h"

enum fit_key { FIT_GAP, FIT_GRIT, FIT_FRICTION, FIT_SHARE, FIT_STIFFNESS, FIT_KEYS };

/* A parameter: its logarithm has a normal prior about ln(value). */
struct fit_parameter {
    bool fitted; /* else it stays at its value */
    double value;
    double spread; /* standard deviation of the logarithm: 0.1 is 10 % */
};
extern const struct fit_name {
    const char *key, *words;
    enum unit_kind unit;
} fit_names[FIT_KEYS];

/* A transducer's movement since the baseline, inches, NaN where not valid; sample i at t0_s + i
 * dt_s since touchdown. */
struct fit_series {
    double station_ft;
    double t0_s, dt_s;
    const double *value_in;
    size_t count;
    double noise_in;    /* standard deviation of a sample */
    double baseline_in; /* standard error of the baseline */
    double gain;        /* relative standard error of a movement */
};

struct fit_window {
    size_t channel; /* SIZE_MAX: the sum of `segment` after the landing */
    size_t segment;
    double from_s, to_s;
    double samples; /* valid ones in it */
};

#define FIT_WINDOWS_MAX (MR_TRANSDUCERS * 8u + MR_SEGMENTS)

struct fit_landing {
    int64_t run;
    struct sim_scene scene; /* owned; the path's force is that of the whole aircraft: weight a/g */
    double thrust_error;    /* relative standard error */
    bool follows;           /* the landing before it in the list, with nothing in between */
    double survey_in[MR_SEGMENTS], after_in[MR_SEGMENTS]; /* sums; NaN: not surveyed */
    double survey_error_in, after_error_in;               /* of a sum; 0: the list's */
    bool later; /* the board had landings before it on this runway; for the reader */
    /* segments of survey_in that were read at gage points after the landing before; for the
     * reader */
    size_t gages;
    struct {
        double station_ft, noise_in, baseline_in, gain;
    } channel[MR_TRANSDUCERS];
    size_t channels;
    struct fit_window window[FIT_WINDOWS_MAX];
    size_t windows;
    size_t first; /* of its statistics, in the list's */
};

struct fit_landings {
    struct fit_parameter parameter[FIT_KEYS];
    double survey_error_in; /* of a segment's sum, where the landing does not say */
    struct fit_landing *landing;
    size_t count;
    double *measured; /* statistics of all landings */
    size_t statistics;
};

/* Everything at its default: values and spreads below, nothing measured. */
void fit_landings_begin(struct fit_landings *list, const struct sim_scene *scene);
/* Takes over a landing whose scene, survey, errors and run are set (scene NULL-safe: moved).
 * MR_TOO_FEW: no window has enough valid samples. */
enum mr_status fit_landings_add(struct fit_landings *list, struct fit_landing *landing,
                                const struct fit_series *series, size_t count, struct error *error);
void fit_landings_free(struct fit_landings *list);

/* The fitted ones in order; gives how many. */
size_t fit_landings_fitted(const struct fit_landings *list, enum fit_key key[FIT_KEYS]);
/* Values of all parameters at z. */
void fit_landings_values(const struct fit_landings *list, const double *z, double value[FIT_KEYS]);
/* The model of fit.h over this list, which must stay as it is. */
struct fit_model fit_landings_model(const struct fit_landings *list);
/* Puts the joints of a draw, as the first landing begins with them, into a scene of as many mats,
 * and gives the share of the thrust of that draw. */
void fit_landings_joints(const struct fit_landings *list, const double *z, uint64_t draw,
                         struct sim_scene *scene, double *share);

/* Beside: the landing of a scene on eight runways side by side (sim/models/chains), which differ in
 * joints, friction, stiffness and the share of the thrust that comes to them.
 *
 * In single precision and one pass, as the board's chain: what is wrong with that is far less than
 * what unknown joints scatter. host/sim computes the same landing in double precision with a check
 * and takes ten times as long; tests/host/test_fit.c compares the two. */

struct beside_lane {
    /* joints 0 .. mats; openings before the landing, then what it leaves, none below 0 */
    double *gap_ft;
    const double *grit_lb;
    double friction, kl_lb_ft;
    double thrust;       /* times the scene's */
    double *sample_u_ft; /* samples rows of stations */
    bool good;           /* out: it has not run away */
};

/* Whether that chain has all that the scene has: nothing but mats, slack, grit, dry friction under
 * their own weight, ends that are fixed, and a path whose thrust goes from mat to mat. */
bool beside_can(const struct sim_scene *scene);

/* Misfit: one posterior predictive check of whether the fitted model can be the data's.
 *
 * The measured data set and its replicas are rows of residuals. The figure of a row is
 * the square of its Mahalanobis distance, by the covariance of all rows (shrunk as Ledoit and Wolf,
 * 2004); where every segment was surveyed before the runway's first landing, plus the square of how
 * far the spread of these sums exceeds what gaps laid alike have, in standard deviations. If the
 * model is the data's, the measured row is one among equals: `share` of the rows, itself among
 * them, are at least as far out, and a share of MISFIT_FALSE or less is found for that share of
 * right models. */

#define MISFIT_FALSE 0.05
#define MISFIT_LEAST 39u /* replicas; fewer decide nothing */

struct misfit {
    bool checked; /* there were replicas enough */
    bool cannot;  /* share <= MISFIT_FALSE: the model cannot be the data's */
    double share;
    size_t replicas;
};

/* `answer` with its replicas; `seed` for the sums that a survey of gaps laid alike would read. */
struct misfit misfit_check(const struct fit_landings *list, const struct fit_answer *answer,
                           uint64_t seed);

/* ---- of a campaign ---- */

/* Adds landing `run`: way of the gear, survey before it, displacements with their errors. The
 * runway is that of the scene file. A landing that the one added before it was followed by (same
 * board, next number) begins with the gaps that one leaves; when it was surveyed anew, its survey
 * is also what the one before left. MR_TOO_FEW: its motion is not known, or no transducer is
 * valid. */
enum mr_status fit_campaign_add(struct store *store, int64_t run, const char *scene_path,
                                struct fit_landings *list, struct error *error);
/* Once all are added: a survey says the gaps' mean, which is then known but for the survey's
 * systematic error. Gives the number of segments surveyed before the first landing. */
size_t fit_campaign_set_gap(struct fit_landings *list);

/* Surveyed: the sums of the gaps of each segment before and after a landing. What was read at gage
 * points between two landings (`matrig survey`, with the error of its readings) holds; a segment
 * that was not read then is as the board had it when the landing was armed. */

struct fit_surveyed {
    double sum_in[MR_SEGMENTS]; /* NaN: not surveyed */
    double error_in;            /* of a sum that was read at gage points; 0: none was */
    size_t segments, gages;     /* how many are known, and how many of them from gage points */
};

/* Before landing `run`, or after it until the next one is armed. `board`: the landing whose board's
 * own survey counts too, or STORE_NONE. */
enum mr_status fit_surveyed(struct store *store, int64_t run, bool after, int64_t board,
                            struct fit_surveyed *surveyed, struct error *error);

#endif
