/* The spread search for zones against a plain one that begins anew at every place, on chains of
 * every kind of disorder. */

#include <math.h>
#include <string.h>

#include "common/splitmix.h"
#include "common/zonescan.h"
#include "tests/cmocka_all.h"

static struct mr_chain chain;
static uint64_t random_state;

static double uniform(void)
{
    return mr_splitmix64_uniform(&random_state);
}

/* Openings and resistances in clusters, so that there are long zones, short ones, and rows of open
 * joints. */
static void draw_chain(unsigned mats, unsigned group)
{
    static float gap_ft[MR_CHAIN_MATS + 1u], grit_lb[MR_CHAIN_MATS + 1u];
    const struct mr_chain_params params = {.mats = (uint16_t)mats,
                                           .mat_length_ft = 2.0f / 7.0f,
                                           .mass_slug = 0.0145f,
                                           .friction_lb = (float)(0.05 + 0.4 * uniform()),
                                           .kl_lb_ft = 2.9e5f,
                                           .cl_lb_s_ft = 5.0f,
                                           .slack_ft = 0.0025f,
                                           .step_s = 1e-4f};
    double part_open = 0.5, most_lb = 20.0;
    for (unsigned j = 0; j <= mats; j++) {
        if (uniform() < 0.05) {
            part_open = uniform() * uniform();
            most_lb = 40.0 * uniform();
        }
        gap_ft[j] = uniform() < part_open ? (float)(0.0025 * uniform()) : 0.0f;
        grit_lb[j] = (float)(most_lb * uniform());
    }
    assert_int_equal(mr_chain_start(&chain, &params, group, gap_ft, grit_lb), MR_OK);
    for (unsigned j = 1; j <= chain.group_count; j++)
        chain.u_ft[j] = (float)(1e-5 * uniform());
}

static bool open_at(unsigned j)
{
    return chain.gap_ft[j] + (chain.u_ft[j] - chain.u_ft[j - 1u]) >
           0.002f / 12.0f * (float)chain.mats_per_group;
}

static unsigned tally(void)
{
    return (10u + chain.mats_per_group - 1u) / chain.mats_per_group;
}

/* Every pair of closed ends, every row of `tally` joints in between: what the zone is by its
 * words. */
static unsigned plain_longest(unsigned from, unsigned *first_out)
{
    unsigned best = 0;
    for (unsigned a = from; a <= chain.group_count + 1u; a++) {
        unsigned last_open = 0;
        if (open_at(a))
            continue;
        for (unsigned b = a + 1u; b <= chain.group_count + 1u; b++) {
            if (open_at(b)) {
                if (last_open && b - last_open < tally())
                    break;
                last_open = b;
            } else if (b - a > best) {
                best = b - a;
                *first_out = a;
            }
        }
    }
    return best;
}

static bool closes(unsigned place, unsigned j, float push_lb)
{
    return push_lb - (float)(j - place) * chain.friction_lb > chain.grit_lb[j] || !open_at(j);
}

static unsigned plain_coming(unsigned place, float push_lb)
{
    unsigned start = 0, best = 0, last_open = 0;
    for (unsigned j = place + 1u; j <= chain.group_count + 1u; j++) {
        if (closes(place, j, push_lb)) {
            start = start ? start : j;
            best = j - start;
            continue;
        }
        if ((start && last_open && j - last_open < tally()) || (!start && j - place > tally()))
            break;
        last_open = j;
    }
    return best;
}

static void compare(unsigned quota)
{
    struct mr_zonescan scan;
    struct mr_zonescan_range order = {
        .search_start_joint = (uint16_t)(1u + (unsigned)(uniform() * chain.group_count)),
        .position = (uint16_t)(1u + (unsigned)(uniform() * uniform() * chain.group_count)),
        .push_lb = (float)(60.0 * uniform() * uniform()),
        .grit_lb = chain.grit_lb};
    order.last_position =
        (uint16_t)(order.position - 1u +
                   (unsigned)(uniform() * (chain.group_count + 40u - order.position)));
    unsigned first = 0, groups = plain_longest(order.search_start_joint, &first), coming = 0,
             coming_place = 0, calls = 1;
    for (unsigned n = order.position; n <= order.last_position && n < chain.group_count;
         n += MR_ZONE_STRIDE_GROUPS) {
        unsigned here = plain_coming(n, order.push_lb);
        coming_place = here > coming ? n : coming_place;
        coming = here > coming ? here : coming;
    }
    mr_zonescan_begin(&scan, &chain, &order);
    for (uint32_t before = 0; !mr_zonescan_continue(&scan, &chain, quota);
         calls++, before = scan.examined_joints) {
        assert_true(scan.examined_joints > before && scan.examined_joints <= before + quota + 1u);
        assert_true(calls < 100000);
    }
    assert_int_equal(scan.result.groups, groups);
    assert_int_equal(scan.result.first_joint, first);
    assert_int_equal(scan.result.future_groups, coming);
    assert_int_equal(scan.result.future_position, coming_place);
    double open_ft = 0.0;
    unsigned closed = 0;
    for (unsigned j = first; groups && j <= first + groups; j++) {
        open_ft += fmax(0.0, (double)mr_chain_opening_ft(&chain, j));
        closed += !open_at(j);
    }
    assert_int_equal(scan.result.closed_joints, closed);
    assert_true(fabs((double)scan.result.opening_sum_ft - open_ft) < 1e-6);
    float most_lb = 0.0f;
    for (unsigned j = order.search_start_joint; j <= chain.group_count + 1u; j++)
        most_lb = fmaxf(most_lb, mr_chain_compression_lb(&chain, j));
    assert_true(scan.result.compression_lb == most_lb);
}

TEST(says_what_a_plain_search_says)
{
    random_state = 6;
    for (unsigned round = 0; round < 600; round++) {
        static const unsigned sizes[] = {420, 512, 60, 11, 4, 1}, groups[] = {1, 2, 4};
        draw_chain(sizes[round % 6], groups[round / 6 % 3]);
        for (unsigned k = 0; k < 4; k++)
            compare(k == 0 ? 1u : k == 1 ? 7u : k == 2 ? 128u : 1000000u);
    }
}

/* Few places, and pushes that are near to what the joints ahead resist: rows of open joints, of
 * which some close from the next place. */
TEST(places_just_short_of_closing)
{
    random_state = 8;
    draw_chain(40, 1);
    for (unsigned round = 0; round < 30000; round++) {
        unsigned row = 1u + (unsigned)(14.0 * uniform());
        for (unsigned j = 1; j <= chain.group_count + 1u; j++) {
            chain.gap_ft[j] = j <= row ? 0.001f : uniform() < 0.15 ? 0.001f : 0.0f;
            chain.grit_lb[j] = (float)(uniform() < 0.5 ? 30.0 : 20.0 - 3.0 * uniform());
        }
        chain.friction_lb = 0.4f;
        struct mr_zonescan scan;
        const struct mr_zonescan_range order = {1, 1, (uint16_t)(1u + 4u * (round % 3u)), 21.0f,
                                                chain.grit_lb};
        unsigned coming = 0;
        for (unsigned n = 1; n <= order.last_position; n += MR_ZONE_STRIDE_GROUPS) {
            unsigned here = plain_coming(n, order.push_lb);
            coming = here > coming ? here : coming;
        }
        mr_zonescan_begin(&scan, &chain, &order);
        while (!mr_zonescan_continue(&scan, &chain, 16)) {
        }
        assert_int_equal(scan.result.future_groups, coming);
    }
}

/* On a runway like the predictor's own, the wheel at its beginning: one visit a joint for the zone
 * that is there; for the one to come one a joint, and some at each place. */
TEST(a_search_is_short)
{
    uint32_t most = 0;
    random_state = 7;
    for (unsigned round = 0; round < 200; round++) {
        struct mr_zonescan scan;
        draw_chain(420, 1);
        for (unsigned j = 1; j <= chain.group_count + 1u; j++)
            chain.grit_lb[j] = (float)(20.0 * uniform());
        const struct mr_zonescan_range order = {1, 1, 419, (float)(40.0 * uniform()),
                                                chain.grit_lb};
        mr_zonescan_begin(&scan, &chain, &order);
        assert_true(mr_zonescan_continue(&scan, &chain, 1000000));
        most = scan.examined_joints > most ? scan.examined_joints : most;
    }
    print_message("most visits of a search: %u\n", most);
    assert_true(most < 421 + 421 + 105 * 6);
}
