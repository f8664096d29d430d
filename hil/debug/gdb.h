/* GDB remote serial protocol over a socket: `PORT` (on 127.0.0.1; 0: any free port) or `unix:PATH`.
 *
 *     gdb-multiarch build/firmware/matrig.elf -ex 'target remote :3333'
 *
 * The board is held when a debugger connects. Virtual time stands still while the board is held,
 * unless `is_time_running` is set. When the debugger detaches, the board continues, and a debugger
 * may connect again. Protocol: GDB manual, appendix E; target description: G.5.4. */
#ifndef MATRIG_HIL_GDB_H
#define MATRIG_HIL_GDB_H

#include <stdbool.h>
#include <stddef.h>

#include "common/status.h"
#include "hil/board/board.h"
#include "hil/core/state.h"
#include "hil/debug/debug.h"

#define HIL_GDB_PACKET_MAX 4096u

struct hil_gdb_connection {
    int fd; /* connection of the debugger; -1: none */
    bool is_acknowledging;
    char input[2 * HIL_GDB_PACKET_MAX];
    size_t input_size;
    struct hil_callback on_disconnect; /* called when the connection has ended */
};

struct hil_gdb {
    int listener; /* listening socket; -1: none */
    struct hil_gdb_connection connection;
    char address[160]; /* address of the listener, for the message */
    char path[108];    /* path of the socket; empty: a port is used */
    struct hil_board *board;
    struct hil_debug debug;
    bool is_attached;
    bool is_hold_reported; /* the debugger has been informed that the board is held */
    bool is_kill_requested;
    bool is_time_running; /* virtual time follows the wall clock while the board is held */
};

/* Opens the listener. MR_OK; MR_USAGE, MR_IO, with the reason in `error`. */
enum mr_status hil_gdb_open(struct hil_gdb *gdb, const char *text, char *error, size_t size);
/* Waits for the first debugger; the board is then held. MR_OK; MR_TIMEOUT; MR_CLOSED: `*stop` ended
 * the wait. */
enum mr_status hil_gdb_accept(struct hil_gdb *gdb, struct hil_board *board, int timeout_ms,
                              const volatile int *stop, char *error, size_t size);
/* Call between pieces of the run, with the status of the last piece. Accepts a new debugger and
 * interrupts (Ctrl-C). While the board is held or has stopped, serves the debugger until the
 * debugger lets the board continue. False: the debugger killed the board. */
bool hil_gdb_serve(struct hil_gdb *gdb, enum mr_status status, const volatile int *stop);
/* Call at the end of the run: reports the exit code to the debugger and closes everything. */
void hil_gdb_close(struct hil_gdb *gdb, int exit_code);

#endif
