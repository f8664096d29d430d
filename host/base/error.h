/* An error for the person at the terminal: a status and one line `WHAT: WHERE; what to do`.
 *
 * A function whose failure must be shown to a person has a `struct error *` parameter and returns
 * the status. The first error is kept: setting an error later changes nothing, so cleaning up after
 * a failure cannot hide its cause. */
#ifndef MATRIG_HOST_BASE_ERROR_H
#define MATRIG_HOST_BASE_ERROR_H

#include "common/status.h"

struct error {
    enum mr_status status; /* MR_OK: no error */
    char text[600];        /* without newline */
    /* NULL, or a function that ends the program with this error: then error_set does not return. */
    void (*end_program)(const struct error *error);
};

/* Formats the line and returns `status`. Control characters from external input are replaced by
 * '?'. */
enum mr_status error_set(struct error *error, enum mr_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Writes the status as a word for programs: "usage", "unknown", "not-now", "io", ... */
#define ERROR_KIND_SIZE 24
void error_kind_text(enum mr_status status, char out[static ERROR_KIND_SIZE]);

#endif
