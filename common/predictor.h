/* The onboard predictor: the chain of mats (common/matchain.h) driven by the gear's motion from the
 * switches and corrected by the transducers. Its results for the wheel: where joints are closed,
 * how well that is known, and how close the compression ahead of the wheel is to the critical
 * compression of an irregularity.
 *
 * Correction. At each transducer's mat a spring of limited force draws the model's mat to the
 * reading, so that the joints on either side answer by their own laws; and the resistance against
 * closing, whose size on a runway is unknown, is scaled down while the springs draw forward, up
 * while they hold back. Joints have closing resistances and gaps of their own that are not known
 * either: the model gives them evenly spread ones (by the golden ratio), so that any ten in a row
 * are a fair sample.
 *
 * One call per block (1 ms). Inputs are a function of block records, edges and commands alone; the
 * level is chosen by counting mat updates, never by time, so a replay gives the same results. No
 * heap, single precision, square root the only library call.
 *
 * Levels of groups: two or four mats move as one; of the joints in a group the weakest closes first
 * (its resistance is that of the weakest still open, followed every 4 blocks), and the openings of
 * each go on by the same rule when the level changes.
 *
 * Cost of a block, and how the search for zones is spread over blocks: docs/measured/predictor.md.
 *
 * Units: feet, pounds, seconds; displacements of transducers and gaps of surveys in inches as they
 * are read. */
#ifndef MATRIG_COMMON_PREDICTOR_H
#define MATRIG_COMMON_PREDICTOR_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/closure.h"
#include "common/matchain.h"
#include "common/zonescan.h"

#define MR_PREDICTOR_LOOK_BLOCKS       50u /* between statements: 20 Hz */
#define MR_PREDICTOR_LOOKS_PER_S       20u
/* buckling begins inside a zone of 50 to 60 compressed mats (report 6.1.4) */
#define MR_PREDICTOR_WARNING_MATS      50u
#define MR_PREDICTOR_ADVISORY_MATS     30u
/* joints looked at in a block, of the search for zones (common/zonescan.h) */
#define MR_PREDICTOR_VISITS_PER_BLOCK  128u
/* so many of them cost one mat update on the board (tests/error_report/predictor_cost.h) */
#define MR_PREDICTOR_VISITS_PER_UPDATE 2u
/* budget: 60 % of 168 MHz, the rest of a block's work taken off (the same) */
#define MR_PREDICTOR_UPDATES_PER_BLOCK 900u

struct mr_predictor_config {
    struct mr_chain_params chain;
    float grit_lb; /* mean closing resistance of a joint; to begin with */
    /* thrust of the lead axle on the strip at 1 g of deceleration: weight / axles */
    float thrust_lb_per_g;
    float deceleration_ft_s2; /* assumed until the switches give one */
    float bump_ft;            /* irregularity assumed: h0 in P_c = w L / (2 h0) */
    float mat_weight_lb;
    /* budget: mean over any second; over a look up to half as much again */
    uint32_t updates_per_block;
    enum mr_predictor_level level;    /* the best one asked for */
    float station_ft[MR_TRANSDUCERS]; /* NaN: not fitted */
};

/* One block. NaN: not known, not valid. */
struct mr_predictor_input {
    float wheel_ft; /* station of the lead wheel; NaN before the first switch */
    float speed_ft_s;
    float deceleration_ft_s2;
    bool braking_known;                    /* deceleration rests on switches beyond touchdown */
    bool on_runway;                        /* touched down, or so it is taken */
    float displacement_in[MR_TRANSDUCERS]; /* since arming */
};

struct mr_predictor_zone {
    unsigned mats; /* 0: none */
    float start_ft, end_ft;
    /* standard errors, calibrated by `make score`; NaN: kinematic */
    float start_error_ft, end_error_ft;
    /* what they are chosen by; `make score` calibrates with it */
    uint8_t start_class, end_class;
    unsigned closed_joints;
    float mean_gap_in; /* of the joints inside */
    /* of the wheel to the start; NaN: it stops before, or not known; 0: there */
    float distance_ft, lead_s;
    /* longest zone that the wheel will have before it before it stops, deceleration kept */
    unsigned coming_mats;
    float coming_ft;      /* where the wheel is then */
    float compression_lb; /* largest ahead of the wheel now */
    float critical_lb;    /* P_c of the irregularity assumed */
    enum mr_predictor_verdict verdict;
    enum mr_predictor_reason reason;
    enum mr_predictor_level level;
    unsigned basis; /* bits of enum mr_predictor_basis */
    /* since a transducer last corrected the model; of a blind one since arming */
    uint32_t age_blocks;
};

#define MR_PREDICTOR_START_CLASSES 8u
#define MR_PREDICTOR_END_CLASSES   8u

struct mr_predictor {
    struct mr_predictor_config config;
    struct mr_chain chain;
    struct mr_zonescan scan;          /* going on */
    struct mr_zonescan_found found;   /* by the last complete one */
    float scanned_ft_s2;              /* deceleration that the scan going on was begun with */
    bool scan_begun_anew;             /* it took the place of an incomplete one */
    uint8_t found_group;              /* mats in a group of `found` */
    float gap_ft[MR_CHAIN_MATS + 1u]; /* when the chain was started, by joint */
    /* of levels of groups: resistance against closing all of one */
    float shut_lb[MR_CHAIN_MATS / 2u + 2u];
    float surveyed_in[MR_SEGMENTS]; /* sums; NaN: not surveyed since a landing */
    float scale;                    /* of the closing resistance */
    float wheel_ft, speed_ft_s, deceleration_ft_s2;
    uint32_t landings; /* folded in */
    bool armed, braking, degraded, fell_back;
    uint32_t moved;                /* transducers that are trusted and have, as bits */
    enum mr_predictor_level level; /* now */
    uint32_t block;                /* since arming */
    uint32_t corrected_block;
    uint32_t updates;      /* of this landing, mats */
    uint32_t visits;       /* of this landing, joints looked at, and their like */
    uint32_t most_updates; /* in one block of this landing, visits counted in */
    uint32_t look_updates; /* since the last look, visits counted in */
    uint32_t looks[MR_PREDICTOR_LOOKS_PER_S - 1u]; /* look_updates of those before, in turn */
    uint32_t second_updates;                       /* their sum */
    uint32_t look_search; /* of these, what the search and its like cost at any level */
    /* in a row in which the next better level would have fitted into the budget */
    unsigned calm_looks;
    unsigned failures;     /* guards that tripped in this landing */
    unsigned ploughed_mat; /* last mat from which the plough has pushed */
    float due_s;           /* not yet stepped */
    /* of the springs on what the transducers have moved, since the last look */
    float work_lb_in;
    float base_in[MR_TRANSDUCERS]; /* model's displacement when the chain was last started */
    float slow_in[MR_TRANSDUCERS]; /* readings, 50 ms behind */
    float last_in[MR_TRANSDUCERS]; /* newest readings that are trusted; NaN: none */
    uint8_t doubt[MR_TRANSDUCERS]; /* enum mr_predictor_doubt */
    uint16_t doubtful_blocks[MR_TRANSDUCERS];
};

/* What is kept between landings and over a reset: openings of joints 1..mats+1 in hundredths of a
 * mil, and the resistance found. */
struct mr_predictor_state {
    uint16_t mats;
    uint16_t landings;
    float scale;
    uint16_t gap_hmil[MR_CHAIN_MATS + 1u];
};

/* A runway without measurements. MR_OK; MR_USAGE: a parameter that makes no sense, or is in another
 * unit, as far as that shows (inches for feet, a weight in kilograms beside a mass in slugs, lb/in
 * for lb/ft); MR_NUMERICS: the step is beyond the stability limit. */
enum mr_status mr_predictor_start(struct mr_predictor *predictor,
                                  const struct mr_predictor_config *config);
void mr_predictor_save(const struct mr_predictor *predictor, struct mr_predictor_state *state);
/* After mr_predictor_start. MR_MALFORMED: of another runway, or with openings that no joint can
 * have; nothing is changed then. */
enum mr_status mr_predictor_load(struct mr_predictor *predictor,
                                 const struct mr_predictor_state *state);
/* Sums of joint openings per segment of ten mats, MR_SEGMENTS of them, NaN: not read. Between
 * landings. A sum that ten joints cannot have (negative, or wider than their slack) counts as not
 * read. */
void mr_predictor_survey(struct mr_predictor *predictor, const float *sum_in);
/* The same sums again, for a runway that has been loaded: no joint changes, and those count as
 * surveyed of which the joints have the sum. */
void mr_predictor_surveyed(struct mr_predictor *predictor, const float *sum_in);
/* A landing begins: displacements count from here. */
void mr_predictor_arm(struct mr_predictor *predictor);
/* Inputs are not trusted: an impossible wheel position or speed counts as not known, a deceleration
 * as the last one, a reading as missing. A chain that diverges is restarted from the measurements
 * and flagged (MR_PREDICTOR_FELL_BACK). */
void mr_predictor_block(struct mr_predictor *predictor, const struct mr_predictor_input *input);
/* Blocks wait for it: on at the next cheaper level from here, as when the budget is exceeded. */
void mr_predictor_hurry(struct mr_predictor *predictor);
/* The result of now. Cheap except at the level MR_PREDICTOR_KINEMATIC, where it sums up all joints:
 * may be asked in every block. */
void mr_predictor_zone(const struct mr_predictor *predictor, struct mr_predictor_zone *zone);
/* The result by transducers and survey, without the model: the closed zone ahead, and in `left_in`
 * (MR_SEGMENTS) the sums of openings that are left, NaN: not known. */
void mr_predictor_find_kinematic(const struct mr_predictor *predictor, struct mr_closure_zone *zone,
                                 float *left_in);
/* The landing is over: what the joints have become is the start of the next one. */
void mr_predictor_fold(struct mr_predictor *predictor);

#endif
