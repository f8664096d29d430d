/* A serial port of this computer, opened with libserialport: raw, 8 data bits, one stop bit, no
 * flow control, parity only if set, exclusive to this program. */
#ifndef MATRIG_HOST_LINK_TTY_H
#define MATRIG_HOST_LINK_TTY_H

#include "host/base/error.h"

#define TTY_BAUD_DEFAULT 2000000
#define TTY_PATH_SIZE    256u

struct link;
struct tty;

/* Splits "TTY[:BAUD]". A colon belongs to the path unless only digits follow it (names in
 * /dev/serial/by-path contain colons). MR_USAGE: wrong syntax; `form` is the correct syntax for the
 * message. */
enum mr_status tty_parse(const char *text, const char *syntax, char path[TTY_PATH_SIZE], int *baud,
                         struct error *error);

#endif
