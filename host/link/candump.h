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

/* Write the line of a frame with newline and final zero; the time is frame->host_us, the interface
 * "can0". Returns its length. */
size_t candump_print(const struct link_frame *frame, char out[CANDUMP_LINE_MAX]);

#endif
