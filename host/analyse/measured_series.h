/* The series of a measured landing: from block records where there are any, the rest from CAN
 * messages; and which of their times belong to it. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_SERIES_H
#define MATRIG_HOST_ANALYSE_MEASURED_SERIES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/status.h"
#include "host/analyse/measured.h"

/* Which times can belong to a landing? Those of its block records, messages and readings, by the
 * second, are groups between pauses of half a minute: a landing lasts 22 s from its first edge
 * (common/onboard/landing.h), so whatever comes later is none of it. A group that is small beside
 * the largest is not the landing: one wrong time would make the record hours long. What belongs to
 * no group is set aside and counted; the campaign keeps it. Pure but for its memory. */

#define MOMENTS_PAUSE_S 30

struct moments {
    struct moments_group {
        int64_t from_s, to_s; /* both in it */
        size_t count, edges;
    } * group;
    size_t groups;
    bool full; /* no memory */
};

/* Any number of times, in any order. */
void moments_add(struct moments *moments, int64_t block);
void moments_add_edge(struct moments *moments, double board_s);
/* Then, once: only groups that belong to the landing are left. MR_FULL: no memory was left for all
 * of them. */
enum mr_status moments_judge(struct moments *moments);
/* True of all while there is none. */
bool moments_hold(const struct moments *moments, int64_t block);
bool moments_hold_edge(const struct moments *moments, double board_s);
void moments_free(struct moments *moments);

/* Fills source, first_block, samples, the raw series and validities, and, with both links, the
 * check of one against the other. Needs landing and channel configuration. */
enum mr_status measured_load_series(struct store *store, struct measured *measured,
                                    struct error *error);

#endif
