/* What a board said at bring-up, held against what it should (bringup_limits.def) and against what
 * it said the last time. */
#ifndef MATRIG_HOST_BOARD_BRINGUP_JUDGE_H
#define MATRIG_HOST_BOARD_BRINGUP_JUDGE_H

#include "common/boards.h"
#include "host/board/bringup.h"

enum bringup_verdict { BRINGUP_OK, BRINGUP_LOOK, BRINGUP_WRONG };

enum bringup_tolerance { BRINGUP_SAME, BRINGUP_PLUS, BRINGUP_PERCENT, BRINGUP_ANY };

struct bringup_limit {
    unsigned sections; /* bits */
    const char *name;  /* with * at its end: all that begin so */
    const char *words; /* one of these; "": any; NULL: a number from least to most */
    double least, most;
    /* the number that this board has instead; NULL: of all boards alike */
    double (*of_board)(const struct mr_board *board);
    enum bringup_verdict beyond, none;
    enum bringup_tolerance tolerance;
    double change;
    const char *source, *advice;
};

struct bringup_judged {
    const char *name;
    const struct bringup_line *line;   /* NULL: it was not said */
    const struct bringup_limit *limit; /* NULL: the name is not known here */
    double least, most;              /* of the limit for this board; NaN: the board is not known */
    const struct bringup_line *last; /* NULL: nothing to compare with */
    bool moved;                      /* beyond its tolerance, since the last time */
    enum bringup_verdict verdict;
};

#define BRINGUP_JUDGED (2 * BRINGUP_LINES)

/* Lines in their order, then those that are missing; `last` may be NULL. Returns how many; they
 * refer to `now` and `last`. */
size_t bringup_judge(const struct bringup *now, const struct bringup *last,
                     struct bringup_judged judged[BRINGUP_JUDGED]);
enum bringup_verdict bringup_worst(const struct bringup_judged *judged, size_t count);
const char *bringup_verdict_text(enum bringup_verdict verdict); /* "ok", "look", "wrong" */
bool bringup_limit_is_group(const struct bringup_limit *limit);

#endif
