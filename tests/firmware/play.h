/* What the tests of the application share: blocks of the instrumented runway played to it,
 * commands, a landing that brakes uniformly, and the frames that come out. */
#ifndef MATRIG_TESTS_FIRMWARE_PLAY_H
#define MATRIG_TESTS_FIRMWARE_PLAY_H

#include <math.h>
#include <string.h>

#include "common/command.h"
#include "firmware/app.h"
#include "tests/cmocka_all.h"
#include "tests/firmware/fake_board.h"

static struct app app;
static uint32_t index_now;
static float moved_in[MR_TRANSDUCERS];
static float pulled_lb;       /* added to every gage */
static unsigned opened_codes; /* of the staircase */
static double touchdown_s;

static inline int start(void **state)
{
    (void)state;
    fake_reset();
    app_start(&app);
    index_now = 0;
    opened_codes = 0;
    touchdown_s = 1.0;
    memset(moved_in, 0, sizeof moved_in);
    pulled_lb = 0.0f;
    return 0;
}

/* Codes from the rig's volts (0.5 V/in about a zero of 50 mV; 0.4 V + 5 mV/lb; 2.5 V), worked out
 * apart from config.c. */
static inline void play_block(void)
{
    struct mr_block *block = &fake.block;
    memset(block, 0, sizeof *block);
    block->index = index_now;
    block->tick = 2352u + 84000u * index_now;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        double codes = (0.050 + 0.5 * (double)moved_in[i]) / 3.3 * 4096.0;
        block->forward_sum[i] = (uint16_t)lround(4.0 * (2048.0 + codes));
        block->reversed_sum[i] = (uint16_t)lround(4.0 * (2048.0 - codes));
    }
    for (unsigned i = 0; i < MR_GAGES; i++)
        block->sum[i] =
            (uint16_t)lround(8.0 * (0.4 + 0.005 * (100.0 + i + (double)pulled_lb)) / 3.3 * 4096.0);
    block->sum[MR_ADC1_STAIRCASE] = (uint16_t)(8u * (62u + opened_codes));
    block->sum[MR_ADC1_REFERENCE] = 8u * 3103u;
    fake.block_ready = true;
    assert_true(app_poll(&app));
    index_now++;
}

static inline void play(unsigned blocks)
{
    while (blocks--)
        play_block();
}

static inline void command(const char *words)
{
    struct mr_command message;
    struct board_can_frame *frame = &fake.received[fake.received_count++];
    assert_int_equal(mr_command_parse(words, (uint16_t)fake.received_count, &message), MR_OK);
    frame->id = MR_ID_COMMAND;
    frame->length = (uint8_t)mr_command_put(&message, frame->data);
}

/* Steps 64 + 8 i, i = 7 (p - 1) mod 24. */
static inline unsigned step_of(unsigned position)
{
    return 64 + 8 * (7 * (position - 1) % 24);
}

/* The gear passes switch `position` now: the edge falls in the block just before the step is
 * seen. */
static inline void pass_switch(unsigned position, double t_s)
{
    fake.edge_tick[fake.edges++] = (uint32_t)(uint64_t)llround(t_s * 84e6);
    opened_codes += step_of(position);
}

static inline const struct board_can_frame *last_frame(uint16_t id)
{
    for (size_t i = fake.sent_count; i-- > 0;) {
        if (fake.sent[i].id == id)
            return &fake.sent[i];
    }
    return NULL;
}

static inline unsigned count_frames(uint16_t id)
{
    unsigned count = 0;
    for (size_t i = 0; i < fake.sent_count; i++)
        count += fake.sent[i].id == id;
    return count;
}

#define GET_LAST(name, NAME, into)                                                    \
    do {                                                                              \
        const struct board_can_frame *frame_ = last_frame(MR_ID_##NAME);              \
        assert_non_null(frame_);                                                      \
        assert_int_equal(mr_##name##_get(into, frame_->data, frame_->length), MR_OK); \
    } while (0)

/* Touchdown at 3 ft, `touchdown_s`, 30 ft/s, braking at 6 ft/s2: rest after 5 s at 78 ft. Runs
 * until `end_s`. */
static inline double fly(double end_s)
{
    unsigned next = 1;
    const double t0 = touchdown_s, v = 30.0, a = 6.0;
    while ((double)index_now * 1e-3 < end_s) {
        double station_ft = -2.5 + 5.0 * (next - 1);
        double d = station_ft - 3.0, left = v * v - 2.0 * a * d;
        double t_s = left < 0.0 ? 1e9 : t0 + (d < 0.0 ? d / v : (v - sqrt(left)) / a);
        if (next <= 24 && t_s < (double)index_now * 1e-3) {
            pass_switch(next, t_s);
            next++;
        }
        play_block();
    }
    return t0 + v / a;
}

#endif
