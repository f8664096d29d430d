/* A file that a command writes: `-o F`, or standard output. */
#ifndef MATRIG_HOST_OUTPUT_H
#define MATRIG_HOST_OUTPUT_H

#include <stdio.h>

#include "host/error.h"

/* `path` NULL: standard output. NULL on failure; a file that is an SQLite database is refused, never overwritten. */
FILE *output_open(const char *path, struct error *error);
/* Before work that takes long: whether output_open would refuse `path`, whether it can be written, and that it is none of what is
 * read (`input`; NULL: nothing), which would be lost. Writes nothing. */
enum mr_status output_check(const char *path, const char *input, struct error *error);
/* MR_USAGE when `path` is the file `input` that the command reads, by whatever name; either may be NULL. */
enum mr_status output_not_input(const char *path, const char *input, struct error *error);
/* Flushes and closes; MR_IO when anything written did not arrive. */
enum mr_status output_close(FILE *file, const char *path, struct error *error);

#endif
