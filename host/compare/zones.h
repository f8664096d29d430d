/* Zones of closed mats as measured (survey and transducers, common/closure.h), as the board said,
 * and as simulated, at the same moment.
 *
 * A simulated segment of ten mats counts as closed when its joints, added up, are open by less than
 * MR_CLOSURE_OPEN_IN: the measure by which the measured one does. Both therefore begin and end at
 * segments, 2.86 ft apart, or at the wheel; an end is good to a segment / sqrt(12). The board's own
 * statement comes with standard errors. Stations in ft. */
#ifndef MATRIG_HOST_COMPARE_ZONES_H
#define MATRIG_HOST_COMPARE_ZONES_H

#include "host/analyse/zones.h"
#include "host/store/store_predict.h"

enum compare_zone_source { COMPARE_MEASURED, COMPARE_BOARD, COMPARE_SIMULATED, COMPARE_SOURCES };

struct compare_zone {
    bool known;  /* false: nobody said */
    double mats; /* 0: none */
    double start_ft, end_ft, start_error_ft, end_error_ft;
};

struct compare_overlap {
    bool known;
    double common_mats, all_mats; /* intersection and union */
    double share;                 /* common / all; 1 when neither has a zone */
    double start_ft, end_ft;      /* measured - the other; NaN when either has none */
};

/* One moment. */
struct compare_zone_moment {
    const char *what; /* "longest measured", ... */
    double t_s, wheel_ft;
    struct compare_zone zone[COMPARE_SOURCES];
    struct compare_overlap board, simulated; /* each against the measured */
};

#define COMPARE_MOMENTS 2u /* where the zone is at its longest, and at rest */

struct compare_zones {
    size_t count; /* 0: no moment */
    struct compare_zone_moment moment[COMPARE_MOMENTS];
};

/* The moment at rest, or the other one; NULL: there is none. */
const struct compare_zone_moment *compare_moment_of(const struct compare_zones *zones, bool rest);
struct compare_overlap compare_overlap_of(const struct compare_zone *measured,
                                          const struct compare_zone *other);

/* Longest run of segments with less than MR_CLOSURE_OPEN_IN left whose end is ahead of the wheel;
 * one that the wheel is in begins there. */
struct compare_zone compare_closed_run(const float *remaining_in, double wheel_ft);

/* What the board said, in order of time; predictions (their errors) may be none. */
struct compare_said {
    const struct store_zone *zone;
    size_t zones;
    const struct store_prediction *prediction;
    size_t predictions;
};
/* What is left of the simulated segments every dt_s since touchdown: rows x MR_SEGMENTS. None: no
 * simulated zone is known. */
struct compare_segments {
    const float *remaining_in;
    size_t rows;
    double dt_s;
};
void compare_zones(const struct measured *measured, const struct zones_closure *survey,
                   const struct compare_said *said, const struct compare_segments *segments,
                   struct compare_zones *zones);

#endif
