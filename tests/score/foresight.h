/* What is said of a landing at fixed times, kept to be scored: foresight.c plays and says,
 * foresight_table.c scores, foresight_diagram.c draws. */
#ifndef MATRIG_TESTS_SCORE_FORESIGHT_H
#define MATRIG_TESTS_SCORE_FORESIGHT_H

#include <stdio.h>

#include "host/base/error.h"
#include "tests/score/advised.h"
#include "tests/score/stats.h"

/* Of a landing: before touchdown, and so long after it. */
enum foresight_when { BEFORE, HALF, ONE, TWO, WHENS };

/* What is known without a model of the runway, and the board's zone to come; about 1 in size. */
enum foresight_fact {
    FACT_ONE,
    FACT_PLAN,      /* planned mean deceleration */
    FACT_HARDEST,   /* the hardest that is planned */
    FACT_BRAKING,   /* measured */
    FACT_COUNT,     /* of landings */
    FACT_KINEMATIC, /* zone closed by transducers and survey alone */
    FACT_SPEED,     /* now; before touchdown planned */
    FACT_FRICTION,  /* told */
    FACT_COMING,    /* zone to come by the board's predictor */
    FACT_SLACK,     /* surveyed, sum of the runway; 0: none */
    FACTS
};

/* Who says how probable an event is. */
enum foresight_by {
    BY_ENSEMBLE, /* of `matrig advise`: before touchdown, and never changed */
    BY_BOARD,    /* the board's risk, with plan and chart */
    BY_COMBINED, /* logistic rule of all facts */
    BY_PLANNED,  /* the board's risk with a plan alone, */
    BY_NOTHING,  /* and with neither */
    BY_FACT      /* and on: of one of them each */
};

struct foresight_said {
    float fact[FACTS];
    /* NaN: not said; share: of the members, as counted */
    float ensemble, share, board, planned, nothing;
    float until_s; /* to the event; NaN: none comes */
    uint16_t series;
    uint8_t landing, when;
};

/* A row of the score: what is perturbed. */
struct foresight_row {
    const char *name, *text;
    enum score_kind kind;
    struct advised_told told;
};
#define FORESIGHT_ROWS 15u
extern const struct foresight_row foresight_rows[FORESIGHT_ROWS];

struct foresight_list {
    struct foresight_said *said;
    size_t count;
    uint32_t series; /* so many */
};

/* Landings of a row that are still at risk at a moment, as they are scored: the event is half a
 * second away or more. */
struct foresight_moment {
    size_t count, events;
    float *by[BY_FACT + FACTS]; /* probabilities; climatology stands in FACT_ONE's place */
    bool *event;
    uint16_t *series;
};

/* Rules are of what `learned` tells; false: no memory. foresight_forget in every case. */
bool foresight_recall(const struct foresight_list *list, const struct foresight_list *learned,
                      enum foresight_when when, struct foresight_moment *moment);
void foresight_forget(struct foresight_moment *moment);

/* The moments of a row: lines of both tables, and the diagram. */
void foresight_print_areas(const struct foresight_row *row, const struct foresight_moment *moment);
void foresight_print_held(const struct foresight_row *row, const struct foresight_moment *moment);
void foresight_print_missed(const struct foresight_row *row, const struct foresight_moment *moment);
enum mr_status foresight_draw(const char *path, const struct foresight_row *row,
                              const struct foresight_moment *moment, struct error *error);

extern const char *const foresight_when_names[WHENS];

#endif
