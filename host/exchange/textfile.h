/* A whole file as read-only text, with its SHA-256. */
#ifndef MATRIG_HOST_EXCHANGE_TEXTFILE_H
#define MATRIG_HOST_EXCHANGE_TEXTFILE_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

struct textfile {
    const char *text; /* no final zero */
    size_t length;
    char sha256[65];
    bool mapped;
};

/* MR_IO: cannot be read. Release with textfile_close, also after an error. */
enum mr_status textfile_open(const char *path, struct textfile *file, struct error *error);
void textfile_close(struct textfile *file);

/* What became of a file that was read: what is good of it is kept, whatever the verdict. */
struct verdict {
    enum mr_status status; /* MR_OK complete, MR_TRUNCATED, MR_MALFORMED */
    size_t line, column;   /* from 1: of the first thing wrong */
    size_t bad_lines;      /* passed over */
    const char *what;      /* is wrong there; static storage */
};
/* The first one holds. */
void verdict_set(struct verdict *verdict, enum mr_status status, size_t line, size_t column,
                 const char *what);
/* "complete", "truncated at line 7, column 12: ...", "malformed at line ...; 3 lines were passed
 * over". */
void verdict_text(const struct verdict *verdict, char *out, size_t size);

#endif
