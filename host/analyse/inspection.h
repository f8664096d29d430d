/* Records of the crew's settings, inspections and notes: run conditions, acceptance, damage,
 * launch, pictures. host/store/records.def lists the kinds and their fields. The row of a record
 * never changes: a correction or a withdrawal is a new row.
 *
 * A value is a text, or a number in the unit with which the field's name ends. A number may have a
 * standard error ("12.3+-0.4"). In the JSON object of a record, NAME_error is the standard error,
 * NAME_sha256 the digest of a picture, and NAME_marks the marks of a height. */
#ifndef MATRIG_HOST_ANALYSE_INSPECTION_H
#define MATRIG_HOST_ANALYSE_INSPECTION_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "host/base/answer.h"
#include "host/base/statistics.h"
#include "host/store/store_journal.h"

enum inspection_subject {
    INSPECTION_CAMPAIGN,
    INSPECTION_LANDING,
    INSPECTION_MAT,
    INSPECTION_JOINT,
    INSPECTION_STATION
};
enum inspection_type {
    INSPECTION_NUMBER,
    INSPECTION_CHOICE,
    INSPECTION_WORDS,
    INSPECTION_PICTURE,
    /* fields from which the field before them is computed or checked; not asked for and not in
     * tables */
    INSPECTION_DIGEST,
    INSPECTION_MARKS
};

struct inspection_field {
    const char *name, *description; /* name and description: "tire_psi", "tire pressure" */
    enum inspection_type type;
    bool is_copied_from_last;
    bool is_integer;            /* a whole number without error */
    double low, high;           /* range of a number, in its unit */
    double pass_low, pass_high; /* limits that a value should be within; NaN: no limit */
    const char *limit;          /* source of the limits; NULL: none */
    const char *choices;        /* allowed values of a choice: "coast|truck" */
    /* choice field that must be given, and not be "open", for this field to have a meaning */
    const char *required_choice;
};
struct inspection_kind {
    const char *name, *description, *source;
    enum inspection_subject place;
    const struct inspection_field *field; /* list of fields; the last entry has no name */
};
/* All kinds; the last entry has no name. */
extern const struct inspection_kind inspection_kinds[];
#define INSPECTION_FIELDS_MAX \
    25 /* largest number of fields of a kind; tests/cli/records.sh checks it */

/* MR_UNKNOWN: there is no such kind; the error names the nearest one. */
enum mr_status inspection_kind_find(const char *name, const struct inspection_kind **kind,
                                    struct error *error);
/* Returns what the records belong to: "run", "mat", "joint" or "station_ft"; "": the campaign. */
const struct inspection_field *inspection_subject(const struct inspection_kind *kind);
/* Returns true for a kind with at most one record per landing. */
bool inspection_is_single(const struct inspection_kind *kind);
/* Unit of a number for display: "psi", "%"; "": none. In SI: "Pa". */
const char *inspection_get_unit(const struct inspection_field *field, bool si);

struct inspection {
    struct store_record row;
    const struct inspection_kind *kind;
    json_t *values; /* values of the record; NULL: the row withdraws another one */
    /* The record that this one corrects or withdraws, and the one that corrects or withdraws this
     * one; NULL: none. */
    const struct inspection *corrected, *replaced_by;
    int64_t origin; /* id of the original record in a chain of corrections */
};
struct inspections {
    struct inspection *entry; /* records in ascending order of id */
    size_t count, room;       /* number of entries in use and allocated */
    int64_t next_id;
    char *folder; /* of the campaign, with a slash at its end */
};
/* Loads all records, except those of kinds that this version of matrig does not know. Call
 * inspection_free in every case. */
enum mr_status inspection_load(struct store *store, struct inspections *all, struct error *error);
void inspection_free(struct inspections *all);
/* Returns true for a valid record of this kind (NULL: any) and landing (0: any). */
bool inspection_is_valid(const struct inspection *entry, const struct inspection_kind *kind,
                         int64_t run);
/* Returns true if there is a valid record of this kind (NULL: any) and landing (0: any). */
bool inspection_has_valid_record(const struct inspections *all, const struct inspection_kind *kind,
                                 int64_t run);
/* Returns the newest valid record of this kind, of the landing or the nearest one before it (run 0:
 * of any landing); NULL: none. A correction has the age of the record that it corrects. */
const struct inspection *inspection_find_newest(const struct inspections *all,
                                                const struct inspection_kind *kind, int64_t run);

/* Reads a number, "12.3+-0.4 lb/in", within the range of the field. */
enum mr_status inspection_parse_number(const struct inspection_field *field, const char *text,
                                       struct estimate *number, struct error *error);
/* Reads FIELD=VALUE into `values`; "FIELD=" sets null. The path of a picture becomes absolute;
 * inspection_add makes it relative to the folder of the campaign. Marks, also as the value of the
 * height that they give, are "DISTANCE: X,Y X,Y X,Y [ERROR]": those of rig_measure_height in pixels
 * (default ERROR: 1). A digest must be that of the picture that was read before. Fails with
 * MR_UNKNOWN, MR_USAGE (also if the field was read before), or MR_IO if a picture cannot be
 * read. */
enum mr_status inspection_parse_field(const struct inspection_kind *kind, const char *word,
                                      json_t *values, struct error *error);
/* Adds a field of `from` with its error, if `values` has neither value nor null. False: it has, or
 * `from` has no value. */
bool inspection_copy_value(const struct inspection_field *field, const json_t *from,
                           json_t *values);
/* Returns the format of a picture as in its MIME type ("png"), from its first bytes; NULL: not a
 * picture. */
const char *inspection_picture_format(const char *path);
/* Returns the path of an unchanged picture, which the caller frees. NULL: the picture is missing or
 * has changed. */
char *inspection_find_picture(const struct inspections *all, const struct inspection *entry,
                              struct error *error);
/* Writes a row with these values, except nulls (`values` NULL: a withdrawal), and adds it to `all`,
 * whose entries may move. Refuses a record that breaks a rule of records.def or repeats the newest
 * one of its subject. The caller begins and ends the transaction. */
enum mr_status inspection_add(struct store *store, struct inspections *all,
                              const struct store_record *row, json_t *values, struct error *error);
/* Returns the number of a field (NaN: none) and its standard error (0: none). */
struct estimate inspection_get_number(const json_t *values, const char *name);
/* Writes a value in the form in which it is typed, "12.3+-0.4"; "": none. */
#define INSPECTION_TEXT_SIZE 300
void inspection_format_value(const struct inspection_field *field, const json_t *values,
                             char out[INSPECTION_TEXT_SIZE]);

enum inspection_verdict {
    INSPECTION_NO_LIMIT,
    INSPECTION_PASS,
    INSPECTION_MARGINAL, /* a limit is within the standard error of the value */
    INSPECTION_FAIL
};
/* Returns the worst verdict of the fields. */
enum inspection_verdict inspection_check_limits(const struct inspection *entry);
const char *inspection_verdict_text(enum inspection_verdict verdict);

/* Adds a table of the records of a kind from index `from` on, with counts and the limits that they
 * do not pass. The worst records are first, withdrawn ones last. `run` 0: all landings. */
void inspection_add_table(const struct inspections *all, const struct inspection_kind *kind,
                          int64_t run, size_t from, struct answer *answer);
/* Adds all records with their history to the JSON. `kind` NULL: all kinds. */
void inspection_add_json(const struct inspections *all, const struct inspection_kind *kind,
                         int64_t run, struct answer *answer);
/* Adds a row for each value or record that differs between two landings. `single_only`: only kinds
 * with one record per landing. Returns the number of rows. */
size_t inspection_add_differences(struct store *store, const struct inspections *all,
                                  bool single_only, int64_t from, int64_t to, struct answer *answer,
                                  struct error *error);

#endif
