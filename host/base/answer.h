/* What a command answers, described once: each fact's name, unit, value and error. Text for people,
 * JSON for programs and HTML for pages are printed from that one description.
 *
 * A fact has a name, under which programs find it, and a label, under which people do. Without a
 * name it is not in the JSON, without a label it is in the JSON alone. In the JSON a unit ends the
 * name ("rms_in", "peak_error_in"), and what is not finite is null. Values are given in the
 * report's units; an answer in SI converts them.
 *
 * For people, facts in a row that share a label show it once, in text.
 *
 * Functions return the fact that they added, to be refined before the next call. Names, labels and
 * words are copied. */
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

struct answer_fact {
    int digits;      /* significant, in the JSON: 6 unless set */
    bool interval;   /* people see the 95 % interval, too */
    bool bounded;    /* a ratio: people see ">999" where it is above 999 */
    bool plus;       /* people see the sign of what is positive, too */
    bool warn;       /* pages show it in the colour of warnings */
    bool run;        /* a RUN: pages lead to its section */
    const char *end; /* follows the value for people; static. NULL: nothing */
};

struct answer *answer_new(bool si);
/* In the JSON values stay in what they are given in, whatever people read. Before the first
 * value. */
void answer_as_given(struct answer *answer);
void answer_free(struct answer *answer);
/* For words that have units in them. */
bool answer_in_si(const struct answer *answer);

/* A number with `decimals` in the unit for people; in SI as many more or less as keep every digit.
 * Below 0: with -`decimals` significant digits. */
struct answer_fact *answer_value(struct answer *answer, const char *name, const char *label,
                                 enum unit_kind unit, double value, int decimals);
/* The same with its standard error; the JSON has NAME and NAME_error. */
struct answer_fact *answer_estimate(struct answer *answer, const char *name, const char *label,
                                    enum unit_kind unit, double value, double error, int decimals);
/* ANSWER_UNKNOWN is null, and a dash for people. */
#define ANSWER_UNKNOWN INT64_MIN
struct answer_fact *answer_count(struct answer *answer, const char *name, const char *label,
                                 int64_t count);
void answer_flag(struct answer *answer, const char *name, const char *label, bool yes);
struct answer_fact *answer_words(struct answer *answer, const char *name, const char *label,
                                 const char *format, ...) __attribute__((format(printf, 4, 5)));
/* A sentence for people is a paragraph of its own, in lines that fit. */
void answer_sentence(struct answer *answer, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
/* For people: follows the last fact's value. */
void answer_remark(struct answer *answer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
/* null; people read why. */
void answer_none(struct answer *answer, const char *name, const char *label, const char *why);
/* The text; of nothing (NULL, "") as answer_none. */
void answer_words_or_none(struct answer *answer, const char *name, const char *label,
                          const char *text, const char *why);
/* Of the JSON alone: any value. Takes `json`. */
void answer_json_value(struct answer *answer, const char *name, json_t *json);

/* Facts that belong together, until answer_close: an object of the JSON; for people a heading with
 * its facts below, or with the label "" its facts alone. People do not see a group, a list or a
 * table without anything in it. */
void answer_open(struct answer *answer, const char *name, const char *label);
/* An array of values without names. */
void answer_list(struct answer *answer, const char *name, const char *label);
/* An array of objects, which people see as a table: each begins with answer_row, and labels of
 * their facts, also of those in groups, head its columns: each label once in a row. People do not
 * see a row without labels. A label that only some rows have stands after the one before it there.
 * `|` begins a new line of the head. What is too wide goes on below, the first column again. */
void answer_table(struct answer *answer, const char *name, const char *label);
/* A row of the table, or an object of the list, that is open: until the next one, or answer_close
 * of the table. */
void answer_row(struct answer *answer);
void answer_close(struct answer *answer);

/* False: `out` cannot be written. */
bool answer_text(const struct answer *answer, FILE *out);
void answer_html(const struct answer *answer, FILE *out);
/* The caller's. */
json_t *answer_json(const struct answer *answer);
/* The same; frees the answer. */
json_t *answer_into_json(struct answer *answer);
/* Text or, with --json, JSON to standard output; frees the answer. Returns `code`, or the exit code
 * of a failed output. */
int answer_show(const struct cli *cli, struct answer *answer, int code);
/* The same; if `error` is set, it is reported instead and its exit code returned. */
int answer_end(const struct cli *cli, struct answer *answer, int code, const struct error *error);

/* Text in lines that fit a terminal. */

/* The words of `text`, a blank between two, and a newline at the end. `column` characters stand in
 * the first line already; the others begin after `indent` blanks, and so does the first one when
 * `column` is 0. A word that is longer than a line has one of its own. Counts characters of
 * UTF-8. */
void wrap_print(const char *text, size_t column, size_t indent, size_t width, FILE *out);
/* Characters, not bytes. */
size_t wrap_width(const char *text, size_t bytes);

#endif
