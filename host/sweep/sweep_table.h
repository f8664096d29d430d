/* Results: the result of one case, which is a simulation or a search with several simulations; and
 * the table of all cases, from any number of files: one row per case in the sweep's order, with the
 * sensitivity indices if the design has them. A line of a file:
 *
 *     {"case": N, "sweep": HASH, "values": {KEY: VALUE, ...}, "status": "ok" or the reason,
 *      ["reason":,] ["result": {...},] ["find": {...}]} */
#ifndef MATRIG_HOST_SWEEP_TABLE_H
#define MATRIG_HOST_SWEEP_TABLE_H

#include "host/base/answer.h"
#include "host/sweep/sweep.h"

/* Runs `input` once. Returns a new object. For a scene it is the output of `matrig sim --json` with
 * peak_u_ft; for a study, the output of `matrig study --json` with a status, "incomplete" if a
 * runway could not be simulated to its end. The status is "refused" for an input that the
 * simulation does not accept; "reason" accompanies every status except "ok". */
typedef json_t *sweep_simulator(const json_t *input);

/* Returns the function that simulates the sweep's base: a scene or a study. */
sweep_simulator *sweep_get_simulator(const struct sweep *sweep);

/* Runs a case in this process. Returns a new object: "status", "reason" unless the status is "ok",
 * "result" with the wanted outputs, and for a search "find" (README.md). */
json_t *sweep_run_case(const struct sweep *sweep, size_t index, sweep_simulator *simulate);

struct sweep_table {
    const struct sweep *sweep;
    json_t **line; /* one line per case; owned by the table. NULL: the case is missing */
    size_t line_count, failed_count, missing_count, repeated_count;
};

/* Makes the line of a finished case; takes ownership of `outcome`. */
json_t *sweep_make_line(const struct sweep *sweep, size_t index, json_t *outcome);

/* Reads the files. MR_MALFORMED with the line number: a line that is not a result, or that belongs
 * to another sweep. If a case occurs twice, the first line is used. The caller frees the table,
 * also after a failure. */
enum mr_status sweep_table_load(struct sweep_table *table, const struct sweep *sweep,
                                const char *const *paths, struct error *error);
void sweep_table_free(struct sweep_table *table);

/* Returns counts, failures by reason, indices and, with `rows`, all cases. */
struct answer *sweep_table_to_answer(const struct sweep_table *table, bool rows);
/* Writes the cases as CSV: number, values, status, threshold, results. */
void sweep_table_write_csv(const struct sweep_table *table, FILE *out);

/* Sensitivity indices: the fraction of the variance of a result that is due to a key. First order:
 * the decrease of the variance if this key were known, S = 1 - E[(f_B - f_ABk)^2] / 2V. Total: the
 * remaining variance if all other keys were known, T = E[(f_A - f_ABk)^2] / 2V (Jansen 1999,
 * Saltelli 2010). f is the result; A and B are two samples of points, ABk is A with key k taken
 * from B, V is the variance over A and B. T - S is the effect of the key in combination with other
 * keys. Intervals: 95 % by bootstrap over points. An estimate may be slightly below 0 or above
 * 1. */
struct sweep_sensitivity {
    double value, low, high;
};

struct sweep_key_sensitivities {
    struct sweep_sensitivity first, total;
};

/* `values` has one block of values per sample, in the order of design_fill_radial (A, B, AB1, ...);
 * NaN: no value. A point with a missing value is not used. Writes `keys` results to `influence`,
 * and the number of used points to *used. Returns false if there are fewer than 8 points, or no
 * variance. */
bool sweep_compute_sensitivities(const double *values, size_t points, size_t keys,
                                 struct sweep_key_sensitivities *influence, size_t *used);

#endif
