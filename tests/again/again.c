/* again DB RUN: the predictor of a recorded landing once more, on this computer, as the board ran
 * it: the firmware's own way from block records and edges to the model (common/onboard/landing.h,
 * common/onboard/predict_feed.h), armed with the runway and the parameters in the record. Its
 * statements are compared with the board's, field by field, as the wire has them: the same bits
 * make the same digits. One JSON object on stdout.
 *
 * Exit: 0 no difference, or it cannot be computed again ("lacks" names why); 1 a difference; else
 * as matrig. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "common/onboard/predict_feed.h"
#include "common/risk.h"
#include "common/watch.h"
#include "host/base/cli.h"
#include "host/store/store.h"

struct predict_again {
    bool possible;     /* the record holds all that is needed */
    const char *lacks; /* what it does not, when it is not possible */
    /* statements of the board, and of the host in the blocks that the record has */
    size_t said, made;
    size_t fields, differ;
    /* fields and statements that did not come, where the record says that frames were lost */
    size_t lost;
    /* the first that the record lacks: the comparison ends there; STORE_NONE: none */
    int64_t lacks_block;
    struct {
        int64_t block;
        char field[24];
        double said, made; /* NaN: none */
    } first;               /* difference */
    size_t backlogs;
    int64_t warned_block; /* that decided the first warning; STORE_NONE: none */
};

struct again {
    struct predict_again *result;
    struct store_landing row;
    struct store_edge *edge;
    size_t edges, next_edge;
    struct store_zone *zone;
    struct store_prediction *prediction;
    size_t zones, predictions, next_zone, next_prediction;
    struct store_risk *risk;
    size_t risks, next_risk;
    struct store_backlog *backlog;
    size_t backlogs, next_backlog;
    struct store_gap *gap;
    size_t gaps;

    struct mr_config config; /* that the board told */
    struct landing landing;
    struct mr_watch watch;
    struct baseline baseline;
    struct mr_predictor predictor;
    struct mr_predictor_zone look;
    struct mr_risk_plan plan;
    float lamp_limit;
    struct mr_risk_state hazard;
    struct mr_risk_report hazard_said;
    struct predict_motion motion;
    bool armed, warning, over;
    bool covered; /* frames of about this block were lost */
    int64_t block;
};

/* --- what the board knew --- */

static enum mr_status load_config(struct store *store, struct again *again, struct error *error)
{
    struct mr_config *config = &again->config;
    struct store_switch *place = NULL;
    size_t found, places = 0;
    enum mr_status status = store_channels_get(store, again->row.id, config->channel, &found,
                                               error);
    if (status == MR_OK)
        status = store_switches_get(store, again->row.id, &place, &places, error);
    for (size_t i = 0; i < places; i++) {
        if (place[i].position >= 1 && place[i].position <= (int64_t)MR_CONFIG_SWITCHES)
            config->gate[place[i].position - 1] =
                (struct mr_gate_config){.station_ft = (float)place[i].station_ft,
                                        .step_codes = (uint16_t)place[i].step_codes};
    }
    free(place);
    config->site[0].touchdown_ft = (float)again->row.touchdown_ft;
    config->site[0].switch_error_ft = (float)again->row.switch_error_ft;
    return status;
}

/* Edges are numbered from arming on; what is beyond 255 cannot be told apart. */
static bool edges_whole(const struct again *again)
{
    for (size_t i = 0; i < again->edges && i < UINT8_MAX; i++) {
        if (again->edge[i].count != (int64_t)i + 1)
            return false;
    }
    return true;
}

/* NULL: all is there. */
static const char *lacking(const struct again *again, bool runway, size_t items)
{
    if (!again->predictions)
        return "a word of the predictor";
    if (!runway)
        return "the runway it was armed with";
    if (items != (size_t)MR_PREDICT_ITEM_COUNT)
        return "its parameters";
    if (!edges_whole(again))
        return "an edge";
    return again->row.armed_block == STORE_NONE ? "the moment of arming" : NULL;
}

static enum mr_status load(struct store *store, struct again *again, struct error *error)
{
    struct mr_predictor_config parameters;
    struct mr_predictor_state state;
    struct store_segment *segment = NULL;
    size_t items = 0, segments = 0, risk_items = 0;
    int64_t run = again->row.id, source;
    bool runway = false;
    enum mr_status status = load_config(store, again, error);
    if (status == MR_OK)
        status = store_edges_get(store, run, &again->edge, &again->edges, error);
    if (status == MR_OK)
        status = store_zones_get(store, run, &again->zone, &again->zones, error);
    if (status == MR_OK)
        status = store_predictions_get(store, run, &again->prediction, &again->predictions, error);
    if (status == MR_OK)
        status = store_risks_get(store, run, &again->risk, &again->risks, error);
    if (status == MR_OK)
        status = store_risk_plan_get(store, run, &again->plan, &again->lamp_limit, &risk_items,
                                     error);
    if (status == MR_OK)
        status = store_backlogs_get(store, run, &again->backlog, &again->backlogs, error);
    if (status == MR_OK)
        status = store_gaps_get(store, run, &again->gap, &again->gaps, error);
    if (status == MR_OK)
        status = store_runway_get(store, run, &state, &source, &runway, error);
    if (status == MR_OK)
        status = store_predict_config_get(store, run, &parameters, &items, error);
    if (status == MR_OK)
        status = store_segments_get(store, run, &segment, &segments, error);
    if (status == MR_OK)
        again->result->lacks = again->risks && !risk_items ? "limits and chart of the risk"
                                                           : lacking(again, runway, items);
    again->result->possible = status == MR_OK && !again->result->lacks;
    if (again->result->possible && (mr_predictor_start(&again->predictor, &parameters) != MR_OK ||
                                    mr_predictor_load(&again->predictor, &state) != MR_OK)) {
        again->result->possible = false;
        again->result->lacks = "a runway that its parameters go with";
    }
    float slack_in[MR_SEGMENTS];
    for (size_t i = 0; i < MR_SEGMENTS; i++)
        slack_in[i] = NAN;
    for (size_t i = 0; status == MR_OK && i < segments; i++) {
        if (segment[i].segment >= 0 && segment[i].segment < (int64_t)MR_SEGMENTS)
            slack_in[segment[i].segment] = (float)segment[i].slack_in;
    }
    if (again->result->possible)
        mr_predictor_mark_surveyed(&again->predictor, slack_in);
    free(segment);
    return status;
}

/* --- comparing --- */

/* Whether the record says itself that it lacks something there. */
static bool has_gap(const struct again *again, int64_t block, bool of_the_board)
{
    for (size_t i = 0; i < again->gaps; i++) {
        const struct store_gap *gap = &again->gap[i];
        bool from = gap->from_block == STORE_NONE || gap->from_block <= block,
             to = gap->to_block == STORE_NONE || gap->to_block >= block;
        bool block_of_the_board = strcmp(gap->message, "block") == 0 &&
                                  strcmp(gap->cause, "board") == 0;
        if (from && to && block_of_the_board == of_the_board)
            return true;
    }
    return false;
}

static void compare(struct again *again, const char *field, double said, double made)
{
    struct predict_again *result = again->result;
    if (again->covered && isnan(said) && !isnan(made)) { /* lost on the way */
        result->lost++;
        return;
    }
    result->fields++;
    if (said == made || (isnan(said) && isnan(made)))
        return;
    if (result->differ++)
        return;
    result->first.block = again->block;
    snprintf(result->first.field, sizeof result->first.field, "%s", field);
    result->first.said = said;
    result->first.made = made;
}

static double whole(int64_t value)
{
    return value == STORE_NONE ? (double)NAN : (double)value;
}

/* What a message says when it has been through the wire. */
#define THROUGH_WIRE(name, message)                                                   \
    do {                                                                              \
        uint8_t payload_[MR_MESSAGE_BYTES_MAX];                                       \
        (void)mr_##name##_get(message, payload_, mr_##name##_put(message, payload_)); \
    } while (0)

static void compare_zone(struct again *again, const struct store_zone *z,
                         struct predict_report *said)
{
    THROUGH_WIRE(zone, &said->zone);
    THROUGH_WIRE(zone_lead, &said->zone_lead);
    compare(again, "mats", whole(z->mats), said->zone.mats);
    compare(again, "start_ft", z->start_ft, (double)said->zone.start_ft);
    compare(again, "end_ft", z->end_ft, (double)said->zone.end_ft);
    compare(again, "lead_s", z->lead_s, (double)said->zone_lead.lead_s);
    compare(again, "wheel_ft", z->wheel_ft, (double)said->zone_lead.wheel_ft);
    compare(again, "warning", whole(z->warning), said->zone_lead.warning);
    compare(again, "inferred_percent", whole(z->inferred_percent),
            said->zone_lead.inferred_percent);
}

static void compare_prediction(struct again *again, const struct store_prediction *p,
                               struct predict_report *said)
{
    THROUGH_WIRE(zone_error, &said->zone_error);
    THROUGH_WIRE(zone_coming, &said->zone_coming);
    THROUGH_WIRE(zone_press, &said->zone_press);
    if (said->zone.mats) {
        compare(again, "start_error_ft", p->start_error_ft, (double)said->zone_error.start_ft);
        compare(again, "end_error_ft", p->end_error_ft, (double)said->zone_error.end_ft);
        compare(again, "mean_gap_in", p->mean_gap_in, (double)said->zone_error.mean_gap_in);
    }
    compare(again, "closed_joints", whole(p->closed_joints), said->zone_coming.closed_joints);
    compare(again, "coming_mats", whole(p->coming_mats), said->zone_coming.mats);
    compare(again, "coming_wheel_ft", p->coming_wheel_ft, (double)said->zone_coming.wheel_ft);
    compare(again, "compression_lb", p->compression_lb, (double)said->zone_press.compression_lb);
    compare(again, "critical_lb", p->critical_lb, (double)said->zone_press.critical_lb);
    compare(again, "distance_ft", p->distance_ft, (double)said->zone_press.distance_ft);
    compare(again, "verdict", whole(p->verdict), said->verdict.verdict);
    compare(again, "reason", whole(p->reason), said->verdict.reason);
    compare(again, "level", whole(p->level), said->verdict.level);
    compare(again, "basis", whole(p->basis), said->verdict.basis);
    compare(again, "age", whole(p->age_blocks), said->verdict.age);
}

/* A board of before told no risk. */
static void compare_risk(struct again *again, struct predict_report *said)
{
    while (again->next_risk < again->risks && again->risk[again->next_risk].block < again->block) {
        compare(again, "risk", 1.0, (double)NAN);
        again->next_risk++;
    }
    if (!again->risks)
        return;
    const struct store_risk *r = &again->risk[again->next_risk];
    if (again->next_risk == again->risks || r->block != again->block) {
        compare(again, "risk", (double)NAN, 1.0);
        return;
    }
    again->next_risk++;
    THROUGH_WIRE(risk, &said->risk);
    THROUGH_WIRE(risk_lead, &said->risk_lead);
    compare(again, "risk", r->risk, (double)said->risk.risk);
    compare(again, "risk_basis", whole(r->basis), said->risk.basis);
    compare(again, "risk_reason", whole(r->reason), said->risk.reason);
    compare(again, "risk_start_s", r->start_s, (double)said->risk_lead.start_s);
    compare(again, "failure_s", r->failure_s, (double)said->risk_lead.failure_s);
    compare(again, "failure_ft", r->failure_ft, (double)said->risk_lead.failure_ft);
}

/* Statements of the board of blocks before `block` that the host has not made are differences. */
static void pass_over(struct again *again, int64_t block)
{
    int64_t now = again->block;
    again->covered = false;
    while (again->next_zone < again->zones &&
           (again->block = again->zone[again->next_zone].block) < block) {
        compare(again, "statement", 1.0, (double)NAN);
        again->next_zone++;
    }
    while (again->next_prediction < again->predictions &&
           (again->block = again->prediction[again->next_prediction].block) < block) {
        compare(again, "statement", 1.0, (double)NAN);
        again->next_prediction++;
    }
    again->block = now;
}

/* A statement of the host: the board's of the same block. One that there is not was lost, as a gap
 * says, or is a difference. */
static void hold_against(struct again *again)
{
    struct predict_report said;
    predict_fill_report(&again->predictor, &again->look, again->warning, (uint32_t)again->block,
                        &said);
    predict_fill_risk_report(&again->hazard_said, (uint32_t)again->block, &said);
    pass_over(again, again->block);
    again->covered = has_gap(again, again->block, false);
    const struct store_zone *z = again->next_zone < again->zones ? &again->zone[again->next_zone]
                                                                 : NULL;
    const struct store_prediction *p = again->next_prediction < again->predictions
                                         ? &again->prediction[again->next_prediction]
                                         : NULL;
    bool has_z = z && z->block == again->block, has_p = p && p->block == again->block;
    again->next_zone += has_z;
    again->next_prediction += has_p;
    again->result->made++;
    if (!has_z || !has_p) {
        bool has_r = again->next_risk < again->risks &&
                     again->risk[again->next_risk].block == again->block;
        again->next_risk += has_r; /* it was of this statement */
        compare(again, "statement", (double)NAN, 1.0);
        return;
    }
    again->result->said++;
    compare_zone(again, z, &said);
    compare_prediction(again, p, &said);
    compare_risk(again, &said);
}

/* --- a block --- */

static unsigned take_edges(struct again *again, uint32_t until_tick, uint32_t *ticks)
{
    unsigned count = 0;
    while (again->next_edge < again->edges && count < MR_SWITCHES_WAITING_MAX &&
           (int32_t)((uint32_t)again->edge[again->next_edge].tick - until_tick) <= 0)
        ticks[count++] = (uint32_t)again->edge[again->next_edge++].tick;
    return count;
}

static void read_transducers(struct again *again, const struct mr_block *block,
                             float *displacement_in)
{
    struct mr_watch_change news;
    float ratio = mr_reference_ratio(&again->config.channel[MR_REFERENCE], block);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        displacement_in[i] = NAN;
        if (again->config.channel[i].kind != MR_KIND_DISPLACEMENT)
            continue;
        struct mr_reading reading = mr_channel_read(&again->config.channel[i], block, i, ratio);
        mr_watch_check(&again->watch, &again->config.channel[i], i, block->index, &reading);
        displacement_in[i] = reading.value;
        if (again->watch.changed_channels >> i & 1u)
            mr_watch_get_change(&again->watch, i, block->index, &news);
    }
}

static void arm(struct again *again, const struct mr_block *block)
{
    landing_arm(&again->landing, (uint16_t)again->row.board_landing, block->index);
    mr_watch_begin(&again->watch, again->config.channel, block->index);
    baseline_discard(&again->baseline);
    mr_predictor_arm(&again->predictor);
    mr_risk_arm(&again->hazard, __builtin_isnan(again->plan.speed_ft_s) ? NULL : &again->plan,
                &again->predictor, again->config.site[0].touchdown_ft);
    again->hazard_said = (struct mr_risk_report){.risk = NAN};
    again->look = (struct mr_predictor_zone){.level = again->predictor.level};
    again->armed = true;
}

static void look(struct again *again, const struct mr_block *block)
{
    struct mr_predictor_zone was = again->look;
    mr_predictor_get_zone(&again->predictor, &again->look);
    mr_risk_compute(&again->hazard, &again->predictor, &again->look, &again->hazard_said);
    bool warning = mr_risk_is_lamp_on(again->lamp_limit, &again->look, &again->hazard_said) &&
                   landing_can_warn(&again->landing, block->index);
    bool changed = warning != again->warning || again->look.verdict != was.verdict ||
                   again->look.level != was.level;
    again->warning = warning;
    if (warning && again->result->warned_block == STORE_NONE)
        again->result->warned_block = block->index;
    if (changed || block->index % PREDICT_REPORT_BLOCKS == 0)
        hold_against(again);
}

static void take_backlog(struct again *again)
{
    while (again->next_backlog < again->backlogs &&
           again->backlog[again->next_backlog].block < again->block)
        again->next_backlog++;
    if (again->next_backlog < again->backlogs &&
        again->backlog[again->next_backlog].block == again->block) {
        mr_predictor_reduce_level(&again->predictor);
        again->result->backlogs++;
    }
}

/* From arming on every block is needed, but those that the board itself has not had. False: it ends
 * here. */
static bool follows(struct again *again, int64_t index)
{
    int64_t wanted = again->armed ? again->block + 1 : again->row.armed_block;
    if (!again->armed && index < wanted)
        return true;
    for (; wanted < index; wanted++) {
        if (!has_gap(again, wanted, true)) {
            again->result->lacks_block = wanted;
            return false;
        }
    }
    return true;
}

static enum mr_status take_block(void *context, const uint8_t *record, size_t length, int link)
{
    (void)link;
    struct again *again = context;
    struct mr_block block;
    struct mr_predictor_input input;
    uint32_t ticks[MR_SWITCHES_WAITING_MAX];
    float displacement_in[MR_TRANSDUCERS];
    if (again->over || mr_block_decode(&block, record, length) != MR_OK)
        return MR_OK;
    again->over = !follows(again, block.index);
    if (again->over)
        return MR_OK;
    again->block = block.index;
    if (!again->armed && again->block >= again->row.armed_block)
        arm(again, &block);
    unsigned edges = again->armed ? take_edges(again, block.tick + LANDING_BLOCK_EDGE_TICKS, ticks)
                                  : 0;
    landing_on_block(&again->landing, &again->config, block.index, block.tick,
                     mr_staircase_code(&block), ticks, edges);
    again->over = again->armed && !landing_is_recording(&again->landing);
    if (!again->armed || again->over)
        return MR_OK;
    read_transducers(again, &block, displacement_in);
    baseline_update(&again->baseline, displacement_in,
                    landing_is_quiet(&again->landing, block.index),
                    predict_find_frozen_zeros(&again->predictor, &again->landing));
    take_backlog(again);
    predict_compute_input(&again->motion, &again->landing, again->config.site[0].touchdown_ft,
                          &(struct predict_block){.index = block.index,
                                                  .tick = block.tick,
                                                  .displacement_in = displacement_in,
                                                  .baseline_in = again->baseline.zero_in},
                          &input);
    mr_predictor_on_block(&again->predictor, &input);
    mr_risk_on_block(&again->hazard, &again->predictor, &input);
    if (block.index % PREDICT_LAMP_BLOCKS == 0)
        look(again, &block);
    return MR_OK;
}

static enum mr_status predict_again(struct store *store, int64_t run, struct predict_again *result,
                                    struct error *error)
{
    struct again *again = calloc(1, sizeof *again);
    if (!again)
        abort();
    *result = (struct predict_again){.lacks_block = STORE_NONE, .warned_block = STORE_NONE};
    again->result = result;
    landing_start(&again->landing);
    enum mr_status status = store_landing_get(store, run, &again->row, error);
    if (status == MR_OK)
        status = load(store, again, error);
    if (status == MR_OK && result->possible)
        status = store_blocks_for_each(store, run, take_block, again, error);
    if (status == MR_OK && result->possible && result->made)
        pass_over(again, result->lacks_block == STORE_NONE ? again->block : result->lacks_block);
    if (status == MR_OK && result->possible && !result->made) {
        result->possible = false;
        result->lacks = again->armed ? "block records" : "block records from arming on";
    }
    free(again->edge);
    free(again->zone);
    free(again->prediction);
    free(again->risk);
    free(again->backlog);
    free(again->gap);
    free(again);
    return status;
}

/* A number, null where there is none. */
static void number(const char *name, double value)
{
    if (isnan(value))
        printf("\"%s\":null,", name);
    else
        printf("\"%s\":%.17g,", name, value);
}

static void count(const char *name, int64_t value)
{
    number(name, value == STORE_NONE ? (double)NAN : (double)value);
}

int main(int argc, char **argv)
{
    struct error error = {0};
    struct predict_again again;
    struct store *store = NULL;
    if (argc != 3) {
        fprintf(stderr, "again: usage: again DB RUN\n");
        return 2;
    }
    enum mr_status status = store_open(argv[1], STORE_READ, &store, &error);
    if (status == MR_OK)
        status = predict_again(store, atoll(argv[2]), &again, &error);
    store_close(store);
    if (status != MR_OK)
        return cli_fail(&error);
    printf("{\"possible\":%s,", again.possible ? "true" : "false");
    count("statements", (int64_t)again.said);
    count("made", (int64_t)again.made);
    count("fields", (int64_t)again.fields);
    count("differ", (int64_t)again.differ);
    count("backlogs", (int64_t)again.backlogs);
    count("first_warning_block", again.warned_block);
    count("lost", (int64_t)again.lost);
    count("lacks_block", again.lacks_block);
    if (again.differ) {
        printf("\"first\":{");
        number("board", again.first.said);
        number("host", again.first.made);
        printf("\"block\":%lld,\"field\":\"%s\"},", (long long)again.first.block,
               again.first.field);
    }
    printf("\"lacks\":\"%s\"}\n", again.lacks ? again.lacks : "");
    return again.differ > 0;
}
