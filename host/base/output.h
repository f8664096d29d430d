/* A file that a command writes: `-o F`, or standard output.  * A page, a table or a picture
 * replaces an existing file, because matrig can make it again. A file that people fill in (a sheet,
 * a configuration, a scene), or that cannot be made again, replaces an existing file only with
 * --force: output_check_new. A database and the input of the command are never overwritten. The new
 * file is written in the same folder and then renamed, so that a command that fails leaves the old
 * file unchanged. A pipe, a terminal or a device is written directly. */
#ifndef MATRIG_HOST_BASE_OUTPUT_H
#define MATRIG_HOST_BASE_OUTPUT_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host/base/error.h"

struct output {
    FILE *file;       /* stream for the content; kept in memory until output_end */
    const char *path; /* path of the file; NULL: standard output */
    bool is_executable;
    char *text;
    size_t length;
};

/* Begins a file; `path` NULL: standard output. Fails if the file may not be written, as
 * output_check does. */
enum mr_status output_begin(struct output *output, const char *path, struct error *error);
/* Moves the written file to its path. If `error` is already set, the old file stays. MR_IO: a write
 * failed. Returns the status of `error`. */
enum mr_status output_end(struct output *output, struct error *error);
/* Writes `length` bytes to a file: output_begin and output_end in one call. */
enum mr_status output_write_bytes(const char *path, const void *bytes, size_t length,
                                  struct error *error);

/* Opens a temporary file for writing and reading; fclose removes it. `what` is the purpose of the
 * file ("the plot"), for error messages. Returns NULL and sets `error` (MR_IO) if the file cannot
 * be created. */
FILE *output_open_temporary(const char *what, struct error *error);
/* Copies the whole temporary file to `to`. */
void output_copy_temporary(FILE *temporary, FILE *to);

/* Writes a JSON value to a file, indented; numbers have `digits` digits. */
enum mr_status output_write_json(const char *path, const json_t *json, unsigned digits,
                                 struct error *error);

/* Checks the output path before long work. Fails if output_begin would refuse `path` (NULL: nothing
 * is written), if the file cannot be written, or if it is the input file `input` (NULL: none),
 * which would be overwritten. Writes nothing. */
enum mr_status output_check(const char *path, const char *input, struct error *error);
/* For files that people fill in: fails with MR_USAGE if a file with content exists at `path` (NULL:
 * none) and --force was not given. */
enum mr_status output_check_new(const char *path, bool force, struct error *error);
/* Fails with MR_USAGE if `path` and `input`, which the command reads, are the same file, even under
 * different names. Either may be NULL. */
enum mr_status output_check_not_input(const char *path, const char *input, struct error *error);

bool output_is_database(const char *path);
/* Checks that a file is of the `wanted` kind ("survey sheet"). Fails with MR_MALFORMED if its first
 * bytes are those of another known kind, such as a spreadsheet. The message names that kind. */
enum mr_status output_check_file_format(const char *path, const char *wanted, struct error *error);
/* Length in bytes (0 or 3) of a UTF-8 byte order mark at the start of a text. Spreadsheets write
 * such a mark. */
size_t utf8_bom_length(const char *text, size_t length);
/* Returns true for UTF-8 with a character other than a blank and without control characters (C0,
 * DEL, C1), which a terminal would execute. */
bool text_is_plain(const char *text);
/* Replaces control characters by blanks. */
void text_blank_controls(char *text);

#endif
