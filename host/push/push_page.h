/* Push tests as one HTML page: what they say, and each test's curve with both laws. */
#ifndef MATRIG_HOST_PUSH_PUSH_PAGE_H
#define MATRIG_HOST_PUSH_PUSH_PAGE_H

#include <stdio.h>

#include "host/push/ground.h"

/* A parameter as the page shows it. */
struct push_page_row {
    const char *key, *unit, *from;
    struct push_interval of; /* low, high NaN: not known */
};

/* `lines`: of the board's configuration, ends with NULL. Memory that ends is said on the page. */
void push_page(FILE *out, const char *title, const struct push_readings *readings,
               const struct push_setting *setting, const struct push_ground *ground,
               const struct push_page_row *rows, size_t row_count, const char *const *lines);

#endif
