/* Bands: figures of each tension band in one landing, computed from the band's gages, and the known
 * failures that these figures show.
 *
 * The input is the tension of every gage, once per MR_BANDS_STEP_BLOCKS blocks (the means of four
 * blocks that the messages tension_* carry). The gages of a band are processed in order of station.
 * A gage without a valid reading (NaN) is ignored.
 *
 * The figures of a band are its pretension, its minimum and maximum tension since the first
 * movement (with gage and block), its tension after the landing, and the change (after minus
 * before). The pretension is the mean of the gages over the last MR_BANDS_GROUP_STEPS steps at rest
 * while armed. The tension after the landing is the mean over the last whole group of steps.
 * Standard errors combine the calibration errors (zero, gain and linearity, independent between
 * gages) with the noise measured at rest. In a difference the zero error cancels, and the gain
 * error applies to the change only.
 *
 * Findings rest on the free body of report appendix C: a band of segments L_j between connections,
 * springs K at the anchors. The ends are fixed, so the changes of length cancel (C.5),
 *     sum of dT_j L_j / AE + (dT_first + dT_last) / K = 0,
 * wherever the mats push. A connection that takes the force R from the mats is a step in tension,
 * dT_n + R - dT_(n-1) = 0 (before C.6). The tension rises behind the connection by R (1 - a ...)
 * (C.7) and falls ahead of it (C.6). The findings are slack, loose, slip, pull-out (of a rivet),
 * step, unequal and overload; each is reported as "recognised as", because none is proven
 * (docs/howto/bands.md).
 *
 * A change counts as sudden when it happens within two steps of 4 ms and is at least three times
 * the change in the two steps before and in the two steps after. The effect of the gear, at most
 * 1.5 lb in 8 ms in tests/runs, does not qualify. While a gage of the band is slack, no sudden
 * change is reported, because C.5 is valid only for a band in tension. tests/common/test_bands.c
 * measures how often damage to a chain of segments, rivets and friction is classified correctly, or
 * only as a step.
 *
 * Single precision, no library calls, no heap, no globals. About 250 instructions a block on the
 * board. */
#ifndef MATRIG_COMMON_BANDS_H
#define MATRIG_COMMON_BANDS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/config.h"

#define MR_BANDS_STEP_BLOCKS          4u
#define MR_BANDS_GROUP_STEPS          64u /* number of steps in a group, 256 ms */
/* number of steps that are kept: two intervals before, two during and two after a sudden change */
#define MR_BANDS_HISTORY_STEPS        7u
/* number of steps (40 ms) that a sudden change must persist; a later change counts as a new one */
#define MR_BANDS_PERSIST_STEPS        10u
/* number of steps (12 ms) below the limit after which a gage counts as slack */
#define MR_BANDS_SLACK_STEPS          3u
/* tension below which a gage counts as slack, as a fraction of the pretension */
#define MR_BANDS_SLACK_MAX_SHARE      0.10f
/* smallest sudden change, as a fraction of the pretension */
#define MR_BANDS_SUDDEN_MIN_SHARE     0.05f
/* smallest sudden change, also for a small pretension */
#define MR_BANDS_SUDDEN_MIN_LB        5.0f
/* fraction of the largest sudden change; smaller changes are ignored */
#define MR_BANDS_SUDDEN_IGNORED_SHARE 0.15f
/* allowed difference between the gages of a band, as a fraction of the mean tension */
#define MR_BANDS_SPREAD_MAX_SHARE     0.20f
#define MR_BANDS_FINDINGS_MAX         16u /* maximum number of findings in one step */

struct mr_band_finding {
    uint8_t band, gage; /* numbers of band and gage, from 1 */
    /* gage on the other side of the connection; for "unequal" the gage with the most tension; 0:
     * none */
    uint8_t other_gage;
    uint8_t reason; /* enum mr_band_reason */
    float value_lb;
    uint32_t block;
};

struct mr_band_extreme {
    float tension_lb; /* extreme tension; NaN: none yet */
    uint8_t gage;
    uint32_t block;
};

struct mr_band_candidate { /* a sudden change that has not persisted long enough yet */
    uint8_t reason;        /* enum mr_band_reason; 0: none */
    uint8_t position, other_gage;
    float change_lb; /* change at the gage `position` */
    /* change that must remain: of the weighted mean for a slip, otherwise of the gage */
    float min_lb;
    float
        before_lb; /* tension before the change, extrapolated with the trend before and after it */
    uint32_t block;
};

struct mr_band {
    uint8_t gage_count;
    uint8_t gage[MR_GAGES]; /* numbers of the gages from 0, ordered by station */
    /* fraction of the band's length that each gage represents; the sum is 1 */
    float weight[MR_GAGES];
    float sudden_change_min_lb, slack_limit_lb, yield_lb;
    struct mr_band_extreme min_tension, max_tension;
    uint8_t persist_steps; /* steps until the next search for a sudden change */
    /* is_baseline_frozen: a failure was found, so the baseline does not change any more */
    bool is_unequal_reported, is_baseline_frozen;
    struct mr_band_candidate candidate;
};

struct mr_bands {
    const struct mr_channel_config *channel; /* configuration of the gages */
    bool is_active;
    struct mr_band band[MR_CONFIG_BANDS];
    float history[MR_BANDS_HISTORY_STEPS][MR_GAGES];
    unsigned newest_row, filled_rows;
    /* sums over the group: tensions, and squared differences between successive steps */
    float sum_lb[MR_GAGES], square_sum_lb2[MR_GAGES];
    unsigned group_step_count;
    bool is_group_quiet;
    /* means and noise of the last complete group; NaN: none */
    float group_mean_lb[MR_GAGES], group_noise_lb[MR_GAGES];
    float before_lb[MR_GAGES], before_noise_lb[MR_GAGES];
    uint8_t slack_step_count[MR_GAGES];
    uint32_t slack_reported_gages,
        overload_reported_gages; /* one bit per gage whose finding has been reported */
    struct mr_band_finding finding[MR_BANDS_FINDINGS_MAX];
    unsigned finding_count;
};

struct mr_band_summary {
    unsigned
        gage_count; /* number of gages with a valid tension both before and after the landing */
    float before_lb, before_error_lb, spread_lb;
    float after_lb, change_lb, change_error_lb;
    struct mr_band_extreme min, max;
    float min_error_lb, max_error_lb;
};

/* Resets the state and starts watching the bands that have a gage. `gages` points to the MR_GAGES
 * gage channels and must stay valid. `gages` and `band` must not change until mr_bands_end. */
void mr_bands_arm(struct mr_bands *bands, const struct mr_channel_config *gages,
                  const struct mr_band_config band[MR_CONFIG_BANDS]);

/* Processes one step that ends with block `block`. `quiet`: no gear is rolling and the mat is at
 * rest. `wheel_ft`: station of the wheel, NaN if there is none. Returns the number of new entries
 * in `finding`. */
unsigned mr_bands_update(struct mr_bands *bands, const float tension_lb[MR_GAGES], bool quiet,
                         float wheel_ft, uint32_t block);

/* Ends the landing; the figures remain available. */
void mr_bands_end(struct mr_bands *bands);

/* Returns in `figures` the figures of band 0 to MR_CONFIG_BANDS - 1; unknown values are NaN. */
void mr_bands_get_summary(const struct mr_bands *bands, unsigned band,
                          struct mr_band_summary *figures);

/* Finds minimum, mean and maximum of a band's valid gages in this step; NaN if no gage is valid.
 * Returns the number of valid gages. */
unsigned mr_bands_find_extremes(const struct mr_channel_config *gages,
                                const float tension_lb[MR_GAGES], unsigned band, float *min_lb,
                                float *mean_lb, float *max_lb);

/* Standard error of a tension from the calibration, without noise. */
float mr_bands_tension_error_lb(const struct mr_channel_config *gage, float tension_lb);

#endif
