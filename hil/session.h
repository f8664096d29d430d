/* A run of matrig-board: its board, its links, and how time goes on for it. */
#ifndef MATRIG_HIL_SESSION_H
#define MATRIG_HIL_SESSION_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "common/symbols.h"
#include "hil/arguments.h"
#include "hil/board/board.h"
#include "hil/core/wall.h"
#include "hil/debug/gdb.h"
#include "hil/debug/debug.h"
#include "hil/link/wire_link.h"
#include "hil/rig/replay.h"
#include "hil/rig/runfile.h"

struct hil_session {
    const struct hil_arguments *a;
    struct hil_board *board;
    struct hil_link can, serial;
    uint64_t host_seen_ps; /* when the pty: was last in use */
    struct mr_symbols symbols;
    struct hil_hang hang;
    struct hil_run rig;
    struct hil_replay replay;
    struct hil_pace pace;
    struct hil_gdb gdb;
    FILE *profile, *margins;
    int stall_ms;
    bool real;
};

/* 1: by a signal, HIL_WALL_STOP: the wall-clock limit. */
extern volatile int hil_stop_asked;

/* Says why, if there is something to say. */
enum mr_status hil_told(enum mr_status status, const char *why);

/* Open the links and wait for their hosts; MR_CLOSED: it was to stop meanwhile. stderr says why
 * not. */
enum mr_status hil_session_open(struct hil_session *session);
/* Run for that long. */
enum mr_status hil_session_play(struct hil_session *session, double duration_s);
/* What the run was, in a line on stderr. */
void hil_session_summarise(const struct hil_session *session, double took_s);
void hil_session_close(struct hil_session *session, enum mr_status status);

#endif
