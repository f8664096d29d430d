/* Copies of a board: for tests that go on from one moment in several ways.
 *
 * A snapshot is the whole machine (memories, core, peripherals, counters) as one block of memory
 * without pointers. Restoring into another board gives a second one that goes on identically; rig,
 * callbacks and options' trace stay the target's own. A reservation of LDREX is not part of it. */
#ifndef MATRIG_TESTS_HIL_SNAPSHOT_H
#define MATRIG_TESTS_HIL_SNAPSHOT_H

#include "hil/board/board.h"

struct snapshot; /* opaque */

/* The caller frees a snapshot with free(). Aborts on lack of memory. */
struct snapshot *snapshot_take(const struct hil_board *board);
void snapshot_restore(struct hil_board *board, const struct snapshot *snapshot);
/* New board in the same state, same rig, no callbacks, no trace. */
struct hil_board *snapshot_fork(const struct hil_board *board);

#endif
