/* The slow log: one row per minute of mat temperature and mean band tensions, which shows how the
 * tension of the bands changes overnight as the mats cool. A row is made at each full minute of the
 * block index while no landing is in progress. It contains the means of the last four seconds and
 * is sent in six messages, one per block. matrig log stores the rows; the board does not. */
#ifndef MATRIG_FIRMWARE_SLOWLOG_H
#define MATRIG_FIRMWARE_SLOWLOG_H

#include "common/block.h"
#include "firmware/telemetry.h"

#define SLOWLOG_MEAN_BLOCKS 4096u
#define SLOWLOG_PER_MESSAGE 3u /* tensions per message */

/* Initialise it with zeros. */
struct slowlog {
    bool has_started;
    uint32_t due_block;
    unsigned block_count;
    float sum[MR_GAGES];
    uint16_t count[MR_GAGES];
    float tension_lb[MR_GAGES]; /* tensions of the newest row; NaN: missing */
    uint8_t row;
    unsigned unsent_gages; /* number of gages whose tensions are not yet sent */
};

/* Call in each block. `tension_lb`: MR_GAGES values, NaN: missing; `quiet`: no landing is in
 * progress. */
void slowlog_on_block(struct slowlog *log, struct telemetry *telemetry, uint32_t index,
                      const float *tension_lb, float temperature_c, bool quiet);
/* Call when a zero or the configuration has changed: restarts the means. */
void slowlog_reset(struct slowlog *log);

#endif
