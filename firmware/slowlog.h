/* The slow log: a row a minute of mat temperature and mean band tensions, so that the campaign
 * shows how bands pull back overnight as the mats cool. A row is made at each full minute of the
 * block index while no landing is going on, of the means of its last four seconds, and sent in six
 * messages, one a block. matrig log stores it; the board keeps nothing. */
#ifndef MATRIG_FIRMWARE_SLOWLOG_H
#define MATRIG_FIRMWARE_SLOWLOG_H

#include "common/block.h"
#include "firmware/telemetry.h"

#define SLOWLOG_MEAN_BLOCKS 4096u
#define SLOWLOG_PER_MESSAGE 3u /* tensions */

/* Zero is the beginning. */
struct slowlog {
    bool begun;
    uint32_t due;
    unsigned blocks;
    float sum[MR_GAGES];
    uint16_t count[MR_GAGES];
    float tension_lb[MR_GAGES]; /* of the newest row; NaN: missing */
    uint8_t row;
    unsigned unsent; /* gages */
};

/* One block. `tension_lb`: MR_GAGES, NaN: missing; `quiet`: no landing is going on. */
void slowlog_block(struct slowlog *log, struct telemetry *telemetry, uint32_t index,
                   const float *tension_lb, float temperature_c, bool quiet);
/* The zero or the configuration is another one: no mean goes over both. */
void slowlog_forget(struct slowlog *log);

#endif
