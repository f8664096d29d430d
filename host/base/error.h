/* What went wrong, for the person at the terminal: a status and one line `WHAT: WHERE; what to do`.
 *
 * Functions that can fail for reasons a person should read take a `struct error *` and return its
 * status. The first error is kept: setting another one later changes nothing, so cleaning up after
 * a failure cannot hide its cause. */
#ifndef MATRIG_HOST_BASE_ERROR_H
#define MATRIG_HOST_BASE_ERROR_H

#include "common/status.h"

struct error {
    enum mr_status status; /* MR_OK: none */
    char text[600];        /* without newline */
    /* NULL, or what ends the program with it: then who set it does not go on */
    void (*end)(const struct error *error);
};

/* Formats the line and returns `status`. Control characters from foreign input become '?'. */
enum mr_status error_set(struct error *error, enum mr_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The status in a word, for programs: "usage", "unknown", "not-now", "io", ... */
#define ERROR_KIND 24
void error_kind(enum mr_status status, char out[static ERROR_KIND]);

#endif
