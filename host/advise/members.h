/* An ensemble of runways: members that are each a runway as it may be, after all that was read of
 * it. What nobody has measured of the mats is drawn by member: the share of the thrust that the
 * strip bears, friction, resistance of closing joints, stiffness and damping of joints, and the
 * opening and resistance of each joint. A survey gives ten joints their sum; a landing that was
 * measured teaches the rest (smoother.h). Members are computed eight side by side
 * (host/sim/models/chains.h), on several threads: seed and inputs fix the result, not the threads.
 *
 * Feet, pounds, seconds; openings of surveys and movements in inches, as they are read. */
#ifndef MATRIG_HOST_ADVISE_MEMBERS_H
#define MATRIG_HOST_ADVISE_MEMBERS_H

#include <stdbool.h>
#include <stddef.h>

#include "common/block.h"
#include "common/closure.h"
#include "common/matchain.h"
#include "host/advise/chance.h"

#define ADVISE_LEAST     64u /* members; of less, chances are too rough to act on */
#define ADVISE_USUAL     256u
#define ADVISE_MOST      4096u
#define ADVISE_ZONE_MATS 50u /* as the board's warning: MR_PREDICTOR_WARNING_MATS */
#define ADVISE_ZONE_FT   2.0 /* the wheel so near to the zone's start is at it */
#define ADVISE_SLOW_FT_S 2.0 /* a slower wheel pushes nothing together */
#define ADVISE_PROFILE   24u
#define ADVISE_JOINTS    (MR_CHAIN_MATS + 1u)
#define ADVISE_G_FT_S2   32.174

/* Logarithms, but for nothing: all are positive. */
enum advise_unknown {
    ADVISE_SHARE, /* of W/axles that the strip bears */
    ADVISE_FRICTION,
    ADVISE_RESISTANCE, /* mean of closing joints, lb */
    ADVISE_STIFFNESS,  /* KL, lb/ft */
    ADVISE_DAMPING,    /* CL, lb s/ft */
    ADVISE_UNKNOWNS
};

/* What is told of the runway. */
struct advise_runway {
    struct mr_chain_params chain;     /* friction as told; its step is not used */
    double grit_lb;                   /* mean closing resistance, as configured */
    double thrust_lb_per_g;           /* of the lead axle on the strip */
    double share;                     /* of that, measured within 3 %; 0: nobody did */
    double bump_ft;                   /* the ground's irregularity; 0: unknown */
    float station_ft[MR_TRANSDUCERS]; /* NaN: not fitted */
};

struct advise_member {
    double unknown[ADVISE_UNKNOWNS];
    float gap_ft[ADVISE_JOINTS]; /* of joint 1 at [0] */
    float grit[ADVISE_JOINTS];   /* closing resistance over the mean */
};

struct advise_members {
    struct advise_runway runway;
    struct advise_member *member;
    size_t count; /* a multiple of 8 */
    unsigned threads;
    unsigned learned;  /* landings */
    bool surveyed;     /* since the mats were laid, ten joints at least */
    uint64_t computed; /* members' landings played since advise_members_draw */
    struct chance chance;
};

/* Braking over time, relative to its mean: joined by straight lines, constant before the first and
 * behind the last. count 0: even. */
struct advise_profile {
    size_t count;
    double t_s[ADVISE_PROFILE], factor[ADVISE_PROFILE];
};

/* A landing of one member. Braking begins with an onset of 60 ms. */
struct advise_braking {
    double speed_ft_s, touchdown_ft;
    double mean_ft_s2;                    /* times the profile's factor */
    const struct advise_profile *profile; /* NULL: even */
};

double advise_braking_ft_s2(const struct advise_braking *braking, double t_s);

/* What came of it. */
struct advise_met {
    float zone_ft; /* station of the wheel when it first is at a zone of 50 mats; NaN: it is not */
    float stop_ft; /* of the wheel; beyond the runway: it rolls off */
    uint16_t most_mats;             /* longest zone that it was at */
    bool ran_away;                  /* the chain did: nothing else holds */
    float moved_in[MR_TRANSDUCERS]; /* at the end; NaN: not fitted */
    float sum_in[MR_SEGMENTS];      /* openings at the end */
};

/* Draws `count` members, rounded up to eight, of a runway that nobody has read. MR_USAGE: the
 * runway's parameters make no sense. advise_members_free in every case. */
enum mr_status advise_members_draw(struct advise_members *members,
                                   const struct advise_runway *runway, size_t count, uint64_t seed);
void advise_members_free(struct advise_members *members);

/* The mats were laid anew: all openings are drawn again, what was learned of the rest stays. */
void advise_relay(struct advise_members *members);
/* Openings get the surveyed sums, NaN: not read. Each member is off by an error of its own. */
void advise_survey(struct advise_members *members, const double sum_in[MR_SEGMENTS],
                   double error_in);
/* Plays a landing on each member. `keeps`: their joints are left as it left them. False: no
 * memory. */
bool advise_play(struct advise_members *members, const struct advise_braking *braking, bool keeps,
                 struct advise_met *met);

/* A landing that was measured. */
struct advise_seen {
    struct advise_braking braking;
    double moved_in[MR_TRANSDUCERS], moved_error_in; /* at the end; NaN: not read */
    double before_in[MR_SEGMENTS];                   /* surveyed; NaN: not read */
    double after_in[MR_SEGMENTS];
    double survey_error_in;
};
/* Takes in what a landing shows: the survey before it, then its readings, in two passes of the
 * smoother, then the landing itself. False: a chain ran away. */
bool advise_learn(struct advise_members *members, const struct advise_seen *seen);

/* Spreads what was learned about its mean again, `times` above 1: for a landing unlike those. */
void advise_widen(struct advise_members *members, double times);

/* Longest zone ahead of the wheel: from a closed joint (0.001 in) to a closed one in which no ten
 * joints in a row have more than one open. Joints are counted from 0; 0 mats: none. */
struct advise_zone {
    unsigned first, mats;
};
struct advise_zone advise_longest(const float *opening_ft, unsigned joints, unsigned from);

/* Geometric mean and relative spread of an unknown over the members. */
void advise_unknown(const struct advise_members *members, enum advise_unknown unknown, double *mean,
                    double *spread);

#endif
