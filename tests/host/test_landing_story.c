/* States of a landing, one message after the other, when anybody may have sent one. */
#include "host/collect/landing_story.h"

#include "tests/cmocka_all.h"

static struct mr_landing state(unsigned is, unsigned cause, unsigned landing, uint32_t block)
{
    return (struct mr_landing){.state = (uint8_t)is,
                               .cause = (uint8_t)cause,
                               .landing = (uint16_t)landing,
                               .block = block};
}

static enum landing_belief hear(struct landing_story *story, struct mr_landing message,
                                int64_t newest)
{
    return landing_story_hear(story, &message, newest);
}

/* As common/onboard/landing.c goes: armed, edge, stopped, settled, each repeated once a second;
 * disarmed; armed again. */
TEST(a_landing_is_believed)
{
    struct landing_story story;
    landing_story_start(&story);
    assert_int_equal(hear(&story, state(0, 0, 0, 0), 10), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(1, 1, 7, 500), 500), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(1, 1, 7, 500), 1500), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(2, 2, 7, 2000), 2001), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(3, 3, 7, 6000), 6001), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(4, 4, 7, 8000), 8001), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(0, 1, 7, 9000), 9001), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(1, 1, 8, 9500), 9501), LANDING_GOES_ON);
}

TEST(strangers_are_dismissed)
{
    const struct mr_landing strange[] = {state(0, 0, 0, 0),     state(255, 255, 65535, UINT32_MAX),
                                         state(1, 1, 8, 2500),  state(4, 4, 8, 2500),
                                         state(2, 2, 7, 90000), state(3, 3, 7, 1000),
                                         state(1, 1, 7, 500)};
    for (size_t i = 0; i < sizeof strange / sizeof strange[0]; i++) {
        struct landing_story story;
        landing_story_start(&story);
        hear(&story, state(4, 4, 6, 100), 100);
        hear(&story, state(1, 1, 7, 500), 500);
        hear(&story, state(1, 1, 7, 500), 1500);
        hear(&story, state(2, 2, 7, 2000), 2001);
        enum landing_belief belief = hear(&story, strange[i], 2600);
        /* the state before again: that is what a torn one looks like */
        bool back = i + 1 == sizeof strange / sizeof strange[0];
        assert_int_equal(belief, back ? LANDING_TAKEN_BACK : LANDING_DOUBTED);
        hear(&story, state(2, 2, 7, 2000), 3001);
        assert_int_equal(hear(&story, state(2, 2, 7, 2000), 4001), LANDING_GOES_ON);
        assert_int_equal(story.said.state, 2);
    }
}

TEST(an_end_is_taken_back)
{
    struct landing_story story;
    landing_story_start(&story);
    hear(&story, state(1, 1, 7, 500), 500);
    hear(&story, state(2, 2, 7, 2000), 2001);
    assert_int_equal(hear(&story, state(0, 1, 7, 2500), 2501), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(2, 2, 7, 2000), 3001), LANDING_TAKEN_BACK);
    assert_int_equal(hear(&story, state(3, 3, 7, 6000), 6001), LANDING_GOES_ON);
}

/* Several changes that were not the board's: its own state, said twice. */
TEST(several_changes_are_taken_back)
{
    struct landing_story story;
    landing_story_start(&story);
    hear(&story, state(1, 1, 7, 500), 500);
    hear(&story, state(2, 2, 7, 2000), 2001);
    assert_int_equal(hear(&story, state(0, 1, 7, 2500), 2501), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(1, 1, 8, 2500), 2501), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(2, 2, 8, 2500), 2501), LANDING_GOES_ON);
    assert_int_equal(hear(&story, state(2, 2, 7, 2000), 3001), LANDING_DOUBTED);
    assert_int_equal(hear(&story, state(2, 2, 7, 2000), 4001), LANDING_TAKEN_BACK);
    assert_int_equal(story.said.landing, 7);
    assert_int_equal(hear(&story, state(3, 3, 7, 6000), 6001), LANDING_GOES_ON);
}

/* What cannot follow may be true when messages were lost: the board says it again after a
 * second. */
TEST(what_is_said_again_is_believed)
{
    struct landing_story story;
    landing_story_start(&story);
    hear(&story, state(1, 1, 7, 500), 500);
    assert_int_equal(hear(&story, state(2, 2, 8, 20000), 30000), LANDING_DOUBTED);
    assert_int_equal(hear(&story, state(2, 2, 8, 20000), 31000), LANDING_GOES_ON);
}
