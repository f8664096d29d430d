/* Two thousand seeded landings: do the stated intervals hold? */
#include "tests/common/seeded_landing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/gates.h"
#include "common/passage.h"
#include "common/switches.h"
#include "tests/cmocka_all.h"

#define LANDINGS    2000
#define BLOCK_S     1e-3
#define TICKS_PER_S 84e6

/* Steps of the staircase: 64 + 8 i codes, i = 7 (p - 1) mod 24. */
static uint16_t steps[SEEDED_SWITCHES];
static float stations[SEEDED_SWITCHES];

static int set_table(void **state)
{
    (void)state;
    for (unsigned i = 0; i < SEEDED_SWITCHES; i++) {
        steps[i] = (uint16_t)(64 + 8 * (7 * i % 24));
        stations[i] = -2.5f + 5.0f * (float)i;
    }
    return 0;
}

struct opening {
    double t_s;
    unsigned position; /* from 0 */
    double closed_s;   /* it closes again then; NaN: it stays */
};

static int by_time(const void *a, const void *b)
{
    double d = ((const struct opening *)a)->t_s - ((const struct opening *)b)->t_s;
    return d < 0.0 ? -1 : d > 0.0;
}

/* Each opening of each contact; it closes half way to the next. */
static size_t openings_of(const struct seeded_landing *landing, struct opening *opening)
{
    size_t count = 0;
    for (unsigned i = 0; i < SEEDED_SWITCHES; i++) {
        for (unsigned b = 0; !isnan(landing->open_s[i]) && b <= landing->bounces[i]; b++) {
            double t_s = landing->open_s[i] + b * landing->bounce_s[i];
            opening[count++] = (struct opening){
                t_s, i, b < landing->bounces[i] ? t_s + 0.5 * landing->bounce_s[i] : (double)NAN};
        }
    }
    qsort(opening, count, sizeof *opening, by_time);
    return count;
}

/* Part of the block that begins at `t_s` for which an opening was open. */
static double open_part(const struct opening *opening, double t_s)
{
    double from = fmax(opening->t_s, t_s), to = t_s + BLOCK_S;
    if (!isnan(opening->closed_s))
        to = fmin(to, opening->closed_s);
    return to > from ? (to - from) / BLOCK_S : 0.0;
}

struct heard {
    struct mr_passage passage;
    unsigned named, bounces, other;
};

/* Block by block, as the board does it; TIM2 starts near its wrap. */
static void hear(const struct seeded_landing *landing, uint64_t seed, struct heard *heard)
{
    struct opening opening[SEEDED_SWITCHES * 4];
    struct mr_switches switches;
    size_t count = openings_of(landing, opening), next = 0;
    uint64_t state = seed + 77;
    const uint32_t tick0 = 0u - 130000000u; /* wraps 1.55 s in */
    memset(heard, 0, sizeof *heard);
    mr_switches_start(&switches);
    mr_passage_start(&heard->passage);
    for (uint32_t block = 0; block * BLOCK_S < landing->stop_s + 0.1; block++) {
        double t_s = block * BLOCK_S, codes = 62.0 + 0.5 * seeded_normal(&state);
        struct mr_switch_edge edge;
        for (size_t i = 0; i < count; i++)
            codes += steps[opening[i].position] * open_part(&opening[i], t_s);
        mr_switches_add_level(&switches, tick0 + 84000u * block, (float)codes);
        for (; next < count && opening[next].t_s < t_s + 0.9e-3; next++)
            assert_true(mr_switches_add_edge(
                &switches, tick0 + (uint32_t)llround(opening[next].t_s * TICKS_PER_S)));
        while (mr_switches_next_edge(&switches, steps, SEEDED_SWITCHES, &edge)) {
            heard->bounces += (unsigned)(edge.reason == MR_SWITCH_BOUNCE);
            heard->other += (unsigned)(edge.reason > MR_SWITCH_BOUNCE);
            if (edge.reason != MR_SWITCH_GOOD)
                continue;
            heard->named++;
            struct mr_passage_edge passed = {.tick = edge.tick,
                                             .block = block,
                                             .position = edge.position,
                                             .number = 1,
                                             .station_ft = (double)stations[edge.position - 1]};
            (void)mr_passage_on_edge(&heard->passage, &passed, (double)NAN, stations,
                                     SEEDED_SWITCHES);
        }
    }
    assert_int_equal(next, count);
}

static int by_size(const void *a, const void *b)
{
    double d = *(const double *)a - *(const double *)b;
    return d < 0.0 ? -1 : d > 0.0;
}

/* What geometry allows: three switches that opened, one of them beyond touchdown. */
static bool can_be_known(const struct seeded_landing *landing)
{
    unsigned opened = 0, beyond = 0;
    for (unsigned i = 0; i < SEEDED_SWITCHES; i++) {
        opened += (unsigned)!isnan(landing->open_s[i]);
        beyond += !isnan(landing->open_s[i]) && i >= 2;
    }
    return opened >= 3 && beyond >= 1;
}

static void check_rate(const char *what, unsigned inside, unsigned of)
{
    printf("# %s: in %.2f %% of %u\n", what, 100.0 * inside / of, of);
    assert_true(inside >= 0.935 * of && inside <= 0.965 * of);
}

static void intervals_hold(double place_in, double stated_in)
{
    static double speed_error[LANDINGS];
    static struct heard heard;
    unsigned known = 0, speed = 0, mean = 0, stop = 0, even = 0, outlier = 0;
    for (unsigned n = 0; n < LANDINGS; n++) {
        struct seeded_landing landing;
        struct mr_gates_summary summary;
        unsigned opened = 0, bounces = 0;
        seeded_draw(&landing, n, place_in);
        hear(&landing, n, &heard);
        for (unsigned i = 0; i < SEEDED_SWITCHES; i++) {
            opened += (unsigned)!isnan(landing.open_s[i]);
            bounces += isnan(landing.open_s[i]) ? 0 : landing.bounces[i];
        }
        assert_int_equal(heard.named, opened);
        assert_int_equal(heard.bounces, bounces);
        assert_int_equal(heard.other, 0);
        assert_int_equal(heard.passage.gate_count, opened >= 2 ? opened : 0);
        enum mr_status status = mr_gates_summarise(heard.passage.gate, heard.passage.gate_count,
                                                   SEEDED_TOUCHDOWN_FT, stated_in / 12.0, &summary);
        assert_int_equal(status == MR_OK, can_be_known(&landing));
        if (status != MR_OK)
            continue;
        speed_error[known++] = fabs(summary.touchdown_speed_ft_s.value / landing.speed_ft_s - 1.0);
        speed += fabs(summary.touchdown_speed_ft_s.value - landing.speed_ft_s) <=
                 1.96 * summary.touchdown_speed_ft_s.error;
        mean += fabs(summary.mean_deceleration_ft_s2.value - landing.mean_ft_s2) <=
                1.96 * summary.mean_deceleration_ft_s2.error;
        stop += fabs(summary.stop_station_ft.value - landing.stop_ft) <=
                1.96 * summary.stop_station_ft.error;
        even += summary.is_uniform;
        outlier += summary.outlier_mask != 0;
    }
    qsort(speed_error, known, sizeof speed_error[0], by_size);
    printf("# %.2f in: %u of %u known, even braking in %u, a switch left out in %u; speed error "
           "median %.4f %%, 95 %% %.3f %%\n",
           stated_in, known, LANDINGS, even, outlier, 100.0 * speed_error[known / 2],
           100.0 * speed_error[known * 95 / 100]);
    check_rate("touchdown speed", speed, known);
    check_rate("mean deceleration", mean, known);
    check_rate("stop station", stop, known);
    assert_true(speed_error[known / 2] < 0.001);
    assert_true(known > 0.9 * LANDINGS);
    assert_true(outlier <= 0.01 * LANDINGS); /* none was late */
}

TEST_IN(stated_intervals_hold, set_table, NULL)
{
    intervals_hold(0.02, 0.02);
}
