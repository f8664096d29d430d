/* Results: of one case, which is a simulation or a search with several; and the lines of all cases,
 * gathered from any number of files: one row a case, in the sweep's order, with the indices of
 * sensitivity where the design has them.
 *
 *   {"case": N, "sweep": HASH, "values": {KEY: VALUE, ...}, "status": "ok" | why not,
 *    ["reason":,] ["result": {...},] ["find": {...}]} */
#ifndef MATRIG_HOST_SWEEP_TABLE_H
#define MATRIG_HOST_SWEEP_TABLE_H

#include "host/base/answer.h"
#include "host/sweep/sweep.h"

/* Runs `input` once. A new object. A scene: what `matrig sim --json` says and peak_u_ft; a
 * study: what `matrig study --json` says and status, "incomplete" when a runway could not be
 * played to its end. Status "refused" for what the simulation does not take; "reason" beside every
 * status that is not "ok". */
typedef json_t *sweep_simulate(const json_t *input);

/* That of the sweep's base. */
sweep_simulate *sweep_simulation(const struct sweep *sweep);

/* Runs a case in this process. A new object: "status", "reason" when that is not "ok", "result"
 * with the wanted outputs, and with a search "find" (README.md). */
json_t *sweep_case_run(const struct sweep *sweep, size_t index, sweep_simulate *simulate);

struct sweep_table {
    const struct sweep *sweep;
    json_t **line; /* [cases], owned; NULL: missing */
    size_t count, failed, missing, repeated;
};

/* The line of a finished case; takes `outcome`. */
json_t *sweep_line(const struct sweep *sweep, size_t index, json_t *outcome);

/* Reads the files. A line that is no result, or one of another sweep: MR_MALFORMED with its number.
 * Of a case that is there twice the first counts. The caller frees, also after a failure. */
enum mr_status sweep_table_load(struct sweep_table *table, const struct sweep *sweep,
                                const char *const *paths, struct error *error);
void sweep_table_free(struct sweep_table *table);

/* Counts, failures by reason, indices and, with `rows`, all cases. */
struct answer *sweep_table_answer(const struct sweep_table *table, bool rows);
/* The cases as CSV: number, values, status, threshold, results. */
void sweep_table_csv(const struct sweep_table *table, FILE *out);

/* Indices of sensitivity: which share of a quantity's variance a key makes.
 *
 * First order: what knowing that key alone would take off the variance,
 * S = 1 - E[(f_B - f_ABk)^2] / 2V. Total: what is left when all others are known,
 * T = E[(f_A - f_ABk)^2] / 2V (Jansen 1999, Saltelli 2010). A and B are two samples of points, ABk
 * is A with key k from B, V is the variance over A and B. T - S is what the key does together with
 * others. Intervals: 95 % by bootstrap over points. An estimate may lie a little below 0 or above
 * 1. */
struct sweep_index {
    double value, low, high;
};

struct sweep_influence {
    struct sweep_index first, total;
};

/* `values` by block, as design_radial: A, B, AB1 ..; NaN: none. A point of which any value is
 * missing is left out. `keys` results into `influence`; points that were of use into *used. False:
 * fewer than 8 points, or no variance. */
bool sweep_indices(const double *values, size_t points, size_t keys,
                   struct sweep_influence *influence, size_t *used);

#endif
