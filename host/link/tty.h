/* A serial port of this computer, through libserialport: raw, 8 data bits, no parity unless set,
 * one stop bit, no flow control, for this program alone. */
#ifndef MATRIG_HOST_LINK_TTY_H
#define MATRIG_HOST_LINK_TTY_H

#include "host/base/error.h"

#define TTY_BAUD_DEFAULT 2000000
#define TTY_PATH_MAX     256u

struct link;
struct tty;

/* "TTY[:BAUD]" in its parts. A colon belongs to the path unless only
 * digits follow it (names below /dev/serial/by-path have colons). MR_USAGE; `form` tells how it
 * should be written. */
enum mr_status tty_parse(const char *text, const char *form, char path[TTY_PATH_MAX], int *baud,
                         struct error *error);

#endif
