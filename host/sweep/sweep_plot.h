/* The pictures of a sweep. */
#ifndef MATRIG_HOST_SWEEP_PLOT_H
#define MATRIG_HOST_SWEEP_PLOT_H

#include <stdio.h>

#include "host/sweep/sweep_table.h"

#define SWEEP_SERIES_MAX 6
#define SWEEP_PANELS_MAX 6

/* A quantity of the cases: a field of the result, or the threshold that was searched. */
struct sweep_quantity {
    const char *field; /* NULL: the threshold */
};

/* A key that is varied over a few values. */
struct sweep_levels {
    const char *key;
    const json_t **value; /* sorted; borrowed */
    size_t count;
    bool numeric;
    bool sampled; /* Latin hypercube */
};

/* All keys, the one with most values first, sampled ones last; the caller frees each `value` and
 * the array. */
struct sweep_levels *sweep_levels_of(const struct sweep_table *table, size_t *count);
void sweep_levels_free(struct sweep_levels *levels, size_t count);

/* A row's value of a quantity; NaN: none, or failed. `low` (may be NULL) is the lower end of a
 * threshold's bracket, or the value. */
double sweep_quantity_of(const struct table_row *row, const struct sweep_quantity *quantity,
                         double *low);
/* What it is called: the study's label, or its name. `text` has 200 bytes. */
void sweep_quantity_label(const struct sweep_table *table, const struct sweep_quantity *quantity,
                          char *text);
void sweep_key_label(const struct sweep_table *table, const char *key, char *text);

/* A varied value as text. */
void sweep_value_text(const json_t *value, char *text, size_t size);

/* Figures of one quantity: lines against the key with most values, one for each value of the next
 * key, a picture for each combination of the others; sampled keys: dots against each. Nothing to
 * draw: no figure. */
void sweep_plot(FILE *out, const struct sweep_table *table, const struct sweep_levels *levels,
                size_t level_count, const struct sweep_quantity *quantity);

#endif
