/* Properties of the rig from the landings of a campaign: touchdown speed as a function of release
 * height, and drag of the bearings as a function of temperature (1973 report, sections 2.4 and
 * 2.7.1); heights in pictures (2.7.3). Predictions are for the next landing. The true value is
 * within 1.96 errors with a probability of 95 %. Pure functions. */
#ifndef MATRIG_HOST_ANALYSE_RIG_H
#define MATRIG_HOST_ANALYSE_RIG_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"
#include "host/base/statistics.h"

#define RIG_RUNWAY_FT       120.0 /* length of the model mat (1973 report, section 2.6) */
#define RIG_RUNWAY_WIDTH_FT 14.0
#define RIG_MATS            420.0

/* Predicts y in the next landing, for x = `at`, from a line through y over x (with `squared`,
 * through y^2 over x). y^2 is for the touchdown speed as a function of release height: the track
 * takes a fixed share of the energy, and drag does not depend on speed. y is for the deceleration
 * without brakes as a function of temperature. MR_TOO_FEW: fewer than three landings, or all x are
 * equal. MR_NUMERICS: the line predicts that the gear does not reach the runway. */
enum mr_status rig_predict_next_landing(const double *x, const double *y, size_t count, double at,
                                        bool squared, struct estimate *predicted,
                                        struct error *error);

/* Points marked in a picture, in pixels from its upper left corner: two points at a known distance,
 * and the point whose height is measured. `error`: standard error of each coordinate. */
struct rig_marks {
    double x[3], y[3], error;
};

/* Returns the height of the third point above the straight line through the first two, whose
 * distance gives the scale; negative if below. Valid if the three points are in one plane that
 * faces the camera. MR_USAGE: the first two points are nearer than 20 errors, so the scale is not
 * known. */
enum mr_status rig_measure_height(const struct rig_marks *marks, struct estimate distance_ft,
                                  struct estimate *height_ft, struct error *error);

#endif
