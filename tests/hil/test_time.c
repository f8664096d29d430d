/* Time on the emulated board, which knows when everything really happened: sync frames against the
 * bus, film frames against the camera, with the firmware image that has one
 * (build/tests/variant/camera.elf). */
#include <math.h>
#include <stdio.h>

#include "common/catalogue.h"
#include "common/command.h"
#include "common/fault.h"
#include "hil/board/board.h"
#include "hil/rig/faults.h"
#include "hil/rig/runfile.h"
#include "tests/cmocka_all.h"
#include "tests/hil/bench.h"

#define ELF         "build/tests/variant/camera.elf"
#define TICKS_PER_S 84e6
#define TICK_S      (1.0 / TICKS_PER_S)
#define FRAMES      4096

struct ear {
    struct hil_board *board;
    struct hil_run run;
    double zero_s; /* power-on time of tick 0 */
    bool zero_known;
    double sync_s; /* when the last sync frame ended, power-on time */
    unsigned syncs, sync_ats;
    double least_late_s, most_late_s; /* of sync_at behind the end of its frame */
    struct mr_sync sync;
    struct mr_camera camera;
    unsigned cameras;
    struct mr_film_frame frame[FRAMES];
    unsigned frames;
    uint32_t faults;
};

/* The switches of the run file tell where tick 0 of TIM2 is. */
static void on_edge(struct ear *ear, const uint8_t *data)
{
    struct mr_edge edge;
    mr_edge_get(&edge, data, 8);
    if (ear->zero_known || edge.position == 0)
        return;
    ear->zero_s = (double)ear->run.switch_open_ps[edge.position - 1] * 1e-12 - edge.tick * TICK_S;
    ear->zero_known = true;
}

static void on_sync_at(struct ear *ear, const uint8_t *data)
{
    struct mr_sync_at at;
    mr_sync_at_get(&at, data, 8);
    assert_int_equal(at.block16, (uint16_t)ear->sync.block);
    assert_int_equal(at.sent, 1);
    ear->sync_ats++;
    if (!ear->zero_known)
        return;
    double late_s = ear->zero_s + at.tick * TICK_S - ear->sync_s;
    ear->least_late_s = fmin(ear->least_late_s, late_s);
    ear->most_late_s = fmax(ear->most_late_s, late_s);
}

static void on_can(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct ear *ear = ctx;
    struct mr_health health;
    switch (frame->id) {
    case MR_ID_SYNC:
        mr_sync_get(&ear->sync, frame->data, 8);
        ear->sync_s = (double)t_ps * 1e-12;
        ear->syncs++;
        break;
    case MR_ID_SYNC_AT: on_sync_at(ear, frame->data); break;
    case MR_ID_EDGE: on_edge(ear, frame->data); break;
    case MR_ID_CAMERA:
        mr_camera_get(&ear->camera, frame->data, 8);
        ear->cameras++;
        break;
    case MR_ID_FILM_FRAME:
        assert_true(ear->frames < FRAMES);
        mr_film_frame_get(&ear->frame[ear->frames++], frame->data, 8);
        break;
    case MR_ID_HEALTH:
        mr_health_get(&health, frame->data, 8);
        ear->faults = health.faults;
        break;
    default: break;
    }
}

static struct ear *play(const char *elf, double hz, double delay_ms, double jitter_us,
                        const char *fault, double end_s)
{
    struct ear *ear = calloc(1, sizeof *ear);
    struct hil_options options;
    char error[256];
    assert_non_null(ear);
    ear->least_late_s = 1.0;
    hil_options_default(&options);
    options.camera_hz = hz;
    options.camera_delay_ps = (uint64_t)(delay_ms * 1e9);
    options.camera_jitter_ps = (uint64_t)(jitter_us * 1e6);
    ear->board = hil_board_create(&options);
    hil_board_set_callbacks(ear->board, &(struct hil_callbacks){ear, on_can, NULL});
    if (hil_run_read("tests/runs/landing5.run", &ear->run, error, sizeof error) != MR_OK)
        fail_msg("%s", error);
    if (hil_board_load_elf(ear->board, elf) != MR_OK)
        fail_msg("%s", hil_board_reason(ear->board));
    hil_board_attach_rig(ear->board, &ear->run);
    if (fault) {
        static struct hil_fault_script script;
        const char *path = bench_scratch("time.faults", fault, strlen(fault));
        if (hil_faults_read(path, NULL, &script, error, sizeof error) != MR_OK)
            fail_msg("%s", error);
        assert_int_equal(hil_board_add_faults(ear->board, &script), MR_OK);
    }
    bench_run(ear->board, (uint64_t)(end_s * 1e12));
    return ear;
}

static void leave(struct ear *ear)
{
    hil_board_destroy(ear->board);
    hil_run_free(&ear->run);
    free(ear);
}

/* The bus is two fifths full and the processor busy; the tick told is that of the end of the frame
 * all the same, late by the interrupt alone. */
TEST(sync_at_tells_when_the_sync_frame_ended)
{
    struct ear *ear = play("build/firmware/matrig.elf", 0.0, 0.0, 0.0, NULL, 6.5);
    assert_int_equal(ear->syncs, 7);
    assert_int_equal(ear->sync_ats, 7);
    printf("# sync_at late by %.2f to %.2f us\n", ear->least_late_s * 1e6, ear->most_late_s * 1e6);
    assert_true(ear->least_late_s > -1.5 * TICK_S); /* the run file's zero is good to a tick */
    assert_true(ear->most_late_s < 30e-6);
    assert_int_equal(ear->frames, 0);
    assert_int_equal(ear->cameras, 0);
    assert_int_equal(hil_board_counters(ear->board)->frames_captured, 0);
    leave(ear);
}

/* A camera without jitter exposes frame n at trigger + delay + n / rate, and that is the tick told,
 * but for the clock's grain. */
TEST(film_frames_are_where_the_camera_put_them)
{
    struct ear *ear = play(ELF, 100.0, 12.5, 0.0, NULL, 8.9);
    assert_int_equal(ear->cameras, 1);
    assert_int_equal(ear->camera.cause, 1);
    assert_true(ear->frames > 700);
    assert_int_equal(ear->faults, 0);
    double worst_s = 0.0;
    for (unsigned i = 0; i < ear->frames; i++) {
        double since_s = (double)(uint32_t)(ear->frame[i].tick - ear->camera.tick) * TICK_S;
        assert_int_equal(ear->frame[i].number, i + 1);
        worst_s = fmax(worst_s, fabs(since_s - (0.0125 + 0.01 * i)));
    }
    printf("# %u film frames, worst %.0f ns from trigger + delay + n / rate\n", ear->frames,
           worst_s * 1e9);
    /* the trigger's own tick is read some instructions after the pin moved */
    assert_true(worst_s < 1e-6);
    leave(ear);
}

TEST(jitter_is_seen_and_a_frame_that_gives_no_pulse_leaves_its_gap)
{
    struct ear *ear = play(ELF, 200.0, 0.0, 300.0,
                           "matrig-faults 1\nat 3.0 camera skip 1\nat 3.5 camera skip 2\n", 5.0);
    unsigned single = 0, twofold = 0;
    double least_s = 1.0, most_s = 0.0;
    for (unsigned i = 1; i < ear->frames; i++) {
        double step_s = (double)(uint32_t)(ear->frame[i].tick - ear->frame[i - 1].tick) * TICK_S;
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
    assert_int_equal(ear->frames, hil_board_counters(ear->board)->film_frames);
    leave(ear);
}

/* Pulses at twice the rate that a camera can have: every second one is refused, and that is
 * told. */
TEST(what_no_camera_gives_is_refused)
{
    struct ear *ear = play(ELF, 2000.0, 0.0, 0.0, NULL, 2.0);
    assert_true(ear->faults & 1u << MR_FAULT_EDGE_OVERRUN);
    assert_true(hil_board_counters(ear->board)->film_frames > 2000);
    assert_in_range(ear->frames, hil_board_counters(ear->board)->film_frames / 2 - 10,
                    hil_board_counters(ear->board)->film_frames / 2 + 1);
    for (unsigned i = 1; i < ear->frames; i++)
        assert_true(ear->frame[i].tick - ear->frame[i - 1].tick >= 84000 - 1);
    leave(ear);
}

/* Armed 0.3 s before TIM2 comes round, with nothing moving: the frames go on every 10 ms. */
TEST(frames_go_on_when_the_counter_comes_round)
{
    struct ear *ear = play(ELF, 100.0, 0.0, 0.0, NULL, 0.01);
    struct hil_can_frame arm = {.id = MR_ID_COMMAND, .length = 8};
    hil_run_free(&ear->run);
    still_run(&ear->run, 60.0);
    hil_board_attach_rig(ear->board, &ear->run);
    mr_command_put(&(struct mr_command){.code = MR_COMMAND_ARM, .tag = 1}, arm.data);
    bench_run(ear->board, 50850 * HIL_MS_PS);
    assert_int_equal(hil_board_can_inject(ear->board, &arm), MR_OK);
    bench_run(ear->board, 51500 * HIL_MS_PS);
    unsigned before = 0;
    assert_true(ear->frames > 60);
    for (unsigned i = 1; i < ear->frames; i++) {
        assert_int_equal(ear->frame[i].number, i + 1);
        assert_in_range(ear->frame[i].tick - ear->frame[i - 1].tick, 839999, 840001);
        before += ear->frame[i].tick > 0x80000000u;
    }
    assert_true(before > 10 && before < ear->frames - 10);
    leave(ear);
}
