/* The onboard predictor: the chain of mats (common/matchain.h), driven by the gear's motion from
 * the switches and corrected by the transducers. Its results are the zone of closed joints ahead of
 * the wheel, the uncertainty of that zone, and the compression ahead of the wheel relative to the
 * critical compression of an irregularity.
 *
 * Correction: at each transducer, a spring of limited force pulls the model's mat towards the
 * reading, and the joints on either side respond according to their laws. The closing resistance of
 * a runway is unknown. The model decreases it while the springs pull mats forward, and increases it
 * while they hold mats back. The closing resistances and gaps of the individual joints are unknown
 * too. The model assigns evenly distributed values to them (multiples of the golden ratio), so that
 * any ten consecutive joints are a representative sample.
 *
 * The predictor is called once per block (1 ms). Inputs are a function of block records, edges and
 * commands only. The level is selected by counting mat updates, never by time, so a replay gives
 * the same results. No heap, single precision; square root is the only library call.
 *
 * At the levels with groups, two or four mats move as one. The weakest joint of a group closes
 * first: the resistance of the group is that of its weakest open joint, updated every 4 blocks. The
 * same rule distributes the openings when the level changes.
 *
 * docs/measured/predictor.md has the cost of a block. The search for zones is spread over blocks
 * (common/zonescan.h): at most 1,300 visits of joints in 11 blocks. A switch edge that changes the
 * deceleration restarts it. During a search, a longer zone than before is reported at once, a
 * shorter one at the end of the search.
 *
 * Units: feet, pounds, seconds. Displacements of transducers and gaps of surveys are in inches, as
 * measured. */
#ifndef MATRIG_COMMON_PREDICTOR_H
#define MATRIG_COMMON_PREDICTOR_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/closure.h"
#include "common/matchain.h"
#include "common/zonescan.h"

#define MR_PREDICTOR_INTERVAL_BLOCKS   50u /* interval between reports: 20 Hz */
#define MR_PREDICTOR_INTERVALS_PER_S   20u
/* length of a zone that causes a warning; buckling begins inside a zone of 50 to 60 compressed mats
 * (report 6.1.4) */
#define MR_PREDICTOR_WARNING_MATS      50u
#define MR_PREDICTOR_ADVISORY_MATS     30u
/* number of joints that the search for zones examines per block (common/zonescan.h) */
#define MR_PREDICTOR_VISITS_PER_BLOCK  128u
/* number of joints whose examination costs as much as one mat update on the board
 * (tests/error_report/predictor_cost.h) */
#define MR_PREDICTOR_VISITS_PER_UPDATE 2u
/* budget: 60 % of 168 MHz minus the other work of a block (same source) */
#define MR_PREDICTOR_UPDATES_PER_BLOCK 900u

struct mr_predictor_config {
    struct mr_chain_params chain;
    float grit_lb; /* initial mean closing resistance of a joint */
    /* thrust of the lead axle on the mat strip at a deceleration of 1 g: weight / number of
     * axles */
    float thrust_lb_per_g;
    float deceleration_ft_s2; /* deceleration assumed until the switches determine it */
    float bump_ft;            /* assumed irregularity: h0 in P_c = w L / (2 h0) */
    float mat_weight_lb;
    /* budget of mat updates per block, as mean over any second; the mean over one interval may be
     * 1.5 times as large */
    uint32_t updates_per_block;
    enum mr_predictor_level level;    /* best level that may be used */
    float station_ft[MR_TRANSDUCERS]; /* stations of the transducers; NaN: not fitted */
};

/* Input of one block. NaN: unknown or not valid. */
struct mr_predictor_input {
    float wheel_ft; /* station of the lead wheel; NaN before the first switch */
    float speed_ft_s;
    float deceleration_ft_s2;
    /* the deceleration was measured by switches beyond touchdown */
    bool is_braking_known;
    bool is_on_runway;                     /* the gear has touched down, or is assumed to have */
    float displacement_in[MR_TRANSDUCERS]; /* movements since arming; NaN: not valid */
};

struct mr_predictor_zone {
    unsigned mats; /* length of the zone; 0: no zone */
    float start_ft, end_ft;
    /* standard errors, calibrated by `make score`; NaN at the level MR_PREDICTOR_KINEMATIC */
    float start_error_ft, end_error_ft;
    /* classes that select the errors; `make score` calibrates each class */
    uint8_t start_error_class, end_error_class;
    unsigned closed_joints;
    float mean_gap_in; /* mean opening of the joints in the zone */
    /* distance and time from the wheel to the start of the zone; NaN: unknown, or the wheel stops
     * before it; 0: reached */
    float distance_ft, lead_s;
    /* longest zone that will form ahead of the wheel before it stops, at constant deceleration */
    unsigned future_mats;
    float future_wheel_ft; /* station of the wheel when the future zone has formed */
    float compression_lb;  /* largest compression ahead of the wheel now */
    float critical_lb;     /* critical compression P_c for the assumed irregularity */
    enum mr_predictor_verdict verdict;
    enum mr_predictor_reason reason;
    enum mr_predictor_level level;
    unsigned basis; /* bits of enum mr_predictor_basis */
    /* time since a transducer last corrected the model; without transducers, since arming */
    uint32_t age_blocks;
};

#define MR_PREDICTOR_START_CLASSES 8u
#define MR_PREDICTOR_END_CLASSES   8u

struct mr_predictor {
    struct mr_predictor_config config;
    struct mr_chain chain;
    struct mr_zonescan scan;               /* search in progress */
    struct mr_zonescan_result scan_result; /* result of the last complete search */
    float scan_deceleration_ft_s2;         /* deceleration at the start of the search in progress */
    bool is_scan_restarted;                /* the search in progress replaced an incomplete one */
    uint8_t scan_result_group;             /* mats per group in `scan_result` */
    float gap_ft[MR_CHAIN_MATS + 1u];      /* gap of each joint when the chain was started */
    /* at levels with groups: resistance against closing a whole group */
    float closing_lb[MR_CHAIN_MATS / 2u + 2u];
    /* sums of openings; NaN: not surveyed since the last landing */
    float surveyed_sum_in[MR_SEGMENTS];
    float resistance_scale; /* factor on the configured closing resistance */
    float wheel_ft, speed_ft_s, deceleration_ft_s2;
    uint32_t landing_count; /* number of landings included in the runway's state */
    bool is_armed, is_braking_known, is_degraded, has_restarted;
    uint32_t moved_mask;           /* bit mask of trusted transducers that have moved */
    enum mr_predictor_level level; /* current level */
    uint32_t block;                /* blocks since arming */
    uint32_t corrected_block;
    uint32_t updates;         /* mat updates since arming */
    uint32_t examined_joints; /* work of the search in this landing, as number of joints examined */
    /* maximum mat updates in one block of this landing, including examined joints */
    uint32_t block_updates_max;
    uint32_t interval_updates; /* mat updates in this interval, including examined joints */
    /* ring buffer: interval_updates of the previous intervals */
    uint32_t interval_history[MR_PREDICTOR_INTERVALS_PER_S - 1u];
    uint32_t history_updates; /* sum of `interval_history` */
    /* part of interval_updates that does not depend on the level: the search and other work counted
     * as joints examined */
    uint32_t interval_scan_updates;
    /* number of consecutive intervals in which the next better level would have been within the
     * budget */
    unsigned intervals_within_budget;
    unsigned failures;     /* number of times that the chain diverged in this landing */
    unsigned ploughed_mat; /* last mat from which the level `plough` pushed */
    float pending_s;       /* elapsed time that the chain has not computed yet */
    /* work that the springs did on the mats at the transducers in this interval */
    float work_lb_in;
    /* displacement at each transducer in the model when the chain was last started */
    float model_base_in[MR_TRANSDUCERS];
    float
        smoothed_reading_in[MR_TRANSDUCERS]; /* running means of the readings, which lag by 50 ms */
    float last_reading_in[MR_TRANSDUCERS];   /* newest trusted readings; NaN: none */
    uint8_t doubt[MR_TRANSDUCERS];           /* enum mr_predictor_doubt */
    uint16_t doubtful_blocks[MR_TRANSDUCERS];
};

/* State kept between landings and across a reset: openings of joints 1..mats+1 in hundredths of a
 * mil, and the estimated resistance. */
struct mr_predictor_state {
    uint16_t mats;
    uint16_t landing_count;
    float resistance_scale;
    uint16_t gap_counts[MR_CHAIN_MATS + 1u];
};

/* Starts with a runway without measurements. MR_USAGE: a parameter is impossible, or is
 * recognisably in a wrong unit (inches for feet, a weight in kilograms with a mass in slugs, lb/in
 * for lb/ft); MR_NUMERICS: the step is beyond the stability limit. */
enum mr_status mr_predictor_start(struct mr_predictor *predictor,
                                  const struct mr_predictor_config *config);
void mr_predictor_save(const struct mr_predictor *predictor, struct mr_predictor_state *state);
/* Loads a state; call after mr_predictor_start. MR_MALFORMED: the state is of a different runway or
 * has impossible openings; nothing is changed then. */
enum mr_status mr_predictor_load(struct mr_predictor *predictor,
                                 const struct mr_predictor_state *state);
/* Sets the openings from a survey. `sum_in`: MR_SEGMENTS sums of joint openings, each of ten mats;
 * NaN: not surveyed. Call between landings. A sum that is impossible for ten joints (negative, or
 * more than their slack) counts as not surveyed. */
void mr_predictor_set_survey(struct mr_predictor *predictor, const float *sum_in);
/* Call after a runway has been loaded, with the sums that were given to mr_predictor_set_survey.
 * Changes no joint; a segment counts as surveyed if its joints have the given sum. */
void mr_predictor_mark_surveyed(struct mr_predictor *predictor, const float *sum_in);
/* Begins a landing: displacements are relative to this time. */
void mr_predictor_arm(struct mr_predictor *predictor);
/* Processes one block. Inputs are checked: an impossible wheel position or speed counts as unknown,
 * an impossible deceleration is replaced by the last one, and an impossible reading counts as
 * missing. If the chain diverges, it is restarted from the measurements and flagged
 * (MR_PREDICTOR_RESTARTED). */
void mr_predictor_on_block(struct mr_predictor *predictor, const struct mr_predictor_input *input);
/* Switches to the next cheaper level, as if the budget were exceeded. Call it if blocks are
 * waiting. */
void mr_predictor_reduce_level(struct mr_predictor *predictor);
/* Current result. May be called in every block: it is cheap except at the level
 * MR_PREDICTOR_KINEMATIC, where it sums over all joints. */
void mr_predictor_get_zone(const struct mr_predictor *predictor, struct mr_predictor_zone *zone);
/* Result from transducers and survey only, without the model: the closed zone ahead, and in
 * `remaining_in` (MR_SEGMENTS values) the remaining sums of openings, NaN if unknown. */
void mr_predictor_find_kinematic_zone(const struct mr_predictor *predictor,
                                      struct mr_closure_zone *zone, float *remaining_in);
/* Ends the landing: the present openings of the joints are the start of the next landing. */
void mr_predictor_end_landing(struct mr_predictor *predictor);

#endif
