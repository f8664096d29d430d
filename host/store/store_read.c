#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"

/* Room for one more element of `size` bytes in an array; false: no memory. */
static bool grow(void **rows, size_t count, size_t size)
{
    if (count & (count - 1)) /* full only at 0 and powers of two */
        return true;
    void *larger = realloc(*rows, (count ? 2 * count : 1) * size);
    if (!larger)
        return false;
    *rows = larger;
    return true;
}

/* Runs a bound query and makes an array of what `read` makes of each row. */
static enum mr_status read_rows(struct store *store, sqlite3_stmt *statement, enum mr_status status,
                                size_t size, void (*read)(sqlite3_stmt *statement, void *row), void **rows,
                                size_t *count, struct error *error)
{
    *rows = NULL;
    *count = 0;
    while (status == MR_OK && (status = store_step(store, statement, error)) == MR_OK) {
        if (!grow(rows, *count, size)) {
            store_reset(statement);
            status = error_set(error, MR_FULL, "no memory: reading %s; close other programs", store->path);
            break;
        }
        read(statement, (char *)*rows + *count * size);
        (*count)++;
    }
    if (status == MR_TOO_FEW)
        return MR_OK;
    free(*rows);
    *rows = NULL;
    *count = 0;
    return status;
}

/* Defines `enum mr_status function(store, run, rows, count, error)` that reads rows of `type`. */
#define READ_ROWS(function, type, which)                                                                 \
    enum mr_status function(struct store *store, int64_t run, type **rows, size_t *count,                \
                            struct error *error)                                                         \
    {                                                                                                    \
        sqlite3_stmt *statement;                                                                         \
        void *made;                                                                                      \
        enum mr_status status = store_query(store, error, &statement, which, run);                       \
        status = read_rows(store, statement, status, sizeof(type), function##_row, &made, count, error); \
        *rows = made;                                                                                    \
        return status;                                                                                   \
    }

static void landing_row(sqlite3_stmt *s, void *to)
{
    struct store_landing *landing = to;
    landing->id = store_integer(s, 0);
    landing->session = store_integer(s, 1);
    landing->boot = store_integer(s, 2);
    landing->board_landing = store_integer(s, 3);
    landing->armed_block = store_integer(s, 4);
    landing->armed_us = store_integer(s, 5);
    landing->state = store_integer(s, 6);
    store_text(s, 7, landing->board_uid, sizeof landing->board_uid);
    store_text(s, 8, landing->firmware, sizeof landing->firmware);
    landing->image_crc = store_integer(s, 9);
    landing->config_crc = store_integer(s, 10);
    landing->clock_source = store_integer(s, 11);
    landing->touchdown_ft = store_real(s, 12);
    landing->switch_error_ft = store_real(s, 13);
    store_text(s, 14, landing->image_commit, sizeof landing->image_commit);
}

enum mr_status store_landings(struct store *store, struct store_landing **rows, size_t *count,
                              struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_LANDINGS);
    status = read_rows(store, statement, status, sizeof **rows, landing_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_landing_get(struct store *store, int64_t run, struct store_landing *landing,
                                 struct error *error)
{
    sqlite3_stmt *statement;
    enum mr_status status = store_query(store, error, &statement, STORE_LANDING_GET, run);
    if (status == MR_OK)
        status = store_step(store, statement, error);
    if (status == MR_TOO_FEW)
        return error_set(error, MR_UNKNOWN,
                         "no such landing: RUN %lld in %s; matrig report lists the landings", (long long)run,
                         store->path);
    if (status != MR_OK)
        return status;
    landing_row(statement, landing);
    store_reset(statement);
    return MR_OK;
}

enum mr_status store_session_get(struct store *store, int64_t session, struct store_session_row *row,
                                 struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = store_query(store, error, &s, STORE_SESSION_GET, session);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status == MR_TOO_FEW)
        return error_set(error, MR_MALFORMED, "session %lld is missing: %s; the database is damaged",
                         (long long)session, store->path);
    if (status != MR_OK)
        return status;
    row->started_us = store_integer(s, 0);
    row->ended_us = store_integer(s, 1);
    store_text(s, 2, row->ended_by, sizeof row->ended_by);
    store_text(s, 3, row->can_link, sizeof row->can_link);
    store_text(s, 4, row->serial_link, sizeof row->serial_link);
    store_reset(s);
    return MR_OK;
}

enum mr_status store_link_get(struct store *store, int64_t session, int link,
                              struct store_link_counts *counts, bool *found, struct error *error)
{
    sqlite3_stmt *statement;
    *found = false;
    enum mr_status status = store_query(store, error, &statement, STORE_LINK_GET, session, (int64_t)link);
    if (status == MR_OK)
        status = store_step(store, statement, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *counts = (struct store_link_counts){store_integer(statement, 0), store_integer(statement, 1),
                                         store_integer(statement, 2), store_integer(statement, 3),
                                         store_integer(statement, 4)};
    *found = true;
    store_reset(statement);
    return MR_OK;
}

static enum mr_status read_calibration(struct store *store, int64_t run, struct mr_channel_config *channels,
                                       struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = store_query(store, error, &s, STORE_CALIBRATION, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        int64_t index = store_integer(s, 0), item = store_integer(s, 1);
        if (index >= 0 && index < (int64_t)MR_CHANNELS && item >= 0 && item < MR_CALIBRATION_ITEMS)
            mr_channel_item_set(&channels[index], (unsigned)item, (float)store_real(s, 2));
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_channels(struct store *store, int64_t run, struct mr_channel_config *channels,
                              size_t *found, struct error *error)
{
    sqlite3_stmt *s;
    memset(channels, 0, MR_CHANNELS * sizeof *channels);
    *found = 0;
    enum mr_status status = store_query(store, error, &s, STORE_CHANNELS, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        int64_t index = store_integer(s, 0);
        if (index < 0 || index >= (int64_t)MR_CHANNELS)
            continue;
        channels[index] = (struct mr_channel_config){
            .kind = (uint8_t)store_integer(s, 1),
            .number = (uint8_t)store_integer(s, 2),
            .band = (uint8_t)store_integer(s, 3),
            .station_ft = (float)store_real(s, 4),
            .unit_per_code = (float)store_real(s, 5),
            .zero_code = (float)store_real(s, 6),
        };
        (*found)++;
    }
    return status == MR_TOO_FEW ? read_calibration(store, run, channels, error) : status;
}

static void store_switches_row(sqlite3_stmt *s, void *to)
{
    *(struct store_switch *)to =
        (struct store_switch){store_integer(s, 0), store_integer(s, 1), store_real(s, 2)};
}
READ_ROWS(store_switches, struct store_switch, STORE_SWITCHES)

static void store_segments_row(sqlite3_stmt *s, void *to)
{
    *(struct store_segment *)to = (struct store_segment){
        store_integer(s, 0), store_integer(s, 1), store_real(s, 2), store_real(s, 3), store_real(s, 4)};
}
READ_ROWS(store_segments, struct store_segment, STORE_SEGMENTS)

static void store_edges_row(sqlite3_stmt *s, void *to)
{
    *(struct store_edge *)to =
        (struct store_edge){store_integer(s, 0), store_integer(s, 1), store_real(s, 2),
                            store_integer(s, 3), store_real(s, 4),    store_integer(s, 5)};
}
READ_ROWS(store_edges, struct store_edge, STORE_EDGES)

static void store_motions_row(sqlite3_stmt *s, void *to)
{
    *(struct store_motion *)to =
        (struct store_motion){store_integer(s, 0), store_real(s, 1), store_real(s, 2), store_real(s, 3),
                              store_real(s, 4),    store_real(s, 5), store_real(s, 6), store_integer(s, 7)};
}
READ_ROWS(store_motions, struct store_motion, STORE_MOTIONS)

static void store_zones_row(sqlite3_stmt *s, void *to)
{
    *(struct store_zone *)to = (struct store_zone){
        store_integer(s, 0), store_integer(s, 1), store_real(s, 2),    store_real(s, 3),   store_real(s, 4),
        store_real(s, 5),    store_integer(s, 6), store_integer(s, 7), store_integer(s, 8)};
}
READ_ROWS(store_zones, struct store_zone, STORE_ZONES)

static void store_gaps_row(sqlite3_stmt *s, void *to)
{
    struct store_gap *gap = to;
    gap->link = (int)store_integer(s, 0);
    store_text(s, 1, gap->message, sizeof gap->message);
    store_text(s, 2, gap->channels, sizeof gap->channels);
    store_text(s, 3, gap->cause, sizeof gap->cause);
    gap->count = store_integer(s, 4);
    gap->from_block = store_integer(s, 5);
    gap->to_block = store_integer(s, 6);
}
READ_ROWS(store_gaps, struct store_gap, STORE_GAPS)

static void store_time_maps_row(sqlite3_stmt *s, void *to)
{
    *(struct store_time_map *)to = (struct store_time_map){
        store_integer(s, 0), store_integer(s, 1), store_integer(s, 2),  store_integer(s, 3), store_integer(s, 4),
        store_integer(s, 5), store_integer(s, 6), store_integer(s, 7),  store_real(s, 8),    store_real(s, 9),
        store_real(s, 10),   store_integer(s, 11), store_integer(s, 12), store_real(s, 13)};
}
READ_ROWS(store_time_maps, struct store_time_map, STORE_TIME_MAPS)

static void store_film_frames_row(sqlite3_stmt *s, void *to)
{
    *(struct store_film_frame *)to =
        (struct store_film_frame){store_integer(s, 0), store_integer(s, 1), store_real(s, 2), store_integer(s, 3)};
}
READ_ROWS(store_film_frames, struct store_film_frame, STORE_FILM_FRAMES)

static void fault_row(sqlite3_stmt *s, void *to)
{
    *(struct store_fault *)to = (struct store_fault){store_integer(s, 0), store_integer(s, 1),
                                                     store_integer(s, 2), store_integer(s, 3)};
}

enum mr_status store_faults(struct store *store, const struct store_landing *landing,
                            struct store_fault **rows, size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status =
        store_query(store, error, &statement, STORE_FAULTS, landing->session, landing->boot, landing->id);
    status = read_rows(store, statement, status, sizeof **rows, fault_row, &made, count, error);
    *rows = made;
    return status;
}

static void trouble_row(sqlite3_stmt *s, void *to)
{
    *(struct store_trouble *)to = (struct store_trouble){store_integer(s, 0), store_integer(s, 1)};
}

static enum mr_status troubles_of_kind(struct store *store, int64_t run, const char *kind, struct store_trouble **rows,
                                       size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_TROUBLES, kind, run);
    status = read_rows(store, statement, status, sizeof **rows, trouble_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_troubles(struct store *store, int64_t run, int link, struct store_trouble **rows,
                              size_t *count, struct error *error)
{
    return troubles_of_kind(store, run, store_trouble_kind(link), rows, count, error);
}

enum mr_status store_doubts(struct store *store, int64_t run, struct store_trouble **rows, size_t *count, struct error *error)
{
    return troubles_of_kind(store, run, STORE_DOUBT_KIND, rows, count, error);
}

enum mr_status store_switch_events(struct store *store, int64_t run, struct store_fault **rows, size_t *count,
                                   struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_SWITCH_EVENTS, run);
    status = read_rows(store, statement, status, sizeof **rows, fault_row, &made, count, error);
    *rows = made;
    return status;
}

enum mr_status store_channel_events(struct store *store, int64_t run, struct store_fault **rows, size_t *count,
                                    struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_CHANNEL_EVENTS, run);
    status = read_rows(store, statement, status, sizeof **rows, fault_row, &made, count, error);
    *rows = made;
    return status;
}

const char *store_trouble_kind(int link)
{
    return link == 0 ? "can-link" : "serial-link";
}

enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result, bool *found,
                                struct error *error)
{
    sqlite3_stmt *s;
    *found = false;
    enum mr_status status = store_query(store, error, &s, STORE_RESULT_GET, run);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *result = (struct store_result){
        store_real(s, 0), store_real(s, 1), store_real(s, 2),    store_real(s, 3),    store_real(s, 4),
        store_real(s, 5), store_real(s, 6), store_integer(s, 7), store_integer(s, 8), store_integer(s, 9)};
    *found = true;
    store_reset(s);
    return MR_OK;
}

enum mr_status store_take_integer(struct store *store, sqlite3_stmt *statement, enum mr_status status, int64_t *value,
                                  struct error *error)
{
    if (status == MR_OK)
        status = store_step(store, statement, error);
    if (status != MR_OK)
        return status;
    *value = store_integer(statement, 0);
    store_reset(statement);
    return MR_OK;
}

enum mr_status store_blocks_count(struct store *store, int64_t run, int64_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    enum mr_status status = store_query(store, error, &statement, STORE_BLOCKS_COUNT, run);
    return store_take_integer(store, statement, status, count, error);
}

enum mr_status store_frames_count(struct store *store, int64_t run, int link, int64_t *count,
                                  struct error *error)
{
    sqlite3_stmt *statement;
    enum mr_status status = store_query(store, error, &statement, STORE_FRAMES_COUNT, run, (int64_t)link);
    return store_take_integer(store, statement, status, count, error);
}

enum mr_status store_blocks_each(struct store *store, int64_t run,
                                 enum mr_status (*each)(void *context, const uint8_t *record, size_t length),
                                 void *context, struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = store_query(store, error, &s, STORE_BLOCKS, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        status = each(context, sqlite3_column_blob(s, 0), (size_t)sqlite3_column_bytes(s, 0));
        if (status != MR_OK)
            store_reset(s);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_block_links_each(struct store *store, int64_t run, void (*each)(void *context, int64_t index, int link),
                                      void *context, struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = store_query(store, error, &s, STORE_BLOCK_LINKS, run);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK)
        each(context, store_integer(s, 0), (int)store_integer(s, 1));
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_frames_each(struct store *store, int64_t run, int link,
                                 enum mr_status (*each)(void *context, const struct store_frame *frame),
                                 void *context, struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = store_query(store, error, &s, STORE_FRAMES, run, (int64_t)link);
    while (status == MR_OK && (status = store_step(store, s, error)) == MR_OK) {
        struct store_frame frame = {
            .run = run,
            .link = link,
            .direction = (int)store_integer(s, 0),
            .seq = store_integer(s, 1),
            .board_us = store_integer(s, 2),
            .host_us = store_integer(s, 3),
            .id = (uint32_t)store_integer(s, 4),
            .data = sqlite3_column_blob(s, 5),
            .length = (size_t)sqlite3_column_bytes(s, 5),
        };
        status = each(context, &frame);
        if (status != MR_OK)
            store_reset(s);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

/* A blob of floats; NULL: it is absent. */
static float *floats(sqlite3_stmt *s, int column, size_t *length)
{
    size_t bytes = (size_t)sqlite3_column_bytes(s, column);
    float *values = bytes ? malloc(bytes) : NULL;
    *length = values ? bytes / sizeof *values : 0;
    if (values)
        memcpy(values, sqlite3_column_blob(s, column), bytes);
    return values;
}

static void simulation_row(sqlite3_stmt *s, void *to)
{
    struct store_simulation *row = to;
    *row = (struct store_simulation){
        .number = store_integer(s, 0),
        .station_ft = store_real(s, 1),
        .peak_measured_in = store_real(s, 2),
        .peak_measured_error_in = store_real(s, 3),
        .peak_simulated_in = store_real(s, 4),
        .peak_simulated_error_in = store_real(s, 5),
        .rms_in = store_real(s, 6),
        .end_measured_in = store_real(s, 7),
        .end_simulated_in = store_real(s, 8),
        .t0_s = store_real(s, 9),
        .dt_s = store_real(s, 10),
    };
    size_t spreads = 0;
    row->series_in = floats(s, 11, &row->length);
    row->spread_in = floats(s, 12, &spreads);
    if (spreads != row->length) {
        free(row->spread_in);
        row->spread_in = NULL;
    }
}

enum mr_status store_simulations(struct store *store, int64_t run, struct store_simulation **rows,
                                 size_t *count, struct error *error)
{
    sqlite3_stmt *statement;
    void *made;
    enum mr_status status = store_query(store, error, &statement, STORE_SIMULATIONS, run);
    status = read_rows(store, statement, status, sizeof **rows, simulation_row, &made, count, error);
    *rows = made;
    return status;
}

void store_simulations_free(struct store_simulation *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        free(rows[i].series_in);
        free(rows[i].spread_in);
    }
    free(rows);
}

enum mr_status store_simulation_head(struct store *store, int64_t run, struct store_simulation_head *head, struct error *error)
{
    sqlite3_stmt *s;
    *head = (struct store_simulation_head){.seeds = STORE_NONE, .edges = STORE_NONE, .run_ms = (double)NAN, .error_in = (double)NAN};
    enum mr_status status = store_query(store, error, &s, STORE_SIMULATION_HEAD, run);
    if (status == MR_OK)
        status = store_step(store, s, error);
    if (status == MR_TOO_FEW)
        return MR_OK;
    if (status != MR_OK)
        return status;
    size_t values;
    *head = (struct store_simulation_head){
        .run_ms = store_real(s, 0),
        .error_in = store_real(s, 1),
        .seeds = store_integer(s, 2),
        .edges = store_integer(s, 3),
        .offset_s = store_real(s, 4),
        .scatter_s = store_real(s, 5),
        .segments_dt_s = store_real(s, 6),
    };
    head->segments_in = floats(s, 7, &values);
    head->segment_rows = values / MR_SEGMENTS;
    store_text(s, 8, head->file, sizeof head->file);
    store_reset(s);
    return MR_OK;
}
