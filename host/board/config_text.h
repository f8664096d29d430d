/* Conversion of a board's configuration to text and back. */
#ifndef MATRIG_HOST_BOARD_CONFIG_TEXT_H
#define MATRIG_HOST_BOARD_CONFIG_TEXT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/config.h"
#include "host/base/error.h"

/* length of "channel[3].unit_per_code" and its terminating zero */
#define CONFIG_FIELD_NAME_SIZE  80u
#define CONFIG_FIELD_VALUE_SIZE 200u /* length of a value as text and its terminating zero */

struct config_field_ref {
    unsigned group, index, field; /* positions in the field table, from 0 */
};

#define CONFIG_DATE_SIZE 11 /* length of "2026-03-14" and its terminating zero */
/* Reads the date at the start of `text`, after 1970-01-01; returns false if there is none. */
bool config_date_parse(const char *text, uint32_t *days);
void config_date_text(uint32_t days, char out[CONFIG_DATE_SIZE]);

/* The configuration as text for people: one `group[index].field = value` per line; `#` begins a
 * comment.
 *
 *     site.name = "rig"
 *     channel[1].unit_per_code = 0.00161132799   # in or lb per code
 *     channel[1].calibrated_day = 2026-03-14
 *
 * Members are counted from 1: channel[1] to [8] are the inputs of the transducers, [9] to [22]
 * those of the gages, [23] is the staircase, [24] the reference; gate[1] is the first switch. Reals
 * are decimal numbers or `missing`; several reals are separated by blanks. Texts are in double
 * quotes, with \" and \\ as escapes. Days are YYYY-MM-DD or `never`. Each field must occur exactly
 * once, in any order. Reading a written text gives exactly the same configuration. */
/* Writes the configuration as text, which the caller frees. */
char *config_text_write(const struct mr_config *config);
/* Reads a text and checks it (mr_config_check). `name` is the file's name for the error message,
 * which states the line, the fault and the correct form: MR_MALFORMED, MR_UNKNOWN, MR_LIMIT. */
enum mr_status config_text_read(const char *text, const char *name, struct mr_config *config,
                                struct error *error);
/* As config_text_read, from a file. MR_IO: the file cannot be read. */
enum mr_status config_text_load(const char *path, struct mr_config *config, struct error *error);

/* Returns a bit mask, by channel index, of the fitted sensors without a calibration date. */
uint32_t config_text_undated_channels(const struct mr_config *config);

/* Writes the reason why a configuration is refused: "channel[3].number is 2, which channel[1] has;
 * ...". */
void config_text_reason(const struct mr_config *config, const struct mr_config_violation *reason,
                        char *out, size_t size);

/* Calls `each` for every field that differs between `old` and `new`, with its name and both values
 * as text. Returns the number of differences. */
unsigned config_text_compare(const struct mr_config *old, const struct mr_config *new,
                             void (*each)(void *context, const char *field, const char *old,
                                          const char *new),
                             void *context);

#endif
