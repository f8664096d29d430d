/* Bands: figures of each tension band in one landing, from its gages, and which of its known
 * failures they show.
 *
 * Input is the tension of every gage each MR_BANDS_STEP_BLOCKS blocks (means of four: the message
 * tension_*). The gages of a band are taken in order of their stations. A gage that is not valid at
 * the time (NaN) takes no part.
 *
 * Figures of a band: pretension (mean of its gages over the last MR_BANDS_GROUP steps that passed
 * while armed and nothing moved), least and most tension from the first movement on, with gage and
 * block, tension after (mean over the last whole group of steps), and what it recovered: after less
 * before. Standard errors from the calibration's (zero, gain and linearity of each gage are
 * independent of the others') and from the noise seen at rest; in a difference the zero cancels and
 * the gain counts for the change alone.
 *
 * Findings rest on the free body of report appendix C: a band of segments L_j between connections,
 * springs K at the anchors. Fixed ends ask that the changes of length cancel (C.5),
 *     sum of dT_j L_j / AE + (dT_first + dT_last) / K = 0,
 * wherever the mats push. A connection that takes the force R from the mats is a step of it, dT_n +
 * R - dT_(n-1) = 0 (before C.6): R (1 - a ...) more behind (C.7), less ahead (C.6). The findings,
 * each "recognised as" and never proven (docs/howto/bands.md): slack, loose, slip, pull-out (of a
 * rivet), step, unequal, overload.
 *
 * A change counts as sudden when it happens within two steps of 4 ms and is three times what the
 * two steps before and after it brought: the gear's own effect, at most 1.5 lb in 8 ms in
 * tests/runs, does not qualify. While a gage of the band is slack none is named: C.5 holds for a
 * band in tension. tests/common/test_bands.c has the rates at which damage to a chain of segments,
 * rivets and friction is named correctly, or only as a step.
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

#define MR_BANDS_STEP_BLOCKS 4u
#define MR_BANDS_GROUP       64u /* steps, 256 ms */
#define MR_BANDS_HISTORY     7u  /* steps: two before, two during, two after a sudden change */
/* steps, 40 ms, that a sudden change must stay; a band's next one is another one after that */
#define MR_BANDS_HOLD        10u
#define MR_BANDS_LOW_STEPS   3u    /* steps, 12 ms */
#define MR_BANDS_SLACK       0.10f /* of the pretension */
#define MR_BANDS_STEP        0.05f /* of the pretension */
#define MR_BANDS_STEP_LB     5.0f  /* at least */
#define MR_BANDS_SHARE       0.15f /* of the largest sudden change: less is none */
#define MR_BANDS_SPREAD      0.20f /* of the mean */
#define MR_BANDS_EVENTS      16u   /* of one step */

struct mr_band_finding {
    uint8_t band, gage; /* from 1 */
    /* gage on the other side of the connection; of unequal, the tightest; 0: none */
    uint8_t other;
    uint8_t reason; /* enum mr_band_reason */
    float value_lb;
    uint32_t block;
};

struct mr_band_extreme {
    float lb; /* NaN: none yet */
    uint8_t gage;
    uint32_t block;
};

struct mr_band_doubt { /* a sudden change that has not stayed long enough yet */
    uint8_t reason;    /* 0: none */
    uint8_t place, other;
    float change_lb; /* of the gage */
    /* the change that must be left: of the weighted mean (slip), of the gage (others) */
    float least_lb;
    float from_lb; /* what it was, carried on as it went before and after the change */
    uint32_t block;
};

struct mr_band {
    uint8_t gages;
    uint8_t gage[MR_GAGES]; /* from 0, by station */
    float weight[MR_GAGES]; /* length of band that each stands for, of 1 in all */
    float step_lb, slack_lb, yield_lb;
    struct mr_band_extreme least, most;
    uint8_t hold;              /* steps until another sudden change is looked for */
    bool unequal_told, frozen; /* frozen: something gave way; the baseline stands */
    struct mr_band_doubt doubt;
};

struct mr_bands {
    const struct mr_channel_config *channel; /* of the gages */
    bool active;
    struct mr_band band[MR_CONFIG_BANDS];
    float history[MR_BANDS_HISTORY][MR_GAGES];
    unsigned newest, filled;
    /* of the group: tensions, squares of their differences from step to step */
    float sum_lb[MR_GAGES], square[MR_GAGES];
    unsigned in_group;
    bool group_quiet;
    float group_lb[MR_GAGES], group_noise_lb[MR_GAGES]; /* of the last whole group; NaN: none */
    float before_lb[MR_GAGES], before_noise_lb[MR_GAGES];
    uint8_t low_steps[MR_GAGES];
    uint32_t low_told, over_told; /* bit per gage */
    struct mr_band_finding finding[MR_BANDS_EVENTS];
    unsigned findings;
};

struct mr_band_figures {
    unsigned gages; /* that have both a before and an after */
    float before_lb, before_error_lb, spread_lb;
    float after_lb, change_lb, change_error_lb;
    struct mr_band_extreme least, most;
    float least_error_lb, most_error_lb;
};

/* Forgets all and watches the bands that have a gage. `gages`: the MR_GAGES channels, which must
 * outlive it. Both are constant until mr_bands_end. */
void mr_bands_arm(struct mr_bands *bands, const struct mr_channel_config *gages,
                  const struct mr_band_config band[MR_CONFIG_BANDS]);

/* One step, up to block `block`. `quiet`: nothing rolls, the mat is at rest. `wheel_ft`: NaN when
 * there is none. Returns how many of `finding` are new. */
unsigned mr_bands_step(struct mr_bands *bands, const float tension_lb[MR_GAGES], bool quiet,
                       float wheel_ft, uint32_t block);

/* The landing is over; the figures stay. */
void mr_bands_end(struct mr_bands *bands);

/* Figures of band 0 to MR_CONFIG_BANDS - 1; NaN what is not known. */
void mr_bands_figures(const struct mr_bands *bands, unsigned band, struct mr_band_figures *figures);

/* Least, mean and most of a band's valid gages now; returns how many there are. NaN with none. */
unsigned mr_bands_now(const struct mr_channel_config *gages, const float tension_lb[MR_GAGES],
                      unsigned band, float *least_lb, float *mean_lb, float *most_lb);

/* Standard error of a tension by its calibration, without noise. */
float mr_bands_error(const struct mr_channel_config *gage, float tension_lb);

#endif
