/* Time on the emulated board, which knows when everything really happened: sync frames against the
 * bus, film frames against the camera, with the firmware image that has one
 * (build/tests/variant/camera.elf). */
#include <math.h>

#include "hil/core/nvic.h"
#include "tests/hil/ear.h"

#define ELF         "build/tests/variant/camera.elf"
#define TICKS_PER_S 84e6
#define TICK_S      (1.0 / TICKS_PER_S)
#define FRAMES      4096

static struct ear *ear;

/* What was heard with its times. */
static struct {
    double zero_s; /* power-on time of tick 0, by the first switch of the run file; 0: not known */
    double sync_s; /* when the last sync frame ended, power-on time */
    double least_late_s, most_late_s; /* of sync_at behind the end of its frame */
    struct mr_film_frame frame[FRAMES];
    unsigned frames;
} heard;

static void on_sync_at(const uint8_t *data)
{
    struct mr_sync sync;
    struct mr_sync_at at;
    mr_sync_get(&sync, ear->last[EAR_CAN][MR_ID_SYNC], 8);
    mr_sync_at_get(&at, data, 8);
    assert_int_equal(at.block16, (uint16_t)sync.block);
    assert_int_equal(at.sent, 1);
    if (heard.zero_s <= 0.0)
        return;
    double late_s = heard.zero_s + at.tick * TICK_S - heard.sync_s;
    heard.least_late_s = fmin(heard.least_late_s, late_s);
    heard.most_late_s = fmax(heard.most_late_s, late_s);
}

static void on_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct mr_edge edge;
    ear_can(ctx, t_ps, frame);
    switch (frame->id) {
    case MR_ID_SYNC: heard.sync_s = (double)t_ps * 1e-12; break;
    case MR_ID_SYNC_AT: on_sync_at(frame->data); break;
    case MR_ID_EDGE:
        mr_edge_get(&edge, frame->data, 8);
        if (heard.zero_s <= 0.0 && edge.position)
            heard.zero_s = (double)ear->run.switch_open_ps[edge.position - 1] * 1e-12 -
                           edge.tick * TICK_S;
        break;
    case MR_ID_FILM_FRAME:
        assert_true(heard.frames < FRAMES);
        mr_film_frame_get(&heard.frame[heard.frames++], frame->data, 8);
        break;
    default: break;
    }
}

static void play(const char *elf, double hz, double delay_ms, double jitter_us, const char *fault,
                 double end_s)
{
    struct hil_options options = ear_options();
    options.camera_hz = hz;
    options.camera_delay_ps = (uint64_t)(delay_ms * 1e9);
    options.camera_jitter_ps = (uint64_t)(jitter_us * 1e6);
    memset(&heard, 0, sizeof heard);
    heard.least_late_s = 1.0;
    ear = ear_open(&options, 5);
    hil_board_set_callbacks(ear->board, &(struct hil_callbacks){ear, on_can, NULL});
    assert_int_equal(hil_board_load_elf(ear->board, elf), MR_OK);
    if (fault)
        ear_order(ear, fault);
    ear_until(ear, end_s);
}

/* The bus is two fifths full and the processor busy; the tick told is that of the end of the frame
 * all the same, late by the interrupt alone. */
TEST(sync_at_tells_when_the_sync_frame_ended)
{
    play("build/firmware/matrig.elf", 0.0, 0.0, 0.0, NULL, 6.5);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_SYNC], 7);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_SYNC_AT], 7);
    printf("# sync_at late by %.2f to %.2f us\n", heard.least_late_s * 1e6,
           heard.most_late_s * 1e6);
    assert_true(heard.least_late_s > -1.5 * TICK_S); /* the run file's zero is good to a tick */
    assert_true(heard.most_late_s < 30e-6);
    assert_int_equal(heard.frames, 0);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_CAMERA], 0);
    assert_int_equal(hil_board_counters(ear->board)->film_frames_captured, 0);
    ear_close(ear);
}

/* A camera without jitter exposes frame n at trigger + delay + n / rate, and that is the tick told,
 * but for the clock's grain. */
TEST(film_frames_are_where_the_camera_put_them)
{
    play(ELF, 100.0, 12.5, 0.0, NULL, 8.9);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_CAMERA], 1);
    struct mr_camera camera;
    mr_camera_get(&camera, ear->last[EAR_CAN][MR_ID_CAMERA], 8);
    assert_int_equal(camera.cause, 1);
    assert_true(heard.frames > 700);
    assert_int_equal(ear_faults(ear, EAR_CAN), 0);
    double worst_s = 0.0;
    for (unsigned i = 0; i < heard.frames; i++) {
        double since_s = (double)(uint32_t)(heard.frame[i].tick - camera.tick) * TICK_S;
        assert_int_equal(heard.frame[i].number, i + 1);
        worst_s = fmax(worst_s, fabs(since_s - (0.0125 + 0.01 * i)));
    }
    printf("# %u film frames, worst %.0f ns from trigger + delay + n / rate\n", heard.frames,
           worst_s * 1e9);
    /* the trigger's own tick is read some instructions after the pin moved */
    assert_true(worst_s < 1e-6);
    ear_close(ear);
}

TEST(jitter_is_seen_and_a_frame_that_gives_no_pulse_leaves_its_gap)
{
    play(ELF, 200.0, 0.0, 300.0, "at 3.0 camera skip 1\nat 3.5 camera skip 2", 5.0);
    unsigned single = 0, twofold = 0;
    double least_s = 1.0, most_s = 0.0;
    for (unsigned i = 1; i < heard.frames; i++) {
        double step_s = (double)(uint32_t)(heard.frame[i].tick - heard.frame[i - 1].tick) * TICK_S;
        if (step_s > 0.0125) {
            twofold++;
        } else if (step_s > 0.0075) {
            single++;
        } else {
            least_s = fmin(least_s, step_s);
            most_s = fmax(most_s, step_s);
        }
    }
    assert_int_equal(single, 1);
    assert_int_equal(twofold, 1);
    /* 5 ms less or more twice 300 us, of hundreds */
    assert_true(least_s >= 0.0044 && least_s < 0.0046);
    assert_true(most_s <= 0.0056 && most_s > 0.0054);
    assert_int_equal(heard.frames, hil_board_counters(ear->board)->film_frames_sent);
    ear_close(ear);
}

/* Pulses at twice the rate that a camera can have: every second one is refused, and that is
 * told. */
TEST(what_no_camera_gives_is_refused)
{
    play(ELF, 2000.0, 0.0, 0.0, NULL, 2.0);
    assert_true(ear_faults(ear, EAR_CAN) & EAR_BIT(EDGE_OVERRUN));
    assert_true(hil_board_counters(ear->board)->film_frames_sent > 2000);
    assert_in_range(heard.frames, hil_board_counters(ear->board)->film_frames_sent / 2 - 10,
                    hil_board_counters(ear->board)->film_frames_sent / 2 + 1);
    for (unsigned i = 1; i < heard.frames; i++)
        assert_true(heard.frame[i].tick - heard.frame[i - 1].tick >= 84000 - 1);
    ear_close(ear);
}

/* Armed 0.3 s before TIM2 comes round, with nothing moving: the frames go on every 10 ms. */
TEST(frames_go_on_when_the_counter_comes_round)
{
    play(ELF, 100.0, 0.0, 0.0, NULL, 0.01);
    hil_run_free(&ear->run);
    still_run(&ear->run, 60.0);
    hil_board_attach_rig(ear->board, &ear->run);
    ear_until(ear, 50.85);
    ear_command(ear, EAR_CAN, MR_COMMAND_ARM, 0, 1);
    ear_until(ear, 51.5);
    unsigned before = 0;
    assert_true(heard.frames > 60);
    for (unsigned i = 1; i < heard.frames; i++) {
        assert_int_equal(heard.frame[i].number, i + 1);
        assert_in_range(heard.frame[i].tick - heard.frame[i - 1].tick, 839999, 840001);
        before += heard.frame[i].tick > 0x80000000u;
    }
    assert_true(before > 10 && before < heard.frames - 10);
    ear_close(ear);
}

/* A pulse while no block comes for 27 s, whatever is begun again: it would pass for one to come,
 * and hold up the frames behind it. */
TEST(an_old_pulse_holds_no_frame_up)
{
    const unsigned scan = 16u + 60u; /* DMA2 stream 4, RM0090 table 61 */
    play(ELF, 100.0, 0.0, 0.0, NULL, 0.01);
    hil_run_free(&ear->run);
    still_run(&ear->run, 60.0);
    hil_board_attach_rig(ear->board, &ear->run);
    struct hil_core *core = &ear->board->core;
    ear_until(ear, 0.5);
    core->state.nvic.enabled[scan / 32u] &= ~(1u << scan % 32u);
    hil_nvic_update(core);
    ear_until(ear, 0.6);
    hil_gpio_drive(&ear->board->mcu.gpio, 1, 3, true, hil_now_cycle(core));
    ear_until(ear, 0.6001);
    hil_gpio_drive(&ear->board->mcu.gpio, 1, 3, false, hil_now_cycle(core));
    ear_until(ear, 27.5);
    core->state.nvic.enabled[scan / 32u] |= 1u << scan % 32u;
    hil_nvic_update(core);
    ear_until(ear, 28.5);
    assert_int_equal(ear->fault[MR_FAULT_EDGE_OVERRUN].count, 1);
    assert_int_equal(ear->fault[MR_FAULT_EDGE_OVERRUN].detail, 2);
    ear_command(ear, EAR_CAN, MR_COMMAND_ARM, 0, 1);
    ear_until(ear, 29.5);
    assert_in_range(heard.frames, 95, 101);
    ear_close(ear);
}
