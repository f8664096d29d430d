#include "firmware/app.h"

#include <string.h>

#include "common/channels.h"
#include "common/command.h"
#include "common/wire.h"
#include "firmware/config.h"
#include "firmware/health.h"
#include "firmware/landinglink.h"
#include "firmware/schedule.h"
#include "firmware/channels.h"

/* number of supervision ticks without a block after which the scans count as stopped */
#define STALL_TICKS ((unsigned)SCHEDULE_STALL_PHASE)

#define BLOCKS(NAME, period, phase, stalled, who, why)           \
    _Static_assert(!(stalled) || SCHEDULE_ROUND % (period) == 0, \
                   #NAME " does not go into a round without scans");
#include "firmware/schedule.def"

/* Checks at compile time that one row of the schedule is due only in blocks in which another row is
 * due too. */
#define DUE_TOGETHER(NAME, OTHER)                                               \
    _Static_assert(SCHEDULE_##NAME##_PERIOD % SCHEDULE_##OTHER##_PERIOD == 0 && \
                       SCHEDULE_##NAME##_PHASE % SCHEDULE_##OTHER##_PERIOD ==   \
                           SCHEDULE_##OTHER##_PHASE,                            \
                   #NAME " without " #OTHER)
DUE_TOGETHER(BANDS, TENSIONS);
DUE_TOGETHER(BANDS_IDLE, TENSIONS_IDLE);
DUE_TOGETHER(ZONES, LAMP);
DUE_TOGETHER(ALL_FAULTS, FAULTS);
#undef DUE_TOGETHER

/* Sets the histories of a missing block to NaN. */
static void clear_history_row(struct app *app, uint32_t index)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        app->displacement_in[index % 4][i] = MR_NAN;
    for (unsigned i = 0; i < MR_GAGES; i++)
        app->tension_lb[index % 4][i] = MR_NAN;
}

/* Clears the history of each channel with a new zero, so that no mean mixes readings with the old
 * and the new zero. */
static void clear_changed_zeros(struct app *app)
{
    uint32_t changed = zero_get_changed();
    if (!changed)
        return;
    for (unsigned row = 0; row < 4; row++) {
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
            if (changed >> i & 1u)
                app->displacement_in[row][i] = MR_NAN;
        }
        for (unsigned i = 0; i < MR_GAGES; i++) {
            if (changed >> (MR_TRANSDUCERS + i) & 1u)
                app->tension_lb[row][i] = MR_NAN;
        }
    }
    slowlog_reset(&app->slowlog);
    channels_on_zero_measured(&app->channels, changed, app->next_index);
}

static void discard_survey(struct app *app)
{
    for (unsigned i = 0; i < MR_SEGMENTS; i++)
        app->slack_in[i] = MR_NAN;
}

void app_apply_configuration(struct app *app)
{
    zero_reset();
    channels_on_zero_measured(&app->channels, UINT32_MAX, 0);
    slowlog_reset(&app->slowlog);
    app->fitted_channels = config_fitted_channels();
    board_scans_configure(app->fitted_channels);
    for (unsigned i = 0; i < 4; i++)
        clear_history_row(app, i);
    app->consecutive_blocks = 0;
    baseline_discard(&app->baseline);
    predict_configure(&app->predict, app->slack_in);
    if (!config.site[0].black_box)
        blackbox_disable(&app->box);
    else if (!blackbox_has_memory(&app->box))
        blackbox_start(&app->box);
    runwaystore_set_memory(&app->runwaystore, blackbox_has_memory(&app->box));
    keystore_set_memory(&app->keystore, blackbox_has_memory(&app->box));
}

static void update_key_message(struct app *app)
{
    app->telemetry.bus_key = (struct mr_bus_key){.state = (uint8_t)app->keystore.state,
                                                 .refused = app->proof.refused_count,
                                                 .changes = app->keystore.change_number};
}

static void report_configuration(struct app *app)
{
    app->telemetry.config_crc = app->configstore.crc;
    app->telemetry.config_state = configstore_get_state(&app->configstore);
    configround_start_burst(&app->telemetry, &app->landing);
}

void app_start(struct app *app)
{
    memset(app, 0, sizeof *app);
    configstore_start(&app->configstore);
    app->can_base = config.site[0].can_base;
    board_can_set_base(app->can_base); /* set the base before the first frame is sent */
    landing_start(&app->landing);
    channels_start(&app->channels);
    mr_deframer_init(&app->deframer);
    discard_survey(app);
    calibrate_start(&app->calibrate);
    runwaystore_start(&app->runwaystore);
    keystore_start(&app->keystore);
    predict_start(&app->predict);
    thermometer_start(&app->thermometer);
    app_apply_configuration(app);
    keystore_check(&app->keystore);
    telemetry_start(&app->telemetry, &app->box);
    healthlink_start(&app->healthlink);
    update_key_message(app);
    report_configuration(app);
    board_set_warning(false);
}

/* Sends up to APP_BLOCKS_BEFORE_ARMING consecutive blocks before the next one, so that the record
 * contains all blocks on which its first means depend. */
static void report_blocks_before_arming(struct app *app)
{
    uint32_t first = app->next_index;
    while (first > 0 && app->next_index - first < APP_BLOCKS_BEFORE_ARMING &&
           app->consecutive_blocks > app->next_index - first)
        first--;
    for (; first != app->next_index; first++) {
        landinglink_send_block(&app->telemetry, &app->recent_blocks[first % APP_NEWEST_BLOCKS]);
        blackbox_on_block(&app->box, &app->recent_blocks[first % APP_NEWEST_BLOCKS]);
    }
}

static bool is_channel_fitted(const struct app *app, unsigned channel)
{
    return app->fitted_channels >> channel & 1u;
}

/* Converts the readings of a block. Values of channels that are not fitted stay NaN. */
static void read_channels(struct app *app, const struct mr_block *block)
{
    unsigned row = block->index % 4;
    float ratio = mr_reference_ratio(&config.channel[MR_REFERENCE], block);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        if (is_channel_fitted(app, i))
            app->displacement_in[row][i] = channels_read(&app->channels, block, i, ratio);
    }
    for (unsigned i = 0; i < MR_GAGES; i++) {
        unsigned channel = MR_TRANSDUCERS + i;
        if (is_channel_fitted(app, channel))
            app->tension_lb[row][i] = channels_read(&app->channels, block, channel, ratio);
    }
}

/* True if a mean that is sent while nothing is recorded uses this block. */
static bool is_reported_while_idle(uint32_t index)
{
    return BLOCKS_UNTIL(DISPLACEMENTS_IDLE, index) < APP_DISPLACEMENT_BLOCKS ||
           BLOCKS_UNTIL(TENSIONS_IDLE, index) < APP_TENSION_BLOCKS;
}

/* At arming, fills the histories with the blocks that the first means use. Missing blocks are
 * already NaN in the histories. */
static void read_blocks_before_arming(struct app *app)
{
    for (unsigned age = 1; age < APP_BLOCKS_BEFORE_ARMING && age <= app->consecutive_blocks; age++)
        read_channels(app, &app->recent_blocks[(app->next_index - age) % APP_NEWEST_BLOCKS]);
}

static enum mr_status execute_arm(struct app *app, const struct mr_command *command)
{
    if (command->argument < 0 || command->argument > (mr_i32)UINT16_MAX)
        return MR_USAGE;
    /* without blocks, the landing could not be measured */
    if (app->ticks_without_block >= STALL_TICKS)
        return MR_NOT_NOW;
    if (calibrate_is_busy(&app->calibrate) || keystore_is_writing(&app->keystore))
        return MR_WAIT;
    enum mr_status status = blackbox_check_ready(&app->box);
    if (status == MR_OK && app->predict.status == MR_OK &&
        !runwaystore_is_loaded(&app->runwaystore))
        status = MR_WAIT;
    if (status == MR_WAIT || status == MR_FULL)
        boxlink_report_state(&app->box, &app->telemetry);
    if (status != MR_OK)
        return status;
    status = landing_arm(&app->landing, (uint16_t)command->argument, app->next_index);
    if (status == MR_OK) {
        baseline_discard(&app->baseline);
        camera_arm(&app->camera);
        braking_arm(&app->braking);
        read_blocks_before_arming(app);
        channels_arm(&app->channels, app->next_index);
        bandwatch_arm(&app->bandwatch);
        healthlink_arm(&app->healthlink, &app->telemetry);
        board_set_warning(false);
        boxlink_arm(&app->box, &app->telemetry, &app->landing, app->slack_in);
        landinglink_send_state(&app->telemetry, &app->landing);
        predict_arm(&app->predict, &app->telemetry, app->slack_in, app->next_index);
        predict_store_in_box(&app->predict, &app->telemetry, app->runwaystore.copy_state);
        report_blocks_before_arming(app);
        configround_start_burst(&app->telemetry, &app->landing);
    }
    return status;
}

/* Ends the prediction for a landing. If a gear has rolled, the survey is discarded, because it is
 * no longer valid. */
static void end_prediction(struct app *app, uint32_t index)
{
    if (predict_end(&app->predict, &app->telemetry, &app->landing, index))
        discard_survey(app);
}

static enum mr_status execute_runway(struct app *app, const struct mr_command *command)
{
    bool is_survey_discarded = false;
    enum mr_status status = predict_execute_command(&app->predict, &app->telemetry, command,
                                                    app->next_index, &is_survey_discarded);
    if (is_survey_discarded)
        discard_survey(app);
    return status;
}

static enum mr_status execute_mark(struct app *app, const struct mr_command *command)
{
    if (command->argument < 0 || command->argument > (mr_i32)UINT16_MAX)
        return MR_USAGE;
    TELEMETRY_SEND(&app->telemetry, TO_RECORD, mark, MARK, .number = (uint16_t)command->argument,
                   .landing = app->landing.number, .block = app->next_index);
    return MR_OK;
}

static enum mr_status execute_survey(struct app *app, const struct mr_command *command)
{
    /* the limit is the largest value that the message `slack` can report */
    if (command->index >= MR_SEGMENTS || command->argument < 0 ||
        command->argument >= (int32_t)MR_MISSING_U16)
        return MR_USAGE;
    app->slack_in[command->index] = (float)command->argument / 10000.0f;
    predict_set_survey(&app->predict, app->slack_in, app->next_index);
    return MR_OK;
}

/* True if the last pages of the last record are still to be written. A command that would end the
 * record has to wait. */
static bool is_box_closing(const struct app *app)
{
    return app->box.state == MR_BOX_CLOSING;
}

static enum mr_status execute_bootrom(struct app *app, const struct mr_command *command)
{
    (void)command;
    if (!board_is_rom_reachable())
        return MR_UNKNOWN;
    if (is_box_closing(app))
        return MR_WAIT;
    app->ticks_until_boot_rom = APP_BOOTROM_DELAY_TICKS;
    return MR_OK;
}

/* Applies a configuration. Readings, passed switches and sums of the old configuration are
 * discarded. */
static enum mr_status execute_config_apply(struct app *app, const struct mr_command *command)
{
    if (calibrate_is_busy(&app->calibrate) || is_box_closing(app))
        return MR_WAIT;
    enum mr_status status = configstore_apply(&app->configstore, &app->telemetry,
                                              (uint32_t)command->argument);
    if (status == MR_OK) {
        landing_reconfigure(&app->landing);
        app_apply_configuration(app);
    }
    if (status == MR_OK || status == MR_IO)
        report_configuration(app);
    return status;
}

/* Changes to a new CAN base after the answer was sent, so that the answer uses the base of the
 * command. */
static void follow_configured_can_base(struct app *app)
{
    if (app->can_base == config.site[0].can_base)
        return;
    app->can_base = config.site[0].can_base;
    board_can_set_base(app->can_base);
    /* includes `hello` for listeners on the new base */
    configround_start_burst(&app->telemetry, &app->landing);
}

/* Status of a command that is answered later or not at all. */
#define NO_ANSWER ((enum mr_status)1)

static enum mr_status execute_state(struct app *app, const struct mr_command *command)
{
    (void)command;
    landinglink_send_state(&app->telemetry, &app->landing);
    configround_start_burst(&app->telemetry, &app->landing);
    healthlink_report_crash(&app->healthlink);
    return MR_OK;
}

static enum mr_status execute_disarm(struct app *app, const struct mr_command *command)
{
    (void)command;
    bandwatch_end(&app->bandwatch, &app->telemetry);
    end_prediction(app, app->next_index);
    landing_disarm(&app->landing, app->next_index);
    landinglink_send_state(&app->telemetry, &app->landing);
    return MR_OK;
}

static enum mr_status execute_reset(struct app *app, const struct mr_command *command)
{
    (void)command;
    if (is_box_closing(app))
        return MR_WAIT;
    healthlink_schedule_restart(&app->healthlink);
    return MR_OK;
}

static enum mr_status execute_self_test(struct app *app, const struct mr_command *command)
{
    return healthlink_self_test(&app->healthlink, command->tag);
}

static enum mr_status execute_calibrate(struct app *app, const struct mr_command *command)
{
    if (command->code == MR_COMMAND_ZERO && command->index && !app->is_replay)
        return MR_REPLAY;
    enum mr_status status = calibrate_begin(&app->calibrate, &app->telemetry, &app->landing,
                                            command, app->next_index);
    if (status == MR_OK && calibrate_is_busy(&app->calibrate))
        return NO_ANSWER; /* answered when the calibration ends */
    clear_changed_zeros(app);
    return status;
}

static enum mr_status execute_config_read(struct app *app, const struct mr_command *command)
{
    return configstore_read(&app->configstore, (uint32_t)command->argument, app->is_sent_by_serial);
}

static enum mr_status execute_camera(struct app *app, const struct mr_command *command)
{
    (void)command;
    return camera_trigger(&app->camera);
}

static enum mr_status execute_live(struct app *app, const struct mr_command *command)
{
    return live_begin(&app->live, &app->landing, command, app->next_index);
}

static enum mr_status execute_backlog(struct app *app, const struct mr_command *command)
{
    enum mr_status status = predict_set_backlog(&app->predict, command->argument);
    /* no answer, because the original board gave none */
    return status == MR_OK ? NO_ANSWER : status;
}

static enum mr_status execute_replay(struct app *app, const struct mr_command *command)
{
    (void)command;
    app->is_replay = true;
    return NO_ANSWER; /* no answer, because the original board gave none */
}

static enum mr_status execute_box(struct app *app, const struct mr_command *command)
{
    return boxlink_execute(&app->boxlink, &app->box, &app->telemetry, command);
}

static enum mr_status execute_key(struct app *app, const struct mr_command *command)
{
    if (blackbox_has_memory(&app->box) && !blackbox_is_idle(&app->box))
        return MR_WAIT; /* not ready: the black box may be erasing for minutes */
    enum mr_status status = keystore_process_command(&app->keystore, command);
    /* the answer follows when the key has been written */
    return status == MR_OK ? NO_ANSWER : status;
}

/* Executes a command by calling the function of its module. A switch is used and no table of
 * functions, because the build computes the stack depth, which function pointers would prevent. */
static enum mr_status dispatch_command(struct app *app, const struct mr_command *command)
{
    switch (command->code) {
/* clang-format off */
#define COMMAND(NAME, code, text, part, ...) case code: return execute_##part(app, command);
/* clang-format on */
#include "common/catalogue.def"
    default: return MR_UNKNOWN;
    }
}

/* Rules by command code: in which states (enum mr_command_states; 0: no such code), by which links,
 * with which privilege. */
static const struct command_rule {
    uint8_t states, links, privilege;
} command_rule[] = {
#define COMMAND(NAME, code, text, part, indexed, counts, privilege, states, links, meaning) \
    [code] = {MR_STATES_##states, MR_LINKS_##links, MR_PRIVILEGE_##privilege},
#include "common/catalogue.def"
};

/* Returns MR_OK if commands from this link may be executed; otherwise the status that states why
 * not. */
static enum mr_status check_link(const struct app *app, enum mr_command_links links)
{
    bool jumper = links != MR_LINKS_BOTH && board_is_jumper_fitted();
    switch (links) {
    case MR_LINKS_CABLE: return app->is_sent_by_serial || jumper ? MR_OK : MR_CABLE;
    case MR_LINKS_JUMPER: return app->is_sent_by_serial && jumper ? MR_OK : MR_JUMPER;
    case MR_LINKS_REPLAY: return app->is_replay ? MR_OK : MR_REPLAY;
    default: return MR_OK;
    }
}

static enum mr_status execute_command(struct app *app, const struct mr_command *command,
                                      const uint8_t *payload)
{
    if (command->code >= sizeof command_rule / sizeof command_rule[0] ||
        !command_rule[command->code].states)
        return MR_UNKNOWN;
    const struct command_rule *rule = &command_rule[command->code];
    /* Check the proof first, so that it is used up even if the command is refused below; otherwise
     * an eavesdropper could repeat the command later. */
    if (rule->privilege == MR_PRIVILEGE_OPERATOR) {
        enum mr_status status = proof_check(&app->proof, &app->keystore, &app->telemetry,
                                            app->is_sent_by_serial, payload);
        if (status != MR_OK)
            return status;
    }
    /* Check the state before the link, so that a replayed landing gets the same answer on either
     * link. */
    if (!(rule->states >> app->landing.state & 1u))
        return MR_NOT_NOW;
    return check_link(app, (enum mr_command_links)rule->links) ?: dispatch_command(app, command);
}

/* Returns MR_OK if the payload was a command, which has then been handled. */
static enum mr_status handle_command(struct app *app, const uint8_t *payload, size_t length)
{
    struct mr_command command;
    enum mr_status status = mr_command_get(&command, payload, length);
    if (status != MR_OK)
        return status;
    blackbox_record_message(&app->box, MR_ID_COMMAND, payload, length);
    status = execute_command(app, &command, payload);
    /* record the command after its execution, because arming begins the record */
    if (command.code == MR_COMMAND_ARM && status == MR_OK)
        blackbox_record_message(&app->box, MR_ID_COMMAND, payload, length);
    if (status != NO_ANSWER)
        TELEMETRY_SEND(&app->telemetry, TO_RECORD, ack, ACK, .code = command.code,
                       .status = (int8_t)status, .tag = command.tag, .block = app->next_index);
    follow_configured_can_base(app);
    return MR_OK;
}

/* Stores a word of a new configuration for the command `config-apply`. */
static void handle_config_word(struct app *app, const uint8_t *payload, size_t length)
{
    enum mr_config_locked locked = landing_is_recording(&app->landing) ? MR_CONFIG_LOCKED_RECORDING
                                 : check_link(app, MR_LINKS_CABLE)     ? MR_CONFIG_LOCKED_CAN
                                                                       : MR_CONFIG_UNLOCKED;
    configstore_put_word(&app->configstore, &app->telemetry, payload, length, locked);
}

static void handle_input(struct app *app)
{
    struct board_can_frame can;
    uint8_t bytes[APP_SERIAL_BYTES_PER_BLOCK];
    tasks_begin(MR_TASK_COMMANDS);

    app->is_sent_by_serial = false;
    for (unsigned i = 0; i < APP_CAN_COMMANDS_PER_BLOCK && board_can_receive(&can); i++) {
        if (can.id == MR_ID_COMMAND)
            (void)handle_command(app, can.data, can.length);
        else if (can.id == MR_ID_CONFIG_WORD)
            handle_config_word(app, can.data, can.length);
        else if (can.id == MR_ID_PROOF)
            proof_store(&app->proof, false, can.data, can.length);
    }
    app->is_sent_by_serial = true;
    size_t count = board_serial_receive(bytes, sizeof bytes);
    for (size_t i = 0; i < count; i++) {
        struct mr_frame frame;
        enum mr_status status = mr_deframer_push(&app->deframer, bytes[i], &frame);
        if (status == MR_OK && frame.type == MR_ID_COMMAND)
            status = handle_command(app, frame.payload, frame.length);
        else if (status == MR_OK && frame.type == MR_ID_CONFIG_WORD)
            handle_config_word(app, frame.payload, frame.length);
        else if (status == MR_OK && frame.type == MR_ID_PROOF)
            proof_store(&app->proof, true, frame.payload, frame.length);
        else if (status == MR_OK && frame.type == MR_ID_KEY_WORD)
            keystore_put_word(&app->keystore, frame.payload, frame.length);
        if (status != MR_OK && status != MR_TOO_FEW) {
            if (app->telemetry.serial_refused_count < UINT16_MAX)
                app->telemetry.serial_refused_count++;
            health_count_fault(MR_FAULT_SERIAL_BAD_FRAME, (uint8_t)-status);
        }
    }
    tasks_done(MR_TASK_COMMANDS);
}

/* Computes the mean of the last `count` rows of a history of 4 rows; NaN if one is missing. `row`:
 * the newest row. */
static void compute_mean_of_last(const float *history, unsigned width, unsigned row, unsigned count,
                                 float *mean)
{
    for (unsigned c = 0; c < width; c++) {
        float sum = 0.0f;
        for (unsigned age = 0; age < count; age++)
            sum += history[((row + 4 - age) % 4) * width + c];
        mean[c] = sum / (float)count;
    }
}

/* Measures the mat temperature and updates the slow log. */
static void handle_slow_log(struct app *app, uint32_t index)
{
    const struct landing *landing = &app->landing;
    const struct thermometer *thermometer = &app->thermometer;
    if (thermometer_on_block(&app->thermometer, index, config.site[0].thermometer))
        TELEMETRY_SEND(&app->telemetry, TO_RECORD, temperature, TEMPERATURE,
                       .temperature_c = thermometer->temperature_c, .error_c = thermometer->error_c,
                       .block = index);
    slowlog_on_block(&app->slowlog, &app->telemetry, index, app->tension_lb[index % 4],
                     thermometer->last_temperature_c,
                     landing->state != MR_LANDING_LANDING && landing->state != MR_LANDING_SETTLING);
}

static void process_block(struct app *app, const struct mr_block *block)
{
    uint32_t edge_ticks[MR_SWITCHES_WAITING_MAX];
    size_t edges = board_edges_get(block->tick + LANDING_BLOCK_EDGE_TICKS, edge_ticks,
                                   MR_SWITCHES_WAITING_MAX);
    unsigned row = block->index % 4;
    bool was_recording = landing_is_recording(&app->landing);
    bool was_armed = app->landing.state == MR_LANDING_ARMED;

    tasks_begin(MR_TASK_LANDING);
    health_set_block(block->index);
    timesync_on_block(&app->timesync, &app->telemetry, block->index, block->tick);
    if (__builtin_isnan(mr_reference_ratio(&config.channel[MR_REFERENCE], block)))
        health_count_fault(MR_FAULT_REFERENCE, 0);
    struct landing_block_changes changes = landing_on_block(&app->landing, &config, block->index,
                                                            block->tick, mr_staircase_code(block),
                                                            edge_ticks, (unsigned)edges);
    bool recording = landing_is_recording(&app->landing);
    tasks_done(MR_TASK_LANDING);

    tasks_begin(MR_TASK_TELEMETRY);
    healthlink_on_block(&app->healthlink, block);
    if (recording || is_reported_while_idle(block->index))
        read_channels(app, block);
    if (was_recording || recording)
        landinglink_send_block(&app->telemetry, block);
    channels_report(&app->channels, &app->telemetry, &app->landing, block->index,
                    app->displacement_in[row], app->baseline.zero_in, app->tension_lb[row]);
    if (changes.has_new_state && app->landing.state == MR_LANDING_DONE) {
        /* report the bands before the message that ends the landing */
        bandwatch_end(&app->bandwatch, &app->telemetry);
        end_prediction(app, block->index);
    }
    live_on_block(&app->live, &app->landing, &app->telemetry, block);
    landinglink_send_changes(&app->telemetry, &app->landing, &changes, block->index);
    camera_on_block(&app->camera, &app->telemetry, &app->landing, block->index, block->tick,
                    block->tick + LANDING_BLOCK_EDGE_TICKS);
    braking_process_block(&app->braking, &app->telemetry, &app->landing, block->index,
                          block->tick + LANDING_BLOCK_EDGE_TICKS);
    boxlink_on_block(&app->boxlink, &app->box, &app->telemetry, &app->landing, block, was_armed);
    if (recording)
        baseline_update(&app->baseline, app->displacement_in[row],
                        landing_is_quiet(&app->landing, block->index),
                        predict_find_frozen_zeros(&app->predict.predictor, &app->landing));
    if (app->fitted_channels & MR_BITS_TRANSDUCERS &&
        (recording ? DUE(DISPLACEMENTS, block->index) : DUE(DISPLACEMENTS_IDLE, block->index))) {
        float mean_in[MR_TRANSDUCERS];
        compute_mean_of_last(app->displacement_in[0], MR_TRANSDUCERS, row, APP_DISPLACEMENT_BLOCKS,
                             mean_in);
        landinglink_send_displacements(&app->telemetry, mean_in, app->fitted_channels,
                                       block->index);
    }
    if (app->fitted_channels & MR_BITS_GAGES &&
        (recording ? DUE(TENSIONS, block->index) : DUE(TENSIONS_IDLE, block->index))) {
        float mean_lb[MR_GAGES];
        compute_mean_of_last(app->tension_lb[0], MR_GAGES, row, APP_TENSION_BLOCKS, mean_lb);
        landinglink_send_tensions(&app->telemetry, mean_lb, app->fitted_channels >> MR_TRANSDUCERS,
                                  block->index);
        bandwatch_on_tensions(&app->bandwatch, &app->telemetry, &app->landing, mean_lb, block);
    }
    calibrate_on_block(&app->calibrate, &app->telemetry, &app->landing, block);
    clear_changed_zeros(app);
    configstore_on_block(&app->configstore, &app->telemetry, recording);
    handle_slow_log(app, block->index);
    landinglink_send_regular(&app->telemetry, &app->landing, app->slack_in, block->index,
                             block->tick);
    healthlink_send_regular(&app->healthlink, &app->telemetry, block->index);
    if (DUE(NONCE, block->index))
        proof_on_second(&app->proof, &app->keystore, &app->telemetry);
    tasks_done(MR_TASK_TELEMETRY);

    tasks_begin(MR_TASK_PREDICTOR);
    predict_send_regular(&app->predict, &app->telemetry, app->runwaystore.copy_state, block->index);
    predict_on_block(&app->predict, &app->telemetry, &app->landing,
                     &(struct predict_block){.index = block->index,
                                             .tick = block->tick,
                                             .displacement_in = app->displacement_in[row],
                                             .baseline_in = app->baseline.zero_in,
                                             .blocks_waiting = board_blocks_waiting()});
    tasks_done(MR_TASK_PREDICTOR);
}

static void count_lost_blocks(struct app *app, uint32_t next_index)
{
    uint32_t lost = next_index - app->next_index;
    uint32_t total = app->telemetry.blocks_lost + lost;
    app->telemetry.blocks_lost = lost > UINT16_MAX || total > UINT16_MAX ? UINT16_MAX
                                                                         : (uint16_t)total;
    for (uint32_t i = 0; i < lost && i < 4; i++)
        clear_history_row(app, next_index - 1 - i);
    if (lost)
        app->consecutive_blocks = 0;
    app->next_index = next_index;
}

/* Copies the next block into newest_blocks, in place of one that is no longer needed. NULL: no
 * block is ready. */
static struct mr_block *fetch_block(struct app *app)
{
    struct mr_block *expected = &app->recent_blocks[app->next_index % APP_NEWEST_BLOCKS];
    if (!board_block_get(expected))
        return NULL;
    struct mr_block *block = &app->recent_blocks[expected->index % APP_NEWEST_BLOCKS];
    if (block != expected) /* blocks between these two are missing */
        *block = *expected;
    return block;
}

/* Continues the storage of the board's key. It uses the memory before all other modules at start,
 * and while the key is changed, which is possible only while nothing is armed. Returns true if it
 * uses the memory now. */
static bool poll_keystore(struct app *app, bool free)
{
    struct keystore *store = &app->keystore;
    struct mr_ack answer;
    keystore_set_memory(store, blackbox_has_memory(&app->box));
    while (!keystore_poll(store)) {
        if (!free || !keystore_begin(store))
            break;
    }
    if (keystore_get_answer(store, &answer))
        TELEMETRY_SEND(&app->telemetry, TO_LINKS, ack, ACK, .code = answer.code,
                       .status = answer.status, .tag = answer.tag, .block = app->next_index);
    update_key_message(app);
    return store->is_in_progress || store->state == MR_KEY_NOT_READ;
}

/* Lets the board's key, the black box and the predictor's runway use the memory in turn, one
 * operation at a time; the runway only when the others are idle. A page of the runway that is being
 * written when a landing begins takes 3 ms at most. An erase takes 400 ms; it begins only while
 * nothing is armed, and the box keeps free pages in its ring for it, as for an erase of its own. */
static void share_nor_memory(struct app *app)
{
    struct blackbox *box = &app->box;
    struct runwaystore *store = &app->runwaystore;
    /* allow the black box to use the memory once the key has been read */
    bool begun = app->keystore.state != MR_KEY_NOT_READ;
    runwaystore_set_memory(store, blackbox_has_memory(box));
    if (!runwaystore_poll(store, &app->predict, app->slack_in) &&
        !poll_keystore(app, !begun || blackbox_is_idle(box))) {
        blackbox_poll(box, app->next_index);
        if (blackbox_is_idle(box) && blackbox_has_memory(box))
            (void)runwaystore_begin(store, &app->predict, !landing_is_recording(&app->landing),
                                    app->next_index);
    }
    box->is_waiting_for_erase = runwaystore_is_erasing(store);
}

bool app_poll(struct app *app)
{
    struct mr_block *block;
    bool any = false;
    while ((block = fetch_block(app)) != NULL) {
        app->ticks_without_block = 0;
        count_lost_blocks(app, block->index);
        handle_input(app);
        process_block(app, block);
        app->consecutive_blocks++;
        app->next_index = block->index + 1;
        any = true;
        tasks_done(MR_TASK_BLOCKS);
    }
    tasks_begin(MR_TASK_BOX);
    share_nor_memory(app);
    tasks_done(MR_TASK_BOX);
    tasks_begin(MR_TASK_UPKEEP);
    healthlink_run_idle(&app->healthlink);
    tasks_begin(MR_TASK_LOOP);
    return any;
}

/* Marks the tasks that process blocks as done: without scans there are no blocks, so these tasks
 * are not late. */
static void mark_tasks_done(void)
{
    tasks_done(MR_TASK_BLOCKS);
    tasks_done(MR_TASK_LANDING);
    tasks_done(MR_TASK_TELEMETRY);
    tasks_done(MR_TASK_PREDICTOR);
}

/* True if a row of the schedule that continues without scans is due at this phase of the round. */
static bool is_row_due_without_scans(uint32_t phase)
{
    bool due = false;
#define BLOCKS(NAME, period, phase_, stalled, who, why) due |= (stalled) && DUE(NAME, phase);
#define TICKS(NAME, period, phase_, who, why)
#include "firmware/schedule.def"
    return due;
}

/* Sends, once a second while the scans are stopped, one round of the regular messages that need no
 * block and no time base. The block index does not advance in this time. */
static void report_without_scans(struct app *app)
{
    for (uint32_t phase = 0; phase < SCHEDULE_ROUND; phase++) {
        if (is_row_due_without_scans(phase))
            landinglink_send_regular(&app->telemetry, &app->landing, app->slack_in, phase, 0);
        if (DUE(NONCE, phase))
            proof_on_second(&app->proof, &app->keystore, &app->telemetry);
        if (DUE(CRASH_STALLED, phase))
            healthlink_send_regular(&app->healthlink, &app->telemetry, phase);
    }
}

void app_supervise(struct app *app)
{
    tasks_begin(MR_TASK_SUPERVISION);
    if (app->ticks_until_boot_rom && --app->ticks_until_boot_rom == 0 &&
        !landing_is_recording(&app->landing))
        board_enter_rom();
    app->ticks_without_block++;
    if (DUE(STALL, app->ticks_without_block)) {
        health_count_fault(MR_FAULT_SCAN_STALL, 0);
        calibrate_abort(&app->calibrate, &app->telemetry, app->next_index);
        board_scans_restart();
    }
    if (app->ticks_without_block >= STALL_TICKS) {
        handle_input(app);
        mark_tasks_done();
    }
    if (app->ticks_without_block && DUE(STALLED, app->ticks_without_block))
        report_without_scans(app);
    healthlink_tick(&app->healthlink, &app->telemetry, !landing_is_recording(&app->landing));
    tasks_done(MR_TASK_SUPERVISION);
    tasks_begin(MR_TASK_LOOP);
}
