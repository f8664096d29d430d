/* Readings of other instruments, by a mapping: a table of numbers as other programs write it, or
 * the signals of CAN frames in a candump log. A line that is none is passed over and counted; the
 * verdict names the first. Pure but for memory. */
#ifndef MATRIG_HOST_EXCHANGE_READINGS_H
#define MATRIG_HOST_EXCHANGE_READINGS_H

#include "host/exchange/import.h"
#include "host/exchange/mapping.h"
#include "host/link/candump.h"

/* Fills the series of the mapping's channels. A line that is no row is passed over; the verdict
 * names the first. MR_MALFORMED: a column is not there, no row is good, or more than one in ten is
 * not. `rows`: taken. */
enum mr_status csv_read(const char *text, size_t length, const char *path, struct mapping *mapping,
                        size_t *rows, struct verdict *verdict, struct error *error);

/* A candump log in memory, frame by frame. */
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

/* Frames of other instruments: the mapping's series from a candump log, times in s since its first
 * frame. MR_MALFORMED: none of them is in it. */
enum mr_status import_read_signals(const struct textfile *file,
                                   const struct import_request *request, struct mapping *mapping,
                                   struct import_result *result, struct error *error);

#endif
