/* Pseudo-terminals, which libserialport does not take: there is no device behind them. Linux keeps
 * no parity for them. */
#ifndef MATRIG_HOST_LINK_PTS_H
#define MATRIG_HOST_LINK_PTS_H

#include "host/link/link.h"

/* Opens it raw, for one alone. `spec` is for errors, `*fd` the caller's to close, also after an
 * error; -1: not opened. */
enum mr_status pts_open(const char *spec, const char *path, int baud, int *fd, struct error *error);
/* Another rate; what was received before is forgotten. */
enum mr_status pts_line(const char *spec, int fd, int baud, struct error *error);

#endif
