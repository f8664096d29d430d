/* Where a channel's peaks are: the largest and the least mean of a few readings. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_PEAK_H
#define MATRIG_HOST_ANALYSE_MEASURED_PEAK_H

#include "host/analyse/measured.h"

/* The extremes of the moving mean from sample `from` on, of the value (measured_value): each looked
 * for in every second reading and taken from the others, both ways round. NaN: no mean has a valid
 * reading. */
void measured_peaks(const struct measured *measured, const struct measured_channel *channel,
                    size_t from, double *high, double *low);
/* How many samples one of these is the mean of, for measured_error. */
double measured_peak_samples(const struct measured_channel *channel);

#endif
