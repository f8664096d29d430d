/* The steps of a test day, in order, and which one is next. day_facts_read gathers the facts from
 * the campaign; day_plan_make is pure. A landing begins with the survey after the one before it and
 * ends with a note on what was seen. */
#ifndef MATRIG_HOST_DAY_DAY_H
#define MATRIG_HOST_DAY_DAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/store/store.h"

/* key, and what the step is for */
#define DAY_STEPS_EACH(X)                                           \
    X(LOOK, look, "look at the landing and note what was seen")     \
    X(SERIES, series, "name what is tested")                        \
    X(CALIBRATE, calibrate, "calibrate the channels that are due")  \
    X(SURVEY, survey, "read the gage points of the mat")            \
    X(LOAD, load, "give the board the openings of the survey")      \
    X(ADVISE, advise, "predict zones, and how hard to brake")       \
    X(READY, ready, "check board, sensors, links, disk: go, no-go") \
    X(LAND, land, "log in another terminal, arm, land")

enum day_step {
#define DAY_STEP(NAME, key, text) DAY_##NAME,
    DAY_STEPS_EACH(DAY_STEP)
#undef DAY_STEP
        DAY_STEPS
};

enum day_state { DAY_DONE, DAY_NEXT, DAY_LATER, DAY_SKIPPED, DAY_NOT_NEEDED };

extern const struct day_word {
    const char *key, *text;
} day_step_words[DAY_STEPS];
const char *day_state_text(enum day_state state);

struct day_facts {
    int64_t now_us;
    char serial[200], can[200]; /* the board's links; "": not known. "none": no CAN */
    char series[80];            /* the newest; "": none */
    /* the newest landing; 0: none */
    int64_t run, armed_us;
    int state;     /* of enum mr_landing_state */
    bool noted;    /* it has a note */
    int64_t today; /* landings armed since midnight, local time */
    /* the newest survey; 0: none */
    int64_t survey, survey_us, survey_ended_us; /* STORE_NONE: not finished */
    size_t survey_read, survey_of;
    char edges[8];
    int64_t loaded_us; /* when a board was given it; 0: never */
    /* the newest advice since the newest landing; 0: none */
    int64_t advised_us;
    char advice[8];
    /* the newest check by `matrig ready` in the last 12 h; 0: none */
    int64_t ready_us;
    bool go, calibration_due;
    char no_go[200]; /* the first reason; that of a calibration first */
    /* a log runs since then */
    bool logging;
    int64_t logging_since_us;
    /* of this `day`, not of the campaign: since the newest landing */
    int64_t calibrated_us;
    bool skipped[DAY_STEPS];
};

/* Reads all of it anew. Keeps the links, and what is of this `day` unless another landing has come.
 * MR_IO, MR_MALFORMED. */
enum mr_status day_facts_read(struct store *store, int64_t now_us, struct day_facts *facts,
                              struct error *error);

struct day_plan {
    enum day_state state[DAY_STEPS];
    char reason[DAY_STEPS][240];
    enum day_step next;
};
void day_plan_make(const struct day_facts *facts, struct day_plan *plan);

#endif
