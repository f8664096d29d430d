/* What the board is: identity and configuration, as it tells them item by item. */
#include <math.h>
#include <string.h>

#include "common/image.h"
#include "host/live/model_parts.h"

static void take_channel(struct live_model *model, const struct mr_channel *m)
{
    if (m->index >= MR_CHANNELS)
        return;
    struct mr_channel_config *known = &model->channel[m->index];
    bool same_station = known->station_ft == m->station_ft || (isnan(known->station_ft) && isnan(m->station_ft));
    if (!model->channel_known[m->index] || known->kind != m->kind || !same_station || known->unit_per_code != m->unit_per_code)
        model->configured++;
    model->channel_known[m->index] = true;
    known->kind = m->kind;
    known->station_ft = m->station_ft;
    known->unit_per_code = m->unit_per_code;
}

static void take_zero(struct live_model *model, const struct mr_channel_zero *m)
{
    if (m->index >= MR_CHANNELS)
        return;
    struct mr_channel_config *known = &model->channel[m->index];
    if (!model->zero_known[m->index] || known->number != m->number || known->band != m->band)
        model->configured++;
    model->zero_known[m->index] = true;
    known->number = m->number;
    known->band = m->band;
    known->zero_code = m->zero_code;
}

static void take_calibration(struct live_model *model, const struct mr_calibration *m)
{
    if (m->index >= MR_CHANNELS || m->item >= MR_CALIBRATION_ITEMS)
        return;
    mr_channel_item_set(&model->channel[m->index], m->item, m->value);
    model->calibration_told[m->index] |= 1u << m->item;
}

bool live_model_calibrated(const struct live_model *model, unsigned index)
{
    const struct mr_channel_config *known = &model->channel[index];
    unsigned points = known->points < MR_CONFIG_POINTS ? known->points : MR_CONFIG_POINTS;
    uint32_t needed = (1u << (MR_CALIBRATION_TABLE + 2u * points)) - 1u;
    if (!model->channel_known[index] || known->kind == MR_KIND_NONE)
        return model->channel_known[index];
    return model->zero_known[index] && (!mr_channel_measures(known) || (model->calibration_told[index] & needed) == needed);
}

bool live_model_lacks_calibration(const struct live_model *model)
{
    for (unsigned i = 0; i < LIVE_CHANNELS; i++) {
        if (!live_model_calibrated(model, i))
            return true;
    }
    return false;
}

static void take_switch(struct live_model *model, const struct mr_switch_place *m)
{
    if (m->position == 0 || m->position > STORE_SWITCHES_MAX)
        return;
    bool *known = &model->switch_known[m->position - 1];
    if (!*known || model->switch_ft[m->position - 1] != m->station_ft)
        model->configured++;
    *known = true;
    model->switch_ft[m->position - 1] = m->station_ft;
}

static void take_slack(struct live_model *model, const struct mr_slack *m)
{
    if (m->segment >= MR_SEGMENTS)
        return;
    struct mr_slack *known = &model->segment[m->segment];
    bool same = known->slack_in == m->slack_in || (isnan(known->slack_in) && isnan(m->slack_in));
    if (!model->segment_known[m->segment] || !same || known->start_ft != m->start_ft || known->end_ft != m->end_ft)
        model->configured++;
    model->segment_known[m->segment] = true;
    *known = *m;
}

static void take_identity(struct live_model *model, uint32_t *known, uint32_t value)
{
    model->configured += *known != value;
    *known = value;
}

static void take_hello(struct live_model *model, const struct mr_hello *m)
{
    bool same = model->hello && memcmp(&model->board, m, sizeof *m) == 0;
    model->configured += !same;
    model->hello = m->layout == MR_LAYOUT;
    model->board = *m;
}

bool live_model_take_configuration(struct live_model *model, uint16_t id, const uint8_t *payload, size_t length)
{
    switch (id) {
    case MR_ID_HELLO: { GET(hello); take_hello(model, &m); return true; }
    case MR_ID_BOARD_UID: {
        GET(board_uid);
        take_identity(model, &model->uid[0], m.uid0);
        take_identity(model, &model->uid[1], m.uid1);
        return true;
    }
    case MR_ID_BOARD_IMAGE: {
        GET(board_image);
        take_identity(model, &model->uid[2], m.uid2);
        take_identity(model, &model->image_crc, m.image_crc);
        return true;
    }
    case MR_ID_IMAGE_COMMIT: {
        GET(image_commit);
        mr_image_commit_text(m.commit, m.commit_more, m.changed != 0, model->commit);
        return true;
    }
    case MR_ID_BOARD_CONFIG: {
        GET(board_config);
        take_identity(model, &model->config_crc, m.config_crc);
        model->warning_mats = m.warning_mats;
        return true;
    }
    case MR_ID_SITE: {
        GET(site);
        model->configured += model->touchdown_ft != m.touchdown_ft;
        model->touchdown_ft = m.touchdown_ft;
        return true;
    }
    case MR_ID_CHANNEL: { GET(channel); take_channel(model, &m); return true; }
    case MR_ID_CHANNEL_ZERO: { GET(channel_zero); take_zero(model, &m); return true; }
    case MR_ID_CALIBRATION: { GET(calibration); take_calibration(model, &m); return true; }
    case MR_ID_SWITCH_PLACE: { GET(switch_place); take_switch(model, &m); return true; }
    case MR_ID_SLACK: { GET(slack); take_slack(model, &m); return true; }
    default: return false;
    }
}
