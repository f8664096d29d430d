#include "hil/rig/replay.h"

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/periph/adc.h"
#include "hil/periph/gpio.h"
#include "hil/periph/rcc.h"
#include "hil/periph/tim.h"
#include "hil/rig/rig.h"
#include "hil/rig/script.h"

/* The application takes a block 0.97 ms after its first trigger: what comes half way before that
 * finds the block before it done, and is there in time. */
#define COMMAND_TICKS     37800u
#define SCAN_TICKS        (MR_TICKS_PER_BLOCK / MR_SCANS_PER_BLOCK)
/* the one-shot goes low again 1 us after the capture; edges may follow closely */
#define PULSE_TICKS       84u
#define FRAME_PULSE_TICKS 8400u /* 100 us */
#define SERIAL_COMMANDS   2u    /* the application takes so many from each link in a block */
#define MARGIN_S          1.0   /* from power on to the first scan, and to send the end */

static uint64_t tick_cycles(const struct hil_replay_device *dev)
{
    return (uint64_t)hil_rcc_apb1_timer_divider(dev->rcc) *
           (dev->tim->state[HIL_TIM2].psc_now + 1u);
}

static uint64_t cycle_of(const struct hil_replay_device *dev, uint64_t tick)
{
    return dev->state->zero_cycle + tick * tick_cycles(dev);
}

static uint64_t command_tick(const struct hil_replay *replay, size_t i)
{
    return replay->origin_tick + (uint64_t)replay->commands[i].block * MR_TICKS_PER_BLOCK +
           COMMAND_TICKS;
}

/* When PA15 has to rise or fall next, HIL_NEVER: no more. */
static uint64_t pin_cycle(const struct hil_replay_device *dev)
{
    const struct hil_replay *replay = dev->replay;
    const struct hil_replay_state *state = dev->state;
    if (state->pulse) {
        uint64_t tick = replay->edge_tick[state->next_edge - 1], low = tick + PULSE_TICKS;
        if (state->next_edge < replay->edge_count &&
            (tick + replay->edge_tick[state->next_edge]) / 2u < low)
            low = (tick + replay->edge_tick[state->next_edge]) / 2u;
        return cycle_of(dev, low);
    }
    if (state->next_edge == replay->edge_count)
        return HIL_NEVER;
    return cycle_of(dev, replay->edge_tick[state->next_edge]) - hil_tim2_capture_delay(dev->tim);
}

/* The same of PB3. */
static uint64_t frame_cycle(const struct hil_replay_device *dev)
{
    const struct hil_replay *replay = dev->replay;
    const struct hil_replay_state *state = dev->state;
    if (state->frame_pulse)
        return cycle_of(dev, replay->frame_tick[state->next_frame - 1] + FRAME_PULSE_TICKS);
    return state->next_frame < replay->frame_count
             ? cycle_of(dev, replay->frame_tick[state->next_frame])
             : HIL_NEVER;
}

static void schedule(struct hil_replay_device *dev)
{
    const struct hil_replay_state *state = dev->state;
    uint64_t next = pin_cycle(dev), frame = frame_cycle(dev);
    next = frame < next ? frame : next;
    if (state->next_command < dev->replay->command_count) {
        uint64_t command = cycle_of(dev, command_tick(dev->replay, state->next_command));
        next = command < next ? command : next;
    }
    hil_event_set_cycle(dev->core, HIL_EVENT_REPLAY, next);
}

/* The first conversion after TIM2 has started: everything is counted from that start. */
static void begin(struct hil_replay_device *dev)
{
    const struct hil_tim *tim2 = &dev->tim->state[HIL_TIM2];
    struct hil_replay_state *state = dev->state;
    *state = (struct hil_replay_state){
        .started = true,
        .zero_cycle = tim2->base_cycle - tim2->base_count * tick_cycles(dev),
        .resets = dev->core->state.counters.resets,
    };
    schedule(dev);
}

static void give(struct hil_replay_device *dev, const struct mr_command *message, bool serial)
{
    if (hil_command_in(dev->can, dev->usart, &dev->state->sequence, message, serial) != MR_OK)
        hil_core_stop(dev->core, MR_FULL, "replayed command %u: too many wait for the board",
                      (unsigned)message->tag);
}

/* All commands of the next block at once. The application takes those from CAN first. */
static void give_block(struct hil_replay_device *dev)
{
    const struct hil_replay *replay = dev->replay;
    struct hil_replay_state *state = dev->state;
    uint32_t first = state->next_command, end = first;
    while (end < replay->command_count &&
           replay->commands[end].block == replay->commands[first].block)
        end++;
    for (uint32_t i = first; i < end; i++)
        give(dev, &replay->commands[i].message, end - i <= SERIAL_COMMANDS);
    state->next_command = end;
}

static void move_pin(struct hil_replay_device *dev, uint64_t at)
{
    struct hil_replay_state *state = dev->state;
    if (state->pulse) {
        state->pulse = false;
    } else {
        state->pulse = true;
        state->next_edge++;
        dev->core->state.counters.switches_opened++;
    }
    hil_gpio_drive(dev->gpio, 0, 15, state->pulse, at);
}

static void move_frame_pin(struct hil_replay_device *dev, uint64_t at)
{
    struct hil_replay_state *state = dev->state;
    state->frame_pulse = !state->frame_pulse;
    if (state->frame_pulse)
        state->next_frame++;
    hil_gpio_drive(dev->gpio, 1, 3, state->frame_pulse, at);
}

static void on_event(void *device, uint64_t at)
{
    struct hil_replay_device *dev = device;
    struct hil_replay_state *state = dev->state;
    if (!dev->replay || !state->started || state->resets != dev->core->state.counters.resets)
        return; /* a board that was reset begins the record again with its scans */
    if (pin_cycle(dev) <= at)
        move_pin(dev, at);
    if (frame_cycle(dev) <= at)
        move_frame_pin(dev, at);
    if (state->next_command < dev->replay->command_count &&
        cycle_of(dev, command_tick(dev->replay, state->next_command)) <= at)
        give_block(dev);
    schedule(dev);
}

static const struct mr_block *block_at(const struct hil_replay *replay, uint64_t index)
{
    const struct mr_block *first = &replay->blocks[0];
    if (index <= first->index)
        return first;
    uint64_t place = index - first->index;
    return place < replay->block_count ? first + place : first + replay->block_count - 1;
}

/* Place of a pin in its converter's scan; false: nothing of the record is on it. */
static bool channel_of(const struct hil_rig_device *rig, unsigned port, unsigned pin,
                       bool *transducer, unsigned *channel)
{
    int of_all = hil_rig_channel(rig, port, pin);
    *transducer = of_all < (int)MR_TRANSDUCERS;
    *channel = (unsigned)of_all - (*transducer ? 0 : MR_TRANSDUCERS);
    return of_all >= 0;
}

/* Code of a pin sampled at cycle `at`. */
static uint16_t code_of(void *device, unsigned port, unsigned pin, uint64_t at)
{
    struct hil_replay_device *dev = device;
    const struct hil_replay *replay = dev->replay;
    struct hil_replay_state *state = dev->state;
    bool transducer;
    unsigned channel, unused;
    if (!(dev->tim->state[HIL_TIM2].cr1 & 1u) ||
        !channel_of(dev->rig, port, pin, &transducer, &channel))
        return 0;
    if (!state->started || state->resets != dev->core->state.counters.resets)
        begin(dev);
    uint64_t tick = (at - state->zero_cycle) / tick_cycles(dev);
    uint64_t since = tick < replay->origin_tick ? 0 : tick - replay->origin_tick;
    const struct mr_block *block = block_at(replay, since / MR_TICKS_PER_BLOCK);
    if (block != dev->codes_block) {
        hil_codes_of(block, &dev->codes, &unused); /* has been tried when the file was read */
        dev->codes_block = block;
    }
    unsigned scan = (unsigned)(since % MR_TICKS_PER_BLOCK / SCAN_TICKS);
    if (!transducer)
        return dev->codes.adc1[channel][scan];
    int polarity = dev->rig->state->excitation;
    if (polarity == 0)
        return 2048; /* an unexcited transducer rests at its middle */
    return dev->codes.transducer[polarity < 0][channel][scan / 2u];
}

void hil_replay_create(struct hil_replay_device *dev)
{
    hil_event_wire(dev->core, HIL_EVENT_REPLAY, on_event, dev);
}

void hil_replay_connect(struct hil_replay_device *dev, const struct hil_replay *replay)
{
    dev->replay = replay;
    dev->codes_block = NULL;
    dev->adc->record = (struct hil_recorded_codes){dev, replay ? code_of : NULL};
}

double hil_replay_duration_s(const struct hil_replay *replay)
{
    return ((double)replay->blocks[replay->block_count - 1].index + 1.0) * 1e-3 + MARGIN_S;
}
