#include "common/closure.h"

#include <math.h>

#include "tests/cmocka_all.h"

static const float station_ft[MR_TRANSDUCERS] = {40, 50, 60, 70, 80, 90, 100, 110};
static float slack_in[MR_SEGMENTS], remaining_in[MR_SEGMENTS];
static float moved_in[MR_TRANSDUCERS];

static struct mr_closure_input even_slack(float each_in)
{
    for (unsigned i = 0; i < MR_SEGMENTS; i++)
        slack_in[i] = each_in;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        moved_in[i] = 0.0f;
    return (struct mr_closure_input){.station_ft = station_ft,
                                     .displacement_in = moved_in,
                                     .slack_in = slack_in,
                                     .wheel_ft = NAN};
}

TEST(open_joints_are_no_zone)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.18f);
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_int_equal(zone.mats, 0);
}

/* All joints closed: the zone goes to the end of the runway, 42 segments of 20/7 ft, none of it
 * between two transducers that see it. The wheel at 115 ft is in it. */
TEST(a_runway_without_slack_is_one_zone)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.0f);
    input.wheel_ft = 115.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_near(zone.start_ft, 115.0, 1e-4);
    assert_near(zone.end_ft, 120.0, 1e-4);
    for (unsigned i = 0; i < 14; i++) /* open to 40 ft */
        slack_in[i] = 0.2f;
    input.wheel_ft = 30.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_near(zone.start_ft, 40.0, 1e-4);
}

/* Segment 14 begins at 14 * 20/7 = 40 ft. 0.30 in of closure between 40 and 50 ft at 0.1 in a
 * segment closes segments 14, 15 and 16: 40.000 to 48.571 ft, 30 mats. */
TEST(a_plough_closes_from_the_wheel_on)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.1f);
    moved_in[0] = 0.35f;
    moved_in[1] = 0.05f;
    moved_in[2] = 0.05f;
    input.wheel_ft = 35.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_int_equal(zone.mats, 30);
    assert_near(zone.start_ft, 40.0, 1e-4);
    assert_near(zone.end_ft, 48.5714, 1e-3);
    assert_near(remaining_in[14], 0.0, 1e-6);
    assert_near(remaining_in[17], 0.1, 1e-6);
    assert_near(remaining_in[13], 0.1, 1e-6);
}

TEST(a_run_the_wheel_is_inside_starts_at_the_wheel)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.1f);
    for (unsigned s = 28; s < 33; s++) /* 80.0 to 94.286 ft closed before the landing */
        slack_in[s] = 0.01f;
    input.wheel_ft = 84.9f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_near(zone.start_ft, 84.9, 1e-4);
    assert_near(zone.end_ft, 94.2857, 1e-3);
    assert_int_equal(zone.mats, 33); /* 9.3857 ft / (2/7 ft) = 32.85 */
}

/* 5 ft at 20 ft/s and 4 ft/s2: t = (20 - sqrt(400 - 2*4*5)) / 4. 50 ft are not reached at 5 ft/s2,
 * and just reached at 4. */
TEST(lead_times)
{
    assert_near(mr_closure_compute_lead_s(5.0f, 20.0f, 4.0f), 0.256584, 1e-5);
    assert_near(mr_closure_compute_lead_s(10.0f, 20.0f, NAN), 0.5, 1e-5);
    assert_near(mr_closure_compute_lead_s(0.0f, 20.0f, 4.0f), 0.0, 0.0);
    assert_near(mr_closure_compute_lead_s(50.0f, 20.0f, 4.0f), 5.0, 1e-3);
    assert_true(isnan(mr_closure_compute_lead_s(50.0f, 20.0f, 5.0f)));
    assert_true(isnan(mr_closure_compute_lead_s(5.0f, NAN, 4.0f)));
}

TEST(a_lost_transducer_widens_the_interval)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.1f);
    moved_in[0] = 0.43f;
    moved_in[1] = NAN;
    input.wheel_ft = 40.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    /* 4.3 segments' worth between 40 and 60 ft: four closed, 0.07 in of the fifth left */
    assert_int_equal(zone.mats, 40);
    assert_near(zone.end_ft, 51.4286, 1e-3);
}

/* Stations 50 ft apart from no segment's end: segment 17 (48.57 to 51.43 ft) lies half on each
 * side. 3.5 segments of 0.36 in close on either side, so it is closed as all the others from 40 to
 * 60 ft are. */
TEST(a_segment_across_a_station_closes_from_both_sides)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.36f);
    moved_in[0] = 2.0f * 3.5f * 0.36f;
    moved_in[1] = 3.5f * 0.36f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_near(remaining_in[17], 0.0, 1e-5);
    assert_int_equal(zone.mats, 70);
    assert_near(zone.start_ft, 40.0, 1e-4);
    assert_near(zone.end_ft, 60.0, 1e-4);
}

/* The wheel at 45 ft: of 0.10 in, segment 15 (42.86 to 45.71 ft) can give only its last quarter,
 * 0.025 in, segment 16 gives the other 0.075 in; behind the wheel nothing closes. */
TEST(nothing_closes_behind_the_wheel)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.1f);
    moved_in[0] = 0.1f;
    input.wheel_ft = 45.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_near(remaining_in[14], 0.1, 1e-6);
    assert_near(remaining_in[15], 0.075, 1e-5);
    assert_near(remaining_in[16], 0.025, 1e-5);
    assert_near(remaining_in[17], 0.1, 1e-6);
}

TEST(of_equal_runs_the_nearest_is_told)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(0.1f);
    for (unsigned s = 0; s < 4; s++)
        slack_in[14 + s] = slack_in[28 + s] = 0.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_int_equal(zone.mats, 40);
    assert_near(zone.start_ft, 40.0, 1e-4);
}

TEST(what_was_not_surveyed_is_never_closed)
{
    struct mr_closure_zone zone;
    struct mr_closure_input input = even_slack(NAN);
    moved_in[0] = 1.0f;
    mr_closure_find_zone(&input, &zone, remaining_in);
    assert_int_equal(zone.mats, 0);
}
