/* The quick look at a landing, for the people beside the runway, within 10 s after the stop and
 * without a command: when a landing ends `matrig log` prints its summary; when its links fall
 * silent in the middle, what came until then; and it keeps a page up to date. */
#ifndef MATRIG_HOST_QUICKLOOK_H
#define MATRIG_HOST_QUICKLOOK_H

#include <sys/types.h>

#include "host/collect/collect.h"

#define QUICKLOOK_SILENT_US 4000000u

struct quicklook {
    const char *db, *page; /* page: NULL, none is written */
    bool si;
    pid_t child; /* writing the page; 0: none */
    bool again;  /* another one is due after it */
};

/* Since when nothing comes of a board. */
struct quicklook_silence {
    int64_t block, told_run; /* newest block; landing whose silence was told */
    uint64_t since_us;       /* when it came */
};

/* Whether a landing in which the gear moves has brought nothing for QUICKLOOK_SILENT_US: once for
 * each. `now_us` is monotonic. */
bool quicklook_silent(struct quicklook_silence *silence, const struct collector_progress *progress,
                      uint64_t now_us);
/* Writes the page, beside the logging: another process reads the campaign as it is on disk. */
void quicklook_write(struct quicklook *look);
/* Looks after that process; `end`: waits for it, a minute at most. */
void quicklook_service(struct quicklook *look, bool end);

#endif
