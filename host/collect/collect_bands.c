/* What the board says of bands, and of their gages' shunt calibration, into the campaign. */
#include <math.h>

#include "host/collect/collect_state.h"
#include "host/store/store_bands.h"

#define MISSING ((double)NAN)

/* A row that says nothing yet. */
static struct store_band blank(const struct side *side, unsigned band)
{
    return (struct store_band){
        .band = band, .gages = STORE_NONE, .before_lb = MISSING, .before_error_lb = MISSING, .spread_lb = MISSING,
        .least_lb = MISSING, .least_error_lb = MISSING, .least_gage = STORE_NONE, .least_block = STORE_NONE,
        .most_lb = MISSING, .most_error_lb = MISSING, .most_gage = STORE_NONE, .most_block = STORE_NONE,
        .after_lb = MISSING, .change_lb = MISSING, .change_error_lb = MISSING, .links = 1 << side->kind};
}

/* Whole index of a block that is not long past; it says nothing of the time now. */
static int64_t block_of(const struct side *side, uint16_t at_block16)
{
    struct timebase copy = side->time;
    int64_t block = timebase_unwrap(&copy, at_block16);
    return block < 0 ? STORE_NONE : block;
}

static enum mr_status put(struct collector *collector, const struct side *side, const struct store_band *row,
                          struct error *error)
{
    return side->current ? store_band_put(collector->store, side->current->row.id, row, error) : MR_OK;
}

static enum mr_status band_event(struct collector *collector, const struct side *side, const struct mr_band_event *m,
                                 struct error *error)
{
    int64_t block = block_of(side, m->at_block16);
    struct store_band_event row = {.block = block == STORE_NONE ? 0 : block, .band = m->band, .gage = m->gage,
                                   .reason = m->reason, .other = m->other, .value_lb = (double)m->value_lb,
                                   .links = 1 << side->kind};
    return side->current ? store_band_event_put(collector->store, side->current->row.id, &row, error) : MR_OK;
}

/* Result and check are two messages of one gage; the first is stored at once, the second completes it. */
static enum mr_status put_shunt(struct collector *collector, const struct side *side, const struct mr_shunt_check *check,
                                struct error *error)
{
    const struct mr_shunt_result *result = &side->shunt_result;
    if (side->shunt.number == 0) /* the log began in the middle */
        return MR_OK;
    struct store_shunt row = {
        .number = side->shunt.number, .gage = result->gage, .block = side->shunt.block, .verdict = result->verdict,
        .span_lb = (double)result->span_lb, .noise_lb = (double)result->noise_lb,
        .expected_lb = check ? (double)check->expected_lb : MISSING, .change_lb = check ? (double)check->change_lb : MISSING,
        .zero_change_lb = check ? (double)check->zero_change_lb : MISSING, .links = 1 << side->kind};
    return store_shunt_put(collector->store, collector->session, side->boot, &row, error);
}

/* Declares `m`, the message got from its payload. */
#define GET(name)                                      \
    struct mr_##name m;                                \
    if (mr_##name##_get(&m, payload, length) != MR_OK) \
    return MR_OK

enum mr_status collect_band_message(struct collector *collector, struct side *side, uint16_t id, const uint8_t *payload,
                                    size_t length, struct error *error)
{
    struct store_band row;
    switch (id) {
    case MR_ID_BAND_EVENT: {
        GET(band_event);
        return band_event(collector, side, &m, error);
    }
    case MR_ID_BAND_BEFORE: {
        GET(band_before);
        row = blank(side, m.band);
        row.gages = m.gages;
        row.before_lb = (double)m.before_lb;
        row.before_error_lb = (double)m.error_lb;
        row.spread_lb = (double)m.spread_lb;
        return put(collector, side, &row, error);
    }
    case MR_ID_BAND_LEAST: {
        GET(band_least);
        row = blank(side, m.band);
        if (m.gage) {
            row.least_lb = (double)m.tension_lb;
            row.least_error_lb = (double)m.error_lb;
            row.least_gage = m.gage;
            row.least_block = block_of(side, m.at_block16);
        }
        return put(collector, side, &row, error);
    }
    case MR_ID_BAND_MOST: {
        GET(band_most);
        row = blank(side, m.band);
        if (m.gage) {
            row.most_lb = (double)m.tension_lb;
            row.most_error_lb = (double)m.error_lb;
            row.most_gage = m.gage;
            row.most_block = block_of(side, m.at_block16);
        }
        return put(collector, side, &row, error);
    }
    case MR_ID_BAND_AFTER: {
        GET(band_after);
        row = blank(side, m.band);
        row.after_lb = (double)m.after_lb;
        row.change_lb = (double)m.change_lb;
        row.change_error_lb = (double)m.error_lb;
        return put(collector, side, &row, error);
    }
    case MR_ID_SHUNT: {
        GET(shunt);
        side->shunt = m;
        return MR_OK;
    }
    case MR_ID_SHUNT_RESULT: {
        GET(shunt_result);
        side->shunt_result = m;
        return put_shunt(collector, side, NULL, error);
    }
    case MR_ID_SHUNT_CHECK: {
        GET(shunt_check);
        return m.gage == side->shunt_result.gage ? put_shunt(collector, side, &m, error) : MR_OK;
    }
    default: return MR_OK;
    }
}
