/* Snapshot, restore and fork: the copy goes on exactly as the original, byte for byte; and two runs
 * are the same. */
#include "common/crc32.h"
#include "hil/board/board.h"
#include "tests/hil/bench.h"
#include "tests/hil/snapshot.h"

struct stream {
    uint32_t crc;
    uint64_t bytes;
};

static void hear(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n)
{
    struct stream *stream = ctx;
    stream->crc = mr_crc32(stream->crc, (const uint8_t *)&t_ps, sizeof t_ps);
    stream->crc = mr_crc32(stream->crc, bytes, n);
    stream->bytes += n;
}

static void hear_frame(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame)
{
    struct stream *stream = ctx;
    uint8_t bytes[13] = {(uint8_t)frame->id, (uint8_t)(frame->id >> 8), 0, 0, frame->length};
    memcpy(bytes + 5, frame->data, frame->length);
    hear(stream, t_ps, bytes, sizeof bytes);
}

static void listen_to(struct hil_board *board, struct stream *stream)
{
    struct hil_callbacks callbacks = {stream, hear_frame, hear};
    *stream = (struct stream){0};
    hil_board_set_callbacks(board, &callbacks);
}

static void assert_same(struct hil_board *a, struct hil_board *b)
{
    assert_int_equal(hil_now_cycle(&a->core), hil_now_cycle(&b->core));
    assert_memory_equal(hil_board_counters(a), hil_board_counters(b), sizeof(struct hil_counters));
    for (unsigned i = 0; i < 17; i++)
        assert_int_equal(hil_cpu_register(&a->core, i), hil_cpu_register(&b->core, i));
    assert_memory_equal(a->memories, b->memories, sizeof *a->memories);
    assert_memory_equal(&a->core.state, &b->core.state, sizeof a->core.state);
    assert_memory_equal(&a->state, &b->state, sizeof a->state);
}

/* Scans in full swing, in the middle of one, with noise; floating point and stacks in the core
 * image. */
TEST(test_fork)
{
    static const char *const images[] = {"scan", "core", "serial"};
    for (unsigned i = 0; i < 3; i++) {
        struct hil_options options;
        hil_options_default(&options);
        struct hil_run run;
        still_run(&run, 1.0);
        run.switch_open_ps[0] = 7 * HIL_PS_PER_MS;
        struct hil_board *board = bench_board(images[i], &options);
        hil_board_attach_rig(board, &run);
        bench_run(board, 2512345 * HIL_PS_PER_NS);
        struct hil_board *copy = snapshot_fork(board);
        assert_same(board, copy);
        bench_run(board, 20 * HIL_PS_PER_MS);
        bench_run(copy, 20 * HIL_PS_PER_MS);
        assert_same(board, copy);
        assert_true(hil_board_counters(board)->exceptions > 0);
        hil_board_destroy(board);
        hil_board_destroy(copy);
        hil_run_free(&run);
    }
}

/* A fork at any moment: inside handlers, with numbers in the floating-point registers, with BASEPRI
 * or PRIMASK set, on the process stack. The image's own sum and notes come out right in every
 * copy. */
TEST(test_fork_anywhere)
{
    struct hil_board *board = bench_board("core", NULL);
    struct hil_board *whole = bench_board("core", NULL);
    bench_run(whole, 2 * HIL_PS_PER_MS);
    for (uint64_t t_ns = 1000; t_ns < 120000; t_ns += 730) {
        bench_run(board, t_ns * HIL_PS_PER_NS);
        struct hil_board *copy = snapshot_fork(board);
        bench_run(copy, 2 * HIL_PS_PER_MS);
        assert_same(copy, whole);
        hil_board_destroy(copy);
    }
    hil_board_destroy(board);
    hil_board_destroy(whole);
}

/* A drawn board goes on in one that was made as the ideal one: options and electronics come
 * along. */
TEST(test_drawn)
{
    struct hil_options options;
    hil_options_default(&options);
    struct hil_board *ideal = bench_board("scan", &options);
    options.has_random_tolerances = true;
    options.tolerance_seed = 7;
    struct hil_board *drawn = bench_board("scan", &options);
    bench_run(drawn, 3 * HIL_PS_PER_MS);
    struct snapshot *snapshot = snapshot_take(drawn);
    snapshot_restore(ideal, snapshot);
    bench_run(drawn, 9 * HIL_PS_PER_MS);
    bench_run(ideal, 9 * HIL_PS_PER_MS);
    assert_same(drawn, ideal);
    assert_memory_equal(&ideal->electronics, &drawn->electronics, sizeof drawn->electronics);
    free(snapshot);
    hil_board_destroy(drawn);
    hil_board_destroy(ideal);
}

/* Back to an earlier moment, twice. */
TEST(test_restore)
{
    struct hil_board *board = bench_board("scan", NULL);
    bench_run(board, 3 * HIL_PS_PER_MS);
    struct snapshot *snapshot = snapshot_take(board);
    bench_run(board, 9 * HIL_PS_PER_MS);
    struct hil_counters first = *hil_board_counters(board);
    for (unsigned i = 0; i < 2; i++) {
        snapshot_restore(board, snapshot);
        assert_int_equal(hil_board_now_ps(board) / HIL_PS_PER_US, 3000);
        bench_run(board, 9 * HIL_PS_PER_MS);
        assert_memory_equal(hil_board_counters(board), &first, sizeof first);
    }
    free(snapshot);
    hil_board_destroy(board);
}

/* The real firmware and a real landing: two boards say the same bytes at the same times, also when
 * one of them is cut into pieces and replaced by a fork half way; another seed says something
 * else. */
TEST(test_firmware)
{
    struct hil_run run;
    struct hil_options options;
    struct stream heard[3];
    char error[256];
    hil_options_default(&options);
    assert_int_equal(hil_run_read("tests/runs/landing5.run", &run, error, sizeof error), MR_OK);
    for (unsigned i = 0; i < 3; i++) {
        options.noise_seed = i == 2 ? 2 : 1;
        struct hil_board *board = hil_board_create(&options);
        if (hil_board_load_elf(board, "build/firmware/matrig.elf") != MR_OK)
            fail_msg("%s", hil_board_failure_reason(board));
        hil_board_attach_rig(board, &run);
        listen_to(board, &heard[i]);
        for (uint64_t t_ms = 7; i == 1 && t_ms < 1500; t_ms += 13)
            bench_run(board, t_ms * HIL_PS_PER_MS);
        if (i == 1) {
            struct stream so_far = heard[1];
            struct hil_board *copy = snapshot_fork(board);
            hil_board_destroy(board);
            board = copy;
            listen_to(board, &heard[1]);
            heard[1] = so_far;
        }
        bench_run(board, 3000 * HIL_PS_PER_MS);
        assert_true(heard[i].bytes > 50000);
        assert_int_equal(hil_board_counters(board)->fault_exceptions, 0);
        assert_int_equal(hil_board_counters(board)->resets, 0);
        hil_board_destroy(board);
    }
    assert_int_equal(heard[0].bytes, heard[1].bytes);
    assert_int_equal(heard[0].crc, heard[1].crc);
    assert_int_not_equal(heard[0].crc, heard[2].crc);
    hil_run_free(&run);
}
