#include "host/exchange/export.h"

#include <math.h>
#include <string.h>

#include "host/analyse/summary.h"
#include "host/link/timemap.h"
#include "host/link/candump.h"

/* Time stamps of a log without a time of day start at this value, because log2asc reads second 0 as
 * "no time yet". They appear as dates in 2001. */
#define UNDATED_START_US  1000000000000000.0
#define TIME_STAMP_MAX_US 9e15 /* largest number of microseconds that a double represents exactly */

struct candump_export {
    FILE *out;
    uint16_t can_base;
    bool is_dated;
    struct store_time_map time_map;
    long frame_count;
    long frames_without_time, frames_out_of_range;
};

static enum mr_status export_frame(void *context, const struct store_frame *stored)
{
    struct candump_export *export = context;
    char line[CANDUMP_LINE_SIZE];
    if (stored->board_us == STORE_NONE || stored->length > 8) {
        export->frames_without_time++;
        return MR_OK;
    }
    double board_us = (double)stored->board_us;
    double stamp_us = export->is_dated
                        ? summary_convert_to_host_time(&export->time_map, board_us).host_us
                        : UNDATED_START_US + board_us;
    if (!(stamp_us >= 0.0 && stamp_us < TIME_STAMP_MAX_US)) {
        export->frames_out_of_range++;
        return MR_OK;
    }
    struct link_frame frame = {.host_us = (uint64_t)llround(stamp_us),
                               .id = link_id_to_bus(stored->id, export->can_base),
                               .length = (uint8_t)stored->length};
    memcpy(frame.data, stored->data, stored->length);
    candump_write_line(&frame, line);
    fputs(line, export->out);
    export->frame_count++;
    return MR_OK;
}

static void note_time_problems(const struct candump_export *export, bool known,
                               const struct cli *cli)
{
    if (!export->is_dated)
        cli_note(
            cli,
            "times of day unknown: time stamps are board time after 2001-09-09 01:46:40 UTC; %s",
            known ? timemap_refusal_text((unsigned)export->time_map.refusal)
                  : "the board's clock was not tracked");
    if (export->can_base)
        cli_note(cli,
                 "the identifiers include base 0x%03x; to import the file, use matrig import "
                 "--base 0x%03x",
                 export->can_base, export->can_base);
    if (export->frames_without_time)
        cli_note(cli, "%ld frames received before the board's first clock message are left out",
                 export->frames_without_time);
    if (export->frames_out_of_range)
        cli_note(cli, "%ld frames with an impossible time are left out",
                 export->frames_out_of_range);
}

enum mr_status export_candump(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                              long *rows, struct error *error)
{
    struct candump_export export = {.out = out};
    int64_t count;
    bool known = false;
    enum mr_status status = store_frames_count(store, run, LINK_CAN, &count, error);
    if (status == MR_OK && count == 0)
        return error_set(
            error, MR_USAGE,
            "no CAN frames: RUN %lld of %s was logged without a CAN link; use --format csv",
            (long long)run, store_path(store));
    if (status == MR_OK)
        status = store_can_base_get(store, run, &export.can_base, error);
    if (status == MR_OK)
        status = summary_load_clock(store, run, &export.time_map, &known, error);
    export.is_dated = known && export.time_map.refusal == TIMEMAP_OK;
    if (status == MR_OK)
        status = store_frames_for_each(store, run, LINK_CAN, export_frame, &export, error);
    if (status == MR_OK)
        note_time_problems(&export, known, cli);
    *rows = export.frame_count;
    return status;
}
