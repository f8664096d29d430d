/* GDB remote serial protocol over a socket: `PORT` (on 127.0.0.1; 0: any that is free) or
 * `unix:PATH`.
 *
 *     gdb-multiarch build/firmware/matrig.elf -ex 'target remote :3333'
 *
 * The board is held from the connection on, and virtual time stands still while it is held, unless
 * `runs` is set. After a
 * detach it runs on, and a debugger may come again. Protocol: GDB manual, appendix E; target
 * description: G.5.4. */
#ifndef MATRIG_HIL_GDB_H
#define MATRIG_HIL_GDB_H

#include <stdbool.h>
#include <stddef.h>

#include "common/status.h"
#include "hil/board/board.h"
#include "hil/core/state.h"
#include "hil/debug/debug.h"

#define HIL_GDB_PACKET 4096u

struct hil_gdb_line {
    int fd; /* -1: none */
    bool acknowledges;
    char in[2 * HIL_GDB_PACKET];
    size_t in_size;
    struct hil_call lost; /* the connection is over */
};

struct hil_gdb {
    int listener; /* -1: none */
    struct hil_gdb_line line;
    char place[160]; /* where it listens, for the message */
    char path[108];  /* of the socket; empty: a port */
    struct hil_board *board;
    struct hil_debug debug;
    bool attached;
    bool reported; /* the debugger knows that the board is held */
    bool killed;
    bool runs; /* time goes on, by the wall clock, while the board is held */
};

/* Listen. MR_USAGE, MR_IO, with the reason in `error`. */
enum mr_status hil_gdb_open(struct hil_gdb *gdb, const char *text, char *error, size_t size);
/* Wait for the first debugger; the board is held then. MR_TIMEOUT; `*stop` ends it (MR_CLOSED). */
enum mr_status hil_gdb_accept(struct hil_gdb *gdb, struct hil_board *board, int timeout_ms,
                              const volatile int *stop, char *error, size_t size);
/* To be called between pieces of the run, with what the last one returned: takes a new debugger, an
 * interrupt (Ctrl-C), and, while the board is held or has stopped, serves the debugger until it
 * lets it go on. False: the debugger killed the board. */
bool hil_gdb_serve(struct hil_gdb *gdb, enum mr_status status, const volatile int *stop);
/* The run is over, and the process will exit with this code. Tells the debugger and closes
 * everything. */
void hil_gdb_close(struct hil_gdb *gdb, int exit_code);

#endif
