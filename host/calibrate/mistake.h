/* What mistake an impossible gain looks like: values in another unit, or swapped columns. Pure. */
#ifndef MATRIG_HOST_CALIBRATE_MISTAKE_H
#define MATRIG_HOST_CALIBRATE_MISTAKE_H

#include <stddef.h>

#include "common/config.h"

/* "; were the values mm?", "; are the columns swapped?"; empty when no such mistake explains the
 * gain of a channel that measures. */
void mistake_text(const struct mr_channel_config *channel, char *out, size_t size);

#endif
