#include "host/store/store_sql.h"

/* Integer parameters are passed as int64_t: that is what the statement table binds. */
#define INT(value) ((int64_t)(value))

enum mr_status store_session_add(struct store *store, struct store_session *session, struct error *error)
{
    enum mr_status status = store_run(store, error, STORE_SESSION_ADD, session->started_us, session->can_link,
                                      session->serial_link);
    session->id = sqlite3_last_insert_rowid(store->database);
    return status;
}

enum mr_status store_session_end(struct store *store, int64_t session, int64_t ended_us, const char *ended_by,
                                 struct error *error)
{
    return store_run(store, error, STORE_SESSION_END, ended_us, ended_by, session);
}

enum mr_status store_link_put(struct store *store, int64_t session, int link,
                              const struct store_link_counts *counts, struct error *error)
{
    return store_run(store, error, STORE_LINK_PUT, session, INT(link), counts->received, counts->lost,
                     counts->dropped, counts->bad, counts->foreign);
}

enum mr_status store_missing_put(struct store *store, int64_t session, int link, const char *message, int64_t missing,
                                 struct error *error)
{
    return store_run(store, error, STORE_MISSING_PUT, session, INT(link), message, missing);
}

enum mr_status store_landing_add(struct store *store, struct store_landing *landing, struct error *error)
{
    enum mr_status status =
        store_run(store, error, STORE_LANDING_ADD, landing->session, landing->boot, landing->board_landing,
                  landing->armed_block, landing->armed_us, landing->state, landing->board_uid,
                  landing->firmware, landing->image_crc, landing->config_crc, landing->clock_source,
                  landing->touchdown_ft, landing->switch_error_ft, landing->image_commit);
    landing->id = sqlite3_last_insert_rowid(store->database);
    return status == MR_OK ? store_run(store, error, STORE_SURVEY_ADD, landing->id) : status;
}

enum mr_status store_landing_put(struct store *store, const struct store_landing *landing,
                                 struct error *error)
{
    return store_run(store, error, STORE_LANDING_PUT, landing->armed_block, landing->armed_us, landing->state,
                     landing->board_uid, landing->firmware, landing->image_crc, landing->config_crc,
                     landing->clock_source, landing->touchdown_ft, landing->switch_error_ft, landing->image_commit,
                     landing->id);
}

enum mr_status store_channel_put(struct store *store, int64_t run, int64_t index,
                                 const struct mr_channel_config *channel, struct error *error)
{
    return store_run(store, error, STORE_CHANNEL_PUT, run, index, INT(channel->kind), INT(channel->number),
                     INT(channel->band), (double)channel->station_ft, (double)channel->unit_per_code,
                     (double)channel->zero_code);
}

enum mr_status store_calibration_put(struct store *store, int64_t run, int64_t index, int64_t item, double value,
                                     struct error *error)
{
    return store_run(store, error, STORE_CALIBRATION_PUT, run, index, item, value);
}

enum mr_status store_quality_put(struct store *store, int64_t run, const struct mr_channel_quality *quality,
                                 struct error *error)
{
    return store_run(store, error, STORE_QUALITY_PUT, run, INT(quality->index), INT(quality->validity),
                     (double)quality->noise_codes, (double)quality->error_codes, INT(quality->invalid));
}

enum mr_status store_switch_put(struct store *store, int64_t run, const struct store_switch *place,
                                struct error *error)
{
    return store_run(store, error, STORE_SWITCH_PUT, run, place->position, place->step_codes,
                     place->station_ft);
}

enum mr_status store_segment_put(struct store *store, int64_t run, const struct store_segment *segment,
                                 struct error *error)
{
    return store_run(store, error, STORE_SEGMENT_PUT, run, segment->segment, segment->joints,
                     segment->slack_in, segment->start_ft, segment->end_ft);
}

enum mr_status store_block_put(struct store *store, int64_t session, int64_t boot, int64_t run, int link, int64_t index,
                               int64_t host_us, const uint8_t *record, size_t length, struct error *error)
{
    return store_run(store, error, STORE_BLOCK_PUT, session, boot, index, run, host_us, (const void *)record,
                     length, INT(link));
}

enum mr_status store_edge_put(struct store *store, int64_t run, const struct store_edge *edge,
                              struct error *error)
{
    return store_run(store, error, STORE_EDGE_PUT, run, edge->count, edge->position, edge->tick,
                     edge->step_codes, edge->board_us, edge->links);
}

enum mr_status store_edge_refuse(struct store *store, int64_t run, int64_t count, struct error *error)
{
    return store_run(store, error, STORE_EDGE_REFUSE, run, count);
}

enum mr_status store_event_put(struct store *store, const struct store_event *event, struct error *error)
{
    return store_run(store, error, STORE_EVENT_PUT, event->session, event->boot, event->run, event->board_us,
                     event->host_us, event->kind, event->code, event->detail, event->value, event->links);
}

enum mr_status store_motion_put(struct store *store, int64_t run, const struct store_motion *motion,
                                struct error *error)
{
    return store_run(store, error, STORE_MOTION_PUT, run, motion->block, motion->position_ft,
                     motion->position_error_ft, motion->speed_ft_s, motion->speed_error_ft_s,
                     motion->deceleration_ft_s2, motion->deceleration_error_ft_s2, motion->links);
}

enum mr_status store_zone_put(struct store *store, int64_t run, const struct store_zone *zone,
                              struct error *error)
{
    return store_run(store, error, STORE_ZONE_PUT, run, zone->block, zone->mats, zone->start_ft, zone->end_ft,
                     zone->lead_s, zone->wheel_ft, zone->warning, zone->inferred_percent, zone->links);
}

enum mr_status store_result_put(struct store *store, int64_t run, const struct store_result *result,
                                struct error *error)
{
    return store_run(store, error, STORE_RESULT_PUT, run, result->speed_ft_s, result->speed_error_ft_s,
                     result->deceleration_ft_s2, result->deceleration_error_ft_s2, result->stop_station_ft,
                     result->stop_station_error_ft, result->after_touchdown_s, result->switches, result->used,
                     result->links);
}

enum mr_status store_gap_put(struct store *store, int64_t session, int64_t run, const struct store_gap *gap,
                             struct error *error)
{
    return store_run(store, error, STORE_GAP_PUT, session, run, INT(gap->link), gap->message, gap->channels,
                     gap->cause, gap->count, gap->from_block, gap->to_block);
}

enum mr_status store_time_map_put(struct store *store, const struct store_time_map *map, struct error *error)
{
    return store_run(store, error, STORE_TIME_MAP_PUT, map->session, map->boot, map->link, map->run, map->refusal,
                     map->pairs, map->from_us, map->to_us, map->spread_us, map->fast_ppm, map->fast_half_ppm,
                     map->board_us, map->host_us, map->host_half_us);
}

enum mr_status store_film_frame_put(struct store *store, int64_t run, const struct store_film_frame *frame,
                                    struct error *error)
{
    return store_run(store, error, STORE_FILM_FRAME_PUT, run, frame->number, frame->tick, frame->board_us, frame->links);
}

enum mr_status store_simulation_put(struct store *store, int64_t run, const char *scene_json, int64_t made_us,
                                    const struct store_simulation_head *head, const struct store_simulation *rows, size_t count,
                                    struct error *error)
{
    enum mr_status status = store_run(store, error, STORE_SIMULATION_ADD, run, scene_json, made_us, head->run_ms, head->error_in,
                                      head->seeds, head->edges, head->offset_s, head->scatter_s, head->segments_dt_s,
                                      (const void *)head->segments_in, head->segment_rows * MR_SEGMENTS * sizeof *head->segments_in);
    int64_t id = sqlite3_last_insert_rowid(store->database);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        const struct store_simulation *row = &rows[i];
        status = store_run(store, error, STORE_SIMULATION_CHANNEL, id, row->number, row->station_ft,
                           row->peak_measured_in, row->peak_measured_error_in, row->peak_simulated_in,
                           row->peak_simulated_error_in, row->rms_in, row->end_measured_in,
                           row->end_simulated_in, row->t0_s, row->dt_s, (const void *)row->series_in,
                           row->length * sizeof *row->series_in, (const void *)row->spread_in,
                           row->spread_in ? row->length * sizeof *row->spread_in : (size_t)0);
    }
    return status;
}
