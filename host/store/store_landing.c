#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/version.h"
#include "common/wire.h"
#include "host/base/xmalloc.h"
#include "host/store/store.h"
#include "host/store/table.h"

#define DEFINE_LANDING_ROWS_GET(function, row, NAME)                                     \
    enum mr_status function(struct store *store, int64_t run, struct store_##row **rows, \
                            size_t *count, struct error *error)                          \
    {                                                                                    \
        STORE_RETURN_ROWS(NAME, STORE_BIND(run));                                        \
    }
STORE_LANDING_ROW_FUNCTIONS(DEFINE_LANDING_ROWS_GET)

#define DEFINE_LANDING_PUT(row)                                                            \
    enum mr_status store_##row##_put(struct store *store, int64_t run,                     \
                                     const struct store_##row *value, struct error *error) \
    {                                                                                      \
        return STORE_PUT(store, error, row, value, run);                                   \
    }
STORE_LANDING_PUT_FUNCTIONS(DEFINE_LANDING_PUT)

#define DEFINE_CAMPAIGN_ROWS_GET(function, row, NAME)                                      \
    enum mr_status function(struct store *store, struct store_##row **rows, size_t *count, \
                            struct error *error)                                           \
    {                                                                                      \
        STORE_RETURN_ROWS(NAME);                                                           \
    }
STORE_CAMPAIGN_ROW_FUNCTIONS(DEFINE_CAMPAIGN_ROWS_GET)

#define DEFINE_CAMPAIGN_PUT(function, row)                                        \
    enum mr_status function(struct store *store, const struct store_##row *value, \
                            struct error *error)                                  \
    {                                                                             \
        return STORE_PUT(store, error, row, value);                               \
    }
STORE_CAMPAIGN_PUT_FUNCTIONS(DEFINE_CAMPAIGN_PUT)

#define DEFINE_CAMPAIGN_NUMBER_GET(function, NAME)                                    \
    enum mr_status function(struct store *store, int64_t *value, struct error *error) \
    {                                                                                 \
        return STORE_READ_NUMBER(store, error, NAME, value);                          \
    }
STORE_CAMPAIGN_NUMBER_FUNCTIONS(DEFINE_CAMPAIGN_NUMBER_GET)

#define DEFINE_LANDING_NUMBER_GET(function, NAME)                                                  \
    enum mr_status function(struct store *store, int64_t run, int64_t *value, struct error *error) \
    {                                                                                              \
        return STORE_READ_NUMBER(store, error, NAME, value, STORE_BIND(run));                      \
    }
STORE_LANDING_NUMBER_FUNCTIONS(DEFINE_LANDING_NUMBER_GET)

enum mr_status store_landing_get(struct store *store, int64_t run, struct store_landing *landing,
                                 struct error *error)
{
    int64_t found = 0;
    char number[60] = "";
    enum mr_status status = STORE_READ_ONE(store, error, LANDING_GET, landing, STORE_BIND(run));
    if (status != MR_TOO_FEW)
        return status;
    if (STORE_READ_NUMBER(store, error, LANDING_BY_NUMBER, &found, STORE_BIND(run)) == MR_OK &&
        found > 0)
        snprintf(number, sizeof number, " (landing %lld of the board is RUN %lld)", (long long)run,
                 (long long)found);
    return error_set(error, MR_UNKNOWN,
                     "no such landing: RUN %lld in %s%s; matrig show DB lists the landings",
                     (long long)run, store->path, number);
}

enum mr_status store_find_run(struct store *store, int64_t *run, struct error *error)
{
    int64_t number = -*run, found = 0;
    enum mr_status status = *run < 0 ? STORE_READ_NUMBER(store, error, LANDING_BY_NUMBER, &found,
                                                         STORE_BIND(number))
                                     : MR_OK;
    if (status != MR_OK || *run >= 0)
        return status;
    *run = found;
    return found > 0
             ? MR_OK
             : error_set(
                   error, MR_UNKNOWN,
                   "%s landing with board number %lld: %s; matrig show DB lists the RUN of each",
                   found ? "more than one" : "no", (long long)number, store->path);
}

enum mr_status store_session_get(struct store *store, int64_t session,
                                 struct store_session_row *row, struct error *error)
{
    enum mr_status status = STORE_READ_ONE(store, error, SESSION_GET, row, STORE_BIND(session));
    return status != MR_TOO_FEW ? status
                                : error_set(error, MR_MALFORMED,
                                            "session %lld is missing: %s; the database is damaged, "
                                            "use a different copy of the campaign",
                                            (long long)session, store->path);
}

enum mr_status store_link_get(struct store *store, int64_t session, int link,
                              struct store_link_counts *counts, bool *found, struct error *error)
{
    enum mr_status status = STORE_READ_ONE(store, error, LINK_GET, counts, STORE_BIND(session),
                                           STORE_BIND(link));
    *found = status == MR_OK;
    return status == MR_TOO_FEW ? MR_OK : status;
}

static enum mr_status read_calibration(struct store *store, int64_t run,
                                       struct mr_channel_config *channels, struct error *error)
{
    sqlite3_stmt *s;
    struct store_calibration row;
    enum mr_status status = STORE_QUERY(store, error, CALIBRATION, &s, STORE_BIND(run));
    while (status == MR_OK &&
           (status = STORE_READ_NEXT(store, error, CALIBRATION, s, &row)) == MR_OK) {
        if (row.index >= 0 && row.index < (int64_t)MR_CHANNELS && row.item >= 0 &&
            row.item < MR_CALIBRATION_ITEM_COUNT)
            mr_channel_set_item(&channels[row.index], (unsigned)row.item, (float)row.value);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_channels_get(struct store *store, int64_t run,
                                  struct mr_channel_config *channels, size_t *found,
                                  struct error *error)
{
    sqlite3_stmt *s;
    struct store_channel row;
    memset(channels, 0, MR_CHANNELS * sizeof *channels);
    *found = 0;
    enum mr_status status = STORE_QUERY(store, error, CHANNELS, &s, STORE_BIND(run));
    while (status == MR_OK &&
           (status = STORE_READ_NEXT(store, error, CHANNELS, s, &row)) == MR_OK) {
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

enum mr_status store_faults_get(struct store *store, const struct store_landing *landing,
                                struct store_fault **rows, size_t *count, struct error *error)
{
    STORE_RETURN_ROWS(FAULTS, STORE_BIND(landing->session), STORE_BIND(landing->boot),
                      STORE_BIND(landing->id));
}

enum mr_status store_link_errors_get(struct store *store, int64_t run, int link,
                                     struct store_link_error **rows, size_t *count,
                                     struct error *error)
{
    STORE_RETURN_ROWS(LINK_ERRORS, STORE_BIND(store_link_error_event_kind(link)), STORE_BIND(run));
}

const char *store_link_error_event_kind(int link)
{
    return link == 0 ? "can-link" : "serial-link";
}

enum mr_status store_result_get(struct store *store, int64_t run, struct store_result *result,
                                bool *found, struct error *error)
{
    enum mr_status status = STORE_READ_ONE(store, error, RESULT_GET, result, STORE_BIND(run));
    *found = status == MR_OK;
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_find_block_within(struct store *store, int64_t run, int64_t from, int64_t to,
                                       int64_t *index, struct error *error)
{
    return STORE_READ_NUMBER(store, error, BLOCK_WITHIN, index, STORE_BIND(run), STORE_BIND(from),
                             STORE_BIND(to));
}

enum mr_status store_frames_count(struct store *store, int64_t run, int link, int64_t *count,
                                  struct error *error)
{
    return STORE_READ_NUMBER(store, error, FRAMES_COUNT, count, STORE_BIND(run), STORE_BIND(link));
}

enum mr_status store_can_base_get(struct store *store, int64_t run, uint16_t *base,
                                  struct error *error)
{
    int64_t number = 0;
    enum mr_status status = STORE_READ_NUMBER(store, error, CAN_BASE, &number, STORE_BIND(run));
    *base = (uint16_t)number;
    return status;
}

enum mr_status store_blocks_for_each(struct store *store, int64_t run,
                                     enum mr_status (*each)(void *context, const uint8_t *record,
                                                            size_t length, int link),
                                     void *context, struct error *error)
{
    sqlite3_stmt *s;
    struct store_block_record row;
    enum mr_status status = STORE_QUERY(store, error, BLOCKS, &s, STORE_BIND(run));
    while (status == MR_OK && (status = STORE_READ_NEXT(store, error, BLOCKS, s, &row)) == MR_OK) {
        status = each(context, row.record.data, row.record.length, row.link);
        if (status != MR_OK)
            sqlite3_reset(s);
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_block_indexes_for_each(struct store *store, int64_t run,
                                            void (*each)(void *context, int64_t index),
                                            void *context, struct error *error)
{
    sqlite3_stmt *s;
    struct store_block_index row;
    enum mr_status status = STORE_QUERY(store, error, BLOCK_INDEXES, &s, STORE_BIND(run));
    while (status == MR_OK &&
           (status = STORE_READ_NEXT(store, error, BLOCK_INDEXES, s, &row)) == MR_OK)
        each(context, row.index);
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_frames_for_each(struct store *store, int64_t run, int link,
                                     enum mr_status (*each)(void *context,
                                                            const struct store_frame *frame),
                                     void *context, struct error *error)
{
    sqlite3_stmt *s;
    struct store_received_frame row;
    enum mr_status status = STORE_QUERY(store, error, FRAMES, &s, STORE_BIND(run),
                                        STORE_BIND(link));
    while (status == MR_OK && (status = STORE_READ_NEXT(store, error, FRAMES, s, &row)) == MR_OK) {
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

/* ---- writing ---- */

enum mr_status store_session_add(struct store *store, struct store_session *session,
                                 struct error *error)
{
    struct store_session row = *session;
    row.ended_us = STORE_NONE; /* not ended */
    row.ended_by = NULL;
    row.matrig = VERSION_TEXT;
    enum mr_status status = STORE_PUT(store, error, session, &row);
    session->id = sqlite3_last_insert_rowid(store->database);
    return status;
}

enum mr_status store_session_end(struct store *store, int64_t session, int64_t ended_us,
                                 const char *ended_by, struct error *error)
{
    return STORE_RUN_STATEMENT(store, error, SESSION_END, STORE_BIND(ended_us),
                               STORE_BIND(ended_by), STORE_BIND(session));
}

enum mr_status store_link_put(struct store *store, int64_t session, int link,
                              const struct store_link_counts *counts, struct error *error)
{
    return STORE_PUT(store, error, link_counts, counts, session, link);
}

enum mr_status store_missing_put(struct store *store, int64_t session, int link,
                                 const char *message, int64_t missing, struct error *error)
{
    const struct store_missing row = {.message = message, .missing = missing};
    return STORE_PUT(store, error, missing, &row, session, link);
}

enum mr_status store_landing_add(struct store *store, struct store_landing *landing,
                                 struct error *error)
{
    const struct store_survey survey = {.source = "board"};
    enum mr_status status = STORE_PUT(store, error, landing, landing);
    landing->id = sqlite3_last_insert_rowid(store->database);
    return status == MR_OK ? STORE_PUT(store, error, survey, &survey, landing->id) : status;
}

enum mr_status store_landing_put(struct store *store, const struct store_landing *landing,
                                 struct error *error)
{
    return STORE_UPDATE(store, error, landing, landing, landing->id);
}

enum mr_status store_channel_put(struct store *store, int64_t run, int64_t index,
                                 const struct mr_channel_config *channel, struct error *error)
{
    const struct store_channel row = {.index = index,
                                      .kind = channel->kind,
                                      .number = channel->number,
                                      .band = channel->band,
                                      .station_ft = (double)channel->station_ft,
                                      .unit_per_code = (double)channel->unit_per_code,
                                      .zero_code = (double)channel->zero_code};
    return STORE_PUT(store, error, channel, &row, run);
}

enum mr_status store_segment_put(struct store *store, int64_t run,
                                 const struct store_segment *segment, struct error *error)
{
    int64_t survey = STORE_NONE;
    enum mr_status status = STORE_READ_NUMBER(store, error, SURVEY_OF, &survey, STORE_BIND(run));
    return status == MR_OK || status == MR_TOO_FEW
             ? STORE_PUT(store, error, segment, segment, survey)
             : status;
}

enum mr_status store_block_put(struct store *store, int64_t session, int64_t boot, int64_t run,
                               int link, int64_t index, int64_t host_us, const uint8_t *record,
                               size_t length, struct error *error)
{
    const struct store_block row = {.session = session,
                                    .boot = boot,
                                    .index = index,
                                    .run = run,
                                    .host_us = host_us,
                                    .record = {record, length},
                                    .link = link};
    return STORE_PUT(store, error, block, &row);
}

enum mr_status store_edge_reject(struct store *store, int64_t run, int64_t count,
                                 struct error *error)
{
    return STORE_RUN_STATEMENT(store, error, EDGE_REJECT, STORE_BIND(run), STORE_BIND(count));
}

enum mr_status store_gap_put(struct store *store, int64_t session, int64_t run,
                             const struct store_gap *gap, struct error *error)
{
    return STORE_PUT(store, error, gap, gap, session, run);
}

/* ---- configuration ---- */

enum mr_status store_configuration_put(struct store *store, uint32_t crc, const char *text,
                                       struct error *error)
{
    const struct store_configuration row = {.crc = crc, .text = text};
    return STORE_PUT(store, error, configuration, &row);
}

enum mr_status store_configuration_get(struct store *store, uint32_t crc, char **text,
                                       struct error *error)
{
    sqlite3_stmt *statement;
    struct store_configuration row;
    *text = NULL;
    enum mr_status status = STORE_QUERY(store, error, CONFIGURATION_GET, &statement,
                                        STORE_BIND(crc));
    if (status == MR_OK)
        status = STORE_READ_NEXT(store, error, CONFIGURATION_GET, statement, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *text = strdup(row.text ? row.text : "");
    sqlite3_reset(statement);
    return *text ? MR_OK
                 : error_set(error, MR_FULL, "out of memory, reading %s; close other programs",
                             store->path);
}

/* ---- messages that the board repeats during a landing, and the slow log ---- */

enum mr_status store_mean_get(struct store *store, int64_t run, enum mr_quantity quantity,
                              struct store_mean *mean, struct error *error)
{
    *mean = (struct store_mean){0};
    switch ((int)quantity) {
/* clang-format off */
#define LANDING_MEAN(name, NAME, quantity, table, column, error_column, why) \
    case MR_QUANTITY_##quantity:                                             \
        return STORE_READ_ONE(store, error, MEAN_##quantity, mean, STORE_BIND(run));
/* clang-format on */
#include "common/catalogue.def"
    default: return MR_OK;
    }
}

enum mr_status store_slow_log_get(struct store *store, const char *board_uid,
                                  struct store_slow **rows, size_t *count, struct error *error)
{
    STORE_RETURN_ROWS(SLOW_ROWS, STORE_BIND(board_uid));
}

/* ---- comparisons of landings with a simulation ---- */

/* Fields that struct store_simulation and struct store_simulation_channel have in common. */
/* clang-format off */
#define SIMULATION_COMMON_FIELDS(from) \
    .number = (from)->number, .station_ft = (from)->station_ft,                            \
    .peak_measured_in = (from)->peak_measured_in,                                          \
    .peak_measured_error_in = (from)->peak_measured_error_in,                              \
    .peak_simulated_in = (from)->peak_simulated_in,                                        \
    .peak_simulated_error_in = (from)->peak_simulated_error_in, .rms_in = (from)->rms_in,  \
    .end_measured_in = (from)->end_measured_in,                                            \
    .end_simulated_in = (from)->end_simulated_in, .t0_s = (from)->t0_s, .dt_s = (from)->dt_s
/* clang-format on */

static enum mr_status put_simulation_channel(struct store *store, int64_t simulation,
                                             const struct store_simulation *from,
                                             struct error *error)
{
    const size_t bytes = from->length * sizeof *from->series_in;
    const struct store_simulation_channel row = {
        SIMULATION_COMMON_FIELDS(from),
        .series_in = {from->series_in, bytes},
        .spread_in = {from->spread_in, from->spread_in ? bytes : 0},
    };
    return STORE_PUT(store, error, simulation_channel, &row, simulation);
}

enum mr_status store_simulation_put(struct store *store, int64_t run, const char *scene_json,
                                    int64_t made_us, const struct store_simulation_summary *head,
                                    const struct store_simulation *rows, size_t count,
                                    struct error *error)
{
    const struct store_simulation_row row = {
        .scene = scene_json,
        .made_us = made_us,
        .run_ms = head->run_ms,
        .error_in = head->error_in,
        .seeds = head->seeds,
        .segments_dt_s = head->segments_dt_s,
        .segments_in = {head->segments_in,
                        head->segment_rows * MR_SEGMENTS * sizeof *head->segments_in},
    };
    enum mr_status status = STORE_PUT(store, error, simulation_row, &row, run);
    int64_t id = sqlite3_last_insert_rowid(store->database);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = put_simulation_channel(store, id, &rows[i], error);
    return status;
}

/* Copies a blob of floats. Returns NULL if it is empty. */
static float *copy_floats(const struct store_bytes *bytes, size_t *length)
{
    float *values = bytes->length ? malloc(bytes->length) : NULL;
    *length = values ? bytes->length / sizeof *values : 0;
    if (values)
        memcpy(values, bytes->data, bytes->length);
    return values;
}

static struct store_simulation make_simulation(const struct store_simulation_channel *row)
{
    struct store_simulation simulation = {
        SIMULATION_COMMON_FIELDS(row),
    };
    size_t spreads = 0;
    simulation.series_in = copy_floats(&row->series_in, &simulation.length);
    simulation.spread_in = copy_floats(&row->spread_in, &spreads);
    if (spreads != simulation.length) {
        free(simulation.spread_in);
        simulation.spread_in = NULL;
    }
    return simulation;
}

enum mr_status store_simulations_get(struct store *store, int64_t run,
                                     struct store_simulation **rows, size_t *count,
                                     struct error *error)
{
    sqlite3_stmt *s;
    struct store_simulation_channel row;
    *rows = NULL;
    *count = 0;
    enum mr_status status = STORE_QUERY(store, error, SIMULATIONS, &s, STORE_BIND(run));
    while (status == MR_OK &&
           (status = STORE_READ_NEXT(store, error, SIMULATIONS, s, &row)) == MR_OK) {
        if (!list_grow(rows, *count, sizeof **rows)) {
            sqlite3_reset(s);
            status = error_set(error, MR_FULL, "out of memory, reading %s; close other programs",
                               store->path);
            break;
        }
        (*rows)[(*count)++] = make_simulation(&row);
    }
    if (status == MR_TOO_FEW)
        return MR_OK;
    store_simulations_free(*rows, *count);
    *rows = NULL;
    *count = 0;
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

enum mr_status store_simulation_summary_get(struct store *store, int64_t run,
                                            struct store_simulation_summary *head,
                                            struct error *error)
{
    sqlite3_stmt *s;
    struct store_simulation_row row;
    size_t values;
    *head = (struct store_simulation_summary){
        .seeds = STORE_NONE, .run_ms = (double)NAN, .error_in = (double)NAN};
    enum mr_status status = STORE_QUERY(store, error, SIMULATION_HEAD, &s, STORE_BIND(run));
    if (status == MR_OK)
        status = STORE_READ_NEXT(store, error, SIMULATION_HEAD, s, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *head = (struct store_simulation_summary){
        .run_ms = row.run_ms,
        .error_in = row.error_in,
        .seeds = row.seeds,
        .segments_dt_s = row.segments_dt_s,
    };
    head->segments_in = copy_floats(&row.segments_in, &values);
    head->segment_rows = values / MR_SEGMENTS;
    snprintf(head->file, sizeof head->file, "%s", row.file);
    sqlite3_reset(s);
    return MR_OK;
}

/* ---- bands ---- */

enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error)
{
    return STORE_PUT(store, error, shunt, shunt, session, boot);
}

enum mr_status store_shunts_before_get(struct store *store, int64_t session, int64_t boot,
                                       int64_t block, struct store_shunt **rows, size_t *count,
                                       struct error *error)
{
    STORE_RETURN_ROWS(SHUNTS_BEFORE, STORE_BIND(session), STORE_BIND(boot), STORE_BIND(block));
}

enum mr_status store_shunts_after_get(struct store *store, int64_t session, int64_t boot,
                                      int64_t block, struct store_shunt **rows, size_t *count,
                                      struct error *error)
{
    STORE_RETURN_ROWS(SHUNTS_AFTER, STORE_BIND(session), STORE_BIND(boot), STORE_BIND(block));
}

/* ---- the predictor ---- */

enum mr_status store_runway_put(struct store *store, int64_t run,
                                const struct mr_predictor_state *state, int64_t source,
                                struct error *error)
{
    uint8_t image[MR_RUNWAY_IMAGE_BYTES];
    mr_runway_encode(state, 0, image);
    const struct store_runway row = {.mats = state->mats,
                                     .landings = state->landing_count,
                                     .resistance = (double)state->resistance_scale,
                                     .source = source,
                                     .crc = mr_runway_crc(state),
                                     .state = {image, sizeof image}};
    return STORE_PUT(store, error, runway, &row, run);
}

enum mr_status store_runway_get(struct store *store, int64_t run, struct mr_predictor_state *state,
                                int64_t *source, bool *found, struct error *error)
{
    sqlite3_stmt *s;
    struct store_runway row;
    uint32_t sequence;
    *found = false;
    enum mr_status status = STORE_QUERY(store, error, RUNWAY_GET, &s, STORE_BIND(run));
    if (status == MR_OK)
        status = STORE_READ_NEXT(store, error, RUNWAY_GET, s, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *source = row.source;
    *found = row.state.length == MR_RUNWAY_IMAGE_BYTES &&
             mr_runway_decode(state, &sequence, row.state.data) == MR_OK;
    sqlite3_reset(s);
    return *found
             ? MR_OK
             : error_set(
                   error, MR_MALFORMED,
                   "the runway of RUN %lld is damaged: %s; use a different copy of the campaign",
                   (long long)run, store->path);
}

enum mr_status store_predict_config_get(struct store *store, int64_t run,
                                        struct mr_predictor_config *config, size_t *items,
                                        struct error *error)
{
    struct store_predict_item *rows;
    memset(config, 0, sizeof *config);
    enum mr_status status = store_predict_items_get(store, run, &rows, items, error);
    for (size_t i = 0; status == MR_OK && i < *items; i++)
        mr_predict_set_item(config, (unsigned)rows[i].item, (float)rows[i].value);
    free(rows);
    return status;
}

enum mr_status store_risk_plan_get(struct store *store, int64_t run, struct mr_risk_plan *plan,
                                   float *lamp_limit, size_t *items, struct error *error)
{
    struct store_risk_item *rows;
    mr_risk_plan_clear(plan);
    *lamp_limit = MR_NAN;
    enum mr_status status = store_risk_items_get(store, run, &rows, items, error);
    for (size_t i = 0; status == MR_OK && i < *items; i++) {
        if (!mr_risk_plan_set_item(plan, (unsigned)rows[i].item, (float)rows[i].value))
            *lamp_limit = (float)rows[i].value;
    }
    free(rows);
    return status;
}

/* ---- imports ---- */

enum mr_status store_import_get(struct store *store, int64_t session, struct store_import *import,
                                bool *found, struct error *error)
{
    sqlite3_stmt *s;
    enum mr_status status = STORE_QUERY(store, error, IMPORT_GET, &s, STORE_BIND(session));
    if (status == MR_OK)
        status = STORE_READ_NEXT(store, error, IMPORT_GET, s, import);
    *found = status == MR_OK;
    if (*found)
        sqlite3_reset(s);
    import->mapping = NULL; /* the text of the mapping is in the row, which is no longer valid */
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_import_find(struct store *store, const struct store_import *import,
                                 uint16_t can_base, int64_t *session, struct error *error)
{
    *session = 0;
    enum mr_status status = STORE_READ_NUMBER(
        store, error, IMPORT_FIND, session, STORE_BIND(import->sha256), STORE_BIND(import->mapping),
        STORE_BIND(import->bus), STORE_BIND((int64_t)can_base));
    return status == MR_TOO_FEW ? MR_OK : status;
}

enum mr_status store_imported_channel_put(struct store *store, int64_t run,
                                          const struct store_imported_channel *readings,
                                          struct error *error)
{
    const struct store_imported_row row = {
        .index = readings->index,
        .first_block = readings->first_block,
        .stride = readings->stride,
        .readings = {readings->reading, readings->count * sizeof *readings->reading}};
    return STORE_PUT(store, error, imported_row, &row, run);
}

static enum mr_status append_imported_channel(struct store *store,
                                              const struct store_imported_row *row,
                                              struct store_imported_channel **rows, size_t *count,
                                              struct error *error)
{
    size_t bytes = row->readings.length;
    if (bytes == 0 || bytes % sizeof(float) != 0)
        return MR_OK;
    float *reading = malloc(bytes);
    if (!reading || !list_grow(rows, *count, sizeof **rows)) {
        free(reading);
        return error_set(error, MR_FULL, "out of memory, reading %s; close other programs",
                         store->path);
    }
    memcpy(reading, row->readings.data, bytes);
    (*rows)[(*count)++] = (struct store_imported_channel){.index = row->index,
                                                          .first_block = row->first_block,
                                                          .stride = row->stride,
                                                          .count = bytes / sizeof(float),
                                                          .reading = reading};
    return MR_OK;
}

enum mr_status store_imported_channels_get(struct store *store, int64_t run,
                                           struct store_imported_channel **rows, size_t *count,
                                           struct error *error)
{
    sqlite3_stmt *s;
    struct store_imported_row row;
    *rows = NULL;
    *count = 0;
    enum mr_status status = STORE_QUERY(store, error, IMPORTED, &s, STORE_BIND(run));
    while (status == MR_OK &&
           (status = STORE_READ_NEXT(store, error, IMPORTED, s, &row)) == MR_OK) {
        status = append_imported_channel(store, &row, rows, count, error);
        if (status != MR_OK)
            sqlite3_reset(s);
    }
    if (status == MR_TOO_FEW)
        return MR_OK;
    store_imported_channels_free(*rows, *count);
    *rows = NULL;
    *count = 0;
    return status;
}

void store_imported_channels_free(struct store_imported_channel *rows, size_t count)
{
    for (size_t i = 0; i < count; i++)
        free(rows[i].reading);
    free(rows);
}
