/* The onboard predictor: the chain of mats (common/matchain.h) driven by what the switches say of the gear, corrected by what the
 * transducers say of the mats, and what follows from it for the wheel: where joints are closed, how well that is known, how close
 * the compression ahead of the wheel is to the one that an irregularity does not bear.
 *
 * One call per block (1 ms). Inputs are a function of block records, edges and commands alone; the level is chosen by counting mat
 * updates, never by time: a replay says the same. No heap, single precision, square root the only library call.
 *
 * Units: feet, pounds, seconds; displacements of transducers in inches as they are read. */
#ifndef MATRIG_COMMON_PREDICTOR_H
#define MATRIG_COMMON_PREDICTOR_H

#include <stdbool.h>
#include <stdint.h>

#include "common/block.h"
#include "common/closure.h"
#include "common/matchain.h"

enum mr_predictor_level {
    MR_PREDICTOR_FULL,      /* every mat */
    MR_PREDICTOR_TWO,       /* two mats in one */
    MR_PREDICTOR_FOUR,
    MR_PREDICTOR_PLOUGH,    /* quasi-static: the wheel closes joints until the resistance ahead equals the thrust */
    MR_PREDICTOR_KINEMATIC, /* no motion known: zones from transducers and survey alone (common/closure.h) */
};

enum mr_predictor_verdict { MR_PREDICTOR_QUIET, MR_PREDICTOR_ADVISORY, MR_PREDICTOR_WARNING };

/* What the statement rests on, as bits. */
enum mr_predictor_basis {
    MR_PREDICTOR_SURVEY = 1,      /* most segments around the zone were surveyed */
    MR_PREDICTOR_BRACKETED = 2,   /* the zone lies between valid transducers; else it is inferred */
    MR_PREDICTOR_BLIND = 4,       /* no valid transducer at all */
    MR_PREDICTOR_NO_MOTION = 8,   /* no switches: kinematic */
    MR_PREDICTOR_DEGRADED = 16,   /* the budget keeps the level below the one asked for */
    MR_PREDICTOR_FELL_BACK = 32,  /* a guard tripped: the model was started again from what is measured */
};

struct mr_predictor_config {
    struct mr_chain_params chain;
    float grit_lb;               /* mean closing resistance of a joint */
    float thrust_lb_per_g;       /* thrust of the lead axle on the strip at 1 g of deceleration: weight / axles */
    float bump_ft;               /* irregularity assumed: half of h0 in P_c = w L / (2 h0) */
    float mat_weight_lb;
    uint32_t updates_per_block;  /* budget */
    enum mr_predictor_level level; /* the best one asked for */
    float station_ft[MR_TRANSDUCERS]; /* NaN: not fitted */
};

/* One block. NaN: not known, not valid. */
struct mr_predictor_input {
    float wheel_ft;              /* station of the lead wheel; NaN before the first switch */
    float speed_ft_s;
    float deceleration_ft_s2;
    bool braking_known;          /* deceleration rests on switches beyond touchdown */
    float displacement_in[MR_TRANSDUCERS]; /* since arming */
};

struct mr_predictor_zone {
    unsigned mats;               /* 0: none */
    float start_ft, end_ft;
    float start_error_ft, end_error_ft; /* standard errors, calibrated by `make score` */
    unsigned closed_joints;
    float mean_gap_in;           /* of the joints inside */
    float distance_ft, lead_s;   /* of the wheel to the start; NaN: it stops before, or is inside, or not known */
    float compression_lb;        /* largest ahead of the wheel now */
    float critical_lb;           /* P_c of the irregularity assumed */
    enum mr_predictor_verdict verdict;
    enum mr_predictor_level level;
    unsigned basis;              /* bits of enum mr_predictor_basis */
    uint32_t age_blocks;         /* since a transducer last corrected the part of the model that the zone lies in */
};

struct mr_predictor; /* in full below: placed by its owner */
