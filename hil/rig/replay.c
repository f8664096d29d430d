#include "hil/rig/replay.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/command.h"
#include "hil/core/core.h"
#include "hil/periph/adc.h"
#include "hil/periph/gpio.h"
#include "hil/periph/rcc.h"
#include "hil/periph/tim.h"
#include "hil/rig/rig.h"

/* The application handles a block 0.97 ms after its first trigger. A command sent half a block
 * earlier arrives after the application has handled the previous block. */
#define COMMAND_TICK_IN_BLOCK  37800u
#define SCAN_TICKS             (MR_TICKS_PER_BLOCK / MR_SCANS_PER_BLOCK)
/* the pulse ends 1 us after the capture, because the next edge may be close */
#define EDGE_PULSE_TICKS       84u
#define TRAIN_PULSE_TICKS      8400u /* 100 us */
/* number of commands from each link that the application handles per block */
#define COMMANDS_PER_LINK      2u
/* time allowed before the first scan and for sending the last data */
#define START_AND_END_MARGIN_S 1.0

static uint64_t get_tick_cycles(const struct hil_replay_device *dev)
{
    return (uint64_t)hil_rcc_timer_divider(dev->rcc, HIL_RCC_APB1) *
           (dev->tim->state[HIL_TIM2].psc_shadow + 1u);
}

static uint64_t get_cycle_at_tick(const struct hil_replay_device *dev, uint64_t tick)
{
    return dev->state->tim2_zero_cycle + tick * get_tick_cycles(dev);
}

static uint64_t get_command_tick(const struct hil_replay *replay, size_t i)
{
    return replay->block0_tick + (uint64_t)replay->commands[i].block * MR_TICKS_PER_BLOCK +
           COMMAND_TICK_IN_BLOCK;
}

/* Cycle of the next change of PA15; HIL_NEVER if there is none. */
static uint64_t get_edge_pin_cycle(const struct hil_replay_device *dev)
{
    const struct hil_replay *replay = dev->replay;
    const struct hil_replay_state *state = dev->state;
    if (state->is_edge_pulse_high) {
        uint64_t tick = replay->edge_ticks[state->next_edge - 1], low = tick + EDGE_PULSE_TICKS;
        if (state->next_edge < replay->edge_count &&
            (tick + replay->edge_ticks[state->next_edge]) / 2u < low)
            low = (tick + replay->edge_ticks[state->next_edge]) / 2u;
        return get_cycle_at_tick(dev, low);
    }
    if (state->next_edge == replay->edge_count)
        return HIL_NEVER;
    return get_cycle_at_tick(dev, replay->edge_ticks[state->next_edge]);
}

/* Cycle of the next change of the input with train i; HIL_NEVER if there is none. */
static uint64_t get_next_pulse_cycle(const struct hil_replay_device *dev, unsigned i)
{
    uint64_t tick = hil_pulse_train_next_edge(&dev->replay->pulse_train[i],
                                              &dev->state->pulse_train[i], TRAIN_PULSE_TICKS);
    return tick == HIL_RUN_NEVER ? HIL_NEVER : get_cycle_at_tick(dev, tick);
}

static void schedule(struct hil_replay_device *dev)
{
    const struct hil_replay_state *state = dev->state;
    uint64_t next = get_edge_pin_cycle(dev);
    for (unsigned i = 0; i < HIL_REPLAY_TRAINS; i++) {
        uint64_t train = get_next_pulse_cycle(dev, i);
        next = train < next ? train : next;
    }
    if (state->next_command < dev->replay->command_count) {
        uint64_t command = get_cycle_at_tick(dev,
                                             get_command_tick(dev->replay, state->next_command));
        next = command < next ? command : next;
    }
    hil_event_set_cycle(dev->core, HIL_EVENT_REPLAY, next);
}

static void apply_command(struct hil_replay_device *dev, const struct mr_command *message,
                          bool serial)
{
    if (hil_command_send(dev->can, dev->usart, &dev->state->sequence, message, serial) != MR_OK)
        hil_core_stop(dev->core, MR_FULL,
                      "replayed command %u: too many commands are waiting for the board",
                      (unsigned)message->tag);
}

/* Called at the first conversion after TIM2 was started: all ticks of the record count from this
 * start. */
static void begin_replay(struct hil_replay_device *dev)
{
    const struct hil_tim *tim2 = &dev->tim->state[HIL_TIM2];
    struct hil_replay_state *state = dev->state;
    *state = (struct hil_replay_state){
        .is_started = true,
        .tim2_zero_cycle = tim2->base_cycle - tim2->base_count * get_tick_cycles(dev),
        .reset_count = dev->core->state.counters.resets,
    };
    apply_command(dev, &(struct mr_command){.code = MR_COMMAND_REPLAY}, true);
    schedule(dev);
}

/* Sends all commands of the next block at once. The application handles the commands from CAN
 * first. */
static void send_block_commands(struct hil_replay_device *dev)
{
    const struct hil_replay *replay = dev->replay;
    struct hil_replay_state *state = dev->state;
    uint32_t first = state->next_command, end = first;
    while (end < replay->command_count &&
           replay->commands[end].block == replay->commands[first].block)
        end++;
    for (uint32_t i = first; i < end; i++)
        apply_command(dev, &replay->commands[i].message, end - i <= COMMANDS_PER_LINK);
    state->next_command = end;
}

static void toggle_edge_pin(struct hil_replay_device *dev, uint64_t at)
{
    struct hil_replay_state *state = dev->state;
    if (state->is_edge_pulse_high) {
        state->is_edge_pulse_high = false;
    } else {
        state->is_edge_pulse_high = true;
        state->next_edge++;
        dev->core->state.counters.switches_opened++;
    }
    hil_gpio_drive(dev->gpio, 0, 15, state->is_edge_pulse_high, at);
}

static void toggle_train_pin(struct hil_replay_device *dev, unsigned i, uint64_t at)
{
    const struct hil_capture_pin *pin = &hil_capture_pins[HIL_REPLAY_FIRST_CAPTURE_CHANNEL + i];
    struct hil_pulse_train_state *state = &dev->state->pulse_train[i];
    hil_pulse_train_pass_edge(state);
    hil_gpio_drive(dev->gpio, pin->port, pin->pin, state->is_high, at);
}

static void on_event(void *device, uint64_t at)
{
    struct hil_replay_device *dev = device;
    struct hil_replay_state *state = dev->state;
    if (!dev->replay || !state->is_started ||
        state->reset_count != dev->core->state.counters.resets)
        return; /* not started here: after a reset, the record begins again with the first scan */
    if (get_edge_pin_cycle(dev) <= at)
        toggle_edge_pin(dev, at);
    for (unsigned i = 0; i < HIL_REPLAY_TRAINS; i++) {
        if (get_next_pulse_cycle(dev, i) <= at)
            toggle_train_pin(dev, i, at);
    }
    if (state->next_command < dev->replay->command_count &&
        get_cycle_at_tick(dev, get_command_tick(dev->replay, state->next_command)) <= at)
        send_block_commands(dev);
    schedule(dev);
}

static const struct mr_block *find_block(const struct hil_replay *replay, uint64_t index)
{
    const struct mr_block *first = &replay->blocks[0];
    if (index <= first->index)
        return first;
    uint64_t place = index - first->index;
    return place < replay->block_count ? first + place : first + replay->block_count - 1;
}

/* Position of a pin in its converter's scan. Returns false if the record has no data for the
 * pin. */
static bool find_channel(const struct hil_rig_device *rig, unsigned port, unsigned pin,
                         bool *transducer, unsigned *channel)
{
    int of_all = hil_rig_find_channel(rig, port, pin);
    *transducer = of_all < (int)MR_TRANSDUCERS;
    *channel = (unsigned)of_all - (*transducer ? 0 : MR_TRANSDUCERS);
    return of_all >= 0;
}

/* Code of a pin sampled at cycle `at`. */
static uint16_t sample_code(void *device, unsigned port, unsigned pin, uint64_t at)
{
    struct hil_replay_device *dev = device;
    const struct hil_replay *replay = dev->replay;
    struct hil_replay_state *state = dev->state;
    bool transducer;
    unsigned channel, unused;
    if (!(dev->tim->state[HIL_TIM2].cr1 & 1u) ||
        !find_channel(dev->rig, port, pin, &transducer, &channel))
        return 0;
    if (!state->is_started || state->reset_count != dev->core->state.counters.resets)
        begin_replay(dev);
    uint64_t tick = (at - state->tim2_zero_cycle) / get_tick_cycles(dev);
    uint64_t since = tick < replay->block0_tick ? 0 : tick - replay->block0_tick;
    const struct mr_block *block = find_block(replay, since / MR_TICKS_PER_BLOCK);
    if (block != dev->codes_block) {
        hil_codes_from_block(block, &dev->codes,
                             /* cannot fail, because the sums were checked when the file was read */
                             &unused);
        dev->codes_block = block;
    }
    unsigned scan = (unsigned)(since % MR_TICKS_PER_BLOCK / SCAN_TICKS);
    if (!transducer)
        return dev->codes.adc1[channel][scan];
    int polarity = dev->rig->state->excitation;
    if (polarity == 0)
        return 2048; /* a transducer without excitation reads half of the range */
    return dev->codes.transducer[polarity < 0][channel][scan / 2u];
}

void hil_replay_create(struct hil_replay_device *dev)
{
    hil_event_connect(dev->core, HIL_EVENT_REPLAY, on_event, dev);
}

void hil_replay_connect(struct hil_replay_device *dev, const struct hil_replay *replay)
{
    dev->replay = replay;
    dev->codes_block = NULL;
    dev->adc->recorded = (struct hil_recorded_codes){dev, replay ? sample_code : NULL};
}

double hil_replay_duration_s(const struct hil_replay *replay)
{
    return ((double)replay->blocks[replay->block_count - 1].index + 1.0) * 1e-3 +
           START_AND_END_MARGIN_S;
}

/* ---- the replay file ---- */

#define refuse_file(r, ...) hil_file_refuse(&(r)->context, MR_MALFORMED, __VA_ARGS__)

static enum mr_status read_block(struct hil_text_file *r, struct hil_replay *replay,
                                 const char *text)
{
    uint8_t record[MR_BLOCK_BYTES_MAX];
    size_t bytes = 0;
    struct mr_block block;
    struct hil_block_codes codes;
    unsigned channel, byte;
    for (int n = 0; bytes < sizeof record && sscanf(text, "%2x%n", &byte, &n) == 1 && n == 2;
         text += 2)
        record[bytes++] = (uint8_t)byte;
    if (*text || mr_block_decode(&block, record, bytes) != MR_OK)
        return refuse_file(r, "not a block record of this layout");
    if (replay->block_count) {
        const struct mr_block *last = &replay->blocks[replay->block_count - 1];
        if (block.index != last->index + 1u || block.tick != last->tick + MR_TICKS_PER_BLOCK)
            return refuse_file(r, "block %u is not the successor of block %u",
                               (unsigned)block.index, (unsigned)last->index);
    } else {
        replay->block0_tick = block.tick - block.index * MR_TICKS_PER_BLOCK;
        if (replay->block0_tick >= MR_TICKS_PER_BLOCK)
            return refuse_file(r, "block %u cannot begin at tick %u", (unsigned)block.index,
                               (unsigned)block.tick);
    }
    if (!hil_codes_from_block(&block, &codes, &channel))
        return refuse_file(
            r, "block %u, channel %u: no sequence of codes has the recorded sum and counts",
            (unsigned)block.index, channel);
    replay->blocks = hil_array_grow(replay->blocks, replay->block_count, sizeof block);
    replay->blocks[replay->block_count++] = block;
    return MR_OK;
}

/* Reads a tick, which must be at least `apart` after the tick before it. */
static enum mr_status read_tick(struct hil_text_file *r, const char *text, uint64_t apart,
                                uint64_t **ticks, size_t *count)
{
    uint64_t tick;
    int end = 0;
    if (sscanf(text, "%" SCNu64 "%n", &tick, &end) != 1 || text[end] ||
        tick > (uint64_t)INT64_MAX / 8u || (*count && tick < (*ticks)[*count - 1] + apart))
        return refuse_file(r, "expected ticks in ascending order, at least %" PRIu64 " apart",
                           apart);
    *ticks = hil_array_grow(*ticks, *count, sizeof tick);
    (*ticks)[(*count)++] = tick;
    return MR_OK;
}

static enum mr_status read_command(struct hil_text_file *r, struct hil_replay *replay,
                                   const char *text)
{
    struct hil_replay_command command;
    size_t count = replay->command_count;
    int end = 0;
    if (sscanf(text, "%" SCNu32 " %" SCNu8 " %" SCNu8 " %" SCNu16 " %" SCNd32 "%n", &command.block,
               &command.message.code, &command.message.index, &command.message.tag,
               &command.message.argument, &end) != 5 ||
        text[end] || (count && command.block < replay->commands[count - 1].block))
        return refuse_file(
            r, "expected `command <block> <code> <index> <tag> <argument>`, with blocks in order");
    replay->commands = hil_array_grow(replay->commands, count, sizeof command);
    replay->commands[replay->command_count++] = command;
    return MR_OK;
}

static enum mr_status read_line(struct hil_text_file *r, struct hil_replay *replay,
                                const char *line)
{
    unsigned crystal;
    int end = 0;
    if (strncmp(line, "block ", 6) == 0)
        return read_block(r, replay, line + 6);
    if (strncmp(line, "edge ", 5) == 0)
        return read_tick(r, line + 5, 1, &replay->edge_ticks, &replay->edge_count);
    for (unsigned i = 0; i < HIL_REPLAY_TRAINS; i++) {
        static const char *const keyword[HIL_REPLAY_TRAINS] = {"frame ", "brake ", "wheel "};
        if (strncmp(line, keyword[i], 6) == 0)
            return read_tick(r, line + 6, MR_TICKS_PER_BLOCK, &replay->pulse_train[i].rise_times,
                             &replay->pulse_train[i].pulse_count);
    }
    if (strncmp(line, "command ", 8) == 0)
        return read_command(r, replay, line + 8);
    if (sscanf(line, "uid %8" SCNx32 " %8" SCNx32 " %8" SCNx32 "%n", &replay->uid[0],
               &replay->uid[1], &replay->uid[2], &end) == 3 &&
        !line[end]) {
        replay->has_uid = true;
        return MR_OK;
    }
    if (sscanf(line, "crystal %1u%n", &crystal, &end) == 1 && !line[end] && crystal <= 1) {
        replay->has_crystal = crystal;
        return MR_OK;
    }
    return refuse_file(r, "unknown line `%.20s`", line);
}

enum mr_status hil_replay_read(const char *path, struct hil_replay *replay, char *error,
                               size_t size)
{
    struct hil_text_file r = {.context = {path, 0, error, size}};
    const char *line;
    *replay = (struct hil_replay){.has_crystal = true};
    enum mr_status status = hil_text_file_open(&r, "matrig-replay");
    while (status == MR_OK && (line = hil_text_file_next_line(&r)) != NULL)
        status = read_line(&r, replay, line);
    if (status == MR_OK && !replay->block_count)
        status = refuse_file(&r, "no block records");
    free(r.bytes);
    if (status != MR_OK)
        hil_replay_free(replay);
    return status;
}

void hil_replay_free(struct hil_replay *replay)
{
    free(replay->blocks);
    free(replay->edge_ticks);
    for (unsigned i = 0; i < HIL_REPLAY_TRAINS; i++)
        free(replay->pulse_train[i].rise_times);
    free(replay->commands);
    *replay = (struct hil_replay){0};
}

/* ---- converter codes of a block record ---- */

#define CODE_MAX 4095u

struct range {
    uint16_t min, max;
};

static const struct range low_codes = {0, MR_CODE_LOW};
static const struct range middle_codes = {MR_CODE_LOW + 1u, MR_CODE_HIGH - 1u};
static const struct range high_codes = {MR_CODE_HIGH, CODE_MAX};

static struct range get_code_range(unsigned i, unsigned low, unsigned high)
{
    return i < low ? low_codes : i < low + high ? high_codes : middle_codes;
}

/* True if `count` codes, `low` and `high` of them saturated, can add up to `sum`. */
static bool is_sum_possible(unsigned sum, unsigned count, unsigned low, unsigned high)
{
    unsigned least = 0, most = 0;
    if (low + high > count)
        return false;
    for (unsigned i = 0; i < count; i++) {
        least += get_code_range(i, low, high).min;
        most += get_code_range(i, low, high).max;
    }
    return sum >= least && sum <= most;
}

/* Gives each code its smallest value and distributes the remaining sum evenly. What a code at its
 * maximum cannot take goes to the following codes. */
static void distribute_sum(unsigned sum, unsigned count, unsigned low, unsigned high,
                           uint16_t *codes)
{
    unsigned rest = sum;
    for (unsigned i = 0; i < count; i++) {
        codes[i] = get_code_range(i, low, high).min;
        rest -= codes[i];
    }
    while (rest) {
        for (unsigned i = 0; i < count && rest; i++) {
            unsigned share = (rest + (count - i) - 1u) / (count - i);
            unsigned room = (unsigned)(get_code_range(i, low, high).max - codes[i]);
            unsigned more = share < room ? share : room;
            codes[i] = (uint16_t)(codes[i] + more);
            rest -= more;
        }
    }
}

/* Distributes the sums of a transducer's two polarities. The record has the numbers of saturated
 * codes only for both polarities together, so this uses the first division that is possible. */
static bool distribute_transducer_sums(const struct mr_block *block, unsigned i,
                                       struct hil_block_codes *codes)
{
    const unsigned n = HIL_CODES_PER_POLARITY;
    for (unsigned low = 0; low <= block->low_count[i]; low++) {
        for (unsigned high = 0; high <= block->high_count[i]; high++) {
            if (!is_sum_possible(block->forward_sum[i], n, low, high) ||
                !is_sum_possible(block->reversed_sum[i], n, block->low_count[i] - low,
                                 block->high_count[i] - high))
                continue;
            distribute_sum(block->forward_sum[i], n, low, high, codes->transducer[0][i]);
            distribute_sum(block->reversed_sum[i], n, block->low_count[i] - low,
                           block->high_count[i] - high, codes->transducer[1][i]);
            return true;
        }
    }
    return false;
}

bool hil_codes_from_block(const struct mr_block *block, struct hil_block_codes *codes,
                          unsigned *channel)
{
    *codes = (struct hil_block_codes){0};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        *channel = i;
        if (!(block->absent_channels >> i & 1u) && !distribute_transducer_sums(block, i, codes))
            return false;
    }
    for (unsigned i = 0; i < MR_ADC1_CHANNELS; i++) {
        unsigned c = *channel = MR_TRANSDUCERS + i;
        if (block->absent_channels >> c & 1u)
            continue;
        if (!is_sum_possible(block->sum[i], MR_SCANS_PER_BLOCK, block->low_count[c],
                             block->high_count[c]))
            return false;
        distribute_sum(block->sum[i], MR_SCANS_PER_BLOCK, block->low_count[c], block->high_count[c],
                       codes->adc1[i]);
    }
    return true;
}
