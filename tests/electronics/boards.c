#include "tests/electronics/boards.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/channels.h"
#include "common/command.h"
#include "common/framing.h"
#include "firmware/config.h"
#include "hil/board/board.h"
#include "hil/periph/cells.h"
#include "hil/rig/runfile.h"
#include "host/calibrate/fit.h"

#define FIRST_OPENS_S 0.25
#define OPENS_EACH_S  0.025 /* edges nearer than 10 ms can be one contact's */
#define SWITCHES_S    0.9   /* all have opened and are told */
#define ZERO_S        0.95
#define LEVELS_S      1.4
#define LEVEL_S       0.4
#define HOLD_S        0.28 /* of a level, the rest is the way to the next */
#define RATE_HZ       10.0
#define CALIBRATED    5u
#define LEVELS        9u
#define FULL_IN       2.8
#define FULL_LB       400.0

/* Parts of the full value: five to calibrate with, four in between. */
static const double level[LEVELS] = {0.0, 0.25, 0.5, 0.75, 1.0, 0.125, 0.375, 0.625, 0.875};

struct play {
    const struct board_request *request;
    struct board_outcome *outcome;
    struct hil_board *board;
    struct mr_deframer deframer;
    struct mr_config zeroed; /* the configuration with the zeros that were measured */
    unsigned edges;
    bool answered;
    double now_s;
    unsigned blocks[LEVELS];
    double code[LEVELS][HIL_RUN_COLUMNS]; /* sums, times the reference's ratio */
    unsigned invalid[HIL_RUN_COLUMNS];
};

double board_vdda_v(uint64_t seed)
{
    uint64_t random = seed * 0x2545f4914f6cdd1dull + 11u;
    return 3.24 + 0.12 * (double)(hil_random(&random) >> 11) * 0x1p-53;
}

static double full(unsigned channel)
{
    return channel < HIL_RUN_TRANSDUCERS ? FULL_IN : FULL_LB;
}

static bool make_run(struct hil_run *run, const struct board_request *request)
{
    bool only_switches = request->only_switches;
    *run = (struct hil_run){.duration_s = 10.0, .rate_hz = RATE_HZ, .sample_count = 1};
    if (!only_switches)
        run->sample_count = (size_t)((LEVELS_S + LEVELS * LEVEL_S) * RATE_HZ) + 1u;
    run->samples = calloc(run->sample_count, sizeof *run->samples);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        run->switch_open_ps[i] = i + 1u == request->stays_closed
                                   ? HIL_RUN_NEVER
                                   : (uint64_t)((FIRST_OPENS_S + OPENS_EACH_S * i) * 1e12);
    for (size_t row = 0; run->samples && row < run->sample_count; row++) {
        double since_s = (double)row / RATE_HZ - LEVELS_S + 0.5 / RATE_HZ;
        if (since_s < 0.0)
            continue;
        double part =
            level[since_s / LEVEL_S < LEVELS ? (unsigned)(since_s / LEVEL_S) : LEVELS - 1u];
        for (unsigned c = 0; c < HIL_RUN_COLUMNS; c++)
            run->samples[row][c] =
                (int32_t)lround(part * full(c) * (c < HIL_RUN_TRANSDUCERS ? 1e5 : 1e2));
    }
    return run->samples != NULL;
}

/* ---- what the board says ---- */

static void take_edge(struct play *play, const struct mr_edge *edge)
{
    struct board_outcome *outcome = play->outcome;
    unsigned i = play->edges++;
    i += play->request->stays_closed && i + 1u >= play->request->stays_closed;
    if (i >= HIL_RUN_SWITCHES)
        return;
    outcome->step_codes[i] = edge->step_codes;
    outcome->position[i] = edge->position;
    if (edge->position == i + 1u)
        outcome->named++;
    else if (edge->position)
        outcome->misnamed++;
}

static void take_block(struct play *play, const struct mr_block *block)
{
    double since_s = play->now_s - LEVELS_S;
    if (since_s < 0.0 || play->request->only_switches)
        return;
    unsigned at = (unsigned)(since_s / LEVEL_S);
    double within_s = since_s - at * LEVEL_S;
    if (at >= LEVELS || within_s < 0.01 || within_s > HOLD_S)
        return;
    float ratio = mr_channels_ratio(&config.channel[MR_REFERENCE], block);
    play->blocks[at]++;
    for (unsigned c = 0; c < HIL_RUN_COLUMNS; c++) {
        struct mr_reading reading = mr_channel_read(&config.channel[c], block, c, ratio);
        play->invalid[c] += reading.validity != MR_VALID;
        play->code[at][c] += (double)(reading.code * ratio);
    }
}

static void take_frame(struct play *play, const struct mr_frame *frame)
{
    struct mr_edge edge;
    struct mr_zero_result zero;
    struct mr_ack ack;
    struct mr_block block;
    if (frame->type == MR_ID_EDGE && mr_edge_get(&edge, frame->payload, frame->length) == MR_OK)
        take_edge(play, &edge);
    else if (frame->type == MR_ID_ZERO_RESULT &&
             mr_zero_result_get(&zero, frame->payload, frame->length) == MR_OK &&
             zero.index < HIL_RUN_COLUMNS)
        play->zeroed.channel[zero.index].zero_code = zero.zero_code;
    else if (frame->type == MR_ID_ACK && mr_ack_get(&ack, frame->payload, frame->length) == MR_OK &&
             ack.code == MR_COMMAND_ZERO)
        play->outcome->zero_taken = ack.status == MR_OK;
    else if (frame->type == MR_ID_BLOCK &&
             mr_block_get(&block, frame->payload, frame->length) == MR_OK)
        take_block(play, &block);
}

static void on_serial(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct play *play = ctx;
    struct mr_frame frame;
    play->now_s = (double)t_ps * 1e-12;
    for (size_t i = 0; i < n; i++) {
        if (mr_deframer_push(&play->deframer, bytes[i], &frame) == MR_OK)
            take_frame(play, &frame);
    }
}

/* ---- the run ---- */

static void order(struct play *play, unsigned code, int32_t argument)
{
    struct mr_command command = {.code = (uint8_t)code, .argument = argument, .tag = 1};
    uint8_t payload[MR_MESSAGE_MAX], bytes[MR_FRAME_MAX];
    size_t n = mr_command_put(&command, payload);
    (void)hil_board_serial_inject(
        play->board, bytes, mr_frame_encode((uint16_t)code, MR_ID_COMMAND, payload, n, bytes));
}

static void until(struct play *play, double t_s)
{
    if (!play->outcome->trouble[0] &&
        hil_board_run_until(play->board, (uint64_t)(t_s * 1e12)) != MR_OK)
        snprintf(play->outcome->trouble, sizeof play->outcome->trouble, "%s",
                 hil_board_reason(play->board));
}

static void run(struct play *play)
{
    const struct board_request *request = play->request;
    until(play, 0.1);
    order(play, MR_COMMAND_LIVE, 20);
    until(play, SWITCHES_S);
    if (request->only_switches)
        return;
    until(play, ZERO_S);
    order(play, MR_COMMAND_ZERO, 0);
    until(play, LEVELS_S + LEVELS * LEVEL_S);
}

/* ---- what is made of it ---- */

static double value_of(const struct mr_channel_config *channel, double code)
{
    return (code - (double)channel->zero_code) * (double)channel->unit_per_code;
}

/* Gain of readings against truth between the first and the last level in between, less 1. */
static double gain_less_one(const struct mr_channel_config *channel, const double code[LEVELS],
                            double full_value)
{
    double read = value_of(channel, code[LEVELS - 1u]) - value_of(channel, code[CALIBRATED]);
    return read / ((level[LEVELS - 1u] - level[CALIBRATED]) * full_value) - 1.0;
}

static void judge(struct play *play, unsigned c)
{
    struct board_channel *out = &play->outcome->channel[c];
    struct mr_channel_config calibrated = config.channel[c];
    struct calibrate_point points[CALIBRATED];
    struct calibrate_fit fit;
    struct error error = {0};
    double code[LEVELS];
    for (unsigned i = 0; i < LEVELS; i++)
        code[i] = play->code[i][c] / play->blocks[i];
    for (unsigned i = 0; i < CALIBRATED; i++)
        points[i] = (struct calibrate_point){level[i] * full(c), code[i], (double)NAN};
    out->valid = !play->invalid[c];
    out->zero = value_of(&config.channel[c], code[0]);
    out->span_rel = gain_less_one(&config.channel[c], code, full(c));
    out->zeroed = value_of(&play->zeroed.channel[c], code[0]);
    out->left_zero = out->left_span = out->left_worst = (double)NAN;
    if (!out->valid ||
        calibrate_fit(points, CALIBRATED, 0.0, false, &calibrated, &fit, &error) != MR_OK)
        return;
    out->left_zero = value_of(&calibrated, code[0]);
    out->left_span = gain_less_one(&calibrated, code, full(c));
    out->left_worst = 0.0;
    for (unsigned i = CALIBRATED; i < LEVELS; i++) {
        double off = value_of(&calibrated, code[i]) - level[i] * full(c);
        out->left_worst = fabs(off) > fabs(out->left_worst) ? off : out->left_worst;
    }
}

void board_play(const struct board_request *request, struct board_outcome *outcome)
{
    struct play *play = calloc(1, sizeof *play);
    struct hil_options options;
    struct hil_run truth;
    memset(outcome, 0, sizeof *outcome);
    for (unsigned i = 0; i < HIL_RUN_SWITCHES; i++)
        outcome->step_codes[i] = NAN;
    if (!play || !make_run(&truth, request))
        abort();
    struct hil_callbacks callbacks = {.ctx = play, .on_serial_bytes = on_serial};
    *play = (struct play){.request = request, .outcome = outcome, .zeroed = config};
    mr_deframer_init(&play->deframer);
    hil_options_default(&options);
    options.seed = request->seed + 1u;
    options.board_drawn = true;
    options.board_seed = request->seed;
    options.vdda_v = request->vdda_v;
    options.figures = request->figures;
    hil_electronics_make(&outcome->electronics, &options, request->figures);
    play->board = hil_board_create(&options);
    hil_board_set_callbacks(play->board, &callbacks);
    if (hil_board_load_elf(play->board, BOARDS_ELF) != MR_OK)
        snprintf(outcome->trouble, sizeof outcome->trouble, "%s", hil_board_reason(play->board));
    hil_board_attach_rig(play->board, &truth);
    run(play);
    outcome->unnamed = HIL_RUN_SWITCHES - outcome->named - outcome->misnamed;
    for (unsigned c = 0; !request->only_switches && !outcome->trouble[0] && c < HIL_RUN_COLUMNS;
         c++)
        judge(play, c);
    hil_board_destroy(play->board);
    hil_run_free(&truth);
    free(play);
}
