/* Series: landings 1 to 5 of the standard pattern on one runway, each starting from the gaps the
 * one before left. Landings 6 and 7 are landing 5 with other braking, each on the runway that
 * landing 4 left: 6 as gently as matrig advise recommends, 7 evenly and hard from touchdown on.
 *
 * What the 1973 report states and what was chosen here is in README.md of this folder. Everything
 * random comes from one seed, by a generator of this file's own, in streams that do not disturb
 * each other. Lengths of the runway in ft, gaps and movement as reported in in. */
#ifndef MATRIG_TESTS_RUNS_SERIES_H
#define MATRIG_TESTS_RUNS_SERIES_H

#include <stdbool.h>
#include <stdint.h>

#include "tests/runs/chain.h"
#include "tests/runs/gear.h"

#define SYN_LANDINGS           7
#define SYN_AGAINST            5 /* later landings begin where this one began */
#define SYN_SWITCHES           24
#define SYN_TRANSDUCERS        8
#define SYN_GAGES              14
#define SYN_SEGMENTS           42
#define SYN_JOINTS_PER_SEGMENT 10
#define SYN_SAMPLES_MAX        16000
#define SYN_RATE_HZ            1000
#define SYN_CLOSED_IN          0.001 /* a joint counts as closed up to this gap */
/* a closed zone ahead of the wheel that a warning should be about */
#define SYN_ZONE_AHEAD_MATS    30
#define SYN_FULL_MATS          50  /* a zone in which mats buckle */
#define SYN_AT_ZONE_FT         2.0 /* the wheel is at a zone from so far on */

/* One draw for the whole series: the rig as built. */
struct syn_rig {
    double switch_nominal_ft[SYN_SWITCHES];
    double switch_true_ft[SYN_SWITCHES];
    double transducer_ft[SYN_TRANSDUCERS];
    double gage_ft[SYN_GAGES];
    int gage_band[SYN_GAGES];
    double pretension_lb[SYN_GAGES];
};

/* Everything one landing leaves. About 5 MB: static storage. */
struct syn_landing {
    int number;
    struct syn_gear gear;
    int duration_ms;
    int samples; /* duration_ms + 1 */
    double displacement_in[SYN_SAMPLES_MAX][SYN_TRANSDUCERS];
    double tension_lb[SYN_SAMPLES_MAX][SYN_GAGES];
    double gap_in[SYN_JOINTS]; /* joint 1 first */
    double gap_end_in[SYN_JOINTS];
    struct syn_zone zone_start;
    struct syn_zone zone_end;
    /* first zone of SYN_ZONE_AHEAD_MATS or more ahead of the rolling wheel */
    struct syn_zone ahead_first;
    double ahead_first_s; /* when; -1: never */
    double ahead_first_wheel_ft;
    /* longest zone ahead of the wheel at any time before the stop */
    int ahead_longest_mats;
    double at_zone_s; /* when the wheel first is at a zone of SYN_FULL_MATS; -1: never */
    double survey_in[SYN_SEGMENTS]; /* as read */
    double peak_any_in;             /* largest movement of any mat */
    double peak_any_ft;             /* where */
    double final_any_in;            /* largest movement left */
    /* from the wheel to a mat that has just moved 0.005 in downfield, */
    double reach_median_ft;
    double reach_max_ft; /* over all mats beyond the touchdown that ever do */
    double thrust_impulse_lb_s;
    double balance_lb_s; /* thrust minus what the ground took: 0 but for rounding */
    double iterations_per_step;
    unsigned long hard_steps;
};

struct syn_series {
    uint64_t seed;
    int steps_per_ms;
    struct syn_rig rig;
    struct syn_chain chain;
    struct syn_chain before_against;
};

/* Draw rig and runway from the seed. */
void syn_series_start(struct syn_series *series, uint64_t seed, int steps_per_ms);

/* Run landing `number` (1..SYN_LANDINGS) from the present state of series->chain. false: the
 * numerics failed, or the gear or the mats did not come to rest; `landing` is then unusable. */
bool syn_series_land(struct syn_series *series, int number, struct syn_landing *landing);

#endif
