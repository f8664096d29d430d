/* The velocity rig: what a damaged switch makes of a landing, as messages. */
#include "tests/firmware/play.h"

#include <stdio.h>

/* As fly(), with one switch that is missing, late, or one after another in the wrong place of the
 * cable. */
static void fly_damaged(unsigned missing, unsigned late, double late_s, unsigned swapped)
{
    unsigned next = 1;
    const double t0 = touchdown_s, v = 30.0, a = 6.0;
    double pending_s = (double)NAN;
    play(100);
    command("arm 7");
    while ((double)index_now * 1e-3 < 9.0) {
        double station_ft = -2.5 + 5.0 * (next - 1), d = station_ft - 3.0, b = d - v * 0.025;
        double left = v * v - 2.0 * a * b;
        double t_s = left < 0.0 ? 1e9 : t0 + (d < 0.0 ? d / v : 0.025 + (v - sqrt(left)) / a);
        double now_s = (double)index_now * 1e-3;
        if (pending_s < now_s) {
            pass_switch(late, pending_s);
            pending_s = (double)NAN;
        }
        if (next <= 24 && t_s < now_s) {
            unsigned named = swapped && next == swapped     ? swapped + 1
                           : swapped && next == swapped + 1 ? swapped
                                                            : next;
            if (next == late)
                pending_s = t_s + late_s;
            else if (next != missing)
                pass_switch(named, t_s);
            next++;
        }
        play_block();
    }
}

static unsigned count_events(unsigned reason, unsigned position, float *late_ms)
{
    unsigned count = 0;
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_switch_event event;
        if (fake.sent[i].id != MR_ID_SWITCH_EVENT)
            continue;
        assert_int_equal(mr_switch_event_get(&event, fake.sent[i].data, fake.sent[i].length),
                         MR_OK);
        if (event.reason != reason || event.position != position)
            continue;
        count++;
        if (late_ms)
            *late_ms = event.late_ms;
    }
    return count;
}

static void check_speed(void)
{
    struct mr_touchdown touchdown;
    GET_LAST(touchdown, TOUCHDOWN, &touchdown);
    assert_near(touchdown.speed_ft_s, 30.0, 0.03); /* a tenth of the 1 % asked for */
}

TEST_IN(a_missing_switch_is_named, start, NULL)
{
    fly_damaged(6, 0, 0.0, 0);
    assert_int_equal(count_events(MR_SWITCH_MISSING, 6, NULL), 1);
    assert_int_equal(count_frames(MR_ID_SWITCH_EVENT), 1);
    check_speed();
}

TEST_IN(a_late_switch_is_named_with_its_lateness, start, NULL)
{
    float late_ms = 0.0f;
    fly_damaged(0, 9, 0.004, 0);
    assert_int_equal(count_events(MR_SWITCH_LATE, 9, &late_ms), 1);
    assert_near(late_ms, 4.0, 0.3);
    check_speed();
}

TEST_IN(a_switch_later_than_the_next_is_out_of_order, start, NULL)
{
    fly_damaged(0, 5, 0.300, 0); /* 5 ft take 0.17 to 0.18 s there */
    assert_int_equal(count_events(MR_SWITCH_MISSING, 5, NULL), 1);
    assert_int_equal(count_events(MR_SWITCH_OUT_OF_ORDER, 5, NULL), 1);
    check_speed();
}

TEST_IN(swapped_cables_are_survived, start, NULL)
{
    fly_damaged(0, 0, 0.0, 7);
    assert_int_equal(count_events(MR_SWITCH_OUT_OF_ORDER, 7, NULL) +
                         count_events(MR_SWITCH_OUT_OF_ORDER, 8, NULL) +
                         count_events(MR_SWITCH_LATE, 8, NULL) +
                         count_events(MR_SWITCH_EARLY, 8, NULL),
                     2);
    check_speed();
}
