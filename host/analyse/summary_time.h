/* The part of a landing's summary that is about time: the board's clock, the time of day of the
 * touchdown, the film. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_TIME_H
#define MATRIG_HOST_ANALYSE_SUMMARY_TIME_H

#include "host/analyse/summary.h"

/* Of a moment of the board: Unix microseconds and half the 95 % interval; NaN: not known. */
struct summary_moment {
    double host_us;
    double half_us;
};
struct summary_moment summary_time_of_day(const struct summary *summary, double board_us);
/* The same by a landing's clock alone: the best of its links, as summary->clock. `*known` false: no
 * link had one. */
enum mr_status summary_time_clock(struct store *store, int64_t run, struct store_time_map *clock,
                                  bool *known, struct error *error);
struct summary_moment summary_time_by(const struct store_time_map *clock, double board_us);

enum mr_status summary_time_load(struct store *store, struct summary *summary, struct error *error);
void summary_time_answer(const struct summary *summary, struct answer *answer);

#endif
