/* From frames to times of day: a hand-made board whose clock is 12.3 ppm fast sends sync frames
 * that come late, and TIM2 comes round meanwhile. Its film's frames come by one link or the
 * other. */
#include <math.h>

#include "host/analyse/summary.h"
#include "host/link/timemap.h"
#include "tests/cmocka_all.h"
#include "tests/host/session.h"

#define EPOCH_US    1790000000000000u
#define FAST_PPM    12.3
#define LATE_US     3000u  /* after a block is complete its messages come */
#define FIRST_BLOCK 20000u /* TIM2 comes round after 51.13 s */

static uint64_t state = 9;

static double even(void)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (double)(state >> 11) / 9007199254740992.0;
}

static uint64_t true_host_us(double board_us)
{
    return EPOCH_US + (uint64_t)llround(board_us / (1.0 + FAST_PPM * 1e-6));
}

/* Once a second the sync frame, noted up to a millisecond after its end, which sync_at tells. */
static void send_sync(struct stream *stream)
{
    uint64_t kept_us = stream->host_us;
    uint32_t block = stream->block - 1, tick = stream_tick((double)block / 1000.0);
    /* however long it waited for the bus */
    double end_us = 1000.0 * block + 1130.0 + 400.0 * even();
    stream->host_us = true_host_us(end_us) + (uint64_t)(1000.0 * even());
    STREAM_CAN(stream, sync, SYNC, .block = block, .tick = tick);
    stream->host_us = kept_us;
    STREAM_CAN(stream, sync_at, SYNC_AT, .tick = stream_tick(end_us / 1e6), .sent = 1,
               .block16 = (uint16_t)block);
    if (block % 3 == 0) { /* one that did not leave says nothing */
        STREAM_CAN(stream, sync, SYNC, .block = block, .tick = tick);
        STREAM_CAN(stream, sync_at, SYNC_AT, .tick = 7, .sent = 0, .block16 = (uint16_t)block);
    }
}

TEST(times_of_day_are_right_within_their_intervals)
{
    struct session session;
    struct stream_truth truth = {.v0_ft_s = 30.0, .a_ft_s2 = 6.0, .peak_in = 0.5, .warn = true};
    struct summary summary;
    session_begin(&session, true, true);
    struct stream *stream = &session.stream;
    uint64_t begun_us = true_host_us(1000.0 * FIRST_BLOCK) + LATE_US;
    stream->block = FIRST_BLOCK;
    stream->host_us = begun_us;
    stream_hello(stream, MR_LAYOUT);
    for (unsigned i = 0; i < 60; i++) {
        stream_idle(stream, 1000);
        send_sync(stream);
    }
    stream_landing(stream, &truth, 3);
    stream_idle(stream, 2000);
    session_log(&session, "clock.db");
    assert_no_error(&session.error);
    assert_int_equal(summary_load(session.store, 1, &summary, &session.error), MR_OK);

    const struct store_time_map *clock = &summary.clock;
    assert_true(summary.is_clock_known);
    assert_int_equal(clock->refusal, TIMEMAP_OK);
    assert_int_equal(clock->link, LINK_CAN);
    assert_int_equal(clock->pairs, 60);
    assert_near(clock->fast_ppm, FAST_PPM, clock->fast_half_ppm);
    assert_true(clock->fast_half_ppm < 5.0);
    double board_us = 1e6 * truth.touchdown_s;
    struct summary_moment touchdown = summary_convert_to_time_of_day(&summary, board_us);
    assert_near(touchdown.host_us, (double)true_host_us(board_us), touchdown.half_width_us);
    assert_true(touchdown.half_width_us < 300.0);

    char line[4000] = "";
    FILE *out = fmemopen(line, sizeof line - 1, "w");
    struct answer *answer = answer_new(false);
    summary_add_times(&summary, answer);
    assert_true(answer_print_text(answer, out));
    answer_free(answer);
    fclose(out);
    assert_non_null(
        strstr(line, "ppm fast (CAN, 60 time pairs); times of day are known within 0."));
    assert_non_null(strstr(line, "touchdown at  2026-09-21 ")); /* date -u -d @1790000081 */
    summary_free(&summary);
    session_end(&session);
}

/* 70,000 frames whose count on the wire comes round; serial is the record. */
TEST(film_frames_are_those_of_the_record)
{
    struct session session;
    struct store_film_frame *frame;
    size_t frames;
    session_begin(&session, true, true);
    struct stream *stream = &session.stream;
    stream->block = 50000;
    stream_hello(stream, MR_LAYOUT);
    stream_idle(stream, 100);
    stream_state(stream, 1, 1, 3, stream->block);
    for (unsigned i = 0; i < 70000; i++) { /* most while nothing else happens */
        uint32_t number = i + 1;
        if (i % 100 == 0)
            stream_idle(stream, 5);
        STREAM_BOTH(stream, film_frame, FILM_FRAME, .number = (uint16_t)number,
                    .tick = stream_tick(stream->block * 1e-3) + i,
                    .block16 = (uint16_t)stream->block);
    }
    stream_state(stream, 4, 4, 3, stream->block);
    session_log(&session, "film.db");
    assert_no_error(&session.error);
    assert_int_equal(store_film_frames_get(session.store, 1, &frame, &frames, &session.error),
                     MR_OK);
    assert_int_equal(frames, 70000);
    for (size_t i = 0; i < frames; i++) {
        assert_int_equal(frame[i].number, i + 1);
        assert_int_equal(frame[i].links, 2); /* serial */
        /* TIM2 comes round at 51.13 s */
        assert_true(frame[i].board_us > 50e6 && frame[i].board_us < 55e6);
    }
    free(frame);
    session_end(&session);
}
