/* What `make score` counts with: areas by hand, zones drawn by hand, and that a series is the same each time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include "tests/score/play.c"
#include "tests/score/table.c"
#include "tests/score/truth.c"

static void areas_by_hand(void **state)
{
    (void)state;
    const bool event[4] = {false, false, true, true};
    assert_true(score_auc((const float[]){1, 2, 3, 4}, event, 4) == 1.0);
    assert_true(score_auc((const float[]){3, 4, 1, 2}, event, 4) == 0.0);
    assert_true(score_auc((const float[]){1, 5, 3, 4}, event, 4) == 0.5);  /* 2 of 4 pairs */
    assert_true(score_auc((const float[]){1, 2, 2, 3}, event, 4) == 0.875); /* 3 and a tie */
    assert_true(isnan(score_auc((const float[]){1, 2}, event, 2)));
}

/* '.' closed, 'o' open, from the runway's edge; beyond the text all is open. */
static struct score_zone longest_in(const char *joints, double from_ft)
{
    static uint16_t gap[SCORE_JOINTS];
    for (size_t j = 0; j < SCORE_JOINTS; j++)
        gap[j] = j < strlen(joints) && joints[j] == '.' ? CLOSED_HMIL : CLOSED_HMIL + 1;
    return score_longest(gap, from_ft);
}

static void zones_drawn_by_hand(void **state)
{
    (void)state;
    struct score_zone zone = longest_in("oo.....o.........o....o..", 0.0); /* open: 7, 17 (ten on), 22 (five on: ends it) */
    assert_int_equal(zone.first, 2);
    assert_int_equal(zone.last, 21);
    zone = longest_in("oo.....o.........o....o..", 9 * SCORE_MAT_FT);
    assert_int_equal(zone.first, 9);
    assert_int_equal(zone.last, 21);
    zone = longest_in("o.o.o.o", 0.0); /* one joint is no mat */
    assert_int_equal(mats_of(zone), 2);
    zone = longest_in("", 0.0);
    assert_int_equal(mats_of(zone), 0);
    assert_true(same((struct score_zone){10, 30}, (struct score_zone){20, 60}));
    assert_false(same((struct score_zone){10, 30}, (struct score_zone){21, 60}));
    assert_false(same((struct score_zone){10, 30}, (struct score_zone){0, 0}));
}

/* The stop follows from speed and distance: v^2 = 2 a d for the mean deceleration over distance, within onset and ripple. */
static void a_series_is_drawn_from_its_number(void **state)
{
    (void)state;
    struct score_series one, two;
    uint64_t first = 7, second = 7;
    draw_series(&one, 3, &first);
    draw_series(&two, 3, &second);
    assert_memory_equal(&one, &two, sizeof one);
    for (int i = 0; i < 50; i++) {
        static struct sim_path_row rows[SCORE_ROWS_MAX];
        static struct score_landing landing;
        struct gear gear;
        size_t count;
        memset(&landing, 0, sizeof landing);
        draw_gear(&gear, &one, &first);
        roll(&landing, &gear, &one, rows, &count, &first);
        assert_true(landing.stop_ft > 45.0 && landing.stop_ft < 140.0);
        assert_true(landing.edges >= 10 && rows[count - 1].force_lb == 0.0);
        double braked = 0.0; /* momentum: the integral of the deceleration is the speed */
        for (double t_s = 0.0; t_s < landing.stop_s; t_s += 1e-4)
            braked += 1e-4 * braking_ft_s2(&gear, t_s);
        assert_true(fabs(braked - gear.v0_ft_s) < 0.05);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(areas_by_hand),
        cmocka_unit_test(zones_drawn_by_hand),
        cmocka_unit_test(a_series_is_drawn_from_its_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
