/* A serial port of this computer, through libserialport: raw, 8 data bits, no parity unless set,
 * one stop bit, no flow control, for this program alone. */
#ifndef MATRIG_HOST_LINK_TTY_H
#define MATRIG_HOST_LINK_TTY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "host/base/error.h"

#define TTY_BAUD_DEFAULT 2000000
#define TTY_BAUD_FIND    0 /* of the usual rates the one at which a board is understood */
#define TTY_PATH_MAX     256u

struct link;
struct tty;

/* "TTY[:BAUD]" or "TTY:find" (TTY_BAUD_FIND) in its parts. A colon belongs to the path unless only
 * digits follow it (names below /dev/serial/by-path have colons). MR_USAGE; `form` tells how it
 * should be written. */
enum mr_status tty_parse(const char *text, const char *form, char path[TTY_PATH_MAX], int *baud,
                         struct error *error);

/* Open a port. `spec` is for errors. MR_IO: not there (the error lists the ports there are), in
 * use, or it does not do the rate (the error says which it took). The caller closes it. */
enum mr_status tty_open(const char *spec, const char *path, int baud, struct tty **tty,
                        struct error *error);
void tty_close(struct tty *tty); /* NULL is allowed */
int tty_fd(const struct tty *tty);

/* Another rate; what was received before is forgotten. MR_IO as tty_open. */
enum mr_status tty_line(struct tty *tty, int baud, struct error *error);

/* As read(2) of a non-blocking descriptor; a port that was unplugged or hung up is -1 with errno
 * ENODEV. */
ssize_t tty_read(struct tty *tty, uint8_t *bytes, size_t size);

/* Waits at most 1 s for room. MR_TIMEOUT, MR_IO. */
enum mr_status tty_write(struct tty *tty, const uint8_t *bytes, size_t length, struct error *error);

/* Counts as troubles of the link what the driver counted since the last call: overruns of the UART
 * and of the kernel's buffer, and errors of the line (framing, parity, break). None when the driver
 * does not count. */
void tty_news(struct tty *tty, struct link *link);

#endif
