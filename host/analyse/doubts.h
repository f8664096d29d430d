/* Whether the numbers of a landing are the board's. Strangers on CAN that were not obeyed changed
 * nothing (host/collect/doubt.h). Those that may have been make the landing doubtful, unless all of
 * it came over serial, where nobody else speaks; a landing that lacks its first edges is torn, and
 * what they would tell is not stated. Every place that states a number of the landing says so. */
#ifndef MATRIG_HOST_ANALYSE_DOUBTS_H
#define MATRIG_HOST_ANALYSE_DOUBTS_H

#include "host/base/answer.h"
#include "host/collect/doubt.h"
#include "host/store/store.h"

#define DOUBTS_TEXT 200u

struct doubts {
    struct store_trouble *row; /* code as in doubt.h */
    size_t rows;
    bool on_can;        /* something of the landing rests on CAN alone */
    int64_t excess;     /* frames more than the board sent that may be among that */
    bool doubtful;      /* what is stated may be a stranger's */
    int64_t first_edge; /* count of the first edge that came; 0: none came */
    bool torn;          /* those before it did not */
};

struct measured;

enum mr_status doubts_load(struct store *store, int64_t run, struct doubts *doubts,
                           struct error *error);
void doubts_free(struct doubts *doubts);
/* Whether anything rests on CAN alone, from the sources, the links of the session and its gaps. */
enum mr_status doubts_judge(struct store *store, const struct measured *measured,
                            struct doubts *doubts, struct error *error);
/* " (doubtful)", or "" when nothing is: after a number. Static storage. */
const char *doubts_mark(const struct doubts *doubts);
/* "doubtful: " with the worst of it in one line, for what stands above numbers; "" when they are
 * the board's. */
void doubts_headline(const struct doubts *doubts, char out[DOUBTS_TEXT]);
/* A line for each doubt, the worst first; for programs "doubts": each frame once, obeyed where what
 * rests on CAN may be theirs. */
void doubts_answer(const struct doubts *doubts, struct answer *answer);

#endif
