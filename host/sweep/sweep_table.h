/* The results of a sweep as a table for the report: one row a case, in the study's order where the
 * study is known. */
#ifndef MATRIG_HOST_SWEEP_TABLE_H
#define MATRIG_HOST_SWEEP_TABLE_H

#include "host/sweep/sweep_study.h"

struct table_row {
    json_t *line; /* owned: a line of the results file; values NULL in it: none */
    size_t index; /* in the study, or the line's place in the file */
};

struct sweep_table {
    struct sweep_study study; /* cases 0: not known */
    struct table_row *rows;
    size_t count, failed, missing, repeated;
    json_t *keys;   /* varied keys, an array of text */
    json_t *fields; /* of "result", likewise */
    bool finds;     /* cases are searches */
};

/* Reads a results file, and the copy of its study beside it when there is one. The caller frees. */
enum mr_status sweep_table_load(struct sweep_table *table, const char *path, struct error *error);
void sweep_table_free(struct sweep_table *table);

/* A varied value, or a field of the result; NULL: none. Borrowed. */
const json_t *sweep_table_value(const struct table_row *row, const char *key);
const json_t *sweep_table_field(const struct table_row *row, const char *field);
/* The text of "status". */
const char *sweep_table_status(const struct table_row *row);
/* A number for a plot: true is 1, false 0; NaN: no number. */
double sweep_table_number(const json_t *value);

#endif
