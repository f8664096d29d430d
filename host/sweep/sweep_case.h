/* One case: a simulation, or a search with several. */
#ifndef MATRIG_HOST_SWEEP_CASE_H
#define MATRIG_HOST_SWEEP_CASE_H

#include "host/sweep/sweep.h"

/* Runs `input` once. A new object. A scene: what `matrig sim --json` says and peak_u_ft; a
 * study: what `matrig study --json` says and status, "incomplete" when a runway could not be
 * played to its end. Status "refused" for what the simulation does not take; "reason" beside every
 * status that is not "ok". */
typedef json_t *sweep_simulate(const struct sweep *sweep, const json_t *input);

/* The simulation of the sweep's kind. */
sweep_simulate *sweep_simulation(enum sweep_kind kind);

/* Whether the simulation takes a scene or study, without running it; `where` begins the
 * error. */
enum mr_status sweep_case_check(const struct sweep *sweep, const json_t *input, const char *where,
                                struct error *error);

/* Runs a case in this process. A new object: "status", "reason" when that is not "ok", "result"
 * with the wanted outputs, and with a search "find" (README.md). */
json_t *sweep_case_run(const struct sweep *sweep, size_t index, sweep_simulate *simulate);

#endif
