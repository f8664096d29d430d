/* A landing of the truth (tests/score/truth.h) as lines of a run file, as the emulated board plays
 * it: its time 0 is TRUTH_BEGIN_S of the run. */
#ifndef MATRIG_TESTS_BOARD_TRUTH_RUN_H
#define MATRIG_TESTS_BOARD_TRUTH_RUN_H

#include "tests/runs/runfile.h"
#include "tests/score/truth.h"

#define TRUTH_BEGIN_S     0.9
#define TRUTH_TRANSDUCERS 8
#define TRUTH_RATE_HZ     (1000 / SCORE_ROW_MS)

/* Switches where they stand, and when they open. */
void truth_run_switches(struct syn_run *run, const struct score_landing *landing);
/* Commands from 0.3 s on: the sums of ten openings before the landing, read with an error. */
void truth_run_survey(struct syn_run *run, const struct score_landing *landing, uint64_t *state);
/* Bands that nothing pulls at, and the transducers, `first`: where the first stands, tens of feet.
 */
void truth_run_samples(struct syn_run *run, const struct score_landing *landing, unsigned first);

#endif
