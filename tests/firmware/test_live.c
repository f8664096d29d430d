/* Live: a rig walked along by hand is told of, and makes no landing, whatever its pace. */
#include "tests/firmware/play.h"

#include "common/framing.h"

/* Block records among the serial bytes from `*at` on; moves it to their end. */
static unsigned records_since(size_t *at)
{
    struct mr_deframer deframer;
    unsigned count = 0;
    mr_deframer_init(&deframer);
    for (; *at < fake.serial_count; ++*at) {
        struct mr_frame frame;
        if (mr_deframer_push(&deframer, fake.serial[*at], &frame) == MR_OK)
            count += frame.type == MR_ID_BLOCK;
    }
    return count;
}

static struct mr_edge edge_at(unsigned which)
{
    struct mr_edge edge = {0};
    for (size_t i = 0; i < fake.sent_count; i++) {
        if (fake.sent[i].id == MR_ID_EDGE && which-- == 0)
            assert_int_equal(mr_edge_get(&edge, fake.sent[i].data, fake.sent[i].length), MR_OK);
    }
    return edge;
}

static int answer_to(const char *words)
{
    struct mr_ack ack;
    command(words);
    play(2);
    GET_LAST(ack, ACK, &ack);
    return ack.status;
}

static void trip(unsigned position, unsigned blocks)
{
    pass_switch(position, (double)index_now * 1e-3);
    play(blocks);
}

static void nothing_was_recorded(void)
{
    assert_int_equal(app.landing.state, MR_LANDING_IDLE);
    assert_false(app.box.is_armed);
    assert_int_equal(app.box.stored_count, 0);
    assert_int_equal(count_frames(MR_ID_MOTION), 0);
    assert_int_equal(count_frames(MR_ID_TOUCHDOWN), 0);
}

TEST_IN(edges_are_told_while_live_alone, start, NULL)
{
    static const uint8_t order[] = {1, 2, 4, 3, 24};
    play(100);
    trip(7, 2000);
    assert_int_equal(count_frames(MR_ID_EDGE), 0);
    assert_int_equal(answer_to("live 60"), MR_OK);
    for (unsigned i = 0; i < 5; i++)
        /* 5 ft in 2 s to 8 s: about the least speed of a landing, and below */
        trip(order[i], 2000 + 1500 * i);
    assert_int_equal(count_frames(MR_ID_EDGE), 5);
    for (unsigned i = 0; i < 5; i++) {
        assert_int_equal(edge_at(i).position, order[i]);
        assert_near(edge_at(i).step_codes, step_of(order[i]), 0.2);
    }
    nothing_was_recorded();
}

TEST_IN(a_fast_walk_is_no_landing, start, NULL) /* 30 ft/s, as a landing has it */
{
    play(100);
    assert_int_equal(answer_to("live 60"), MR_OK);
    touchdown_s = 1.0;
    fly(7.0);
    /* 3 ft + 75 ft lie behind switch 17, at 77.5 ft */
    assert_int_equal(count_frames(MR_ID_EDGE), 17);
    for (unsigned i = 0; i < 17; i++)
        assert_int_equal(edge_at(i).position, i + 1);
    nothing_was_recorded();
}

TEST_IN(a_record_goes_out_each_20_ms, start, NULL)
{
    size_t at = 0;
    play(1000);
    assert_int_equal(records_since(&at), 0);
    assert_int_equal(answer_to("live 3"), MR_OK);
    play(2000);
    assert_near(records_since(&at), 100.0, 1.0);
    play(1000);
    assert_near(records_since(&at), 50.0, 1.0);
    play(2000); /* it ended by itself */
    assert_int_equal(records_since(&at), 0);
    trip(5, 100);
    assert_int_equal(count_frames(MR_ID_EDGE), 0);
    assert_int_equal(answer_to("live 10"), MR_OK);
    play(100);
    assert_int_equal(answer_to("live 0"), MR_OK);
    (void)records_since(&at);
    play(1000);
    assert_int_equal(records_since(&at), 0);
}

TEST_IN(arming_ends_it, start, NULL)
{
    size_t at = 0;
    play(100);
    assert_int_equal(answer_to("live 60"), MR_OK);
    assert_int_equal(answer_to("arm 3"), MR_OK);
    assert_int_equal(answer_to("live 5"), MR_NOT_NOW);
    play(100);
    assert_int_equal(answer_to("disarm"), MR_OK);
    (void)records_since(&at);
    play(500);
    assert_int_equal(records_since(&at), 0);
    assert_int_equal(answer_to("live 61"), MR_USAGE);
    assert_int_equal(answer_to("live -1"), MR_USAGE);
}

/* A contact that chatters does not fill the links; a second's peace is enough. */
TEST_IN(chatter_is_limited, start, NULL)
{
    play(100);
    assert_int_equal(answer_to("live 60"), MR_OK);
    for (unsigned round = 1; round <= 2; round++) {
        for (unsigned i = 0; i < 150; i++) {
            if (fake.edges_taken == fake.edges)
                fake.edges = fake.edges_taken = 0;
            fake.edge_tick[fake.edges++] = (uint32_t)(84000 * index_now - 42000);
            play(20);
        }
        assert_int_equal(count_frames(MR_ID_EDGE), round * LANDING_EDGES_MAX);
        play(1100);
    }
    nothing_was_recorded();
}
