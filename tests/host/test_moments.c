/* Which times belong to a landing: what is far and little is set aside, what is far and much, or
 * has the edges, is not. */
#include "host/analyse/measured_series.h"
#include "tests/cmocka_all.h"

static void stretch(struct moments *moments, int64_t from_block, int64_t blocks)
{
    for (int64_t i = 0; i < blocks; i++)
        moments_add(moments, from_block + i);
}

TEST(nothing_is_far_from_nothing)
{
    struct moments moments = {0};
    assert_int_equal(moments_judge(&moments), MR_OK);
    assert_true(moments_hold(&moments, INT64_MIN));
    assert_true(moments_hold_edge(&moments, 1e300));
    moments_free(&moments);
}

TEST(one_far_time_is_set_aside)
{
    static const int64_t far[] = {8000 + 40000, 3508744, INT64_MAX, INT64_MIN, -3500000};
    for (size_t i = 0; i < sizeof far / sizeof far[0]; i++) {
        struct moments moments = {0};
        moments_add(&moments, far[i]); /* in whatever order */
        stretch(&moments, 787, 8000);
        assert_int_equal(moments_judge(&moments), MR_OK);
        assert_int_equal(moments.groups, 1);
        assert_true(moments_hold(&moments, 787));
        assert_true(moments_hold(&moments, 8786));
        assert_false(moments_hold(&moments, far[i]));
        moments_free(&moments);
    }
}

/* 20 s later is no pause; a minute with the link down is one, but a tenth of the landing stays, and
 * so does what has the edges. */
TEST(what_is_much_stays)
{
    struct moments moments = {0};
    stretch(&moments, 0, 10000);
    stretch(&moments, 29000, 5);
    stretch(&moments, 120000, 1000);
    stretch(&moments, 200000, 101);
    moments_add_edge(&moments, 200.05);
    stretch(&moments, 300000, 100);
    assert_int_equal(moments_judge(&moments), MR_OK);
    assert_int_equal(moments.groups, 3);
    assert_true(moments_hold(&moments, 29004));
    assert_true(moments_hold(&moments, 120999));
    assert_true(moments_hold(&moments, 200100));
    assert_false(moments_hold(&moments, 300000));
    moments_free(&moments);
}

TEST(edges_alone_hold_nothing)
{
    static const double far_s[] = {3500.0, -1.0, 1e300, -1e300, 5e6};
    struct moments moments = {0};
    stretch(&moments, 787, 8000);
    moments_add_edge(&moments, 1.45);
    for (size_t i = 0; i < sizeof far_s / sizeof far_s[0]; i++)
        moments_add_edge(&moments, far_s[i]);
    assert_int_equal(moments_judge(&moments), MR_OK);
    assert_true(moments_hold_edge(&moments, 1.45));
    for (size_t i = 0; i < sizeof far_s / sizeof far_s[0]; i++)
        assert_false(moments_hold_edge(&moments, far_s[i]));
    moments_free(&moments);
}
