/* Draw: what a seed makes of a series' ranges, and the path of a landing. Streams are
 * independent: another landing or another range does not change what else is drawn. */
#ifndef MATRIG_HOST_LANDING_SERIES_DRAW_H
#define MATRIG_HOST_LANDING_SERIES_DRAW_H

#include "host/landing_series/series.h"

enum draw_stream { DRAW_GAPS, DRAW_CLOSING, DRAW_GROUND, DRAW_LANDING };

struct draw {
    uint64_t state;
};

struct draw draw_from(uint64_t seed, unsigned stream);

/* Uniform in [0, 1), and in a range. */
double draw_uniform(struct draw *draw);
double draw_between(struct draw *draw, struct series_range range);

/* The aircraft's way from touchdown to its stop, or off the runway. */
struct draw_path {
    struct sim_path_row *rows;
    size_t count;
    double touchdown_ft, stop_ft, mean_ft_s2;
};

/* Path of landing `index` (from 0) on the runway of a seed: brakes from touchdown, with an onset of
 * onset_s; thrust W/axles a/g; or is towed to the runway's end. `path` is all zero or of an earlier
 * call. MR_FULL; MR_USAGE when it does not stop within 600 s. */
enum mr_status draw_landing(const struct landing_series *series,
                            const struct series_landing *landing, uint64_t seed, size_t index,
                            struct draw_path *path, struct error *error);
void draw_path_free(struct draw_path *path);

#endif
