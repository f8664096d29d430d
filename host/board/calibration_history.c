#include "host/board/calibration_history.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "common/gain.h"
#include "host/base/cli.h"
#include "host/base/xmalloc.h"
#include "host/board/config_text.h"
#include "host/calibrate/jump.h"
#include "host/store/store_readiness.h"

/* One moment of the past: a row of readiness, or a landing. */
struct moment {
    int64_t time_us, run;
    bool said; /* somebody said that it is so */
    struct mr_channel_config channel[MR_CHANNELS];
};

struct moments {
    struct moment *list;
    size_t count;
};

static struct moment *add_moment(struct moments *moments)
{
    if (!list_grow(&moments->list, moments->count, sizeof *moments->list))
        abort();
    struct moment *moment = &moments->list[moments->count++];
    memset(moment, 0, sizeof *moment);
    return moment;
}

static float real_of(const json_t *value)
{
    return json_is_number(value) ? (float)json_number_value(value) : NAN;
}

static void take_row(void *context, int64_t made_us, const char *kind, const char *checks)
{
    json_t *object = json_loads(checks, 0, NULL), *list = json_object_get(object, "calibration"),
           *one;
    size_t i;
    unsigned input;
    if (json_array_size(list) > 0) {
        struct moment *moment = add_moment(context);
        moment->time_us = made_us;
        moment->said = strcmp(kind, "change") == 0;
        json_array_foreach(list, i, one)
        {
            const char *name = json_string_value(json_object_get(one, "channel")),
                       *serial = json_string_value(json_object_get(one, "serial"));
            if (!name || !jump_channel_read(name, strlen(name), &input))
                continue;
            struct mr_channel_config *channel = &moment->channel[input];
            channel->kind = input < MR_TRANSDUCERS ? MR_KIND_DISPLACEMENT : MR_KIND_TENSION;
            channel->number = (uint8_t)json_integer_value(json_object_get(one, "number"));
            channel->unit_per_code = real_of(json_object_get(one, "gain"));
            channel->zero_code = real_of(json_object_get(one, "zero_code"));
            channel->calibrated_day =
                (uint32_t)json_integer_value(json_object_get(one, "calibrated_day"));
            if (serial && strlen(serial) <= sizeof channel->serial)
                memcpy(channel->serial, serial, strlen(serial));
            if (isnan(channel->unit_per_code))
                channel->kind = MR_KIND_NONE;
        }
    }
    json_decref(object);
}

/* Gains as the landing has them, corrections included; the zero is the configuration's: that of a
 * landing may have been measured just before it. A landing whose configuration was not kept has no
 * zero, and its gains count as calibrated. */
static enum mr_status take_landing(struct store *store, const struct store_landing *landing,
                                   struct moments *moments, struct error *error)
{
    static struct mr_config config;
    struct mr_channel_config channel[MR_CHANNELS];
    struct error unread = {0};
    char *text = NULL;
    size_t found = 0;
    enum mr_status status = store_channels(store, landing->id, channel, &found, error);
    if (status == MR_OK && landing->config_crc != STORE_NONE)
        status = store_configuration_get(store, (uint32_t)landing->config_crc, &text, error);
    if (status != MR_OK)
        return status;
    bool known = text && config_text_read(text, "", &config, &unread) == MR_OK;
    struct moment *moment = add_moment(moments);
    moment->time_us = landing->armed_us;
    moment->run = landing->id;
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (!mr_channel_measures(&channel[i]))
            continue;
        struct mr_channel_config *c = &moment->channel[i];
        *c = (struct mr_channel_config){.kind = channel[i].kind,
                                        .number = channel[i].number,
                                        .unit_per_code = mr_channel_gain(&channel[i]),
                                        .zero_code = known ? config.channel[i].zero_code : NAN,
                                        .calibrated_day = known ? config.channel[i].calibrated_day
                                                                : 1u};
        if (known)
            memcpy(c->serial, config.channel[i].serial, sizeof c->serial);
    }
    free(text);
    return MR_OK;
}

static int by_time(const void *a, const void *b)
{
    const struct moment *one = a, *other = b;
    return (one->time_us > other->time_us) - (one->time_us < other->time_us);
}

/* What followed takes the place of what was; a jump does not. */
static void follow(struct calibration_history *past, const struct moment *moment)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        struct mr_channel_config *was = &past->channel[i];
        const struct mr_channel_config *is = &moment->channel[i];
        struct jump jump;
        if (is->kind == MR_KIND_NONE || (!moment->said && jump_find(was, is, &jump)))
            continue;
        float zero_code = isnan(is->zero_code) && was->kind == is->kind ? was->zero_code
                                                                        : is->zero_code;
        *was = *is;
        was->zero_code = zero_code;
        past->run[i] = moment->run;
    }
}

enum mr_status calibration_history_read(struct store *store, const char *board_uid,
                                        struct calibration_history *past, struct error *error)
{
    struct store_landing *rows = NULL;
    struct moments moments = {0};
    size_t count = 0;
    memset(past, 0, sizeof *past);
    enum mr_status status = store_readiness_all(store, board_uid, take_row, &moments, error);
    if (status == MR_OK)
        status = store_landings(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (strcmp(rows[i].board_uid, board_uid) == 0)
            status = take_landing(store, &rows[i], &moments, error);
    }
    if (status == MR_OK && moments.count)
        qsort(moments.list, moments.count, sizeof *moments.list, by_time);
    for (size_t i = 0; i < moments.count && status == MR_OK; i++)
        follow(past, &moments.list[i]);
    free(moments.list);
    free(rows);
    return status;
}

json_t *calibration_history_json(const struct mr_config *config, uint32_t only)
{
    json_t *list = json_array();
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        const struct mr_channel_config *c = &config->channel[i];
        char name[8];
        if (!(only >> i & 1u) || !mr_channel_measures(c))
            continue;
        jump_channel(i, name);
        json_array_append_new(list,
                              json_pack("{sssisososs%sI}", "channel", name, "number", c->number,
                                        "gain", cli_json_number((double)mr_channel_gain(c), 9),
                                        "zero_code", cli_json_number((double)c->zero_code, 9),
                                        "serial", c->serial, strnlen(c->serial, sizeof c->serial),
                                        "calibrated_day", (json_int_t)c->calibrated_day));
    }
    return list;
}

enum mr_status calibration_history_say(struct store *store, const char *board_uid,
                                       const struct mr_config *config, uint32_t channels,
                                       const char *note, int64_t made_us, struct error *error)
{
    const char *user = getenv("USER");
    json_t *object = json_pack("{ssssso}", "note", note, "who", user ? user : "", "calibration",
                               calibration_history_json(config, channels));
    struct store_readiness row = {.made_us = made_us, .verdict = "said"};
    if (!object)
        return error_set(error, MR_USAGE,
                         "a note that is no UTF-8 text: '%s'; write it in plain letters", note);
    row.checks = json_dumps(object, JSON_COMPACT);
    json_decref(object);
    if (!row.checks)
        abort();
    enum mr_status status = store_begin(store, error);
    if (status == MR_OK)
        status = store_readiness_put(store, board_uid, "change", &row, error);
    if (status == MR_OK)
        status = store_commit(store, error);
    free(row.checks);
    return status;
}
