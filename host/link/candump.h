/* One line of a log as `candump -L` writes it and log2asc, canplayer and others read it:
 *
 *     (1436509053.850870) can0 123#DEADBEEF       data frame, 11-bit identifier
 *     (1436509053.850870) can0 1F334455#11        extended identifier: 8 digits
 *     (1436509053.850870) can0 123#R8             remote frame, with the length it asks for
 *
 * The time is in seconds, here with 6 decimals; an 8-digit identifier with bit 29 set is an error
 * frame. Between two fields is any run of blanks: versions of 2018 to 2021 pad the interface when
 * they record several. Newer ones add the direction, R or T, at the end, or a length code beyond 8
 * (_9 to _F) behind 8 bytes; both are allowed and not kept. CAN FD lines (##) are malformed
 * here. */
#ifndef MATRIG_HOST_LINK_CANDUMP_H
#define MATRIG_HOST_LINK_CANDUMP_H

#include <stddef.h>

#include "host/link/link.h"

#define CANDUMP_LINE_MAX 200u

/* Parse `length` characters without the newline. MR_OK or MR_MALFORMED. */
enum mr_status candump_parse(const char *text, size_t length, struct link_frame *frame);

/* The same, with what a frame has no place for. */
struct candump_line {
    struct link_frame frame;
    const char *interface; /* in the text given */
    size_t interface_length;
    size_t column; /* from 1: where it stopped being a line of a log */
};
enum mr_status candump_parse_line(const char *text, size_t length, struct candump_line *line);

/* What became of a file that was read: what is good of it is kept, whatever the verdict. */
struct verdict {
    enum mr_status status; /* MR_OK complete, MR_TRUNCATED, MR_MALFORMED */
    size_t line, column;   /* from 1: of the first thing wrong */
    size_t bad_lines;      /* passed over */
    const char *what;      /* is wrong there; static storage */
};
/* The first one holds. */
void verdict_set(struct verdict *verdict, enum mr_status status, size_t line, size_t column,
                 const char *what);
/* "complete", "truncated at line 7, column 12: ...", "malformed at line ...; 3 lines were passed
 * over". */
void verdict_text(const struct verdict *verdict, char *out, size_t size);

/* A log of one bus or several, line by line. */
#define CANDUMP_INTERFACE 64u
struct candump_log {
    char interface[CANDUMP_INTERFACE]; /* whose frames are taken; "": of any */
    size_t line;                       /* the last one, from 1 */
    uint64_t elsewhere;                /* frames of other interfaces, left out */
    struct verdict verdict;
};
/* The next line, without its end; not `whole`: the log ends in it. True: a frame to be taken. A
 * line that is none is passed over, and counted. */
bool candump_log_take(struct candump_log *log, const char *text, size_t length, bool whole,
                      struct candump_line *line);
bool candump_is_of(const struct candump_line *line, const char *interface);

/* Write the line of a frame with newline and final zero; the time is frame->host_us, the interface
 * "can0". Returns its length. */
size_t candump_print(const struct link_frame *frame, char out[CANDUMP_LINE_MAX]);

#endif
