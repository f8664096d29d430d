/* Zones of a landing: the board's warnings, their times, and whether the wheel reached them; and
 * closed segments over time as the host computes them from displacements and survey
 * (common/closure.h). */
#ifndef MATRIG_HOST_ANALYSE_ZONES_H
#define MATRIG_HOST_ANALYSE_ZONES_H

#include "common/block.h"
#include "host/analyse/measured.h"
#include "host/base/answer.h"

/* Whether a record has all the board's zone messages. The board sends them 20 times a second from
 * arming until the end of the landing; in a longer gap a warning may have been sent. */

/* Times as t_s of the landing. */
struct zones_heard {
    bool any;   /* number of zone messages */
    bool late;  /* the first of them did not: the record begins after arming */
    bool ended; /* the board reported the end of the landing */
    double first_s, last_s;
    double pause_from_s, pause_to_s; /* the longest between two statements; NaN: none */
    bool since_touchdown;            /* else t_s counts from the first switch or arming */
};

#define ZONES_HEARD_TEXT 300
/* Why a warning before `before_s` may have been missed (INFINITY: any warning). False: there is no
 * reason. */
bool zones_heard_doubt(const struct zones_heard *heard, double before_s,
                       char out[ZONES_HEARD_TEXT]);

struct zone_warning {
    bool warned;
    /* At the first warning. The moment is that of the decision on the board, by the board's clock:
     * the beginning of the block that decided, which is the stamp of the frame. Lamp and frame
     * follow when the block is complete, 1 ms later; summary.h knows when the frame was
     * received. */
    int64_t block;
    /* since touchdown: the clock of log, report and make series. The live page, before the
     * fit, has the block */
    double t_s;
    int64_t mats;
    double start_ft, end_ft;
    double wheel_ft; /* NaN: not known yet */
    int64_t inferred_percent;
    /* By the predictor, at the same time; STORE_NONE, NaN: not sent, as by an older board: */
    int64_t reason, level;
    double start_error_ft, end_error_ft; /* standard errors */
    int64_t coming_mats;                 /* longest zone that it sees coming */
    double coming_wheel_ft;              /* where the wheel is then, */
    double coming_after_s;               /* and how much later it was there; NaN: it was not */
    /* Longest run while the warning stood: */
    int64_t most_mats;
    double most_start_ft, most_end_ft;
    /* The wheel at the zone first warned of, from the final fit: */
    bool path_known;    /* up to the stop; otherwise the wheel's position is unknown */
    bool reached;       /* it reached its start, or was in it already */
    double reached_t_s; /* NaN: it did not */
    double true_lead_s; /* reached_t_s - t_s; NaN: not reached */
    /* The first lead time that the board gave with a warning, and what it turned out to be: */
    double lead_s; /* NaN: none was ever given */
    double lead_t_s;
    double lead_start_ft; /* where the zone began then */
    double lead_became_s; /* until the wheel was there; NaN: it stopped before, or not known */
};

struct zones {
    struct store_zone *row;
    size_t count;
    struct zone_warning warning;
    struct zones_heard heard;
};

enum mr_status zones_load(struct store *store, const struct measured *measured, struct zones *zones,
                          struct error *error);
void zones_free(struct zones *zones);
/* The first warning and its outcome. `watched`: a board could have warned. */
void zones_answer(const struct zones *zones, bool watched, struct answer *answer);
/* Whether and when it warned, for people. */
void zones_warned_answer(const struct zones *zones, bool watched, struct answer *answer);
/* Why a warning before the first one may have been missed. False: there is no reason, or no
 * warning. */
bool zones_earlier_text(const struct zones *zones, char out[ZONES_HEARD_TEXT]);
double zones_time_s(const struct measured *measured, const struct store_zone *zone);

/* Slack left in each segment at a sample, inches (NaN: not surveyed), and the longest closed run
 * ahead of the wheel. */
struct zones_closure {
    float slack_in[MR_SEGMENTS];
    size_t surveyed; /* segments with a slack */
};
enum mr_status zones_load_survey(struct store *store, int64_t run, struct zones_closure *closure,
                                 struct error *error);
void zones_closed(const struct measured *measured, const struct zones_closure *closure,
                  size_t sample, float remaining_in[MR_SEGMENTS], struct mr_closure_zone *zone);

/* What the board's predictor rested on in a landing, in words: the runway it began with, and what
 * it had to do without. */

enum foresight_lack {
    FORESIGHT_BLIND,
    FORESIGHT_NO_MOTION,
    FORESIGHT_DEGRADED,
    FORESIGHT_BEGUN_AGAIN,
    FORESIGHT_LACKS
};

/* Seconds since touchdown, as elsewhere of a landing; NaN: not at all. */
struct foresight_span {
    double from_s, to_s;
};

struct foresight {
    size_t statements; /* 0: the board has no predictor, or sent nothing */
    int64_t source;    /* enum mr_runway_source; STORE_NONE: not reported */
    unsigned landings; /* that its runway has seen */
    double resistance; /* found, relative to the configured one; NaN: not reported */
    struct foresight_span lack[FORESIGHT_LACKS];
    int64_t worst_level; /* cheapest model */
    /* why a transducer was left out last; 0: it was trusted throughout */
    unsigned doubt[MR_TRANSDUCERS];
    struct foresight_span left_out[MR_TRANSDUCERS]; /* as reported once a second and on change */
    bool doubted_still[MR_TRANSDUCERS];             /* at the last report */
    double risk_most, risk_most_s;                  /* NaN: no risk was reported */
    unsigned risk_basis;                            /* then */
    double plan_left_s;                             /* from when on the plan was left; NaN: not */
    bool chart_old;
};

enum mr_status foresight_load(struct store *store, const struct measured *measured,
                              struct foresight *foresight, struct error *error);
/* A line for each of them. */
void foresight_answer(const struct foresight *foresight, const struct measured *measured,
                      struct answer *answer);

#endif
