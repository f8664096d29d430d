#include "host/board/gage_client.h"

#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/command.h"
#include "host/board/ready_client.h"
#include "host/base/xmalloc.h"

/* ---- shunts ---- */

void shunts_take(struct shunts *shunts, uint32_t id, const uint8_t *bytes, size_t length)
{
    struct mr_shunt_check check;
    if (id == MR_ID_SHUNT) {
        shunts->begun = true;
        shunts->count = 0;
    } else if (id == MR_ID_SHUNT_RESULT) {
        if (shunts->begun && shunts->count < MR_GAGES &&
            mr_shunt_result_get(&shunts->result[shunts->count], bytes, length) == MR_OK)
            shunts->check[shunts->count++] = (struct mr_shunt_check){
                .expected_lb = NAN, .change_lb = NAN, .zero_change_lb = NAN};
    } else if (id == MR_ID_SHUNT_CHECK && shunts->count &&
               mr_shunt_check_get(&check, bytes, length) == MR_OK &&
               check.gage == shunts->result[shunts->count - 1].gage) {
        shunts->check[shunts->count - 1] = check;
    }
}

const char *shunts_verdict_text(int64_t verdict)
{
    return verdict >= MR_SHUNT_GOOD && verdict <= MR_SHUNT_WRONG
             ? mr_shunt_verdict_text((unsigned)verdict)
             : "not calibrated";
}

/* ---- zeros and shunts of a board ---- */

static enum mr_status take(void *context, const struct dialogue_message *message,
                           struct error *error)
{
    struct gage_client *talk = context;
    (void)error;
    shunts_take(&talk->shunts, message->id, message->payload, message->length);
    if (message->id == MR_ID_ZERO_RESULT && talk->zeros < MR_CHANNELS &&
        mr_zero_result_get(&talk->zero[talk->zeros], message->payload, message->length) == MR_OK)
        talk->zeros++;
    return MR_OK;
}

enum mr_status gage_client_order(struct gage_client *talk, struct dialogue *dialogue, unsigned code,
                                 int32_t argument, struct error *error)
{
    const struct dialogue_order order = {
        .code = (uint8_t)code, .argument = argument, .answer_s = DIALOGUE_ANSWER_S};
    const char *link = dialogue_spec(dialogue);
    *talk = (struct gage_client){.zeros = 0};
    dialogue_subscribe(dialogue, take, talk);
    enum mr_status status = dialogue_hello(dialogue, NULL, NULL, error);
    if (status == MR_OK)
        status = dialogue_order(dialogue, &order, &talk->ack, error);
    if (status == MR_TIMEOUT)
        return error_set(
            error, MR_TIMEOUT,
            "the board did not answer within %.0f s: %s; is it powered, are its scans running?",
            DIALOGUE_ANSWER_S, link);
    if (status != MR_OK)
        return status;
    if (talk->ack.status == MR_NOT_NOW)
        return error_set(error, MR_NOT_NOW,
                         "the board is armed, in a landing, or calibrating: %s; disarm it, or wait",
                         link);
    if (talk->ack.status != MR_OK && talk->ack.status != MR_LIMIT)
        return error_set(error, (enum mr_status)talk->ack.status,
                         "the board refused %s (%s): %s; see matrig board --help",
                         mr_command_name(code), mr_status_text((enum mr_status)talk->ack.status),
                         link);
    return MR_OK;
}

/* ---- guided calibration ---- */

#define POINT_BLOCKS 40u  /* of the board's live readings, 20 ms apart */
#define POINT_S      10.0 /* for them to come */
#define LIVE_S       20
#define MEET_S       20.0
#define MOVES_CODES  6.0 /* a block's noise is below 1 code; more is movement */

struct gathering {
    const struct mr_channel_config *reference;
    unsigned channel, count, bad;
    double sum, squares, first;
};

static void gather(void *context, const struct mr_block *block)
{
    struct gathering *g = context;
    const struct mr_channel_config plain = {
        .kind = g->channel < MR_TRANSDUCERS ? MR_KIND_DISPLACEMENT : MR_KIND_TENSION,
        .unit_per_code = 1.0f};
    float ratio = mr_channels_ratio(g->reference, block);
    struct mr_reading reading = mr_channel_read(&plain, block, g->channel, ratio);
    if (g->count == POINT_BLOCKS)
        return;
    if (isnan(reading.value)) {
        g->bad++;
        return;
    }
    double code = (double)reading.code * (double)ratio;
    g->first = g->count ? g->first : code;
    g->sum += code - g->first;
    g->squares += (code - g->first) * (code - g->first);
    g->count++;
}

static bool gathered(const void *context)
{
    const struct gathering *g = context;
    return g->count == POINT_BLOCKS || g->bad == POINT_BLOCKS;
}

/* The channel's mean over a second or so. */
static enum mr_status measure(struct ready_client *talk, struct gathering *g, const char *name,
                              struct calibrate_point *point, struct error *error)
{
    *g = (struct gathering){.reference = g->reference, .channel = g->channel};
    enum mr_status status = ready_client_live(talk, LIVE_S, error);
    if (status != MR_OK && error->status == MR_OK)
        return error_set(error, status, "the board does not read live (%s): %s; it must be idle",
                         mr_status_text(status), dialogue_spec(talk->dialogue));
    if (status == MR_OK)
        status = dialogue_until(talk->dialogue, gathered, g, POINT_S, error);
    if (error->status == MR_OK && g->count < POINT_BLOCKS)
        return error_set(error, g->bad ? MR_LIMIT : MR_TIMEOUT, "%s: %s; %s", name,
                         g->bad ? "its readings are not valid" : "no readings came within 10 s",
                         g->bad ? "look at its leads" : "is the board connected?");
    double n = g->count;
    point->code = g->first + g->sum / n;
    point->spread = sqrt(fmax(g->squares - g->sum * g->sum / n, 0.0) / (n - 1.0));
    return status;
}

/* A line from the keyboard while the board is listened to, so that nothing piles up. False: the
 * end. */
static bool typed_line(struct ready_client *talk, char *line, size_t size, struct error *error)
{
    size_t length = 0;
    while (error->status == MR_OK) {
        struct pollfd ready = {.fd = STDIN_FILENO, .events = POLLIN};
        char byte;
        if (poll(&ready, 1, 0) == 1) {
            if (read(STDIN_FILENO, &byte, 1) != 1)
                return false;
            if (byte == '\n' || byte == '\r') {
                line[length] = '\0';
                return true;
            }
            if (length + 1 < size)
                line[length++] = byte;
            continue;
        }
        (void)dialogue_turn(talk->dialogue, DIALOGUE_TURN_S, error);
    }
    return false;
}

static enum mr_status guide(const struct calibrate_guided *r, struct ready_client *talk,
                            const struct mr_config *config, struct calibrate_points *points,
                            struct error *error)
{
    struct gathering g = {.reference = &config->channel[MR_REFERENCE], .channel = r->channel};
    char line[100];
    const char *unit = r->unit->word;
    points->unit = r->unit;
    talk->context = &g;
    talk->reading = gather;
    talk->until_s = (double)INFINITY;
    cli_note(r->cli,
             "%s: set a known value, let it rest, type it (%s) and Enter; u takes the last one "
             "back; an empty line or q ends",
             r->name, unit);
    while (points->count < CALIBRATE_POINTS_MAX) {
        if (!r->cli->quiet)
            fprintf(stderr, "point %zu, %s: ", points->count + 1, unit);
        if (!typed_line(talk, line, sizeof line, error) || line[0] == '\0' ||
            strcmp(line, "q") == 0)
            break;
        if (strcmp(line, "u") == 0) {
            points->count -= points->count > 0;
            continue;
        }
        struct calibrate_point point;
        struct quantity_wrong wrong;
        if (!calibrate_value(line, r->unit->kind, r->unit, &point.value, &wrong)) {
            cli_note(r->cli, "not a value: '%s': %s; %s", line, wrong.what, wrong.advice);
            continue;
        }
        if (measure(talk, &g, r->name, &point, error) != MR_OK)
            break;
        bool moves = point.spread > MOVES_CODES;
        cli_note(r->cli, "%.3f codes, noise %.2f%s", point.code, point.spread,
                 moves ? ": it moves, not taken; let it rest and type it again" : "");
        if (!moves)
            points->point[points->count++] = point;
    }
    struct error late = {0};
    if (error->status == MR_OK)
        (void)ready_client_live(talk, 0, &late);
    return error->status;
}

enum mr_status calibrate_guide(const struct calibrate_guided *r, struct mr_config *config,
                               struct calibrate_points *points, struct error *error)
{
    struct dialogue dialogue;
    struct ready_client *talk = xcalloc(1, sizeof *talk);
    struct ready_facts *facts = xcalloc(1, sizeof *facts);
    enum mr_status status = dialogue_open(&dialogue, NULL, r->serial, error);
    if (status == MR_OK) {
        ready_client_begin(talk, &dialogue, facts, MEET_S);
        status = ready_client_meet(talk, error);
    }
    if (status == MR_OK && !facts->hello)
        status = dialogue_no_hello(&dialogue, error);
    if (status == MR_OK && !facts->config_known)
        status = error_set(
            error, MR_TIMEOUT,
            "the board did not tell its configuration: %s; it must be idle, try again", r->serial);
    if (status == MR_OK)
        *config = facts->config;
    if (status == MR_OK && !mr_channel_measures(&config->channel[r->channel]))
        status = error_set(error, MR_USAGE,
                           "%s is not fitted: the configuration of %s; see matrig board config",
                           r->name, r->serial);
    if (status == MR_OK)
        status = guide(r, talk, config, points, error);
    dialogue_close(&dialogue);
    free(talk);
    free(facts);
    return status;
}
