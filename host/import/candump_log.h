/* A candump log in memory, frame by frame. A line that is none is passed over and counted; the
 * verdict names the first. Pure. */
#ifndef MATRIG_HOST_IMPORT_CANDUMP_LOG_H
#define MATRIG_HOST_IMPORT_CANDUMP_LOG_H

#include "host/import/textfile.h"
#include "host/link/candump.h"

struct candump_log {
    const char *text, *end;
    const char *at;
    size_t line;           /* the last one taken, from 1 */
    const char *interface; /* NULL: any; else frames of others are counted alone */
    size_t interface_length;
    size_t elsewhere; /* frames of other interfaces */
    struct verdict verdict;
};

void candump_log_start(struct candump_log *log, const char *text, size_t length,
                       const char *interface);
/* False: the end; the verdict stands then. The line's interface lies in the text. */
bool candump_log_next(struct candump_log *log, struct candump_line *line);

#endif
