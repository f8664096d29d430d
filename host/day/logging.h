/* The log of a landing, begun by the day and not tied to it: when the day is killed, the log goes
 * on, and the next day finds it. It takes its orders from a FIFO, and what it says is in a file;
 * both lie in the day's folder beside the campaign. */
#ifndef MATRIG_HOST_DAY_LOGGING_H
#define MATRIG_HOST_DAY_LOGGING_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <sys/types.h>

#include "host/base/error.h"

#define DAY_PATH 4096

struct day_logging {
    char folder[DAY_PATH]; /* DB-day */
    pid_t pid;             /* of the log; 0: none runs */
    int64_t before;        /* the newest landing when it began */
    long shown;            /* of what it said, bytes that were shown */
};

/* Looks whether a log runs. MR_TOO_LONG. */
enum mr_status day_logging_begin(struct day_logging *logging, const char *db, struct error *error);
/* The folder, when it is not there. MR_IO. */
enum mr_status day_logging_folder(const struct day_logging *logging, struct error *error);
/* words: as of process_start; orders reach it as lines; `before`: the newest landing. MR_IO. */
enum mr_status day_logging_start(struct day_logging *logging, const char *const words[],
                                 int64_t before, struct error *error);
/* Whether it runs. */
bool day_logging_runs(struct day_logging *logging);
/* A line for it ("arm"); false: it does not read. */
bool day_logging_order(const struct day_logging *logging, const char *line);
/* Shows on `out` what it has said since. True: there was something. */
bool day_logging_show(struct day_logging *logging, FILE *out);
/* Asks it to end and waits for at most limit_s. False: it goes on. */
bool day_logging_stop(struct day_logging *logging, double limit_s);

#endif
