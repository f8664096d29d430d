/* Another program as a child of this one, its words for a shell, and the temporary folder it works
 * in. A child is started, awaited for a bounded time, and ends when this program does. */
#ifndef MATRIG_HOST_BASE_PROCESS_H
#define MATRIG_HOST_BASE_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <sys/types.h>

#include "host/base/error.h"

/* words[0] is the program's path, or its name in PATH; NULL ends them. `streams` are descriptors
 * that become its 0, 1 and 2; -1: this program's own. They stay the caller's. A program that cannot
 * be run ends with exit code 127. MR_IO. */
enum mr_status process_start(const char *const words[], const int streams[3], pid_t *child,
                             struct error *error);

/* Until it ends, `*status` as of waitpid; false: it did not within limit_s, and was killed. */
bool process_wait(pid_t child, double limit_s, int *status);

/* Words as a POSIX shell takes them. */

/* The text in quotes, whatever is in it: one word of a shell. */
void shell_quote(FILE *out, const char *text);

/* A temporary folder, in $TMPDIR or /tmp. */

#define TEMPORARY_FOLDER 200

/* Makes matrig-NAME.XXXXXX, which is the caller's to remove. MR_IO: `path` is then "". */
enum mr_status temporary_folder_make(char path[TEMPORARY_FOLDER], const char *name,
                                     struct error *error);
/* Removes these files, as far as they are there, and the folder; nothing for "". */
void temporary_folder_remove(const char *path, const char *const names[], size_t count);

#endif
