/* What the score keeps of a landing, and what it makes of all of them. */
#ifndef MATRIG_TESTS_SCORE_SCORE_H
#define MATRIG_TESTS_SCORE_SCORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/predictor.h"
#include "tests/score/truth.h"

/* How a landing is seen: by survey or none, transducers at 40 to 110 or 10 to 70; the score's
 * tables have these four. Or without any transducer, without every second one, surveyed before the
 * first landing of a series alone. */
enum {
    SCORE_SURVEYED = 1,
    SCORE_UPFIELD = 2,
    SCORE_VIEWS = 4,
    SCORE_BLIND = 4,
    SCORE_HALF = 8,
    SCORE_ONCE = 16
};
/* series below have made the stated errors: those are held against the others only */
#define SCORE_TRAINED 310
enum score_method { SCORE_PREDICTOR, SCORE_KINEMATIC, SCORE_METHODS };
/* What ranks landings by danger. */
enum score_rank {
    SCORE_BY_PREDICTOR,
    SCORE_BY_THRUST,
    SCORE_BY_COUNT,
    SCORE_BY_KINEMATIC,
    SCORE_BY_HINDSIGHT,
    SCORE_RANKS
};

/* What ranks landings by the danger of a bow wave. */
enum score_wave_rank {
    SCORE_WAVE_COMING,
    SCORE_WAVE_COMPRESSION,
    SCORE_WAVE_THRUST,
    SCORE_WAVE_COUNT,
    SCORE_WAVE_KINEMATIC,
    SCORE_WAVE_RANKS
};

#define SCORE_EVENT_MATS 50  /* a zone of so many compressed mats with the wheel at it */
#define SCORE_EVENT_FT   2.0 /* that near */
#define SCORE_AHEAD_S    0.5 /* a warning so long before is in time; ranks are taken then */
#define SCORE_ZONE_MATS  30  /* zones of so many mats have their ends compared */
#define SCORE_SLOW_FT_S  2.0 /* slower wheels are not scored */

/* Joints first..last of a zone, from 0; empty: last <= first. */
struct score_zone {
    int16_t first, last;
};

struct score_look {
    struct score_zone truth, said;
    float start_error, end_error; /* stated, mats; NaN: none stated */
    uint16_t series;
    uint8_t landing, view, method;
    uint8_t start_class, end_class; /* of the predictor's stated errors */
};

struct score_outcome {
    uint16_t series;
    uint8_t landing, view;
    float event_s;                     /* NaN: none */
    float wave_s;                      /* planar truth: a bow wave; NaN: none */
    float warned_s[SCORE_METHODS];     /* first warning; NaN: none */
    float advised_s;                   /* first advisory or warning */
    float wave_rank[SCORE_WAVE_RANKS]; /* until SCORE_AHEAD_S before the wave, or the stop */
    /* the third switch beyond touchdown: before, nobody knows the braking */
    float known_s;
    float updates;     /* of mats */
    int16_t most_mats; /* longest true zone at the wheel */
    uint8_t doubted;   /* sound transducers left out */
    /* until SCORE_AHEAD_S before the event, or the stop; hindsight: thrust to the stop */
    float rank[SCORE_RANKS];
};

/* Longest zone of joints with their left ends at `from_ft` or beyond: closed joints (a gap of 0.001
 * in at most) at both ends, no ten in a row with more than one open. */
struct score_zone score_longest(const uint16_t *gap_counts, double from_ft);

/* Plays a series in one view. Looks and outcomes are handed over one by one. */
struct score_sink {
    void (*look)(void *ctx, const struct score_look *look);
    void (*outcome)(void *ctx, const struct score_outcome *outcome);
    /* NULL or: the predictor is armed; and has taken the block of `ms` */
    void (*armed)(void *ctx, const struct mr_predictor *predictor,
                  const struct score_landing *landing);
    void (*block)(void *ctx, const struct mr_predictor *predictor,
                  const struct mr_predictor_input *input, unsigned ms);
    void *ctx;
};
/* Time at which the wheel first reaches a zone of SCORE_EVENT_MATS, from the first row; NaN: it
 * does not. `most_mats`: NULL or the longest true zone at the wheel. */
double score_event_s(const struct score_landing *landing, int16_t *most_mats);
/* Slack of the segments as the survey before the landing reads it. */
void score_read_survey(const struct score_landing *landing, float *sum_in, uint64_t *state);
void score_play(const struct score_truth *truth, unsigned view, unsigned level,
                const struct score_sink *sink);

/* Prints the tables. */
void score_print(const struct score_look *looks, size_t look_count,
                 const struct score_outcome *outcomes, size_t outcome_count);

/* 95 % points of the errors, and half a mat as they are whole, over 1.96, by class: what
 * common/predictor.c states, of series below SCORE_TRAINED; how they hold in the others; and by
 * what the errors stated now would have to be multiplied. */
void score_calibrate(const struct score_look *looks, size_t count);

/* Area under the curve that hits against false alarms make, ties half; NaN with one kind only. */
double score_auc(const float *rank, const bool *event, size_t count);

#endif
