/* Trace of a run as a VCD file (IEEE 1364-2001, 18.2; timescale 1 ns), for GTKWave, PulseView and
 * the like: pins, converters, links, exceptions, sleep.
 *
 * An exception's lane is high while it is active, preempted or not. Peripherals and pins change at
 * their exact time, what the core does at the start of the basic block that does it. Same run, same
 * bytes. */
#ifndef MATRIG_HIL_VCD_H
#define MATRIG_HIL_VCD_H

#include <stddef.h>

#include "common/status.h"
#include "hil/core/elf.h"

struct hil_board;

/* Begin a trace of `board`, whose image is loaded, into `path`. MR_IO, with the
 * reason in `error`. */
enum mr_status hil_vcd_open(struct hil_board *board, const char *path,
                            const struct mr_symbols *symbols, char *error, size_t size);
/* End it; MR_IO when not all of it could be written. Without a trace: MR_OK. */
enum mr_status hil_vcd_close(struct hil_board *board, char *error, size_t size);

#endif
