/* What the predictor says, and the runway and the parameters that a landing is armed with, into the
 * campaign. */
#include <string.h>

#include "host/collect/collect_state.h"
#include "host/store/store_predict.h"

static bool same(float a, float b)
{
    return memcmp(&a, &b, sizeof a) == 0;
}

static enum mr_status trust(struct collector *collector, struct side *side,
                            const struct mr_message *m, struct error *error)
{
    struct store_trust row = {.block = collect_block(side, m), .links = collect_link_bit(side)};
    collect_trust_row(&row, &m->as.trust);
    return side->current && row.block >= 0
             ? store_trust_put(collector->store, side->current->row.id, &row, error)
             : MR_OK;
}

/* A runway is kept when it is whole: all its joints in a row, and of the CRC that the board
 * gave. */
static enum mr_status joints(struct collector *collector, struct side *side,
                             const struct mr_runway_joints *m, struct error *error)
{
    struct mr_predictor_state *state = &side->runway;
    if (m->index != 1u + MR_RUNWAY_PER_MESSAGE * side->runway_parts ||
        side->runway_parts >= mr_runway_messages(state))
        return MR_OK;
    mr_runway_take(state, m);
    side->runway_parts++;
    if (!side->current || side->runway_parts < mr_runway_messages(state) ||
        mr_runway_crc(state) != side->runway_store.crc)
        return MR_OK;
    return store_runway_put(collector->store, side->current->row.id, state,
                            side->runway_store.source, error);
}

static void runway(struct side *side, const struct mr_runway *m)
{
    side->runway = (struct mr_predictor_state){.mats = m->mats <= MR_CHAIN_MATS ? m->mats : 0,
                                               .landings = m->landings,
                                               .scale = m->resistance};
    side->runway_parts = 0;
}

static void runway_store(struct collector *collector, struct side *side,
                         const struct mr_runway_store *m)
{
    const struct mr_runway_store *known = &collector->stored;
    side->runway_store = *m;
    collector->stored_news |= !collector->stored_known || known->state != m->state ||
                              known->source != m->source || known->copy_a != m->copy_a ||
                              known->copy_b != m->copy_b;
    collector->stored = *m;
    collector->stored_known = true;
}

static enum mr_status item(struct collector *collector, const struct side *side,
                           const struct mr_predict_item *m, struct error *error)
{
    if (m->index >= MR_PREDICT_ITEMS ||
        (collector->predict_known[m->index] && same(collector->predict_item[m->index], m->value)))
        return MR_OK;
    collector->predict_known[m->index] = true;
    collector->predict_item[m->index] = m->value;
    return side->current ? store_predict_item_put(collector->store, side->current->row.id, m->index,
                                                  (double)m->value, error)
                         : MR_OK;
}

enum mr_status collect_write_parameters(struct collector *collector, const struct slot *slot,
                                        struct error *error)
{
    enum mr_status status = MR_OK;
    for (unsigned i = 0; i < MR_PREDICT_ITEMS && status == MR_OK; i++) {
        if (collector->predict_known[i])
            status = store_predict_item_put(collector->store, slot->row.id, i,
                                            (double)collector->predict_item[i], error);
    }
    for (unsigned i = 0; i < MR_RISK_TOLD && status == MR_OK; i++) {
        if (collector->risk_known[i])
            status = store_risk_item_put(collector->store, slot->row.id, i,
                                         (double)collector->risk_item[i], error);
    }
    return status;
}

/* A list begins with its first number: what is not in it is missing. */
static enum mr_status risk_item(struct collector *collector, const struct side *side,
                                const struct mr_risk_item *m, struct error *error)
{
    if (m->index >= MR_RISK_TOLD)
        return MR_OK;
    if (m->index == 0)
        memset(collector->risk_known, 0, sizeof collector->risk_known);
    collector->risk_known[m->index] = true;
    collector->risk_item[m->index] = m->value;
    return side->current ? store_risk_item_put(collector->store, side->current->row.id, m->index,
                                               (double)m->value, error)
                         : MR_OK;
}

static enum mr_status risk(struct collector *collector, struct side *side,
                           const struct mr_message *m, struct error *error)
{
    struct store_risk part = store_blank_risk;
    part.links = collect_link_bit(side);
    if (m->place == MR_PLACE_RISK)
        collect_risk_row(&part, &m->as.risk);
    else
        collect_risk_lead_row(&part, &m->as.risk_lead);
    part.block = collect_block(side, m);
    return side->current && part.block >= 0
             ? store_risk_put(collector->store, side->current->row.id, &part, error)
             : MR_OK;
}

/* The parts of a statement. They have its block, the newest that came or one not long past. */
static enum mr_status statement(struct collector *collector, struct side *side,
                                const struct mr_message *m, struct error *error)
{
    struct store_prediction part = store_blank_prediction;
    part.links = collect_link_bit(side);
    switch (m->place) {
    case MR_PLACE_ZONE_ERROR: collect_zone_error_row(&part, &m->as.zone_error); break;
    case MR_PLACE_ZONE_COMING: collect_zone_coming_row(&part, &m->as.zone_coming); break;
    case MR_PLACE_ZONE_PRESS: collect_zone_press_row(&part, &m->as.zone_press); break;
    case MR_PLACE_VERDICT: collect_verdict_row(&part, &m->as.verdict); break;
    default: return MR_OK;
    }
    part.block = collect_block(side, m);
    return side->current && part.block >= 0
             ? store_prediction_put(collector->store, side->current->row.id, &part, error)
             : MR_OK;
}

enum mr_status collect_predict_message(struct collector *collector, struct side *side,
                                       const struct collector_event *event, struct error *error)
{
    const struct mr_message *m = event->message;
    switch (m->place) {
    case MR_PLACE_TRUST: return trust(collector, side, m, error);
    case MR_PLACE_RUNWAY: runway(side, &m->as.runway); return MR_OK;
    case MR_PLACE_RUNWAY_JOINTS: return joints(collector, side, &m->as.runway_joints, error);
    case MR_PLACE_RUNWAY_STORE: runway_store(collector, side, &m->as.runway_store); return MR_OK;
    case MR_PLACE_RISK:
    case MR_PLACE_RISK_LEAD: return risk(collector, side, m, error);
    case MR_PLACE_RISK_ITEM: return risk_item(collector, side, &m->as.risk_item, error);
    case MR_PLACE_PREDICT_ITEM: return item(collector, side, &m->as.predict_item, error);
    default: return statement(collector, side, m, error);
    }
}
