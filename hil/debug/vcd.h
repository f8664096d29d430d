/* Trace of a run as a VCD file (IEEE 1364-2001, 18.2; timescale 1 ns) for viewers such as GTKWave
 * and PulseView. It shows pins, converters, links, exceptions and sleep.
 *
 * The signal of an exception is high while the exception is active, preempted or not. Peripherals
 * and pins change at their exact time; actions of the core appear at the start of their basic
 * block. The same run gives the same file, byte for byte. */
#ifndef MATRIG_HIL_VCD_H
#define MATRIG_HIL_VCD_H

#include <stddef.h>

#include "common/status.h"
#include "hil/core/elf.h"

struct hil_board;

/* Begins a trace of `board`, whose image must be loaded, into the file `path`. MR_IO: it cannot be
 * written; `error` has the reason. */
enum mr_status hil_vcd_open(struct hil_board *board, const char *path,
                            const struct mr_symbols *symbols, char *error, size_t size);
/* Ends the trace. Does nothing without a trace. MR_IO: the file is incomplete. */
enum mr_status hil_vcd_close(struct hil_board *board, char *error, size_t size);

#endif
