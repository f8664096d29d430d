/* Comparisons for people, within 100 columns, and as JSON. A dash, null: not known. */
#ifndef MATRIG_HOST_COMPARE_SHOW_H
#define MATRIG_HOST_COMPARE_SHOW_H

#include <jansson.h>
#include <stdio.h>

#include "host/compare/series.h"

void compare_show(FILE *out, const struct compare_figures *figures, bool si);
void compare_show_series(FILE *out, const struct compare_series *set, bool si);
/* One line; nothing where nothing was checked. */
void compare_show_verdict(FILE *out, const struct compare_verdict *verdict);
json_t *compare_json(const struct compare_figures *figures, const struct compare_verdict *verdict, bool si);
json_t *compare_series_json(const struct compare_series *set, bool si);

#endif
