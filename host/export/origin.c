#include "host/export/origin.h"

#include <ctype.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define STATE_MOST    4
#define BOARD_US_MOST 4.294967296e12 /* 2^32 blocks of 1 ms */

/* ---- to text ---- */

static json_t *whole(int64_t value)
{
    return value == STORE_NONE ? json_null() : json_integer(value);
}

static json_t *real(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *head_json(const struct store_landing *l)
{
    json_t *head = json_pack("{sIsIsIssss}", "run", (json_int_t)l->id, "landing",
                             (json_int_t)l->board_landing, "armed_us", (json_int_t)l->armed_us,
                             "board", l->board_uid, "firmware", l->firmware);
    json_object_set_new(head, "image_commit", json_string(l->image_commit));
    json_object_set_new(head, "image_crc", whole(l->image_crc));
    json_object_set_new(head, "config_crc", whole(l->config_crc));
    json_object_set_new(head, "clock_source", whole(l->clock_source));
    json_object_set_new(head, "armed_block", whole(l->armed_block));
    json_object_set_new(head, "state", whole(l->state));
    json_object_set_new(head, "touchdown_ft", real(l->touchdown_ft));
    json_object_set_new(head, "switch_error_ft", real(l->switch_error_ft));
    return head;
}

static json_t *switches_json(const struct store_switch *place, size_t places)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < places; i++)
        json_array_append_new(rows, json_pack("[IIo]", (json_int_t)place[i].position,
                                              (json_int_t)place[i].step_codes,
                                              real(place[i].station_ft)));
    return rows;
}

static json_t *edges_json(const struct store_edge *edge, size_t edges)
{
    json_t *rows = json_array();
    for (size_t i = 0; i < edges; i++)
        json_array_append_new(rows,
                              json_pack("[IIIoo]", (json_int_t)edge[i].count,
                                        (json_int_t)edge[i].position, (json_int_t)edge[i].tick,
                                        real(edge[i].step_codes), real(edge[i].board_us)));
    return rows;
}

/* kind, number, band, station, codes, then the calibration's items. */
static json_t *channels_json(const struct measured *measured)
{
    json_t *rows = json_array();
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct mr_channel_config *config = &measured->channel[c].config;
        if (!config->kind)
            continue;
        json_t *row = json_pack(
            "[iIiiiooo]", (int)c, (json_int_t)measured->channel[c].stride, (int)config->kind,
            (int)config->number, (int)config->band, real((double)config->station_ft),
            real((double)config->unit_per_code), real((double)config->zero_code));
        for (unsigned item = 0; item < MR_CALIBRATION_TABLE; item++)
            json_array_append_new(row, real((double)mr_channel_item(config, item)));
        json_array_append_new(rows, row);
    }
    return rows;
}

char *origin_text(struct store *store, const struct measured *measured, struct error *error)
{
    struct store_switch *place = NULL;
    struct store_edge *edge = NULL;
    size_t places = 0, edges = 0;
    char *text = NULL;
    enum mr_status status = store_switches(store, measured->landing.id, &place, &places, error);
    if (status == MR_OK)
        status = store_edges(store, measured->landing.id, &edge, &edges, error);
    if (status == MR_OK) {
        json_t *head = head_json(&measured->landing);
        json_object_set_new(head, "switches", switches_json(place, places));
        json_object_set_new(head, "edges", edges_json(edge, edges));
        json_object_set_new(head, "channels", channels_json(measured));
        text = json_dumps(head, JSON_COMPACT | JSON_REAL_PRECISION(17));
        json_decref(head);
    }
    free(place);
    free(edge);
    return text;
}

/* ---- from text ---- */

/* Values of a file: each asked for by its place or name, with what it may be. One that is not that
 * makes all of it bad. */
struct reader {
    bool bad;
};

static int64_t take_whole(struct reader *r, json_t *value, int64_t low, int64_t high,
                          bool may_be_none)
{
    int64_t v = json_integer_value(value);
    if (may_be_none && json_is_null(value))
        return STORE_NONE;
    r->bad |= !json_is_integer(value) || v < low || v > high;
    return r->bad ? 0 : v;
}

static double take_real(struct reader *r, json_t *value, double most)
{
    double v = json_number_value(value);
    if (json_is_null(value))
        return (double)NAN;
    r->bad |= !json_is_number(value) || !(fabs(v) <= most);
    return r->bad ? 0.0 : v;
}

static void take_text(struct reader *r, json_t *value, char *to, size_t size)
{
    const char *text = json_string_value(value);
    if (!text || strlen(text) >= size) {
        r->bad = true;
        return;
    }
    for (const char *c = text; *c; c++)
        r->bad |= !isprint((unsigned char)*c);
    snprintf(to, size, "%s", text);
}

static void take_head(struct reader *r, json_t *head, struct store_landing *l)
{
    l->id = take_whole(r, json_object_get(head, "run"), 1, INT64_MAX, false);
    l->board_landing = take_whole(r, json_object_get(head, "landing"), 0, UINT16_MAX, false);
    l->armed_us = take_whole(r, json_object_get(head, "armed_us"), 0, INT64_MAX, false);
    l->armed_block = take_whole(r, json_object_get(head, "armed_block"), 0, UINT32_MAX, true);
    l->state = take_whole(r, json_object_get(head, "state"), 0, STATE_MOST, false);
    l->image_crc = take_whole(r, json_object_get(head, "image_crc"), 0, UINT32_MAX, true);
    l->config_crc = take_whole(r, json_object_get(head, "config_crc"), 0, UINT32_MAX, true);
    l->clock_source = take_whole(r, json_object_get(head, "clock_source"), 0, UINT8_MAX, true);
    l->touchdown_ft = take_real(r, json_object_get(head, "touchdown_ft"), 1e6);
    l->switch_error_ft = take_real(r, json_object_get(head, "switch_error_ft"), 1e6);
    take_text(r, json_object_get(head, "board"), l->board_uid, sizeof l->board_uid);
    take_text(r, json_object_get(head, "firmware"), l->firmware, sizeof l->firmware);
    take_text(r, json_object_get(head, "image_commit"), l->image_commit, sizeof l->image_commit);
}

static void take_switch(struct reader *r, json_t *row, struct store_switch *place)
{
    place->position = take_whole(r, json_array_get(row, 0), 1, ORIGIN_SWITCHES, false);
    place->step_codes = take_whole(r, json_array_get(row, 1), 0, UINT16_MAX, false);
    place->station_ft = take_real(r, json_array_get(row, 2), 1e6);
}

static void take_edge(struct reader *r, json_t *row, struct store_edge *edge)
{
    edge->count = take_whole(r, json_array_get(row, 0), 0, INT32_MAX, false);
    edge->position = take_whole(r, json_array_get(row, 1), 0, ORIGIN_SWITCHES, false);
    edge->tick = take_whole(r, json_array_get(row, 2), 0, UINT32_MAX, false);
    edge->step_codes = take_real(r, json_array_get(row, 3), 1e9);
    edge->board_us = take_real(r, json_array_get(row, 4), BOARD_US_MOST);
}

static void take_channel(struct reader *r, json_t *row, struct origin *origin)
{
    size_t index = (size_t)take_whole(r, json_array_get(row, 0), 0, MR_CHANNELS - 1, false);
    struct mr_channel_config *config = &origin->channel[index];
    origin->stride[index] = (size_t)take_whole(r, json_array_get(row, 1), 1, 1000, false);
    config->kind = (uint8_t)take_whole(r, json_array_get(row, 2), 1, MR_KIND_REFERENCE, false);
    config->number = (uint8_t)take_whole(r, json_array_get(row, 3), 0, UINT8_MAX, false);
    config->band = (uint8_t)take_whole(r, json_array_get(row, 4), 0, UINT8_MAX, false);
    config->station_ft = (float)take_real(r, json_array_get(row, 5), 1e30);
    config->unit_per_code = (float)take_real(r, json_array_get(row, 6), 1e30);
    config->zero_code = (float)take_real(r, json_array_get(row, 7), 1e30);
    for (unsigned item = 0; item < MR_CALIBRATION_TABLE; item++) {
        /* its table is not told: the readings are computed already */
        if (item != MR_CALIBRATION_POINTS)
            mr_channel_item_set(config, item,
                                (float)take_real(r, json_array_get(row, 8 + item), 1e30));
    }
}

static json_t *take_rows(struct reader *r, json_t *head, const char *key, size_t most,
                         size_t *count)
{
    json_t *rows = json_object_get(head, key);
    *count = json_array_size(rows);
    r->bad |= !json_is_array(rows) || *count > most;
    return rows;
}

bool origin_parse(const char *text, size_t length, struct origin *origin)
{
    struct reader r = {false};
    size_t channels = 0;
    memset(origin, 0, sizeof *origin);
    json_t *head = json_loadb(text, length, JSON_REJECT_DUPLICATES, NULL);
    if (!json_is_object(head)) {
        json_decref(head);
        return false;
    }
    take_head(&r, head, &origin->landing);
    json_t *switches = take_rows(&r, head, "switches", ORIGIN_SWITCHES, &origin->places);
    json_t *edges = take_rows(&r, head, "edges", ORIGIN_EDGES, &origin->edges);
    json_t *rows = take_rows(&r, head, "channels", MR_CHANNELS, &channels);
    for (size_t i = 0; i < origin->places && !r.bad; i++)
        take_switch(&r, json_array_get(switches, i), &origin->place[i]);
    for (size_t i = 0; i < origin->edges && !r.bad; i++)
        take_edge(&r, json_array_get(edges, i), &origin->edge[i]);
    for (size_t i = 0; i < channels && !r.bad; i++)
        take_channel(&r, json_array_get(rows, i), origin);
    json_decref(head);
    return !r.bad;
}
