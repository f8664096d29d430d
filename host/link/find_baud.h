/* The rate of a board on a serial port, by trying the usual ones. */
#ifndef MATRIG_HOST_LINK_FIND_BAUD_H
#define MATRIG_HOST_LINK_FIND_BAUD_H

#include "host/link/tty.h"

/* Listens at each usual rate until a frame is whole; the port stays at that one. About a second for
 * each: a board speaks ten times a second. MR_TIMEOUT: nothing came at any; MR_IO: something did,
 * and none is whole. */
enum mr_status find_baud(struct tty *tty, const char *spec, int *baud, struct error *error);

#endif
