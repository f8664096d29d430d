/* A survey being taken: what is asked next, what was typed, what is doubted. Pure: who keeps the
 * readings is the caller.
 *
 * A line is a number and Enter, as a caliper types it ("33.512", "33,512", "33.512 in", "851.2
 * mm"; any unit of a length), or a word:
 *
 *     s        skip this one
 *     b        back by one
 *     f        forward by one
 *     u        undo the last reading, and ask for it again
 *     n TEXT   a note on the last reading
 *     q        quit; the survey can be resumed
 *     ?        these words */
#ifndef MATRIG_HOST_SURVEY_DESK_H
#define MATRIG_HOST_SURVEY_DESK_H

#include "host/base/quantity.h"
#include "host/survey/plan.h"

enum survey_word {
    SURVEY_NUMBER,
    SURVEY_SKIP,
    SURVEY_UNDO,
    SURVEY_BACK,
    SURVEY_FORWARD,
    SURVEY_NOTE,
    SURVEY_QUIT,
    SURVEY_HELP,
    SURVEY_NOTHING, /* an empty line */
    SURVEY_NONSENSE,
};

struct survey_entry {
    enum survey_word word;
    double value_in;             /* SURVEY_NUMBER */
    const char *note;            /* SURVEY_NOTE: inside the line that was parsed */
    struct quantity_wrong wrong; /* SURVEY_NONSENSE: why a number is none; empty: it is no number */
};

/* A number without a unit is in inches, millimetres with `si`. */
void survey_entry_parse(const char *line, bool si, struct survey_entry *entry);

struct survey_desk {
    struct survey_plan plan;
    double value_in[SURVEY_ITEMS_MAX]; /* NaN: not read */
    bool skipped[SURVEY_ITEMS_MAX];
    double previous_in[SURVEY_ITEMS_MAX]; /* of the survey before; NaN: none */
    size_t at;                            /* asked now; plan.count: all is read or skipped */
    size_t last[SURVEY_ITEMS_MAX];        /* items in the order in which they were read, for undo */
    size_t lasts;
    bool doubted; /* the same again keeps it */
    double doubted_in;
};

enum survey_outcome {
    SURVEY_KEPT,      /* `item` has a new value */
    SURVEY_CONFIRMED, /* the same, after a doubt */
    SURVEY_DOUBTED,   /* type it again */
    SURVEY_SKIPPED,   /* `item` is left out */
    SURVEY_UNDONE,    /* `item` has no value any more */
    SURVEY_MOVED,     /* another item is asked for */
    SURVEY_NOTED,     /* the note belongs to `item` */
    SURVEY_REFUSED,   /* nothing to undo, back from the first, nonsense */
};

/* Nothing read yet; previous_in NaN. */
void survey_desk_init(struct survey_desk *desk, enum survey_pattern pattern,
                      enum survey_edges edges);
/* A reading that was kept before (resuming); NaN takes it away again, `skipped` leaves it out.
 * Afterwards survey_desk_next. */
void survey_desk_restore(struct survey_desk *desk, size_t item, double value_in, bool skipped);
/* To the first item from `from` on that is neither read nor skipped; then from the beginning. */
void survey_desk_next(struct survey_desk *desk, size_t from);
/* Takes an entry other than quit, help and nothing. `item`: which one it was about. */
enum survey_outcome survey_desk_take(struct survey_desk *desk, const struct survey_entry *entry,
                                     size_t *item);
/* What the reading is compared with: of the survey before, else as designed; NaN: nothing. */
double survey_desk_expected_in(const struct survey_desk *desk, size_t item);
size_t survey_desk_read(const struct survey_desk *desk); /* how many have a value */

#endif
