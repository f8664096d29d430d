/* The file of results: JSON lines, one a case, appended whole.
 *
 *   {"case": ID, "values": {KEY: VALUE, ...}, "status": "ok" | why not, ["reason":,] ["result":
 *   {...},] ["find": {...},] "cpu_ms":}
 *
 * One process writes a file at a time (POSIX lock on it). A line reaches the file by one write with
 * O_APPEND, so a process that is killed leaves whole lines; power cut or full disk may leave a torn
 * last one, which has no newline: it is taken off when the file is opened for writing, and its case
 * is done again. */
#ifndef MATRIG_HOST_SWEEP_RESULTS_H
#define MATRIG_HOST_SWEEP_RESULTS_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "host/base/error.h"

struct sweep_results {
    int fd; /* -1: not open */
    char path[1100];
    off_t size;
    size_t torn; /* bytes of a torn last line that were taken off */
};

/* For writing: locked, made when it is not there. Another process has it: MR_NOT_NOW, with its
 * number. */
enum mr_status sweep_results_open(struct sweep_results *results, const char *path,
                                  struct error *error);
void sweep_results_close(struct sweep_results *results);

/* Appends one line. What did not fit (disk full) is taken off again. */
enum mr_status sweep_results_append(struct sweep_results *results, const char *line,
                                    struct error *error);
/* To the disk. */
enum mr_status sweep_results_sync(struct sweep_results *results, struct error *error);

/* Puts the lines for which `keep` is true into a new file in its place; still locked. */
typedef bool sweep_keep(void *ctx, const json_t *line);
enum mr_status sweep_results_rewrite(struct sweep_results *results, sweep_keep *keep, void *ctx,
                                     struct error *error);

/* Goes through the whole lines of a file that is open for writing, or of any file by its path (a
 * torn last line is left out; a file that is not there has none: MR_OK). Never by path while this
 * process has it open: closing it would end the lock. A line that is no result: MR_MALFORMED with
 * its number. `text` has no newline. */
typedef enum mr_status sweep_line(void *ctx, size_t number, uint64_t id, const json_t *line,
                                  const char *text, struct error *error);
enum mr_status sweep_results_lines(const struct sweep_results *results, sweep_line *each, void *ctx,
                                   struct error *error);
enum mr_status sweep_results_read(const char *path, sweep_line *each, void *ctx,
                                  struct error *error);

#endif
