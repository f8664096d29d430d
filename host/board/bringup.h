/* Bring-up of a new board: what its image reports, and whether that is within limits. */
#ifndef MATRIG_HOST_BOARD_BRINGUP_H
#define MATRIG_HOST_BOARD_BRINGUP_H

#include <stdbool.h>
#include <stddef.h>

#include "common/image.h"
#include "host/link/link.h"

/* Output of the bring-up image (firmware/bringup/say.h): read from a link or from a text file, and
 * checked to be complete. */
#define BRINGUP_BAUD     115200
#define BRINGUP_LINES    400
#define BRINGUP_NAME     48
#define BRINGUP_VALUE    40
#define BRINGUP_SECTIONS "report", "brown-out"

struct bringup_line {
    char name[BRINGUP_NAME], value[BRINGUP_VALUE], unit[BRINGUP_NAME];
    double number; /* NaN: the value is a word, or none */
    bool none;     /* it is not there, or did not answer */
};

struct bringup {
    char section[BRINGUP_NAME];
    char *text; /* from `begin` to the end of the line `end`, as received; freed by bringup_free */
    size_t length;
    size_t lines;
    struct bringup_line line[BRINGUP_LINES];
};

/* Text that begins with `begin`. MR_OK; MR_TRUNCATED: its end is missing, or lines of it; MR_CRC;
 * MR_VERSION: an unknown format; MR_MALFORMED: `error` names the line. */
enum mr_status bringup_parse(struct bringup *bringup, const char *text, size_t length,
                             struct error *error);
/* Asks for a section and reads it; of a recorded link reads the first one there. MR_TIMEOUT: no
 * such answer; else as bringup_parse and the link. */
enum mr_status bringup_ask(struct bringup *bringup, struct link *link, const char *section,
                           struct error *error);
/* Starts the boot ROM. Errors likewise. */
enum mr_status bringup_rom(struct link *link, struct error *error);
void bringup_free(struct bringup *bringup);

/* NULL: there is none of that name. */
const struct bringup_line *bringup_find(const struct bringup *bringup, const char *name);

/* A board's bring-up report, checked against limits (bringup_limits.def). */
enum bringup_verdict { BRINGUP_OK, BRINGUP_LOOK, BRINGUP_WRONG };

struct bringup_limit {
    unsigned sections; /* bits */
    const char *name;  /* with * at its end: all that begin so */
    const char *words; /* one of these; "": any; NULL: a number from least to most */
    double least, most;
    /* the number that this board has instead; NULL: of all boards alike */
    double (*of_board)(const struct mr_board *board);
    enum bringup_verdict beyond, none;
    const char *source, *advice;
};

struct bringup_judged {
    const char *name;
    const struct bringup_line *line;   /* NULL: not reported */
    const struct bringup_limit *limit; /* NULL: the name is not known here */
    double least, most; /* of the limit for this board; NaN: the board is not known */
    enum bringup_verdict verdict;
};

#define BRINGUP_JUDGED (2 * BRINGUP_LINES)

/* Lines in their order, then those that are missing. Returns how many; they refer to `now`. */
size_t bringup_judge(const struct bringup *now, struct bringup_judged judged[BRINGUP_JUDGED]);
enum bringup_verdict bringup_worst(const struct bringup_judged *judged, size_t count);
const char *bringup_verdict_text(enum bringup_verdict verdict); /* "ok", "look", "wrong" */
bool bringup_limit_is_group(const struct bringup_limit *limit);

#endif
