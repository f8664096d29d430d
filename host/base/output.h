/* A file that a command writes: `-o F`, or standard output.
 *
 * A page, a table or a picture, which matrig can make again, takes the place of the file that is
 * there. What people fill in (a sheet, a configuration, a scene), and what cannot be made again,
 * replaces a file only with --force: output_keep. A database is never overwritten, nor what the
 * command reads. The file appears whole or not at all: it is made beside its place and renamed, so
 * that a command that fails leaves the old one. A pipe, a terminal or a device is simply
 * written to. */
#ifndef MATRIG_HOST_BASE_OUTPUT_H
#define MATRIG_HOST_BASE_OUTPUT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host/base/error.h"

struct output {
    FILE *file;       /* takes what is written; in memory until output_end */
    const char *path; /* NULL: standard output */
    bool executable;
    char *text;
    size_t length;
};

/* `path` NULL: standard output. Fails where the file may not be written, as output_check. */
enum mr_status output_begin(struct output *output, const char *path, struct error *error);
/* Puts in place what was written, unless `error` holds one already: then the old file stays. MR_IO
 * when anything did not arrive. Returns the error's status. */
enum mr_status output_end(struct output *output, struct error *error);
/* Both, of `length` bytes. */
enum mr_status output_bytes(const char *path, const void *bytes, size_t length,
                            struct error *error);

/* And of a JSON value, indented; `digits` of its numbers. */
enum mr_status output_json(const char *path, const json_t *json, unsigned digits,
                           struct error *error);

/* Before work that takes long: whether output_begin would refuse `path` (NULL: nothing is written),
 * whether it can be written, and that it is none of what is read (`input`; NULL: nothing), which
 * would be lost. Writes nothing. */
enum mr_status output_check(const char *path, const char *input, struct error *error);
/* MR_USAGE when a file with content is at `path` (NULL: none) and --force was not given: for what
 * people fill in. */
enum mr_status output_keep(const char *path, bool force, struct error *error);
/* MR_USAGE when `path` is the file `input` that the command reads, by whatever name; either may be
 * NULL. */
enum mr_status output_not_input(const char *path, const char *input, struct error *error);

bool output_is_database(const char *path);
/* MR_MALFORMED: what is to be read as `wanted` ("survey sheet") is a file of another kind, by its
 * first bytes: "a spreadsheet, no survey sheet: F; save it as CSV". */
enum mr_status output_other_kind(const char *path, const char *wanted, struct error *error);
/* How many bytes at the beginning of a text are the mark of UTF-8, which spreadsheets write: 0
 * or 3. */
size_t output_mark(const char *text, size_t length);

#endif
