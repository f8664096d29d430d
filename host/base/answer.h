/* The output of a command as a list of facts, each with name, unit, value and error. Printed text,
 * JSON and HTML pages are all generated from this list.
 *
 * A fact has a name, which is its JSON key, and a label, which people see. A fact without a name is
 * not in the JSON; a fact without a label is only in the JSON. In the JSON the name ends with the
 * unit ("rms_in", "peak_error_in"), and a value that is not finite is null. Callers pass values in
 * the report's units; an answer in SI units converts them.
 *
 * If consecutive facts have the same label, text shows it once.
 *
 * Functions return the style of the added fact; its fields may be set until the next call. Names,
 * labels and texts are copied. */
#ifndef MATRIG_HOST_BASE_ANSWER_H
#define MATRIG_HOST_BASE_ANSWER_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/base/cli.h"
#include "host/base/units.h"

struct answer;

struct answer_style {
    int digits;          /* significant digits in the JSON; default: 6 */
    bool shows_interval; /* text also shows the 95 % interval */
    bool is_capped;      /* a ratio: text shows ">999" for a value above 999 */
    bool shows_sign;     /* text also shows the sign of a positive value */
    bool is_warning;     /* pages show the fact in the warning colour */
    bool is_number;      /* the text shows a number, so tables align it right */
    bool is_run_number;  /* a RUN number: HTML pages link it to the section of that landing */
    const char *suffix;  /* text after the value, for people; static. NULL: none */
};

struct answer *answer_new(bool si);
/* Keeps each JSON value in the unit in which it is passed, even if the answer is in SI. Call before
 * the first value. */
void answer_keep_units(struct answer *answer);
void answer_free(struct answer *answer);
/* True if the answer is in SI units. Callers need it for texts that contain units. */
bool answer_is_si(const struct answer *answer);

/* Adds a number. Text shows it with `decimals` decimals in the report's unit; in SI the number of
 * decimals is adapted so that no digit is lost. If `decimals` is negative, text shows -`decimals`
 * significant digits. */
struct answer_style *answer_add_value(struct answer *answer, const char *name, const char *label,
                                      enum unit_kind unit, double value, int decimals);
/* Adds a value with its standard error; the JSON has NAME and NAME_error. */
struct answer_style *answer_add_estimate(struct answer *answer, const char *name, const char *label,
                                         enum unit_kind unit, double value, double error,
                                         int decimals);
/* A count that is not known: null in the JSON, a dash in text. */
#define ANSWER_COUNT_UNKNOWN INT64_MIN
struct answer_style *answer_add_count(struct answer *answer, const char *name, const char *label,
                                      int64_t count);
void answer_add_flag(struct answer *answer, const char *name, const char *label, bool yes);
struct answer_style *answer_add_text(struct answer *answer, const char *name, const char *label,
                                     const char *format, ...) __attribute__((format(printf, 4, 5)));
/* Adds a sentence. In text it is a separate paragraph, wrapped to the line width. */
void answer_add_sentence(struct answer *answer, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* Appends text after the value of the last fact, for people only. */
void answer_append_remark(struct answer *answer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* Adds a missing value: null in the JSON; text shows the reason. */
void answer_add_missing_value(struct answer *answer, const char *name, const char *label,
                              const char *why);
/* Adds the text, or a missing value (answer_add_missing_value) if the text is NULL or "". */
void answer_add_text_or_missing(struct answer *answer, const char *name, const char *label,
                                const char *text, const char *why);
/* Adds any JSON value; text does not show it. Takes ownership of `json`. */
void answer_add_json(struct answer *answer, const char *name, json_t *json);

/* Opens a group of facts, until answer_close_group: an object in the JSON. Text shows a heading
 * with the facts below it; if the label is "", it shows only the facts. Text omits an empty group,
 * list or table. */
void answer_open_group(struct answer *answer, const char *name, const char *label);
/* Opens an array of values without names. */
void answer_open_list(struct answer *answer, const char *name, const char *label);
/* Opens an array of objects, which text shows as a table. Each object begins with answer_open_row.
 * The labels of its facts, including those in groups, head the columns; a label must be unique
 * within a row. Text omits a row without labels. A label that occurs only in some rows is placed
 * after the label that precedes it there. `|` starts a new line of the column head. A table that is
 * too wide continues below, with the first column repeated. */
void answer_open_table(struct answer *answer, const char *name, const char *label);
/* Starts a row of the open table, or an object of the open list. The row ends at the next
 * answer_open_row or at answer_close_group. */
void answer_open_row(struct answer *answer);
void answer_close_group(struct answer *answer);

/* Prints the answer as text. Returns false if `out` cannot be written. */
bool answer_print_text(const struct answer *answer, FILE *out);
void answer_print_html(const struct answer *answer, FILE *out);
/* Returns JSON that the caller owns. */
json_t *answer_make_json(const struct answer *answer);
/* Same as answer_make_json, but also frees the answer. */
json_t *answer_make_json_and_free(struct answer *answer);
/* Prints the answer to standard output, as text or with --json as JSON, and frees it. Returns
 * `code`, or the exit code of a failed output. */
int answer_print(const struct cli *cli, struct answer *answer, int code);
/* Same as answer_print if `error` is not set. Otherwise frees the answer, reports the error and
 * returns its exit code. */
int answer_print_or_fail(const struct cli *cli, struct answer *answer, int code,
                         const struct error *error);

/* Prints the words of `text`, separated by one blank, and a newline at the end. `column` is the
 * number of characters already in the first line. All other lines begin with `indent` blanks; so
 * does the first line if `column` is 0. A word that is longer than a line gets a separate line.
 * Counts UTF-8 characters. */
void text_print_wrapped(const char *text, size_t column, size_t indent, size_t width, FILE *out);
/* Number of UTF-8 characters in the first `bytes` bytes of `text`. */
size_t text_count_characters(const char *text, size_t bytes);

#endif
