/* One field of one member of the configuration: its name, its bytes, its value and its limits as
 * text. Days are written as dates. */
#ifndef MATRIG_HOST_CONFIGPLACE_H
#define MATRIG_HOST_CONFIGPLACE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/config.h"

#define CONFIGPLACE_NAME  80u  /* "channel[3].unit_per_code" and its end */
#define CONFIGPLACE_VALUE 200u /* a value as text and its end */

struct configplace {
    unsigned group, index, field; /* from 0 */
};

const struct mr_config_field *configplace_field(struct configplace at);
/* The field's bytes in `config`, which may be written to when the caller's is not const. */
void *configplace_bytes(const struct mr_config *config, struct configplace at);
/* The next one in the order of the table; false: that was the last. Begin with {0}. */
bool configplace_next(struct configplace *at);
void configplace_name(struct configplace at, char out[CONFIGPLACE_NAME]);

/* The field is a day. */
bool configplace_is_day(const struct mr_config_field *field);
/* Days from 1970-01-01 to a date of the Gregorian calendar, and back. */
int64_t configplace_day(int64_t year, unsigned month, unsigned day);
void configplace_date(uint32_t days, unsigned *year, unsigned *month, unsigned *day);
#define CONFIGPLACE_DATE 11 /* "2026-03-14" and its end */
/* The date that `text` begins with, after 1970-01-01; false: none. What follows is not looked
 * at. */
bool configplace_date_read(const char *text, uint32_t *days);
void configplace_date_text(uint32_t days, char out[CONFIGPLACE_DATE]);

void configplace_value(const struct mr_config_field *field, const void *bytes,
                       char out[CONFIGPLACE_VALUE]);
/* "from 1 to 512". */
void configplace_limits(const struct mr_config_field *field, char *out, size_t size);

#endif
