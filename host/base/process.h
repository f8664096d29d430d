/* Running another program as a child process, quoting for a shell, and temporary folders. A child
 * is started, waited for with a time limit, and ends when this program ends. */
#ifndef MATRIG_HOST_BASE_PROCESS_H
#define MATRIG_HOST_BASE_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <sys/types.h>

#include "host/base/error.h"

/* Starts a program. words[0] is its path, or its name in PATH; NULL ends the list. `streams` are
 * the descriptors for its streams 0, 1 and 2 (-1: those of this program); the caller still owns
 * them. A program that cannot be run ends with exit code 127. MR_IO: the child cannot be
 * started. */
enum mr_status process_start(const char *const words[], const int streams[3], pid_t *child,
                             struct error *error);

/* Waits until the child ends, or kills it after `limit_s` seconds and returns false. `*status` is
 * the status of waitpid. */
bool process_wait(pid_t child, double limit_s, int *status);

/* Writes the text in quotes, as one word for a POSIX shell, whatever it contains. */
void shell_quote(FILE *out, const char *text);

/* Size of the path of a temporary folder, which is in $TMPDIR or /tmp. */

#define TEMPORARY_FOLDER_SIZE 200

/* Makes matrig-NAME.XXXXXX; the caller removes it. MR_IO: it cannot be made, and `path` is "". */
enum mr_status temporary_folder_create(char path[TEMPORARY_FOLDER_SIZE], const char *name,
                                       struct error *error);
/* Removes those of the named files that exist, and then the folder. Does nothing if `path` is
 * "". */
void temporary_folder_remove(const char *path, const char *const names[], size_t count);

#endif
