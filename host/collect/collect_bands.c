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

static struct store_band least(const struct side *side, const struct mr_band_least *m)
{
    struct store_band row = blank(side, m->band);
    if (m->gage) {
        row.least_lb = (double)m->tension_lb;
        row.least_error_lb = (double)m->error_lb;
        row.least_gage = m->gage;
        row.least_block = block_of(side, m->at_block16);
    }
    return row;
}

static struct store_band most(const struct side *side, const struct mr_band_most *m)
{
    struct store_band row = blank(side, m->band);
    if (m->gage) {
        row.most_lb = (double)m->tension_lb;
        row.most_error_lb = (double)m->error_lb;
        row.most_gage = m->gage;
        row.most_block = block_of(side, m->at_block16);
    }
    return row;
}

static struct store_band before(const struct side *side, const struct mr_band_before *m)
{
    struct store_band row = blank(side, m->band);
    row.gages = m->gages;
    row.before_lb = (double)m->before_lb;
    row.before_error_lb = (double)m->error_lb;
    row.spread_lb = (double)m->spread_lb;
    return row;
}

static struct store_band after(const struct side *side, const struct mr_band_after *m)
{
    struct store_band row = blank(side, m->band);
    row.after_lb = (double)m->after_lb;
    row.change_lb = (double)m->change_lb;
    row.change_error_lb = (double)m->error_lb;
    return row;
}

enum mr_status collect_band_message(struct collector *collector, struct side *side, const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    struct store_band row;
    switch (m->place) {
    case MR_PLACE_BAND_EVENT: return band_event(collector, side, &m->as.band_event, error);
    case MR_PLACE_BAND_BEFORE: row = before(side, &m->as.band_before); break;
    case MR_PLACE_BAND_LEAST: row = least(side, &m->as.band_least); break;
    case MR_PLACE_BAND_MOST: row = most(side, &m->as.band_most); break;
    case MR_PLACE_BAND_AFTER: row = after(side, &m->as.band_after); break;
    case MR_PLACE_SHUNT: side->shunt = m->as.shunt; return MR_OK;
    case MR_PLACE_SHUNT_RESULT: side->shunt_result = m->as.shunt_result; return put_shunt(collector, side, NULL, error);
    case MR_PLACE_SHUNT_CHECK:
        return m->as.shunt_check.gage == side->shunt_result.gage ? put_shunt(collector, side, &m->as.shunt_check, error) : MR_OK;
    default: return MR_OK;
    }
    return put(collector, side, &row, error);
}
