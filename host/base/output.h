/* A file that a command writes: `-o F`, or standard output.
 *
 * One rule for all of them: a file is overwritten only while its content is what matrig wrote there
 * (written.h), or with --force; also an empty one. A database never is, nor what SQLite keeps
 * beside one (-wal, -shm, -journal), nor what the command reads. The file appears whole or not at
 * all: it is made beside its place and renamed, so that a command that fails leaves the old one. A
 * pipe, a terminal or a device is simply written to. */
#ifndef MATRIG_HOST_BASE_OUTPUT_H
#define MATRIG_HOST_BASE_OUTPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "host/base/error.h"

struct output {
    FILE *file;       /* takes what is written; in memory until output_end */
    const char *path; /* NULL: standard output */
    bool force, executable;
    char *text;
    size_t length;
};

/* `path` NULL: standard output. `force`: --force was given. Fails where the file may not be
 * written, as output_check. */
enum mr_status output_begin(struct output *output, const char *path, bool force,
                            struct error *error);
/* Puts in place what was written, unless `error` holds one already: then the old file stays. MR_IO
 * when anything did not arrive. Returns the error's status. */
enum mr_status output_end(struct output *output, struct error *error);
/* Both, of `length` bytes. */
enum mr_status output_bytes(const char *path, bool force, const void *bytes, size_t length,
                            struct error *error);

/* Before work that takes long: whether output_begin would refuse `path` (NULL: nothing is written),
 * whether it can be written, and that it is none of what is read (`input`; NULL: nothing), which
 * would be lost. Writes nothing. */
enum mr_status output_check(const char *path, bool force, const char *input, struct error *error);
/* MR_USAGE when `path` is the file `input` that the command reads, by whatever name; either may be
 * NULL. */
enum mr_status output_not_input(const char *path, const char *input, struct error *error);

/* MR_USAGE when `path`, or what it leads to, is what SQLite keeps beside a database, there or not.
 * For what is opened elsewhere: a database, results that are added to. */
enum mr_status output_not_beside_database(const char *path, struct error *error);

/* Of a command whose output is a database: the same, and a file that was made already takes its
 * place. */
enum mr_status output_check_database(const char *path, bool force, struct error *error);
enum mr_status output_place_database(const char *draft, const char *path, bool force,
                                     struct error *error);
bool output_is_database(const char *path);

#endif
