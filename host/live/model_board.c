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
    bool same_station = known->station_ft == m->station_ft ||
                        (isnan(known->station_ft) && isnan(m->station_ft));
    if (!model->channel_known[m->index] || known->kind != m->kind || !same_station ||
        known->unit_per_code != m->unit_per_code)
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
    return model->zero_known[index] &&
           (!mr_channel_measures(known) || (model->calibration_told[index] & needed) == needed);
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
    if (!model->segment_known[m->segment] || !same || known->start_ft != m->start_ft ||
        known->end_ft != m->end_ft)
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

static void take_image(struct live_model *model, const struct mr_board_image *m)
{
    take_identity(model, &model->uid[2], m->uid2);
    take_identity(model, &model->image_crc, m->image_crc);
}

static void take_board_config(struct live_model *model, const struct mr_board_config *m)
{
    take_identity(model, &model->config_crc, m->config_crc);
    model->warning_mats = m->warning_mats;
}

static void take_site(struct live_model *model, const struct mr_site *m)
{
    model->configured += model->touchdown_ft != m->touchdown_ft;
    model->touchdown_ft = m->touchdown_ft;
}

void live_model_take_configuration(struct live_model *model, const struct live_heard *heard)
{
    const struct mr_message *m = heard->message;
    switch (m->place) {
    case MR_PLACE_HELLO: take_hello(model, &m->as.hello); break;
    case MR_PLACE_BOARD_UID:
        take_identity(model, &model->uid[0], m->as.board_uid.uid0);
        take_identity(model, &model->uid[1], m->as.board_uid.uid1);
        break;
    case MR_PLACE_BOARD_IMAGE: take_image(model, &m->as.board_image); break;
    case MR_PLACE_IMAGE_COMMIT:
        mr_image_commit_text(m->as.image_commit.commit, m->as.image_commit.commit_more,
                             m->as.image_commit.changed != 0, model->commit);
        break;
    case MR_PLACE_BOARD_CONFIG: take_board_config(model, &m->as.board_config); break;
    case MR_PLACE_SITE: take_site(model, &m->as.site); break;
    case MR_PLACE_CHANNEL: take_channel(model, &m->as.channel); break;
    case MR_PLACE_CHANNEL_ZERO: take_zero(model, &m->as.channel_zero); break;
    case MR_PLACE_CALIBRATION: take_calibration(model, &m->as.calibration); break;
    case MR_PLACE_SWITCH_PLACE: take_switch(model, &m->as.switch_place); break;
    case MR_PLACE_SLACK: take_slack(model, &m->as.slack); break;
    default: break;
    }
}
