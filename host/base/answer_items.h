/* An answer's facts in their order: what answer.c gathers and the printers walk through. */
#ifndef MATRIG_HOST_BASE_ANSWER_ITEMS_H
#define MATRIG_HOST_BASE_ANSWER_ITEMS_H

#include "host/base/answer.h"

enum answer_kind {
    ANSWER_VALUE,
    ANSWER_ESTIMATE,
    ANSWER_COUNT,
    ANSWER_FLAG,
    ANSWER_WORDS,
    ANSWER_SENTENCE,
    ANSWER_NONE,
    ANSWER_JSON,
    ANSWER_OPEN,
    ANSWER_LIST,
    ANSWER_TABLE,
    ANSWER_CLOSE
};

struct answer_item {
    struct answer_fact fact; /* the first: its address is the item's */
    enum answer_kind kind;
    char *name, *label; /* owned; NULL: not for programs, not for people */
    const struct unit *unit;
    double value, error; /* as shown: converted */
    const struct unit *json_unit;
    double json_value, json_error;
    int decimals;
    int64_t count;
    char *words;
    char *remark; /* NULL: none */
    json_t *json;
};

struct answer {
    struct answer_item *item;
    size_t count;
    bool si, as_given, failed; /* failed: memory ended */
    unsigned depth;            /* of groups that are open */
    uint64_t rows;             /* bit d: the group at depth d has a row open, at depth d + 1 */
};

static inline bool answer_is_group(enum answer_kind kind)
{
    return kind == ANSWER_OPEN || kind == ANSWER_LIST || kind == ANSWER_TABLE;
}

/* The index after item `i` and all that is in it. */
size_t answer_after(const struct answer *answer, size_t i);

/* A group without facts: people see neither its heading nor its columns. */
static inline bool answer_is_empty(const struct answer *answer, size_t i)
{
    return answer_is_group(answer->item[i].kind) && answer_after(answer, i) <= i + 2;
}

#define ANSWER_CELL    1200 /* as long as words can be */
#define ANSWER_COLUMNS 80   /* of a table, for people: more than a campaign has stations */
/* The fact as people read it, without its unit. `plus_minus`: between value and error. */
void answer_cell(const struct answer_item *item, const char *plus_minus,
                 char text[static ANSWER_CELL]);
/* The same with its unit, its interval and its end. */
void answer_line(const struct answer_item *item, const char *plus_minus,
                 char text[static ANSWER_CELL]);

/* The columns of the table at `table`: a fact's index for each label, of one that has a unit if any
 * has. At most `most`; how many. */
size_t answer_columns(const struct answer *answer, size_t table, size_t *column, size_t most);
/* The fact of the row at `row` with this label, or with any (NULL); NULL: the row has none. */
const struct answer_item *answer_in_row(const struct answer *answer, size_t row, const char *label);

#endif
