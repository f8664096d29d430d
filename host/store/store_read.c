#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

enum mr_status store_landings(struct store *store, struct store_landing **rows, size_t *count,
                              struct error *error)
{
    STORE_ROWS(LANDINGS);
}

enum mr_status store_landing_get(struct store *store, int64_t run, struct store_landing *landing,
                                 struct error *error)
{
    enum mr_status status = STORE_ONE(store, error, LANDING_GET, landing, BIND(run));
    return status != MR_TOO_FEW
             ? status
             : error_set(error, MR_UNKNOWN,
                         "no such landing: RUN %lld in %s; matrig show DB lists them",
                         (long long)run, store->path);
}

enum mr_status store_session_get(struct store *store, int64_t session,
                                 struct store_session_row *row, struct error *error)
{
    enum mr_status status = STORE_ONE(store, error, SESSION_GET, row, BIND(session));
    return status != MR_TOO_FEW ? status
                                : error_set(error, MR_MALFORMED,
                                            "session %lld is missing: %s; the database is damaged",
                                            (long long)session, store->path);
}

enum mr_status store_link_get(struct store *store, int64_t session, int link,
                              struct store_link_counts *counts, bool *found, struct error *error)
{
    enum mr_status status = STORE_ONE(store, error, LINK_GET, counts, BIND(session), BIND(link));
    *found = status == MR_OK;
    return status == MR_TOO_FEW ? MR_OK : status;
}

static enum mr_status read_calibration(struct store *store, int64_t run,
                                       struct mr_channel_config *channels, struct error *error)
{
    sqlite3_stmt *s;
    struct store_calibration row;
    enum mr_status status = STORE_QUERY(store, error, CALIBRATION, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, CALIBRATION, s, &row)) == MR_OK) {
        if (row.index >= 0 && row.index < (int64_t)MR_CHANNELS && row.item >= 0 &&
            row.item < MR_CALIBRATION_ITEMS)
            mr_channel_item_set(&channels[row.index], (unsigned)row.item, (float)row.value);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_channels(struct store *store, int64_t run, struct mr_channel_config *channels,
                              size_t *found, struct error *error)
{
    sqlite3_stmt *s;
    struct store_channel row;
    memset(channels, 0, MR_CHANNELS * sizeof *channels);
    *found = 0;
    enum mr_status status = STORE_QUERY(store, error, CHANNELS, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, CHANNELS, s, &row)) == MR_OK) {
        if (row.index < 0 || row.index >= (int64_t)MR_CHANNELS)
            continue;
        channels[row.index] = (struct mr_channel_config){
            .kind = (uint8_t)row.kind,
            .number = (uint8_t)row.number,
            .band = (uint8_t)row.band,
            .station_ft = (float)row.station_ft,
            .unit_per_code = (float)row.unit_per_code,
            .zero_code = (float)row.zero_code,
        };
        (*found)++;
    }
    return status == MR_TOO_FEW ? read_calibration(store, run, channels, error) : status;
}

STORE_ROWS_OF_LANDING(store_switches, SWITCHES)
STORE_ROWS_OF_LANDING(store_segments, SEGMENTS)
STORE_ROWS_OF_LANDING(store_edges, EDGES)
STORE_ROWS_OF_LANDING(store_motions, MOTIONS)
STORE_ROWS_OF_LANDING(store_zones, ZONES)
STORE_ROWS_OF_LANDING(store_gaps, GAPS)
STORE_ROWS_OF_LANDING(store_time_maps, TIME_MAPS)
STORE_ROWS_OF_LANDING(store_film_frames, FILM_FRAMES)
STORE_ROWS_OF_LANDING(store_switch_events, SWITCH_EVENTS)
STORE_ROWS_OF_LANDING(store_channel_events, CHANNEL_EVENTS)

enum mr_status store_faults(struct store *store, const struct store_landing *landing,
                            struct store_fault **rows, size_t *count, struct error *error)
{
    STORE_ROWS(FAULTS, BIND(landing->session), BIND(landing->boot), BIND(landing->id));
}

enum mr_status store_troubles(struct store *store, int64_t run, int link,
                              struct store_trouble **rows, size_t *count, struct error *error)
{
    STORE_ROWS(TROUBLES, BIND(store_trouble_kind(link)), BIND(run));
}

const char *store_trouble_kind(int link)
{
    return link == 0 ? "can-link" : "serial-link";
}

enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result,
                                bool *found, struct error *error)
{
    enum mr_status status = STORE_ONE(store, error, RESULT_GET, result, BIND(run));
    *found = status == MR_OK;
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_blocks_count(struct store *store, int64_t run, int64_t *count,
                                  struct error *error)
{
    return STORE_NUMBER(store, error, BLOCKS_COUNT, count, BIND(run));
}

enum mr_status store_block_first(struct store *store, int64_t run, int64_t *index,
                                 struct error *error)
{
    return STORE_NUMBER(store, error, BLOCK_FIRST, index, BIND(run));
}

enum mr_status store_block_within(struct store *store, int64_t run, int64_t from, int64_t to,
                                  int64_t *index, struct error *error)
{
    return STORE_NUMBER(store, error, BLOCK_WITHIN, index, BIND(run), BIND(from), BIND(to));
}

enum mr_status store_frames_count(struct store *store, int64_t run, int link, int64_t *count,
                                  struct error *error)
{
    return STORE_NUMBER(store, error, FRAMES_COUNT, count, BIND(run), BIND(link));
}

enum mr_status store_frames_base(struct store *store, int64_t run, uint16_t *base,
                                 struct error *error)
{
    int64_t number = 0;
    enum mr_status status = STORE_NUMBER(store, error, FRAMES_BASE, &number, BIND(run));
    *base = (uint16_t)number;
    return status;
}

enum mr_status store_blocks_each(struct store *store, int64_t run,
                                 enum mr_status (*each)(void *context, const uint8_t *record,
                                                        size_t length),
                                 void *context, struct error *error)
{
    sqlite3_stmt *s;
    struct store_block_record row;
    enum mr_status status = STORE_QUERY(store, error, BLOCKS, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, BLOCKS, s, &row)) == MR_OK) {
        status = each(context, row.record.data, row.record.length);
        if (status != MR_OK)
            sqlite3_reset(s);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_block_links_each(struct store *store, int64_t run,
                                      void (*each)(void *context, int64_t index, int link),
                                      void *context, struct error *error)
{
    sqlite3_stmt *s;
    struct store_block_link row;
    enum mr_status status = STORE_QUERY(store, error, BLOCK_LINKS, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, BLOCK_LINKS, s, &row)) == MR_OK)
        each(context, row.index, row.link);
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_frames_each(struct store *store, int64_t run, int link,
                                 enum mr_status (*each)(void *context,
                                                        const struct store_frame *frame),
                                 void *context, struct error *error)
{
    sqlite3_stmt *s;
    struct store_received_frame row;
    enum mr_status status = STORE_QUERY(store, error, FRAMES, &s, BIND(run), BIND(link));
    while (status == MR_OK && (status = STORE_NEXT(store, error, FRAMES, s, &row)) == MR_OK) {
        struct store_frame frame = {
            .run = run,
            .link = link,
            .direction = row.direction,
            .seq = row.seq,
            .board_us = row.board_us,
            .host_us = row.host_us,
            .id = (uint32_t)row.can_id,
            .data = row.data.data,
            .length = row.data.length,
        };
        status = each(context, &frame);
        if (status != MR_OK)
            sqlite3_reset(s);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}
