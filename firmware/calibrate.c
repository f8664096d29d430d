#include "firmware/calibrate.h"

#include <string.h>

#include "common/channels.h"
#include "common/command.h"
#include "common/wire.h"
#include "firmware/config.h"
#include "firmware/channels.h"
#include "firmware/configround.h"

#define MOVEMENT_MAX_IN    0.004f
#define MOVEMENT_MAX_LB    0.75f
#define ZERO_OFFSET_MAX_LB 30.0f
/* allowed deviation of the span, relative to the expected span; at least SIGNIFICANCE_SIGMA
 * standard errors are allowed */
#define SPAN_TOLERANCE     0.01f
#define SIGNIFICANCE_SIGMA 3.0f
#define HALF_BLOCKS        (CALIBRATE_BLOCKS / 2u)

enum { PHASE_REST, PHASE_SHUNTED, PHASE_REST_AFTER, PHASE_REPORT };
enum verdict {
    VERDICT_GOOD = MR_ZERO_GOOD,
    VERDICT_NOT_VALID = MR_ZERO_NOT_VALID,
    VERDICT_MOVING = MR_ZERO_MOVING,
    VERDICT_WRONG = MR_ZERO_TOO_FAR
};
_Static_assert(VERDICT_GOOD == (int)MR_SHUNT_GOOD && VERDICT_NOT_VALID == (int)MR_SHUNT_NOT_VALID &&
                   VERDICT_MOVING == (int)MR_SHUNT_MOVED && VERDICT_WRONG == (int)MR_SHUNT_WRONG,
               "zero and shunt calibration use the same result codes");

bool calibrate_is_busy(const struct calibrate *calibrate)
{
    return calibrate->command != 0;
}

void calibrate_start(struct calibrate *calibrate)
{
    memset(calibrate, 0, sizeof *calibrate);
    for (unsigned g = 0; g < MR_GAGES; g++)
        calibrate->previous_span_lb[g] = calibrate->previous_rest_lb[g] = MR_NAN;
    board_set_shunts(false);
}

static void send_answer(struct telemetry *telemetry, const struct calibrate *calibrate,
                        enum mr_status status, uint32_t block)
{
    TELEMETRY_SEND(telemetry, TO_RECORD, ack, ACK, .code = calibrate->command,
                   .status = (int8_t)status, .tag = calibrate->tag, .block = block);
}

/* ---- which channels ---- */

static bool has_shunt(unsigned gage)
{
    const struct mr_channel_config *channel = &config.channel[MR_TRANSDUCERS + gage];
    return channel->kind == MR_KIND_TENSION && channel->shunt_lb > 0.0f;
}

static bool is_calibrated(const struct calibrate *calibrate, unsigned channel)
{
    unsigned kind = config.channel[channel].kind;
    if (calibrate->command == MR_COMMAND_SHUNT)
        return channel >= MR_TRANSDUCERS && channel < MR_TRANSDUCERS + MR_GAGES &&
               has_shunt(channel - MR_TRANSDUCERS);
    return (kind == MR_KIND_DISPLACEMENT && calibrate->zero_argument != 2) ||
           (kind == MR_KIND_TENSION && calibrate->zero_argument != 1);
}

/* ---- means of a phase ---- */

/* Returns the code to which common/channels.h applies the zero, before correction by the
 * reference. */
static float get_channel_code(const struct mr_block *block, unsigned channel)
{
    float sum = channel < MR_TRANSDUCERS
                  ? (float)block->forward_sum[channel] - (float)block->reversed_sum[channel]
                  : (float)block->sum[channel - MR_TRANSDUCERS];
    return sum / (float)MR_SCANS_PER_BLOCK;
}

static void add_block(struct calibrate *calibrate, const struct mr_block *block)
{
    float ratio = mr_reference_ratio(&config.channel[MR_REFERENCE], block);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct calibrate_mean *mean = &calibrate->mean[c];
        if (!is_calibrated(calibrate, c))
            continue;
        struct mr_reading reading = mr_channel_read(&config.channel[c], block, c, ratio);
        if (reading.validity != MR_VALID) {
            calibrate->invalid_channels |= 1u << c;
            continue;
        }
        float value = calibrate->command == MR_COMMAND_SHUNT ? reading.value
                                                             : get_channel_code(block, c) * ratio;
        if (calibrate->block_count == 0)
            *mean = (struct calibrate_mean){.origin = value};
        value -= mean->origin;
        mean->sum += value;
        mean->square_sum += value * value;
        mean->first_half_sum += calibrate->block_count < HALF_BLOCKS ? value : 0.0f;
    }
    calibrate->block_count++;
}

static float get_mean(const struct calibrate_mean *mean)
{
    return mean->origin + mean->sum / (float)CALIBRATE_BLOCKS;
}

static float compute_standard_deviation(const struct calibrate_mean *mean)
{
    float n = (float)CALIBRATE_BLOCKS;
    float variance = (mean->square_sum - mean->sum * mean->sum / n) / (n - 1.0f);
    return __builtin_sqrtf(variance > 0.0f ? variance : 0.0f);
}

/* Returns the larger of the standard deviation and the difference between the two halves. */
static float compute_mean_spread(const struct calibrate_mean *mean)
{
    float apart = __builtin_fabsf(mean->sum - 2.0f * mean->first_half_sum) / (float)HALF_BLOCKS,
          deviation = compute_standard_deviation(mean);
    return apart > deviation ? apart : deviation;
}

/* ---- zero ---- */

static enum verdict check_zero(const struct calibrate *calibrate, unsigned c)
{
    const struct mr_channel_config *channel = &config.channel[c];
    const struct calibrate_mean *mean = &calibrate->mean[c];
    float unit = __builtin_fabsf(channel->unit_per_code);
    bool tension = channel->kind == MR_KIND_TENSION;
    if (calibrate->invalid_channels >> c & 1u)
        return VERDICT_NOT_VALID;
    if (!(compute_mean_spread(mean) * unit <= (tension ? MOVEMENT_MAX_LB : MOVEMENT_MAX_IN)))
        return VERDICT_MOVING;
    return tension && __builtin_fabsf(get_mean(mean) - zero_get_configured(c)) * unit >
                          ZERO_OFFSET_MAX_LB
             ? VERDICT_WRONG
             : VERDICT_GOOD;
}

static void end_zero(struct calibrate *calibrate, struct telemetry *telemetry,
                     const struct landing *landing, uint32_t block)
{
    bool good = true;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        if (!is_calibrated(calibrate, c))
            continue;
        enum verdict verdict = check_zero(calibrate, c);
        bool valid = verdict != VERDICT_NOT_VALID;
        struct mr_zero_result result = {
            .index = (uint8_t)c,
            .verdict = (uint8_t)verdict,
            .spread_codes = valid ? compute_mean_spread(&calibrate->mean[c]) : MR_NAN,
            .zero_code = valid ? get_mean(&calibrate->mean[c]) : MR_NAN};
        TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, zero_result, ZERO_RESULT, &result);
        good &= verdict == VERDICT_GOOD;
    }
    for (unsigned c = 0; good && c < MR_CHANNELS; c++) {
        if (is_calibrated(calibrate, c))
            zero_set_measured(c, get_mean(&calibrate->mean[c]));
    }
    send_answer(telemetry, calibrate, good ? MR_OK : MR_LIMIT, block);
    if (good)
        configround_start_burst(telemetry, landing);
    calibrate->command = 0;
}

/* Sets a zero that was measured earlier. The argument contains the bits of the code, a float. */
static enum mr_status set_given_zero(const struct mr_command *command)
{
    unsigned channel = command->index - 1u;
    float code;
    memcpy(&code, &command->argument, sizeof code);
    if (channel >= MR_TRANSDUCERS + MR_GAGES || !(__builtin_fabsf(code) <= 4096.0f))
        return MR_USAGE;
    zero_set_measured(channel, code);
    return MR_OK;
}

/* ---- shunt ---- */

static void begin_phase(struct calibrate *calibrate, unsigned phase, uint32_t next_block)
{
    calibrate->phase = (uint8_t)phase;
    calibrate->next_block = next_block;
    calibrate->block_count = 0;
}

static void end_phase(struct calibrate *calibrate)
{
    for (unsigned g = 0; g < MR_GAGES; g++) {
        const struct calibrate_mean *mean = &calibrate->mean[MR_TRANSDUCERS + g];
        float lb = get_mean(mean);
        if (!has_shunt(g))
            continue;
        if (compute_mean_spread(mean) > MOVEMENT_MAX_LB)
            calibrate->moved_gages |= 1u << g;
        if (calibrate->phase == PHASE_SHUNTED) {
            calibrate->shunt_reading_lb[g] = lb;
        } else if (calibrate->phase == PHASE_REST) {
            calibrate->rest_lb[g] = lb;
            calibrate->noise_lb[g] = compute_standard_deviation(mean);
        } else {
            if (__builtin_fabsf(lb - calibrate->rest_lb[g]) > MOVEMENT_MAX_LB)
                calibrate->moved_gages |= 1u << g;
            calibrate->rest_lb[g] = 0.5f * (calibrate->rest_lb[g] + lb);
        }
    }
}

/* Checks the span of a gage. The variance has the factor 1.5 because the span is the difference
 * between a mean over 256 blocks and one over 512 blocks. The configured gain error does not widen
 * the limit, because the shunt is there to check the gain. */
static enum verdict check_span(const struct calibrate *calibrate, unsigned g, float span_lb)
{
    const struct mr_channel_config *channel = &config.channel[MR_TRANSDUCERS + g];
    float noise = calibrate->noise_lb[g] * calibrate->noise_lb[g] * 1.5f / (float)CALIBRATE_BLOCKS;
    float allowed_lb = SPAN_TOLERANCE * channel->shunt_lb;
    float error_lb = SIGNIFICANCE_SIGMA * __builtin_sqrtf(noise);
    if (calibrate->invalid_channels >> (MR_TRANSDUCERS + g) & 1u)
        return VERDICT_NOT_VALID;
    if (calibrate->moved_gages >> g & 1u)
        return VERDICT_MOVING;
    return __builtin_fabsf(span_lb - channel->shunt_lb) >
                   (error_lb > allowed_lb ? error_lb : allowed_lb)
             ? VERDICT_WRONG
             : VERDICT_GOOD;
}

static void report_gage(struct calibrate *calibrate, struct telemetry *telemetry, unsigned g)
{
    float span_lb = calibrate->shunt_reading_lb[g] - calibrate->rest_lb[g];
    enum verdict verdict = check_span(calibrate, g, span_lb);
    bool known = verdict == VERDICT_GOOD || verdict == VERDICT_WRONG;
    if (verdict == VERDICT_NOT_VALID)
        span_lb = MR_NAN;
    struct mr_shunt_result result = {.gage = (uint8_t)(g + 1),
                                     .verdict = (uint8_t)verdict,
                                     .noise_lb = calibrate->noise_lb[g],
                                     .span_lb = span_lb};
    struct mr_shunt_check check = {
        .gage = (uint8_t)(g + 1),
        .expected_lb = config.channel[MR_TRANSDUCERS + g].shunt_lb,
        .change_lb = known ? span_lb - calibrate->previous_span_lb[g] : MR_NAN,
        .zero_change_lb = known ? calibrate->rest_lb[g] - calibrate->previous_rest_lb[g] : MR_NAN};
    TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, shunt_result, SHUNT_RESULT, &result);
    TELEMETRY_SEND_MESSAGE(telemetry, TO_LINKS, shunt_check, SHUNT_CHECK, &check);
    calibrate->has_failed |= verdict != VERDICT_GOOD;
    if (known) {
        calibrate->previous_span_lb[g] = span_lb;
        calibrate->previous_rest_lb[g] = calibrate->rest_lb[g];
    }
}

static void report_begin(struct calibrate *calibrate, struct telemetry *telemetry,
                         const struct landing *landing)
{
    TELEMETRY_SEND(telemetry, TO_LINKS, shunt, SHUNT, .number = ++calibrate->number,
                   .landing = landing->number, .block = calibrate->start_block);
}

/* Reports one gage per block, to avoid a burst. */
static void report_next(struct calibrate *calibrate, struct telemetry *telemetry, uint32_t block)
{
    while (calibrate->gages_to_report && !has_shunt(MR_GAGES - calibrate->gages_to_report))
        calibrate->gages_to_report--;
    if (calibrate->gages_to_report) {
        report_gage(calibrate, telemetry, MR_GAGES - calibrate->gages_to_report);
        calibrate->gages_to_report--;
        return;
    }
    send_answer(telemetry, calibrate, calibrate->has_failed ? MR_LIMIT : MR_OK, block);
    calibrate->command = 0;
}

static void continue_phase(struct calibrate *calibrate, struct telemetry *telemetry,
                           const struct landing *landing, uint32_t block)
{
    if (calibrate->command == MR_COMMAND_ZERO) {
        end_zero(calibrate, telemetry, landing, block);
        return;
    }
    end_phase(calibrate);
    board_set_shunts(calibrate->phase == PHASE_REST);
    if (calibrate->phase == PHASE_REST_AFTER) {
        report_begin(calibrate, telemetry, landing);
        calibrate->gages_to_report = MR_GAGES;
    }
    begin_phase(calibrate, calibrate->phase + 1u, block + 1u + CALIBRATE_SETTLE_BLOCKS);
}

/* ---- commands and blocks ---- */

enum mr_status calibrate_begin(struct calibrate *calibrate, struct telemetry *telemetry,
                               const struct landing *landing, const struct mr_command *command,
                               uint32_t block)
{
    if (calibrate_is_busy(calibrate))
        return MR_NOT_NOW;
    bool zero = command->code == MR_COMMAND_ZERO;
    if (zero && command->index) {
        enum mr_status status = set_given_zero(command);
        if (status == MR_OK)
            configround_start_burst(telemetry, landing);
        return status;
    }
    if (command->argument < 0 || command->argument > (zero ? 2 : 0))
        return MR_USAGE;
    calibrate->command = command->code;
    calibrate->zero_argument = (uint8_t)command->argument;
    calibrate->tag = command->tag;
    calibrate->invalid_channels = calibrate->moved_gages = 0;
    calibrate->has_failed = false;
    calibrate->start_block = block;
    begin_phase(calibrate, PHASE_REST, block);
    return MR_OK;
}

void calibrate_on_block(struct calibrate *calibrate, struct telemetry *telemetry,
                        const struct landing *landing, const struct mr_block *block)
{
    if (!calibrate_is_busy(calibrate))
        return;
    if (calibrate->phase == PHASE_REPORT) {
        report_next(calibrate, telemetry, block->index);
        return;
    }
    if ((int32_t)(block->index - calibrate->next_block) < 0)
        return;
    add_block(calibrate, block);
    if (calibrate->block_count == CALIBRATE_BLOCKS)
        continue_phase(calibrate, telemetry, landing, block->index);
}

void calibrate_abort(struct calibrate *calibrate, struct telemetry *telemetry, uint32_t block)
{
    if (!calibrate_is_busy(calibrate))
        return;
    board_set_shunts(false);
    send_answer(telemetry, calibrate, MR_TIMEOUT, block);
    calibrate->command = 0;
}
