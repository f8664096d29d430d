/* What the bring-up image says (firmware/bringup/say.h): read from a link or from text that was
 * kept, and checked to be whole. */
#ifndef MATRIG_HOST_BOARD_BRINGUP_H
#define MATRIG_HOST_BOARD_BRINGUP_H

#include <stdbool.h>
#include <stddef.h>

#include "host/link/link.h"

#define BRINGUP_BAUD     115200
#define BRINGUP_LINES    400
#define BRINGUP_NAME     48
#define BRINGUP_VALUE    40
#define BRINGUP_SECTIONS "report", "memory", "brown-out"

struct bringup_line {
    char name[BRINGUP_NAME], value[BRINGUP_VALUE], unit[BRINGUP_NAME];
    double number; /* NaN: the value is a word, or none */
    bool none;     /* it is not there, or did not answer */
};

struct bringup {
    char section[BRINGUP_NAME];
    char *text; /* from `begin` to the end of the line `end`, as it came; bringup_free's */
    size_t length;
    size_t lines;
    struct bringup_line line[BRINGUP_LINES];
};

/* Text that begins with `begin`. MR_OK; MR_TRUNCATED: its end is missing, or lines of it; MR_CRC;
 * MR_VERSION: of a format that this matrig does not know; MR_MALFORMED: `error` says which line. */
enum mr_status bringup_parse(struct bringup *bringup, const char *text, size_t length,
                             struct error *error);
/* Asks for a section and reads it; of a recorded link reads the first one there. MR_TIMEOUT: nobody
 * answers so; else as bringup_parse and the link. */
enum mr_status bringup_ask(struct bringup *bringup, struct link *link, const char *section,
                           struct error *error);
/* Starts the boot ROM. Errors likewise. */
enum mr_status bringup_rom(struct link *link, struct error *error);
void bringup_free(struct bringup *bringup);

/* NULL: there is none of that name. */
const struct bringup_line *bringup_find(const struct bringup *bringup, const char *name);

#endif
