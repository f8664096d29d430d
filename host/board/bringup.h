/* Bring-up of a new board: reads the values that its bring-up image reports, and checks them
 * against limits. */
#ifndef MATRIG_HOST_BOARD_BRINGUP_H
#define MATRIG_HOST_BOARD_BRINGUP_H

#include <stdbool.h>
#include <stddef.h>

#include "common/image.h"
#include "host/link/link.h"

/* Output of the bring-up image (firmware/bringup/print.h): read from a link or from a text file,
 * and checked for completeness. */
#define BRINGUP_BAUD          115200
#define BRINGUP_LINES_MAX     400
#define BRINGUP_NAME_SIZE     48
#define BRINGUP_VALUE_SIZE    40
#define BRINGUP_SECTION_NAMES "report", "brown-out"

struct bringup_line {
    char name[BRINGUP_NAME_SIZE], value[BRINGUP_VALUE_SIZE], unit[BRINGUP_NAME_SIZE];
    double number;  /* NaN: the value is a word or missing */
    bool is_absent; /* the board reports that the part is not fitted or did not answer */
};

struct bringup {
    char section[BRINGUP_NAME_SIZE];
    /* received text from the line `begin` to the end of the line `end`; freed by bringup_free */
    char *text;
    size_t length;
    size_t line_count;
    struct bringup_line line[BRINGUP_LINES_MAX];
};

/* Parses text that starts with the line `begin`. MR_TRUNCATED: the end or some lines are missing.
 * MR_CRC: wrong checksum. MR_VERSION: unknown format. MR_MALFORMED: `error` names the line. */
enum mr_status bringup_parse(struct bringup *bringup, const char *text, size_t length,
                             struct error *error);
/* Requests a section from the board and reads it; from a recorded link, reads the first section of
 * that name. MR_TIMEOUT: no answer. Other statuses as bringup_parse and those of the link. */
enum mr_status bringup_request(struct bringup *bringup, struct link *link, const char *section,
                               struct error *error);
/* Makes the board start the boot ROM of its processor. Statuses as bringup_request. */
enum mr_status bringup_start_rom(struct link *link, struct error *error);
void bringup_free(struct bringup *bringup);

/* Finds a line by name; NULL if there is none. */
const struct bringup_line *bringup_find(const struct bringup *bringup, const char *name);

/* Result of checking one line against its limit: within it, suspect ("look"), or wrong. */
enum bringup_verdict { BRINGUP_OK, BRINGUP_SUSPECT, BRINGUP_WRONG };

struct bringup_limit {
    unsigned section_bits; /* bit mask of the sections to which the limit applies */
    /* name of a line; a * at the end matches all names with this beginning */
    const char *name;
    const char *words; /* allowed words; "": any word; NULL: a number from min to max */
    double min, max;
    /* Limit computed for this board; NULL: the limit is the same for all boards. */
    double (*board_value)(const struct mr_board *board);
    enum bringup_verdict verdict_if_outside, verdict_if_missing;
    const char *source, *advice;
};

struct bringup_result {
    const char *name;
    const struct bringup_line *line;   /* the reported line; NULL: the board did not report it */
    const struct bringup_limit *limit; /* NULL: there is no limit for this name */
    /* limits for this board; NaN: no limits, because the board type is not known */
    double min, max;
    enum bringup_verdict verdict;
};

#define BRINGUP_RESULTS_MAX (2 * BRINGUP_LINES_MAX)

/* Judges the lines in their order, then adds the missing ones. Returns the number of results, which
 * point into `bringup`. */
size_t bringup_check_limits(const struct bringup *bringup,
                            struct bringup_result results[BRINGUP_RESULTS_MAX]);
enum bringup_verdict bringup_worst_verdict(const struct bringup_result *results, size_t count);
const char *bringup_verdict_text(enum bringup_verdict verdict); /* "ok", "look", "wrong" */
bool bringup_limit_is_group(const struct bringup_limit *limit);

#endif
