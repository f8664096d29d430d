/* A pseudo-terminal as the other end of a serial line: a host program opens its name as it would a
 * serial port, and the rate it sets is the rate at which its end of the line runs.
 *
 * Linux drops the parity setting of pseudo-terminals (drivers/tty/pty.c clears PARENB and forces
 * eight bits), so it cannot be read from here, and a program that insists on parity must be told to
 * do without: `stm32flash -m 8n1`. */
#ifndef MATRIG_HIL_PTY_H
#define MATRIG_HIL_PTY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"

/* Open one in raw mode at `baud`, with a symbolic link to it at `path`; an old link there is
 * replaced. *fd is this end, non-blocking. MR_IO; `error` says why. */
enum mr_status hil_pty_open(const char *path, uint32_t baud, int *fd, char *error, size_t size);
/* Does a host have it open? */
bool hil_pty_in_use(int fd);
/* Rate that the host has set, bits/s; 0 when it cannot be read. */
uint32_t hil_pty_baud(int fd);
/* Close and remove the link. */
void hil_pty_close(const char *path, int fd);

#endif
