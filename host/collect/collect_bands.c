/* What the board says of bands, and of their gages' shunt calibration, into the campaign. */
#include "host/collect/collect_state.h"
#include "host/store/store_bands.h"

/* Whole index of a block that is not long past; it says nothing of the time now. */
static int64_t block_of(const struct side *side, uint16_t at_block16)
{
    struct timebase copy = side->time;
    int64_t block = timebase_unwrap(&copy, at_block16);
    return block < 0 ? STORE_NONE : block;
}

static enum mr_status band_event(struct collector *collector, const struct side *side,
                                 const struct mr_band_event *m, struct error *error)
{
    int64_t block = block_of(side, m->at_block16);
    struct store_band_event row = {.block = block == STORE_NONE ? 0 : block,
                                   .links = collect_link_bit(side)};
    collect_band_event_row(&row, m);
    return side->current
             ? store_band_event_put(collector->store, side->current->row.id, &row, error)
             : MR_OK;
}

/* Result and check are two messages of one gage; the first is stored at once, the second completes
 * it. */
static enum mr_status shunt(struct collector *collector, struct side *side,
                            const struct mr_message *m, struct error *error)
{
    struct store_shunt *row = &side->shunt_result;
    if (m->place == MR_PLACE_SHUNT) {
        side->shunt = store_blank_shunt;
        side->shunt.links = collect_link_bit(side);
        collect_shunt_row(&side->shunt, &m->as.shunt);
        return MR_OK;
    }
    if (m->place == MR_PLACE_SHUNT_RESULT) {
        *row = side->shunt;
        collect_shunt_result_row(row, &m->as.shunt_result);
    } else if (m->as.shunt_check.gage == row->gage) {
        collect_shunt_check_row(row, &m->as.shunt_check);
    } else {
        return MR_OK;
    }
    if (side->shunt.number == 0) /* the log began in the middle */
        return MR_OK;
    return store_shunt_put(collector->store, collector->session, side->boot, row, error);
}

/* Before and after, least and most of a band are of one row. A least or most of no gage says
 * nothing. */
static enum mr_status band(struct collector *collector, const struct side *side,
                           const struct mr_message *m, struct error *error)
{
    struct store_band row = store_blank_band;
    const struct mr_band_least *least = &m->as.band_least;
    const struct mr_band_most *most = &m->as.band_most;
    row.links = collect_link_bit(side);
    if (m->place == MR_PLACE_BAND_BEFORE)
        collect_band_before_row(&row, &m->as.band_before);
    else if (m->place == MR_PLACE_BAND_AFTER)
        collect_band_after_row(&row, &m->as.band_after);
    else
        row.band = m->place == MR_PLACE_BAND_LEAST ? least->band : most->band;
    if (m->place == MR_PLACE_BAND_LEAST && least->gage) {
        collect_band_least_row(&row, least);
        row.least_block = block_of(side, least->at_block16);
    }
    if (m->place == MR_PLACE_BAND_MOST && most->gage) {
        collect_band_most_row(&row, most);
        row.most_block = block_of(side, most->at_block16);
    }
    return side->current ? store_band_put(collector->store, side->current->row.id, &row, error)
                         : MR_OK;
}

enum mr_status collect_band_message(struct collector *collector, struct side *side,
                                    const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->place) {
    case MR_PLACE_BAND_EVENT: return band_event(collector, side, &m->as.band_event, error);
    case MR_PLACE_BAND_BEFORE:
    case MR_PLACE_BAND_LEAST:
    case MR_PLACE_BAND_MOST:
    case MR_PLACE_BAND_AFTER: return band(collector, side, m, error);
    default: return shunt(collector, side, m, error);
    }
}
