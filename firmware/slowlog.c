#include "firmware/slowlog.h"

#include <string.h>

#include "common/wire.h"
#include "firmware/schedule.h"

#define READINGS_MIN 2u /* smallest number of readings for a mean */

void slowlog_reset(struct slowlog *log)
{
    log->block_count = 0;
    memset(log->sum, 0, sizeof log->sum);
    memset(log->count, 0, sizeof log->count);
}

static bool is_at_or_after(uint32_t index, uint32_t when)
{
    return (int32_t)(index - when) >= 0;
}

/* Returns the first block after this one in which a row is due. */
static uint32_t find_next_row_block(uint32_t index)
{
    return index + 1u + BLOCKS_UNTIL(SLOW_ROW, index + 1u);
}

static void send_tensions(struct slowlog *log, struct telemetry *telemetry)
{
    unsigned first = MR_GAGES - log->unsent_gages;
    float lb[SLOWLOG_PER_MESSAGE];
    for (unsigned k = 0; k < SLOWLOG_PER_MESSAGE; k++)
        lb[k] = first + k < MR_GAGES ? log->tension_lb[first + k] : MR_NAN;
    TELEMETRY_SEND(telemetry, TO_LINKS, slow_tension, SLOW_TENSION, .row = log->row,
                   .first = (uint8_t)(first + 1u), .a_lb = lb[0], .b_lb = lb[1], .c_lb = lb[2]);
    log->unsent_gages -= log->unsent_gages < SLOWLOG_PER_MESSAGE ? log->unsent_gages
                                                                 : SLOWLOG_PER_MESSAGE;
}

/* Writes a row. A mean needs readings in half of the blocks. */
static void make_row(struct slowlog *log, struct telemetry *telemetry, uint32_t index,
                     float temperature_c)
{
    unsigned least = log->block_count / 2 > READINGS_MIN ? log->block_count / 2 : READINGS_MIN;
    for (unsigned i = 0; i < MR_GAGES; i++)
        log->tension_lb[i] = log->count[i] >= least ? log->sum[i] / (float)log->count[i] : MR_NAN;
    log->unsent_gages = MR_GAGES;
    TELEMETRY_SEND(telemetry, TO_LINKS, slow_row, SLOW_ROW, .block = index,
                   .temperature_c = temperature_c, .row = ++log->row);
}

void slowlog_on_block(struct slowlog *log, struct telemetry *telemetry, uint32_t index,
                      const float *tension_lb, float temperature_c, bool quiet)
{
    if (log->unsent_gages)
        send_tensions(log, telemetry);
    if (!log->has_started)
        log->due_block = find_next_row_block(index);
    log->has_started = true;
    if (!is_at_or_after(index, log->due_block - SLOWLOG_MEAN_BLOCKS))
        return;
    if (!quiet) { /* begin again after the landing */
        slowlog_reset(log);
        log->due_block = index + SLOWLOG_MEAN_BLOCKS;
        return;
    }
    log->block_count++;
    for (unsigned i = 0; i < MR_GAGES; i++) {
        if (__builtin_isnan(tension_lb[i]))
            continue;
        log->sum[i] += tension_lb[i];
        log->count[i]++;
    }
    if (!is_at_or_after(index, log->due_block))
        return;
    make_row(log, telemetry, index, temperature_c);
    slowlog_reset(log);
    log->due_block = find_next_row_block(index);
}
