#include "common/version.h"
#include "host/store/store_sql.h"

enum mr_status store_session_add(struct store *store, struct store_session *session,
                                 struct error *error)
{
    struct store_session row = *session;
    row.ended_us = STORE_NONE; /* it begins */
    row.ended_by = NULL;
    row.matrig = VERSION_TEXT;
    enum mr_status status = STORE_PUT(store, error, session, &row);
    session->id = sqlite3_last_insert_rowid(store->database);
    return status;
}

enum mr_status store_session_end(struct store *store, int64_t session, int64_t ended_us,
                                 const char *ended_by, struct error *error)
{
    return STORE_RUN(store, error, SESSION_END, BIND(ended_us), BIND(ended_by), BIND(session));
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
    return STORE_CHANGE(store, error, landing, landing, landing->id);
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

enum mr_status store_calibration_put(struct store *store, int64_t run, int64_t index, int64_t item,
                                     double value, struct error *error)
{
    const struct store_calibration row = {.index = index, .item = item, .value = value};
    return STORE_PUT(store, error, calibration, &row, run);
}

STORE_PUT_OF_LANDING(quality)
STORE_PUT_OF_LANDING(switch)
STORE_PUT_OF_LANDING(edge)
STORE_PUT_OF_LANDING(motion)
STORE_PUT_OF_LANDING(zone)
STORE_PUT_OF_LANDING(result)
STORE_PUT_OF_LANDING(film_frame)

enum mr_status store_segment_put(struct store *store, int64_t run,
                                 const struct store_segment *segment, struct error *error)
{
    int64_t survey = STORE_NONE;
    enum mr_status status = STORE_NUMBER(store, error, SURVEY_OF, &survey, BIND(run));
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

enum mr_status store_edge_refuse(struct store *store, int64_t run, int64_t count,
                                 struct error *error)
{
    return STORE_RUN(store, error, EDGE_REFUSE, BIND(run), BIND(count));
}

enum mr_status store_event_put(struct store *store, const struct store_event *event,
                               struct error *error)
{
    return STORE_PUT(store, error, event, event);
}

enum mr_status store_gap_put(struct store *store, int64_t session, int64_t run,
                             const struct store_gap *gap, struct error *error)
{
    return STORE_PUT(store, error, gap, gap, session, run);
}

enum mr_status store_time_map_put(struct store *store, const struct store_time_map *map,
                                  struct error *error)
{
    return STORE_PUT(store, error, time_map, map);
}
