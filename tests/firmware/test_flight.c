/* Landings: states, switches, motion, warnings. */
#include "common/fault.h"
#include "tests/firmware/play.h"

#include <stdio.h>

TEST_IN(a_landing_goes_through_its_states, start, NULL)
{
    struct mr_landing message;
    struct mr_touchdown touchdown;
    struct mr_stop stop;
    struct mr_zone_lead lead;
    play(100);
    command("arm 7");
    double rest_s = fly(9.0);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_DONE);
    assert_int_equal(message.landing, 7);
    assert_int_equal(count_frames(MR_ID_EDGE), 17); /* -2.5, 2.5, ... 77.5 */
    GET_LAST(touchdown, TOUCHDOWN, &touchdown);
    assert_near(touchdown.speed_ft_s, 30.0, 0.0011);
    assert_near(touchdown.deceleration_ft_s2, 6.0, 0.0011);
    GET_LAST(stop, STOP, &stop);
    assert_near(stop.station_ft, 78.0, 0.003);
    assert_near(stop.after_touchdown_s, 5.0, 0.0011);
    assert_int_equal(stop.switches, 17);
    /* at rest the wheel stays where it is */
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_near(lead.wheel_ft, 78.0, 0.003);
    /* half a second after rest it settles, two seconds later it is done */
    assert_near(message.block, 1000.0 * (rest_s + 0.5 + 2.0), 5.0);
    command("disarm");
    play(1);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_IDLE);
}

TEST_IN(every_switch_is_named, start, NULL)
{
    unsigned next = 1;
    command("arm 1");
    play(10);
    fly(8.0);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_edge edge;
        if (fake.sent[i].id != MR_ID_EDGE)
            continue;
        assert_int_equal(mr_edge_get(&edge, fake.sent[i].data, fake.sent[i].length), MR_OK);
        assert_int_equal(edge.position, next);
        assert_near(edge.step_codes, step_of(next), 0.2);
        next++;
    }
}

static void survey(float slack_in)
{
    char words[64];
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        snprintf(words, sizeof words, "survey %u %.4f", s, (double)slack_in);
        command(words);
    }
}

static void close_joints(void)
{
    moved_in[0] = 0.72f;
    moved_in[1] = 0.37f;
    moved_in[2] = 0.02f;
}

TEST_IN(closing_joints_ahead_are_warned_of, start, NULL)
{
    struct mr_zone zone;
    struct mr_zone_lead lead;
    struct mr_verdict verdict;
    survey(0.1f);
    play(2);
    command("arm 2");
    play(600);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 0);
    assert_false(fake.warning);
    /* no switch has told of a wheel, so transducers and survey speak alone: stations 40, 50 and 60
     * approach each other by 0.35 in each, the joints of three segments and a half: 70 mats */
    close_joints();
    play(30);
    assert_true(fake.warning);
    GET_LAST(zone, ZONE, &zone);
    assert_near(zone.start_ft, 40.0, 0.011);
    assert_in_range(zone.mats, 60, 75);
    GET_LAST(verdict, VERDICT, &verdict);
    assert_int_equal(verdict.verdict, MR_PREDICTOR_WARNING);
    assert_int_equal(verdict.reason, MR_PREDICTOR_LONG_ZONE);
    assert_int_equal(verdict.level, MR_PREDICTOR_KINEMATIC);
    assert_true(verdict.basis & MR_PREDICTOR_NO_MOTION);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 1);
    assert_true(isnan(lead.lead_s)); /* no wheel yet */
    command("disarm");
    play(1);
    assert_false(fake.warning);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 0);
}

TEST_IN(a_warning_ends_with_the_landing, start, NULL)
{
    struct mr_landing message;
    struct mr_zone_lead lead;
    survey(0.0f); /* all joints are closed: wherever the wheel comes, it is in a zone */
    play(30);
    command("arm 2");
    play(600);
    assert_false(fake.warning); /* nothing rolls */
    pass_switch(1, (double)index_now * 1e-3);
    play(200);
    pass_switch(2, (double)index_now * 1e-3); /* 25 ft/s: a landing */
    play(1000);                               /* at 25 ft/s the wheel is not yet there */
    assert_true(fake.warning);
    play(4100); /* three seconds without another switch, two of settling */
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_DONE);
    assert_false(fake.warning);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 0);
}

/* Over the time limit while the motion is not known and transducers alone speak: the last word is
 * that the warning is over. */
TEST_IN(a_kinematic_warning_ends_before_the_landing, start, NULL)
{
    struct mr_landing message;
    struct mr_zone_lead lead;
    survey(0.0f);
    play(30);
    command("arm 2");
    play(600);
    moved_in[0] = 0.2f;
    play(30);
    assert_true(fake.warning);
    pass_switch(1, (double)index_now * 1e-3);
    play(200);
    pass_switch(2, (double)index_now * 1e-3);
    play(40);
    app.landing.is_motion_known = false; /* an estimate that found nothing */
    app.predict.motion.is_known = false;
    play(5100);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_DONE);
    assert_false(fake.warning);
    GET_LAST(zone_lead, ZONE_LEAD, &lead);
    assert_int_equal(lead.warning, 0);
    bool done = false;
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id == MR_ID_LANDING &&
            mr_landing_get(&message, fake.sent[i].data, 8) == MR_OK)
            done |= message.state == MR_LANDING_DONE;
        assert_false(done && fake.sent[i].id == MR_ID_ZONE_LEAD);
    }
}

/* Movement counts from arming, each time anew: what moved before is in the survey already. */
TEST_IN(what_moved_before_arming_is_the_zero, start, NULL)
{
    survey(0.1f);
    command("arm 1");
    play(600);
    command("disarm");
    play(1);
    close_joints();
    command("arm 2");
    play(600);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_zone_lead lead;
        if (fake.sent[i].id != MR_ID_ZONE_LEAD)
            continue;
        assert_int_equal(mr_zone_lead_get(&lead, fake.sent[i].data, 8), MR_OK);
        assert_int_equal(lead.warning, 0);
    }
}

TEST_IN(two_landings_in_one_run, start, NULL)
{
    struct mr_stop stop;
    struct mr_landing message;
    play(100);
    command("arm 7");
    fly(9.0);
    fake.sent_count = 0;
    command("arm"); /* done: no need to disarm */
    play(100);
    touchdown_s = 10.0;
    opened_codes = 0; /* the switches are closed again */
    fly(18.0);
    GET_LAST(stop, STOP, &stop);
    assert_int_equal(stop.switches, 17);
    assert_near(stop.station_ft, 78.0, 0.003);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.landing, 8);
    assert_int_equal(message.state, MR_LANDING_DONE);
}

/* Braking begins at touchdown; the switches on the track before it must not bend the parabola: from
 * the third switch beyond on, the deceleration told is the true one. */
TEST_IN(the_track_does_not_bend_the_motion, start, NULL)
{
    unsigned seen = 0;
    play(100);
    command("arm 7");
    fly(4.0);
    for (size_t i = 0; i < fake.sent_count; i++) {
        struct mr_motion motion;
        if (fake.sent[i].id != MR_ID_MOTION)
            continue;
        assert_int_equal(mr_motion_get(&motion, fake.sent[i].data, 8), MR_OK);
        if (++seen >= 4) /* the first is told at the second switch */
            assert_near(motion.deceleration_ft_s2, 6.0, 0.01);
    }
    assert_true(seen > 8);
}

TEST_IN(a_switch_while_settling_is_part_of_the_landing, start, NULL)
{
    struct mr_landing message;
    struct mr_stop stop;
    play(100);
    command("arm 7");
    fly(7.0);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_SETTLING);
    pass_switch(18, 7.0);
    play(8);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_LANDING);
    play(6000);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_DONE);
    assert_int_equal(count_frames(MR_ID_EDGE), 18);
    GET_LAST(stop, STOP, &stop);
    assert_int_equal(stop.switches, 18);
}

/* Edges that no switch made, `period_s` apart for 30 s. */
static void chatter(double period_s)
{
    double next_s = 1.0;
    while (index_now < 31000) {
        if (next_s < (double)index_now * 1e-3) {
            if (fake.edges_taken == fake.edges)
                fake.edges = fake.edges_taken = 0;
            fake.edge_tick[fake.edges++] = (uint32_t)(uint64_t)llround(next_s * 84e6);
            next_s += period_s;
        }
        play_block();
    }
}

/* Edges that no switch made: no landing, and not more of them told than a landing can need. */
TEST_IN(chatter_is_no_landing, start, NULL)
{
    struct mr_landing message;
    struct mr_switch_event event;
    command("arm 1");
    chatter(0.020);
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_ARMED);
    assert_int_equal(count_frames(MR_ID_EDGE), LANDING_EDGES_MAX);
    assert_int_equal(count_frames(MR_ID_MOTION), 0);
    GET_LAST(switch_event, SWITCH_EVENT, &event);
    assert_int_equal(event.reason, MR_SWITCH_NO_STEP);
}

/* A switch every 2.4 s: just faster than being pushed. */
TEST_IN(a_landing_ends_at_its_limit, start, NULL)
{
    struct mr_landing message;
    command("arm 1");
    play(100);
    for (unsigned position = 1; position <= 12; position++) {
        pass_switch(position, (double)index_now * 1e-3);
        play(2400);
    }
    GET_LAST(landing, LANDING, &message);
    assert_int_equal(message.state, MR_LANDING_DONE);
    /* known to be one at the second switch */
    assert_near(message.block, 100 + 2400 + 20000 + 2000, 10.0);
}

TEST_IN(a_landing_without_a_fit_says_why, start, NULL)
{
    struct mr_fault fault;
    command("arm 1");
    play(300);
    pass_switch(1, (double)index_now * 1e-3);
    play(200);
    pass_switch(2, (double)index_now * 1e-3);
    play(5000); /* three seconds without an edge, and the next round of faults */
    assert_int_equal(count_frames(MR_ID_TOUCHDOWN), 0);
    bool told = false;
    for (size_t i = 0; i < fake.sent_count; i++)
        told |= fake.sent[i].id == MR_ID_FAULT &&
                mr_fault_get(&fault, fake.sent[i].data, 8) == MR_OK &&
                fault.code == MR_FAULT_NO_FIT && fault.detail == -MR_TOO_FEW;
    assert_true(told);
}

TEST_IN(an_edge_without_a_name_says_nothing_of_motion, start, NULL)
{
    play(100);
    command("arm 7");
    fly(3.0);
    unsigned edges = count_frames(MR_ID_EDGE), motions = count_frames(MR_ID_MOTION);
    fake.edge_tick[fake.edges++] = (uint32_t)(84000 * index_now - 42000);
    play(10);
    assert_int_equal(count_frames(MR_ID_EDGE), edges + 1);
    assert_int_equal(count_frames(MR_ID_MOTION), motions);
}
