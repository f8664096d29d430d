#include "firmware/app.h"

#include <string.h>

#include "common/channels.h"
#include "common/command.h"
#include "common/wire.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "firmware/tasks.h"

/* An edge belongs to the block in whose first 0.9 ms it falls, or to the next: when a block is taken, 0.97 ms after its
 * first trigger, every edge up to there has been stored, however busy the processor was. */
#define EDGE_WINDOW_TICKS 75600u
#define STALL_TICKS 5u             /* supervision ticks without a block */
#define TICKS_PER_S 100u

/* A row of the histories whose block there is not. */
static void miss_block(struct app *app, uint32_t index)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        app->displacement_in[index % 4][i] = MR_NAN;
    for (unsigned i = 0; i < MR_GAGES; i++)
        app->tension_lb[index % 4][i] = MR_NAN;
}

static void forget_baseline(struct app *app)
{
    app->baseline_blocks = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        app->baseline_sum_in[i] = 0.0f;
        app->baseline_in[i] = MR_NAN;
    }
}

void app_start(struct app *app)
{
    memset(app, 0, sizeof *app);
    landing_start(&app->landing);
    mr_deframer_init(&app->deframer);
    for (unsigned i = 0; i < MR_SEGMENTS; i++)
        app->slack_in[i] = MR_NAN;
    for (unsigned i = 0; i < 4; i++)
        miss_block(app, i);
    forget_baseline(app);
    blackbox_start(&app->box);
    telemetry_start(&app->telemetry);
    app->telemetry.box = &app->box;
    healthlink_start(&app->healthlink);
    telemetry_burst(&app->telemetry, &app->landing);
    board_warn(false);
}

/* The blocks just before the one to come, as far as there is no gap: what follows is a function of the record alone. */
static void tell_blocks_before(struct app *app)
{
    uint32_t first = app->next_index;
    while (first > 0 && app->next_index - first < APP_BLOCKS_BEFORE && app->blocks_in_row > app->next_index - first)
        first--;
    for (; first != app->next_index; first++)
        telemetry_block(&app->telemetry, &app->newest[first % APP_BLOCKS_BEFORE]);
}

static enum mr_status arm(struct app *app, const struct mr_command *command)
{
    if (command->argument < 0 || command->argument > UINT16_MAX)
        return MR_USAGE;
    enum mr_status status = landing_recording(&app->landing) ? MR_NOT_NOW : blackbox_ready(&app->box);
    if (status == MR_WAIT || status == MR_FULL)
        boxlink_tell_state(&app->box, &app->telemetry);
    if (status != MR_OK)
        return status;
    status = landing_arm(&app->landing, (uint16_t)command->argument, app->next_index);
    if (status == MR_OK) {
        forget_baseline(app);
        healthlink_arm(&app->healthlink, &app->telemetry);
        board_warn(app->warning);
        boxlink_arm(&app->box, &app->telemetry, &app->landing, app->slack_in);
        telemetry_state(&app->telemetry, &app->landing);
        tell_blocks_before(app);
        telemetry_burst(&app->telemetry, &app->landing);
    }
    return status;
}

static void warn(struct app *app, bool warning)
{
    app->warning = warning;
    board_warn(warning);
}

/* The landing is over: a warning ends with it, and that is told. */
static void end_warning(struct app *app, uint32_t index)
{
    if (app->warning)
        telemetry_zone(&app->telemetry, &(struct mr_closure_zone){.lead_s = MR_NAN}, MR_NAN, false, index);
    warn(app, false);
}

static enum mr_status mark(struct app *app, const struct mr_command *command)
{
    if (command->argument < 0 || command->argument > UINT16_MAX)
        return MR_USAGE;
    telemetry_mark(&app->telemetry, &(struct mr_mark){.number = (uint16_t)command->argument,
                                                      .landing = app->landing.number, .block = app->next_index});
    return MR_OK;
}

static enum mr_status survey(struct app *app, const struct mr_command *command)
{
    if (landing_recording(&app->landing))
        return MR_NOT_NOW;
    /* not more than the message `slack` can repeat */
    if (command->index >= MR_SEGMENTS || command->argument < 0 ||
        command->argument >= (int32_t)MR_MISSING_U16)
        return MR_USAGE;
    app->slack_in[command->index] = (float)command->argument / 10000.0f;
    return MR_OK;
}

static enum mr_status enter_rom(struct app *app)
{
    if (landing_recording(&app->landing))
        return MR_NOT_NOW;
    app->ticks_to_rom = APP_ROM_TICKS;
    return MR_OK;
}

/* MR_OK: answered, whatever the answer; else it was no command. */
static enum mr_status obey(struct app *app, const uint8_t *payload, size_t length)
{
    struct mr_command command;
    enum mr_status status = mr_command_get(&command, payload, length);
    if (status != MR_OK)
        return status;
    blackbox_note(&app->box, MR_ID_COMMAND, payload, length);
    switch (command.code) {
    case MR_COMMAND_STATE:
        telemetry_state(&app->telemetry, &app->landing);
        telemetry_burst(&app->telemetry, &app->landing);
        healthlink_tell_crash(&app->healthlink);
        break;
    case MR_COMMAND_ARM:
        status = arm(app, &command);
        break;
    case MR_COMMAND_DISARM:
        landing_disarm(&app->landing, app->next_index);
        end_warning(app, app->next_index);
        telemetry_state(&app->telemetry, &app->landing);
        break;
    case MR_COMMAND_MARK:
        status = mark(app, &command);
        break;
    case MR_COMMAND_SURVEY:
        status = survey(app, &command);
        break;
    case MR_COMMAND_BOOTROM:
        status = enter_rom(app);
        break;
    case MR_COMMAND_RESET:
    case MR_COMMAND_SELF_TEST:
        status = healthlink_obey(&app->healthlink, &command, !landing_recording(&app->landing));
        break;
    default:
        status = boxlink_obey(&app->boxlink, &app->box, &app->telemetry, &command);
        break;
    }
    telemetry_ack(&app->telemetry, &(struct mr_ack){.code = command.code, .status = (int8_t)status,
                                                    .tag = command.tag, .block = app->next_index});
    return MR_OK;
}

static void take_commands(struct app *app)
{
    struct board_can_frame can;
    uint8_t bytes[APP_SERIAL_BYTES];
    tasks_begin(MR_TASK_COMMANDS);

    for (unsigned i = 0; i < APP_CAN_COMMANDS && board_can_receive(&can); i++) {
        if (can.id == MR_ID_COMMAND)
            (void)obey(app, can.data, can.length);
    }
    size_t count = board_serial_receive(bytes, sizeof bytes);
    for (size_t i = 0; i < count; i++) {
        struct mr_frame frame;
        enum mr_status status = mr_deframer_push(&app->deframer, bytes[i], &frame);
        if (status == MR_OK && frame.type == MR_ID_COMMAND)
            status = obey(app, frame.payload, frame.length);
        if (status != MR_OK && status != MR_TOO_FEW) {
            if (app->telemetry.serial_bad < UINT16_MAX)
                app->telemetry.serial_bad++;
            health_count(MR_FAULT_SERIAL_BAD_FRAME, (uint8_t)-status);
        }
    }
    tasks_done(MR_TASK_COMMANDS);
}

/* Mean of the last `count` rows of a history of 4; NaN when one is missing. `row` is the newest. */
static void mean_of_last(const float *history, unsigned width, unsigned row, unsigned count, float *mean)
{
    for (unsigned c = 0; c < width; c++) {
        float sum = 0.0f;
        for (unsigned age = 0; age < count; age++)
            sum += history[((row + 4 - age) % 4) * width + c];
        mean[c] = sum / (float)count;
    }
}

static void read_channels(struct app *app, const struct mr_block *block)
{
    unsigned row = block->index % 4;
    float ratio = mr_channels_ratio(block);
    if (__builtin_isnan(ratio))
        health_count(MR_FAULT_REFERENCE, 0);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        app->displacement_in[row][i] = mr_channel_read(&config.channel[i], block, i, ratio).value;
    for (unsigned i = 0; i < MR_GAGES; i++)
        app->tension_lb[row][i] =
            mr_channel_read(&config.channel[MR_TRANSDUCERS + i], block, MR_TRANSDUCERS + i, ratio).value;
}

/* While armed, the mean of each full group of blocks becomes the zero: the newest one before the first edge stands. */
static void follow_baseline(struct app *app, unsigned row)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        app->baseline_sum_in[i] += app->displacement_in[row][i];
    if (++app->baseline_blocks < APP_BASELINE_BLOCKS)
        return;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        app->baseline_in[i] = app->baseline_sum_in[i] / (float)APP_BASELINE_BLOCKS;
        app->baseline_sum_in[i] = 0.0f;
    }
    app->baseline_blocks = 0;
}

/* The group that was being summed ends with something that may move the mat. */
static void forget_partial_baseline(struct app *app)
{
    app->baseline_blocks = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        app->baseline_sum_in[i] = 0.0f;
}

static void seek_zone(struct app *app, const struct mr_block *block)
{
    float station_ft[MR_TRANSDUCERS];
    float moved_in[MR_TRANSDUCERS];
    struct mr_closure_zone zone;
    struct landing_wheel wheel = landing_wheel_at(&app->landing, block->tick);

    mean_of_last(app->displacement_in[0], MR_TRANSDUCERS, block->index % 4, 4, moved_in);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        station_ft[i] = config.channel[i].station_ft;
        moved_in[i] -= app->baseline_in[i];
    }
    mr_closure_find(&(struct mr_closure_input){.station_ft = station_ft, .displacement_in = moved_in,
                                               .slack_in = app->slack_in, .wheel_ft = wheel.station_ft,
                                               .speed_ft_s = wheel.speed_ft_s,
                                               .deceleration_ft_s2 = wheel.deceleration_ft_s2},
                    &zone, NULL);
    bool warning = zone.mats >= MR_CLOSURE_WARNING_MATS && landing_may_warn(&app->landing, block->index);
    bool changed = warning != app->warning;
    warn(app, warning);
    if (changed || block->index % APP_ZONE_SEND_BLOCKS == 0)
        telemetry_zone(&app->telemetry, &zone, wheel.station_ft, warning, block->index);
}

static void tell_landing(struct app *app, const struct landing_news *news, uint32_t index)
{
    const struct landing *landing = &app->landing;
    for (unsigned i = 0; i < news->edges; i++)
        telemetry_edge(&app->telemetry, &landing->edge[i]);
    for (unsigned i = 0; i < news->events; i++)
        telemetry_switch(&app->telemetry, &landing->event[i]);
    if (news->pushed)
        telemetry_pushback(&app->telemetry, landing, index);
    if (news->motion)
        telemetry_motion(&app->telemetry, &landing->motion, index);
    if (news->summary)
        telemetry_summary(&app->telemetry, &landing->summary);
    if (news->no_fit != MR_OK)
        health_count(MR_FAULT_NO_FIT, (uint8_t)-news->no_fit);
    if (news->state)
        telemetry_state(&app->telemetry, landing);
}

static void take_block(struct app *app, const struct mr_block *block)
{
    uint32_t edge_ticks[MR_SWITCHES_WAITING];
    size_t edges = board_edges_take(block->tick + EDGE_WINDOW_TICKS, edge_ticks, MR_SWITCHES_WAITING);
    float staircase_code = (float)block->sum[MR_ADC1_STAIRCASE] / (float)MR_SCANS_PER_BLOCK;
    unsigned row = block->index % 4;
    bool was_recording = landing_recording(&app->landing);
    bool was_armed = app->landing.state == LANDING_ARMED;

    tasks_begin(MR_TASK_LANDING);
    health_set_block(block->index);
    read_channels(app, block);
    struct landing_news news =
        landing_block(&app->landing, block->index, block->tick, staircase_code, edge_ticks, (unsigned)edges);
    bool recording = landing_recording(&app->landing);
    tasks_done(MR_TASK_LANDING);

    tasks_begin(MR_TASK_TELEMETRY);
    healthlink_block(&app->healthlink, block);
    if (was_recording || recording)
        telemetry_block(&app->telemetry, block);
    tell_landing(app, &news, block->index);
    boxlink_block(&app->boxlink, &app->box, &app->telemetry, &app->landing, block, was_armed);
    if (recording) {
        if (landing_quiet(&app->landing, block->index))
            follow_baseline(app, row);
        else
            forget_partial_baseline(app);
        if (block->index % APP_ZONE_BLOCKS == 0)
            seek_zone(app, block);
    } else if (was_recording) {
        end_warning(app, block->index);
    }
    if (block->index % (recording ? 2u : APP_IDLE_BLOCKS) == 0) {
        float mean_in[MR_TRANSDUCERS];
        mean_of_last(app->displacement_in[0], MR_TRANSDUCERS, row, 2, mean_in);
        telemetry_displacements(&app->telemetry, mean_in, block->index);
    }
    if (block->index % (recording ? 4u : APP_IDLE_BLOCKS) == 1) {
        float mean_lb[MR_GAGES];
        mean_of_last(app->tension_lb[0], MR_GAGES, row, 4, mean_lb);
        telemetry_tensions(&app->telemetry, mean_lb, block->index);
    }
    telemetry_regular(&app->telemetry, &app->landing, app->slack_in, block->index, block->tick);
    healthlink_regular(&app->healthlink, &app->telemetry, block->index);
    tasks_done(MR_TASK_TELEMETRY);
}

static void miss_blocks(struct app *app, uint32_t next_index)
{
    uint32_t lost = next_index - app->next_index;
    uint32_t total = app->telemetry.blocks_lost + lost;
    app->telemetry.blocks_lost = lost > UINT16_MAX || total > UINT16_MAX ? UINT16_MAX : (uint16_t)total;
    for (uint32_t i = 0; i < lost && i < 4; i++)
        miss_block(app, next_index - 1 - i);
    if (lost)
        app->blocks_in_row = 0;
    app->next_index = next_index;
}

bool app_poll(struct app *app)
{
    struct mr_block block;
    bool any = false;
    while (board_block_take(&block)) {
        miss_blocks(app, block.index);
        take_commands(app);
        take_block(app, &block);
        app->newest[block.index % APP_BLOCKS_BEFORE] = block;
        app->blocks_in_row++;
        app->next_index = block.index + 1;
        any = true;
        tasks_done(MR_TASK_BLOCKS);
    }
    tasks_begin(MR_TASK_BOX);
    blackbox_poll(&app->box, app->next_index);
    tasks_done(MR_TASK_BOX);
    tasks_begin(MR_TASK_UPKEEP);
    healthlink_idle(&app->healthlink);
    tasks_begin(MR_TASK_LOOP);
    if (any)
        app->ticks_without_block = 0;
    return any;
}

/* Without scans there is no block to take, no landing to follow: those whose work that is are not late. */
static void excuse_tasks(void)
{
    tasks_done(MR_TASK_BLOCKS);
    tasks_done(MR_TASK_LANDING);
    tasks_done(MR_TASK_TELEMETRY);
}

void app_supervise(struct app *app)
{
    tasks_begin(MR_TASK_SUPERVISION);
    if (app->ticks_to_rom && --app->ticks_to_rom == 0 && !landing_recording(&app->landing))
        board_enter_rom();
    app->ticks_without_block++;
    if (app->ticks_without_block % TICKS_PER_S == STALL_TICKS) {
        health_count(MR_FAULT_SCAN_STALL, 0);
        board_scans_restart();
    }
    if (app->ticks_without_block >= STALL_TICKS) {
        take_commands(app);
        excuse_tasks();
    }
    /* With no scans at all the block index stands still; walk one round of the regular messages each second instead, all but
     * the clock: there is no time base. */
    if (app->ticks_without_block >= TICKS_PER_S && app->ticks_without_block % TICKS_PER_S == 0) {
        for (uint32_t phase = 0; phase < 1000; phase++) {
            if ((phase % 20 == 3 && phase % 100 != 3) || phase == 513 || phase == 713)
                telemetry_regular(&app->telemetry, &app->landing, app->slack_in, phase, 0);
            if (phase % 20 == 3)
                healthlink_regular(&app->healthlink, &app->telemetry, phase);
        }
    }
    healthlink_tick(&app->healthlink, &app->telemetry, !landing_recording(&app->landing));
    tasks_done(MR_TASK_SUPERVISION);
    tasks_begin(MR_TASK_LOOP);
}
