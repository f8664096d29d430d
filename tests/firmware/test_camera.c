/* The film camera and the time sync, above a fake board: when the trigger comes, which pulses are
 * frames, what is told of them. */
#include "common/fault.h"
#include "tests/firmware/play.h"

#define TICKS_PER_S 84e6

static void fit_camera(float station_ft)
{
    config.site[0].camera = 1;
    config.site[0].camera_station_ft = station_ft;
}

static int without_camera(void **state)
{
    config.site[0].camera = 0;
    config.site[0].camera_station_ft = NAN;
    return start(state);
}

static void pulse_at(double t_s)
{
    fake.pulses[BOARD_FRAME_PULSES].tick[fake.pulses[BOARD_FRAME_PULSES].count++] =
        (uint32_t)(uint64_t)llround(t_s * TICKS_PER_S);
}

TEST_IN(armed_it_is_triggered_for_ten_milliseconds, without_camera, NULL)
{
    struct mr_camera told;
    fit_camera(NAN);
    fake.camera_tick = 777;
    play(5);
    assert_int_equal(fake.camera_pulses, 0);
    command("arm 5");
    play(1);
    assert_true(fake.camera);
    GET_LAST(camera, CAMERA, &told);
    assert_int_equal(told.tick, 777);
    assert_int_equal(told.cause, MR_CAMERA_BY_ARMING);
    assert_int_equal(told.block16, 5);
    play(9);
    assert_true(fake.camera);
    play(1);
    assert_false(fake.camera);
    play(500);
    assert_int_equal(fake.camera_pulses, 1);
    assert_int_equal(count_frames(MR_ID_CAMERA), 1);
}

/* The landing of play.h: x = 3 + 30 t - 3 t^2 after touchdown, so 40.5 ft is passed 1.4391 s after
 * it, at t = 5 - sqrt(12.5). */
TEST_IN(by_station_it_is_triggered_where_the_gear_is, without_camera, NULL)
{
    struct mr_camera told;
    fit_camera(40.5f);
    command("arm 5");
    play(100);
    assert_int_equal(fake.camera_pulses, 0);
    fly(8.0);
    assert_int_equal(fake.camera_pulses, 1);
    GET_LAST(camera, CAMERA, &told);
    assert_int_equal(told.cause, MR_CAMERA_BY_STATION);
    double passed_s = touchdown_s + 5.0 - sqrt(12.5);
    /* the estimate is good to a tenth of a foot */
    assert_near(told.block16 * 1e-3, passed_s, 0.004);
}

TEST_IN(by_command_it_is_triggered_at_any_time, without_camera, NULL)
{
    struct mr_ack ack;
    struct mr_camera told;
    command("camera");
    play(2);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_NOT_NOW); /* there is none */
    assert_int_equal(fake.camera_pulses, 0);
    fit_camera(NAN);
    command("camera");
    play(2);
    GET_LAST(ack, ACK, &ack);
    assert_int_equal(ack.status, MR_OK);
    GET_LAST(camera, CAMERA, &told);
    assert_int_equal(told.cause, MR_CAMERA_BY_COMMAND);
    assert_int_equal(fake.camera_pulses, 1);
}

/* Asked for once more within the pulse of 10 ms: that one is as long as ever, and another follows
 * it. */
TEST_IN(a_second_trigger_waits_for_the_first, without_camera, NULL)
{
    fit_camera(NAN);
    play(5);
    command("camera");
    play(3);
    assert_true(fake.camera);
    command("camera");
    play(7);
    assert_true(fake.camera);
    assert_int_equal(fake.camera_pulses, 1);
    play(20);
    assert_int_equal(fake.camera_pulses, 2);
    assert_int_equal(count_frames(MR_ID_CAMERA), 2);
    assert_false(fake.camera);
}

TEST_IN(frames_are_told_with_number_and_time, without_camera, NULL)
{
    fit_camera(NAN);
    play(20);
    for (unsigned i = 0; i < 5; i++) /* before arming: none of the landing's */
        pulse_at(0.025 + 0.005 * i);
    play(40);
    assert_int_equal(count_frames(MR_ID_FILM_FRAME), 0);
    command("arm 5");
    play(1);
    for (unsigned i = 0; i < 40; i++)
        pulse_at(0.1 + 0.005 * i);
    play(300);
    assert_int_equal(count_frames(MR_ID_FILM_FRAME), 40);
    unsigned number = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_film_frame frame;
        if (fake.sent[i].id != MR_ID_FILM_FRAME)
            continue;
        assert_int_equal(mr_film_frame_get(&frame, fake.sent[i].data, fake.sent[i].length), MR_OK);
        assert_int_equal(frame.number, ++number);
        assert_int_equal(frame.tick, (100000 + 5000 * (number - 1)) * 84);
        /* the block in whose first 0.9 ms it falls, or the next: triggers are at 28 us */
        uint32_t since = frame.tick - (2352u + 84000u * frame.block16);
        assert_true((int32_t)since <= 75600 && (int32_t)since > 75600 - 84000);
    }
}

TEST_IN(each_landing_counts_its_own_frames, without_camera, NULL)
{
    struct mr_film_frame frame;
    fit_camera(NAN);
    for (unsigned landing = 0; landing < 2; landing++) {
        command("arm 0");
        play(1);
        for (unsigned i = 0; i < 3 + landing; i++)
            pulse_at(0.001 * (index_now + 1) + 0.005 * i);
        play(50);
        command("disarm");
        play(10);
        GET_LAST(film_frame, FILM_FRAME, &frame);
        assert_int_equal(frame.number, 3 + landing);
        assert_int_equal(fake.camera_pulses, 1 + landing);
    }
}

TEST_IN(noise_is_refused_and_counted, without_camera, NULL)
{
    struct mr_fault fault;
    fit_camera(NAN);
    command("arm 5");
    play(100);
    for (unsigned i = 0; i < 20; i++) {
        pulse_at(0.200 + 0.010 * i);
        pulse_at(0.2003 + 0.010 * i); /* the contact bounces */
    }
    fake.pulses[BOARD_FRAME_PULSES].tick[fake.pulses[BOARD_FRAME_PULSES].count++] =
        (uint32_t)llround(0.390 * TICKS_PER_S) - 50; /* out of order */
    play(400);
    assert_int_equal(count_frames(MR_ID_FILM_FRAME), 20);
    GET_LAST(fault, FAULT, &fault);
    assert_int_equal(fault.code, MR_FAULT_EDGE_OVERRUN);
    assert_int_equal(fault.detail, 2);
    assert_int_equal(fault.count, 21);
}

/* TIM2 comes round after 51.130 s. */
TEST_IN(frames_go_on_over_the_wrap_of_the_clock, without_camera, NULL)
{
    fit_camera(NAN);
    index_now = 51000;
    app.next_index = 51000;
    command("arm 5");
    play(1);
    for (unsigned i = 0; i < 50; i++)
        pulse_at(51.010 + 0.005 * i); /* modulo 2^32 */
    play(400);
    assert_int_equal(count_frames(MR_ID_FILM_FRAME), 50);
    struct mr_film_frame frame;
    GET_LAST(film_frame, FILM_FRAME, &frame);
    assert_int_equal(frame.number, 50);
    assert_int_equal(frame.tick, (uint32_t)(51255000ull * 84u));
}

/* Longer than half a round of the clock (25.6 s) after the frame before it, a pulse is told like
 * any other. */
TEST_IN(a_pause_of_half_a_minute_refuses_no_frame, without_camera, NULL)
{
    fit_camera(NAN);
    play(5);
    command("arm 5");
    play(100);
    pulse_at(0.1);
    play(30000);
    pulse_at(30.1);
    play(10);
    assert_int_equal(count_frames(MR_ID_FILM_FRAME), 2);
}

/* A second command in the pulse of the first waits for its end; a camera that is taken out
 * meanwhile is not triggered when it comes back. */
TEST_IN(a_trigger_does_not_outlast_its_camera, without_camera, NULL)
{
    fit_camera(NAN);
    play(5);
    command("camera");
    play(1);
    command("camera");
    play(1);
    config.site[0].camera = 0;
    play(20);
    assert_false(fake.camera);
    config.site[0].camera = 1;
    play(20);
    assert_int_equal(fake.camera_pulses, 1);
}

TEST_IN(without_a_camera_it_costs_nothing, without_camera, NULL)
{
    command("arm 5");
    play(10);
    pulse_at(0.02);
    fly(4.0);
    assert_false(fake.pulses[BOARD_FRAME_PULSES].captured);
    assert_int_equal(fake.pulses[BOARD_FRAME_PULSES].taken, 0);
    assert_int_equal(fake.camera_pulses, 0);
    assert_int_equal(count_frames(MR_ID_CAMERA) + count_frames(MR_ID_FILM_FRAME), 0);
}

TEST_IN(sync_is_followed_by_its_time, without_camera, NULL)
{
    struct mr_sync sync;
    struct mr_sync_at at;
    fake.sync_block = 253;
    fake.sync_tick = 21260123;
    fake.sync_left = true;
    play(262);
    assert_int_equal(count_frames(MR_ID_SYNC), 1);
    assert_int_equal(count_frames(MR_ID_SYNC_AT), 0);
    play(900);
    GET_LAST(sync, SYNC, &sync);
    GET_LAST(sync_at, SYNC_AT, &at);
    assert_int_equal(sync.block, 253);
    assert_int_equal(sync.tick, 253 * 84000 + 2352);
    assert_int_equal(at.block16, 253);
    assert_int_equal(at.sent, 1);
    assert_int_equal(at.tick, 21260123);
    play(200); /* the next one does not leave */
    GET_LAST(sync_at, SYNC_AT, &at);
    assert_int_equal(count_frames(MR_ID_SYNC), 2);
    assert_int_equal(at.block16, 1253);
    assert_int_equal(at.sent, 0);
}
