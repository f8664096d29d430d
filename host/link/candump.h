/* One line of a log in the format of `candump -L`, which log2asc, canplayer and other programs
 * read:
 *
 *     (1436509053.850870) can0 123#DEADBEEF   data frame, 11-bit identifier
 *     (1436509053.850870) can0 1F334455#11    extended identifier: 8 digits
 *     (1436509053.850870) can0 123#R8         remote frame, with the requested length
 *
 * The time is in seconds, written here with 6 decimals. An 8-digit identifier with bit 29 set is an
 * error frame. Fields may be separated by any number of blanks: candump versions of 2018 to 2021
 * pad the interface name when recording several interfaces. Newer versions append the direction, R
 * or T, or a length code beyond 8 (_9 to _F) after 8 bytes; both are accepted and ignored. CAN FD
 * lines (##) are malformed here. */
#ifndef MATRIG_HOST_LINK_CANDUMP_H
#define MATRIG_HOST_LINK_CANDUMP_H

#include <stddef.h>

#include "host/link/link.h"

#define CANDUMP_LINE_SIZE 200u

/* Parses `length` characters without the newline. Returns MR_OK or MR_MALFORMED. */
enum mr_status candump_parse(const char *text, size_t length, struct link_frame *frame);

/* A parsed line, including the parts that struct link_frame does not contain. */
struct candump_line {
    struct link_frame frame;
    const char *interface; /* name of the interface, which points into the text */
    size_t interface_length;
    size_t error_column; /* column, from 1, of the first character that does not fit the format */
};
enum mr_status candump_parse_line(const char *text, size_t length, struct candump_line *line);

/* Result of reading a file. Valid parts are used even after a fault. */
struct parse_result {
    enum mr_status status;  /* MR_OK: complete; MR_TRUNCATED; MR_MALFORMED */
    size_t line, column;    /* position of the first fault, from 1 */
    size_t bad_lines;       /* number of invalid lines, which were skipped */
    const char *fault_text; /* description of the first fault; static storage */
};
/* Sets the result. Only the first call has an effect. */
void parse_result_set(struct parse_result *result, enum mr_status status, size_t line,
                      size_t column, const char *what);
/* Writes the result as text: "complete", "truncated at line 7, column 12: ...", "malformed at line
 * ...; 3 lines were passed over". */
void parse_result_text(const struct parse_result *result, char *out, size_t size);

/* State of reading a log of one or several buses, line by line. */
#define CANDUMP_INTERFACE_SIZE 64u
struct candump_log {
    char interface[CANDUMP_INTERFACE_SIZE]; /* interface whose frames are read; "": all */
    size_t line_number;                     /* number of the last line, from 1 */
    uint64_t other_interface_frames; /* number of frames of other interfaces, which are skipped */
    struct parse_result result;
};
/* Parses the next line. `text`: the line without its newline. `whole` false: the file ends inside
 * this line. Returns true if `line` has a frame to use. An invalid line is skipped and counted. */
bool candump_log_parse_line(struct candump_log *log, const char *text, size_t length, bool whole,
                            struct candump_line *line);
bool candump_is_from_interface(const struct candump_line *line, const char *interface);

/* Writes the line of a frame with newline and terminating zero; the time is frame->host_us, the
 * interface "can0". Returns its length. */
size_t candump_write_line(const struct link_frame *frame, char out[CANDUMP_LINE_SIZE]);

#endif
