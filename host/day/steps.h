/* The steps of a day at the runway, in their order, and which one is next. Pure: all that is known
 * comes in `struct day_facts` (facts.h reads it from a campaign), so a day that was broken off
 * anywhere goes on where it was. A landing begins with the survey after the one before, and ends
 * when somebody has looked at it. */
#ifndef MATRIG_HOST_DAY_STEPS_H
#define MATRIG_HOST_DAY_STEPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/store/rows.h"

/* key, and what it is for */
#define DAY_STEPS_EACH(X)                                                     \
    X(LOOK, look, "look at the landing, and say what was seen")               \
    X(SERIES, series, "a name for what is tested")                            \
    X(CALIBRATE, calibrate, "channels against known values, where it is due") \
    X(SURVEY, survey, "gage points of the mat, read with a caliper")          \
    X(LOAD, load, "the survey's openings to the board")                       \
    X(ADVISE, advise, "how probable a zone is, and how hard to brake")        \
    X(READY, ready, "board, sensors, links, disk: go or no-go")               \
    X(LAND, land, "log, arm, land")

enum day_step {
#define DAY_STEP(NAME, key, text) DAY_##NAME,
    DAY_STEPS_EACH(DAY_STEP)
#undef DAY_STEP
        DAY_STEPS
};

enum day_state {
    DAY_DONE,
    DAY_NEXT,
    DAY_LATER,
    DAY_SKIPPED,
    DAY_NOT_NEEDED, /* here and now */
};

extern const struct day_word {
    const char *key, *text;
} day_step_words[DAY_STEPS];
const char *day_state_text(enum day_state state);
/* DAY_STEPS: no step has that key. */
enum day_step day_step_find(const char *key);

struct day_facts {
    int64_t now_us;
    char serial[200], can[200]; /* the board's links, as last said; "": not yet. "none": no CAN */
    char series[80];            /* the newest; "": none */
    /* the newest landing; 0: none */
    int64_t run, armed_us;
    int state;     /* of enum mr_landing_state */
    bool looked;   /* somebody has */
    int64_t today; /* landings armed since midnight here */
    /* the newest survey; 0: none */
    int64_t survey, survey_us, survey_ended_us; /* STORE_NONE: it goes on */
    size_t survey_read, survey_of;
    char pattern[16], edges[8];
    int64_t loaded_us; /* when a board was given it; 0: not */
    /* the newest advice for the landing to come; 0: none */
    int64_t advised_us;
    char advice[8];
    /* the newest of `matrig ready` in the last 12 h; 0: none */
    int64_t ready_us;
    bool go, calibration_due; /* it said so */
    char no_go[200];          /* its first reason */
    int64_t calibrated_us;    /* the last walk along the channels; 0: none */
    bool skipped[DAY_STEPS];  /* for the landing to come */
    bool logging;             /* a log that the day began is running */
    bool held;                /* another one is */
};

/* The newest landing is armed, or not yet over. */
bool day_landing_goes_on(const struct day_facts *facts);

struct day_plan {
    enum day_state state[DAY_STEPS];
    char reason[DAY_STEPS][240];
    enum day_step next;
};
void day_plan_make(const struct day_facts *facts, struct day_plan *plan);

#endif
