/* The configuration as text. */
#ifndef MATRIG_HOST_BOARD_CONFIG_TEXT_H
#define MATRIG_HOST_BOARD_CONFIG_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/config.h"
#include "host/base/error.h"

/* One field of one member of the configuration: its name, its bytes, its value and its limits as
 * text. Days are written as dates. */
#define CONFIGPLACE_NAME  80u  /* "channel[3].unit_per_code" and its end */
#define CONFIGPLACE_VALUE 200u /* a value as text and its end */

struct configplace {
    unsigned group, index, field; /* from 0 */
};

#define CONFIGPLACE_DATE 11 /* "2026-03-14" and its end */
/* The date that `text` begins with, after 1970-01-01; false: none. */
bool configplace_date_read(const char *text, uint32_t *days);
void configplace_date_text(uint32_t days, char out[CONFIGPLACE_DATE]);

/* The configuration as text for people: one `group[index].field = value` per line, `#` begins a
 * comment.
 *
 *     site.name = "rig"
 *     channel[1].unit_per_code = 0.00161132799    # in or lb per code
 *     channel[1].calibrated_day = 2026-03-14
 *
 * Members count from 1: channel[1] to [8] are the transducers' inputs, [9] to [22] the gages', [23]
 * the staircase, [24] the reference; gate[1] is the first switch. Reals are decimal numbers or
 * `missing`; several are separated by blanks; texts stand in double quotes, with \" and \\ in them;
 * days are YYYY-MM-DD or `never`. Each field stands there exactly once, in any order. What
 * is written reads back bit for bit. */
/* The text; the caller frees it. */
char *config_text_write(const struct mr_config *config);
/* Reads a text and checks it (mr_config_check). `name` is the file's, for the error, which names
 * the line, what is wrong there and what would be right: MR_MALFORMED, MR_UNKNOWN, MR_LIMIT. */
enum mr_status config_text_read(const char *text, const char *name, struct mr_config *config,
                                struct error *error);
/* The same of a file. MR_IO: cannot be read. */
enum mr_status config_text_load(const char *path, struct mr_config *config, struct error *error);

/* Sensors that are fitted and have no date of calibration: bit of index. */
uint32_t config_text_undated(const struct mr_config *config);

/* Why a configuration is refused: "channel[3].number is 2, which channel[1] has; ...". */
void config_text_reason(const struct mr_config *config, const struct mr_config_reason *reason,
                        char *out, size_t size);

/* Calls `each` for every field in which they differ, with its name and both values as the text
 * writes them. Returns how many. */
unsigned config_text_compare(const struct mr_config *old, const struct mr_config *new,
                             void (*each)(void *context, const char *field, const char *old,
                                          const char *new),
                             void *context);

#endif
