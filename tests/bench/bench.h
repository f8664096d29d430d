/* Timings of the simulation, as ratios within one run where a ratio says it: what `make bench`
 * prints.
 *
 * Each part prints one line per figure: measured, wanted, "met" or "missed". Nothing here fails: a
 * loaded machine is not a fault. Times are medians of interleaved repetitions, or the least where
 * the wall clock takes them. */
#ifndef MATRIG_TESTS_BENCH_H
#define MATRIG_TESTS_BENCH_H

#include <stdbool.h>
#include <stddef.h>

#include "host/sim/sim.h"

#define BENCH_EVEN_TIMES 64

/* Time on this thread, ms: what others do on the machine is not counted. */
double bench_clock_ms(void);

/* Sorts them. */
double bench_median(double *values, size_t count);

/* "  what: measured unit (wanted <= or >= bound): met". */
void bench_line(const char *what, double measured, const char *unit, bool at_most, double wanted);

/* Load a scene of host/scenes; its outputs are the 64 even times and, with own_times, its own t_out
 * besides. */
bool bench_load(struct sim_scene *scene, const char *file, bool own_times);

/* False, with the reason on standard output when `what` is given, unless the run is ok. */
bool bench_run(const struct sim_scene *scene, const struct sim_options *options,
               struct sim_result *result, const char *what);

void bench_growth(void); /* time against N */
void bench_pruning(void);
void bench_landings(void);
void bench_ensemble(void);

#endif
