/* The predictor against closed forms, the host's fine chain, and everything that can go wrong with
 * what it is given. */

#include <string.h>

#include "common/splitmix.h"
#include "tests/host/predictor_case.h"
#include "tests/cmocka_all.h"

#define MATS         420
#define MAT_FT       CASE_MAT_FT
#define ROW_S        0.01
#define ROWS         800
#define TOUCHDOWN_FT CASE_TOUCHDOWN_FT
#define MAT_LB       CASE_MAT_LB
#define GEAR_LB      CASE_GEAR_LB
#define G_FT_S2      CASE_G_FT_S2

static struct mr_predictor predictor;
static struct mr_predictor_zone zone;

static struct mr_predictor_config rig(void)
{
    struct mr_predictor_config config = case_rig();
    config.updates_per_block = 100000;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = 40.0f + 10.0f * (float)i;
    return config;
}

/* --- a landing of even braking --- */

struct landing {
    double speed_ft_s, braking_ft_s2;
    size_t count;
    double *u_in; /* by millisecond and transducer; NULL: no truth */
    size_t rows;
    double gap_end_in[MATS + 1];
};

static double stop_s(const struct landing *landing)
{
    return landing->speed_ft_s / landing->braking_ft_s2;
}

static struct mr_predictor_input gear_at(const struct landing *landing, double t_s)
{
    double s = fmin(t_s, stop_s(landing)), v = landing->speed_ft_s, a = landing->braking_ft_s2;
    struct mr_predictor_input input = {.wheel_ft = (float)(TOUCHDOWN_FT + (v - 0.5 * a * s) * s),
                                       .speed_ft_s = (float)(v - a * s),
                                       .deceleration_ft_s2 = (float)a,
                                       .is_braking_known = true,
                                       .is_on_runway = true};
    size_t row = (size_t)(t_s * 1000.0 + 0.5);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        input.displacement_in[i] =
            landing->u_in
                ? (float)landing
                      ->u_in[(row < landing->rows ? row : landing->rows - 1) * MR_TRANSDUCERS + i]
                : NAN;
    return input;
}

/* The host's chain in double precision, with gaps and resistances of its own. */
static void find_truth(struct landing *landing, uint64_t seed, double gap_in[MATS + 1])
{
    static double gap_ft[MATS + 1], grit_lb[MATS + 1], stations_ft[MR_TRANSDUCERS];
    static struct sim_path_row rows[ROWS];
    struct error error = {0};
    struct sim_scene scene;
    struct sim_result result;
    size_t count = 0;
    for (int j = 0; j <= MATS; j++) {
        gap_ft[j] = fmin(0.036 * mr_splitmix64_uniform(&seed), 0.030) / 12.0;
        gap_in[j] = 12.0 * gap_ft[j];
        grit_lb[j] = 20.0 * mr_splitmix64_uniform(&seed);
    }
    for (; (double)count * ROW_S < stop_s(landing); count++) {
        struct mr_predictor_input gear =
            gear_at(&(struct landing){landing->speed_ft_s, landing->braking_ft_s2, 0, NULL, 0, {0}},
                    (double)count * ROW_S);
        rows[count] = (struct sim_path_row){(double)count * ROW_S, (double)gear.wheel_ft,
                                            GEAR_LB / 12.0 * landing->braking_ft_s2 / G_FT_S2};
    }
    rows[count - 1].force_lb = 0.0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        stations_ft[i] = 40.0 + 10.0 * i;
    sim_scene_set_defaults(&scene);
    scene.model = SIM_MODEL_CHAIN;
    scene.mats = MATS;
    scene.length_ft = MAT_FT;
    scene.weight_lb = MAT_LB;
    scene.kl_lb_ft = 2.9e5;
    scene.cl_lb_s_ft = 5.0;
    scene.slack_ft = 0.0025;
    scene.left_end = scene.right_end = SIM_END_FIXED;
    scene.v0_ft_s = 0.0;
    scene.t_dwell_s = 0.3;
    sim_scene_set_list(&scene.gap0_ft, gap_ft, MATS + 1);
    sim_scene_set_list(&scene.grit_lb, grit_lb, MATS + 1);
    sim_scene_set_path(&scene, rows, count);
    const struct sim_options options = {.dt_s = 5e-5,
                                        .rtol = 0.5,
                                        .sample_dt_s = 1e-3,
                                        .station_ft = stations_ft,
                                        .station_count = MR_TRANSDUCERS};
    assert_int_equal(sim_run(&scene, &options, &result, &error), MR_OK);
    landing->rows = result.sample_count;
    landing->u_in = calloc(landing->rows * MR_TRANSDUCERS, sizeof *landing->u_in);
    for (size_t i = 0; i < landing->rows * MR_TRANSDUCERS; i++)
        landing->u_in[i] = 12.0 * result.sample_u_ft[i];
    for (int j = 0; j <= MATS; j++)
        landing->gap_end_in[j] = 12.0 * result.gap_ft[j + 1];
    sim_result_free(&result);
    sim_scene_free(&scene);
}

static void survey(const double *gap_in)
{
    float sum_in[MR_SEGMENTS] = {0};
    for (unsigned j = 0; j < MR_SEGMENTS * 10u; j++)
        sum_in[j / 10u] += (float)gap_in[j];
    mr_predictor_set_survey(&predictor, sum_in);
}

/* Plays it; `spoil` may change what is told. */
static void play(const struct landing *landing,
                 void (*spoil)(struct mr_predictor_input *, unsigned ms))
{
    unsigned last = (unsigned)(stop_s(landing) * 1000.0) + 200u;
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms < last; ms++) {
        struct mr_predictor_input input = gear_at(landing, 1e-3 * ms);
        if (spoil)
            spoil(&input, ms);
        mr_predictor_on_block(&predictor, &input);
    }
    mr_predictor_get_zone(&predictor, &zone);
}

static void assert_sane(void)
{
    mr_predictor_get_zone(&predictor, &zone);
    for (unsigned j = 0; j <= predictor.config.chain.mats; j++)
        assert_true(predictor.gap_ft[j] >= 0.0f &&
                    predictor.gap_ft[j] <= predictor.config.chain.slack_ft);
    assert_true(zone.mats <= predictor.config.chain.mats + 4u);
}

/* --- closed forms --- */

/* P_c = w L / (2 h0); and n = F / (f w) mats are closed when nothing but friction resists. */
TEST(critical_compression_and_length)
{
    struct mr_predictor_config config = rig();
    config.grit_lb = 0.0f;
    config.level = MR_PREDICTOR_PLOUGH;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    struct landing landing = {.speed_ft_s = 28.0, .braking_ft_s2 = 4.0};
    struct mr_predictor_input input = gear_at(&landing, 1.0);
    for (unsigned ms = 0; ms < 20; ms++)
        mr_predictor_on_block(&predictor, &input);
    mr_predictor_get_zone(&predictor, &zone);
    assert_true(fabs((double)zone.critical_lb - MAT_LB * MAT_FT / (2.0 * 0.0036)) < 1e-3);
    double mats = GEAR_LB / 12.0 * 4.0 / G_FT_S2 / (0.5 * MAT_LB); /* 57.8 */
    assert_true(fabs(zone.future_mats - mats) < 2.5);
    assert_int_equal(zone.verdict, MR_PREDICTOR_WARNING);
    assert_true(fabs((double)zone.mats - mats) < 2.5);
}

static double plough_closes_in(float grit_lb)
{
    struct mr_predictor_config config = rig();
    config.grit_lb = grit_lb;
    config.level = MR_PREDICTOR_PLOUGH;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    struct landing landing = {.speed_ft_s = 28.0, .braking_ft_s2 = 4.0};
    double before_in = 0.0, after_in = 0.0;
    struct mr_predictor_input input = gear_at(&landing, 1.0);
    unsigned mat = (unsigned)((double)input.wheel_ft / MAT_FT) + 1u;
    for (unsigned j = mat; j < MATS; j++)
        before_in += 12.0 * (double)predictor.gap_ft[j];
    mr_predictor_on_block(&predictor, &input);
    for (unsigned j = mat + 1u; j <= MATS; j++)
        after_in += 12.0 * (double)mr_chain_opening_ft(&predictor.chain, j);
    assert_true(fabs(before_in - after_in -
                     12.0 * (double)mr_chain_displacement_ft(&predictor.chain, mat)) < 1e-4);
    return before_in - after_in;
}

/* What closes ahead is what the wheel's mat has moved, and no more closes the more resists. */
TEST(plough_keeps_lengths)
{
    double free_in = plough_closes_in(0.0f), gritty_in = plough_closes_in(10.0f);
    assert_true(free_in > 0.8 && gritty_in > 0.05 && gritty_in < 0.7 * free_in);
    assert_true(plough_closes_in(1000.0f) < 0.02);
}

/* With nothing but friction n = F / (f w) mats close: 29 at 2 ft/s2, 65 at 4.5. The edge that tells
 * of the harder braking comes in any phase of a search; the warning is there eleven blocks later at
 * most, and no block costs more than its share. */
TEST(a_warning_follows_the_edge)
{
    struct mr_predictor_config config = rig();
    const struct landing before = {.speed_ft_s = 28.0, .braking_ft_s2 = 2.0},
                         after = {.speed_ft_s = 28.0, .braking_ft_s2 = 4.5};
    unsigned most = 0;
    config.grit_lb = 0.0f;
    config.level = MR_PREDICTOR_PLOUGH;
    for (unsigned phase = 0; phase < 50; phase++) {
        assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
        mr_predictor_arm(&predictor);
        unsigned ms = 0, late = 0;
        for (; ms < 100u + phase; ms++) {
            struct mr_predictor_input input = gear_at(&before, 1e-3 * ms);
            uint32_t visits = predictor.examined_joints;
            mr_predictor_on_block(&predictor, &input);
            assert_true(predictor.examined_joints - visits <= MR_PREDICTOR_VISITS_PER_BLOCK + 1u);
        }
        mr_predictor_get_zone(&predictor, &zone);
        assert_int_equal(zone.verdict, MR_PREDICTOR_QUIET);
        assert_true(zone.future_mats >= 26 && zone.future_mats <= 30);
        for (; zone.verdict != MR_PREDICTOR_WARNING && late < 100; late++, ms++) {
            struct mr_predictor_input input = gear_at(&after, 1e-3 * ms);
            mr_predictor_on_block(&predictor, &input);
            mr_predictor_get_zone(&predictor, &zone);
        }
        most = late > most ? late : most;
    }
    print_message("latest warning: %u blocks after the edge\n", most);
    assert_true(most <= 11);
}

/* --- against the fine chain --- */

TEST(follows_the_fine_chain)
{
    static double gap_in[MATS + 1];
    struct landing landing = {.speed_ft_s = 33.0, .braking_ft_s2 = 8.0};
    struct mr_predictor_config config = rig();
    find_truth(&landing, 11, gap_in);
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    survey(gap_in);
    play(&landing, NULL);
    assert_true(!(zone.basis & (MR_PREDICTOR_NO_TRANSDUCER | MR_PREDICTOR_NO_MOTION |
                                MR_PREDICTOR_DEGRADED | MR_PREDICTOR_RESTARTED)));
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_int_equal(predictor.doubt[i], MR_PREDICTOR_TRUSTED);
    /* The sums of openings over 35 joints between stations are what the fine chain has, though each
     * joint differs. */
    mr_predictor_end_landing(&predictor);
    for (unsigned s = 4; s < 10; s++) {
        double off_in = 0.0;
        for (unsigned j = 35 * s; j < 35 * (s + 1); j++)
            off_in += 12.0 * (double)predictor.gap_ft[j] - landing.gap_end_in[j];
        assert_true(fabs(off_in) < 0.12); /* 0.6 in as laid */
    }
    free(landing.u_in);
}

static unsigned bad_channel;

static void stuck(struct mr_predictor_input *input, unsigned ms)
{
    (void)ms;
    input->displacement_in[bad_channel] = 0.0f;
}

static void drifting(struct mr_predictor_input *input, unsigned ms)
{
    input->displacement_in[bad_channel] += 0.2f * 1e-3f * (float)ms;
}

static void lost(struct mr_predictor_input *input, unsigned ms)
{
    (void)ms;
    input->displacement_in[bad_channel] = NAN;
}

TEST(a_bad_channel_is_left_out)
{
    static double gap_in[MATS + 1];
    struct landing landing = {.speed_ft_s = 35.5, .braking_ft_s2 = 8.0};
    struct mr_predictor_config config = rig();
    static const struct {
        void (*spoil)(struct mr_predictor_input *, unsigned);
        unsigned channel, doubt;
    } faults[] = {{stuck, 1, MR_PREDICTOR_DISAGREES},
                  {drifting, 7, MR_PREDICTOR_DRIFTS},
                  {lost, 2, MR_PREDICTOR_MISSING}};
    find_truth(&landing, 12, gap_in);
    for (unsigned k = 0; k < 3; k++) {
        bad_channel = faults[k].channel;
        assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
        survey(gap_in);
        play(&landing, faults[k].spoil);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            assert_int_equal(predictor.doubt[i],
                             i == bad_channel ? faults[k].doubt : MR_PREDICTOR_TRUSTED);
    }
    free(landing.u_in);
}

/* --- what is missing --- */

TEST(without_channels_it_runs_blind)
{
    struct landing landing = {.speed_ft_s = 28.0, .braking_ft_s2 = 5.0};
    struct mr_predictor_config config = rig();
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    play(&landing, NULL);
    assert_true(zone.basis & MR_PREDICTOR_NO_TRANSDUCER);
    assert_false(zone.basis & (MR_PREDICTOR_BRACKETED | MR_PREDICTOR_SURVEY));
    assert_int_equal(zone.age_blocks, predictor.block);
    assert_true(zone.mats > 5); /* it has ploughed */
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = NAN;
    struct mr_predictor_zone seen = zone;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    play(&landing, NULL);
    assert_memory_equal(&seen, &zone, sizeof seen); /* not fitted is as good as lost */
}

/* All gaps 0.01 in: a segment has 0.1 in of slack. Station 40 has moved by what 40 to 60 holds (70
 * joints, 0.7 in), 50 by half. */
TEST(without_switches_it_is_kinematic)
{
    struct mr_predictor_config config = rig();
    float sum_in[MR_SEGMENTS];
    struct mr_predictor_input input = {
        .wheel_ft = NAN, .speed_ft_s = NAN, .deceleration_ft_s2 = NAN};
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = 0.1f;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_set_survey(&predictor, sum_in);
    mr_predictor_arm(&predictor);
    mr_predictor_on_block(&predictor, &input);
    mr_predictor_get_zone(&predictor, &zone);
    assert_int_equal(zone.mats, 0);
    input.displacement_in[0] = 0.70f;
    input.displacement_in[1] = 0.35f;
    mr_predictor_on_block(&predictor, &input);
    mr_predictor_get_zone(&predictor, &zone);
    assert_int_equal(zone.level, MR_PREDICTOR_KINEMATIC);
    assert_true(zone.basis & MR_PREDICTOR_NO_MOTION);
    assert_true(fabs((double)zone.start_ft - 40.0) < 3.0 && fabs((double)zone.end_ft - 60.0) < 3.0);
    assert_int_equal(zone.verdict, MR_PREDICTOR_WARNING);
    mr_predictor_end_landing(&predictor); /* and the next landing begins with it */
    mr_predictor_arm(&predictor);
    mr_predictor_get_zone(&predictor, &zone);
    assert_true(fabs((double)zone.start_ft - 40.0) < 3.0 && fabs((double)zone.end_ft - 60.0) < 3.0);
}

TEST(level_follows_the_budget)
{
    struct landing landing = {.speed_ft_s = 35.5, .braking_ft_s2 = 8.0};
    struct mr_predictor_config config = rig();
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    play(&landing, NULL);
    uint32_t whole = predictor.updates, blocks = predictor.block;
    assert_int_equal(zone.level, MR_PREDICTOR_FULL);
    config.updates_per_block = whole / blocks / 3u;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    enum mr_predictor_level worst = MR_PREDICTOR_FULL, before = MR_PREDICTOR_FULL;
    for (unsigned ms = 0; ms < blocks + 5000u; ms++) {
        struct mr_predictor_input input = gear_at(&landing, 1e-3 * ms);
        mr_predictor_on_block(&predictor, &input);
        assert_true(abs((int)predictor.level - (int)before) <= 1);
        before = predictor.level;
        worst = before > worst ? before : worst;
        mr_predictor_get_zone(&predictor, &zone);
        assert_int_equal(!(zone.basis & MR_PREDICTOR_DEGRADED), before == MR_PREDICTOR_FULL);
    }
    assert_true(worst > MR_PREDICTOR_FULL);
    assert_int_equal(before, MR_PREDICTOR_FULL); /* at rest for 5 s: recovered */
    assert_true(predictor.updates < whole / 2u);
}

/* The board's own budget is enough for every mat; a third of it for two in one, and when the gear
 * stands every mat is back. */
TEST(a_third_of_the_budget_is_two_in_one)
{
    struct landing landing = {.speed_ft_s = 33.0, .braking_ft_s2 = 8.0};
    for (unsigned part = 1; part <= 3; part += 2) {
        struct mr_predictor_config config = rig();
        enum mr_predictor_level worst = MR_PREDICTOR_FULL;
        config.updates_per_block = MR_PREDICTOR_UPDATES_PER_BLOCK / part;
        assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
        mr_predictor_arm(&predictor);
        for (unsigned ms = 0; ms < 8000; ms++) {
            struct mr_predictor_input input = gear_at(&landing, 1e-3 * ms);
            mr_predictor_on_block(&predictor, &input);
            worst = predictor.level > worst ? predictor.level : worst;
        }
        assert_int_equal(worst, part == 1 ? MR_PREDICTOR_FULL : MR_PREDICTOR_TWO);
        assert_int_equal(predictor.level, MR_PREDICTOR_FULL);
    }
}

/* Two levels down at once; each level up is waited for anew, ten looks. */
TEST(it_comes_back_level_by_level)
{
    struct mr_predictor_config config = rig();
    struct mr_predictor_input input = {
        .wheel_ft = 10.0f, .speed_ft_s = 0.0f, .deceleration_ft_s2 = 5.0f};
    unsigned blocks[MR_PREDICTOR_PLOUGH] = {0};
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    mr_predictor_reduce_level(&predictor);
    mr_predictor_reduce_level(&predictor);
    for (unsigned ms = 0; ms < 2000; ms++) {
        mr_predictor_on_block(&predictor, &input);
        assert_true(predictor.level < MR_PREDICTOR_PLOUGH);
        blocks[predictor.level]++;
    }
    assert_in_range(blocks[MR_PREDICTOR_FOUR], 450, 550);
    assert_in_range(blocks[MR_PREDICTOR_TWO], 450, 550);
    assert_int_equal(predictor.level, MR_PREDICTOR_FULL);
}

/* A budget that no look exceeds by half, but a second does. */
TEST(a_second_beyond_the_budget_counts)
{
    struct landing landing = {.speed_ft_s = 33.0, .braking_ft_s2 = 8.0};
    struct mr_predictor_config config = rig();
    uint32_t looks[200] = {0}, most = 0, second = 0;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms < 4000; ms++) {
        struct mr_predictor_input input = gear_at(&landing, 1e-3 * ms);
        uint32_t updates = predictor.updates, visits = predictor.examined_joints;
        mr_predictor_on_block(&predictor, &input);
        looks[ms / 50] += predictor.updates - updates + (predictor.examined_joints - visits) / 2u;
        most = looks[ms / 50] > most ? looks[ms / 50] : most;
    }
    for (unsigned n = 0; n + 20 <= 80; n++) {
        uint32_t sum = 0;
        for (unsigned i = n; i < n + 20; i++)
            sum += looks[i];
        second = sum > second ? sum : second;
    }
    config.updates_per_block = most / 50u * 3u / 4u; /* a look: at most 1.33 of it */
    assert_true(second > 1000u * config.updates_per_block);
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    enum mr_predictor_level worst = MR_PREDICTOR_FULL;
    for (unsigned ms = 0; ms < 4000; ms++) {
        struct mr_predictor_input input = gear_at(&landing, 1e-3 * ms);
        mr_predictor_on_block(&predictor, &input);
        worst = predictor.level > worst ? predictor.level : worst;
    }
    assert_int_equal(worst, MR_PREDICTOR_TWO);
}

/* What is carried on, and what is not: a channel that was lost for a while is trusted again; a
 * deceleration counts when switches beyond touchdown tell it, and only in its landing; the
 * resistance stays within its bounds however the mats are dragged. */
TEST(what_counts_and_how_long)
{
    struct mr_predictor_config config = rig();
    struct mr_predictor_input input = {
        .wheel_ft = 30.0f, .speed_ft_s = 10.0f, .deceleration_ft_s2 = 9.0f, .is_on_runway = true};
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    mr_predictor_on_block(&predictor, &input);
    assert_true(predictor.deceleration_ft_s2 == 5.0f);
    input.is_braking_known = true;
    input.displacement_in[2] = NAN;
    mr_predictor_on_block(&predictor, &input);
    assert_true(predictor.deceleration_ft_s2 == 9.0f);
    assert_int_equal(predictor.doubt[2], MR_PREDICTOR_MISSING);
    input.displacement_in[2] = 0.0f;
    mr_predictor_on_block(&predictor, &input);
    assert_int_equal(predictor.doubt[2], MR_PREDICTOR_TRUSTED);
    for (int way = 1; way >= -1; way -= 2) {
        mr_predictor_arm(&predictor);
        assert_true(predictor.deceleration_ft_s2 == 5.0f);
        for (unsigned ms = 0; ms < 4000; ms++) {
            for (unsigned i = 0; i < 3; i++)
                input.displacement_in[i] = (float)way * 0.01f *
                                           (float)(ms % 1000 < 100 ? ms % 1000 : 100);
            memset(predictor.doubt, 0, sizeof predictor.doubt); /* whatever it is, it is believed */
            mr_predictor_on_block(&predictor, &input);
            assert_true(predictor.resistance_scale >= 0.3f && predictor.resistance_scale <= 2.5f);
        }
    }
}

/* --- what is wrong --- */

static unsigned wrong_kind;

static void wrong(struct mr_predictor_input *input, unsigned ms)
{
    static const float values[] = {NAN, INFINITY, -INFINITY, 1e30f, -1e30f, 0.0f};
    float value = values[wrong_kind % 6];
    if (ms % 400 < 300)
        return;
    switch (wrong_kind / 6) {
    case 0: input->wheel_ft = value; break;
    case 1: input->speed_ft_s = value; break;
    case 2: input->deceleration_ft_s2 = value; break;
    default:
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            input->displacement_in[i] = value;
    }
}

TEST(wrong_inputs_end_in_sane_statements)
{
    struct landing landing = {.speed_ft_s = 28.0, .braking_ft_s2 = 5.0};
    struct mr_predictor_config config = rig();
    for (wrong_kind = 0; wrong_kind < 24; wrong_kind++) {
        assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
        play(&landing, wrong);
        assert_false(zone.basis & MR_PREDICTOR_RESTARTED); /* none of it has reached the chain */
        assert_int_equal(zone.level, MR_PREDICTOR_FULL);
        mr_predictor_end_landing(&predictor);
        assert_sane();
    }
}

TEST(extremes_stay_bounded)
{
    for (unsigned k = 0; k < 10; k++) {
        struct mr_predictor_config config = rig();
        struct landing landing = {.speed_ft_s = 30.0, .braking_ft_s2 = 6.0};
        float sum_in[MR_SEGMENTS];
        for (unsigned s = 0; s < MR_SEGMENTS; s++)
            /* 5: in other units */
            sum_in[s] = k == 3 ? 0.0f : k == 4 ? 0.30f : k == 5 ? 3.0f : NAN;
        switch (k) {
        case 0: landing.braking_ft_s2 = 32.0; break;
        case 1: config.chain.friction_lb = (float)(0.05 * MAT_LB); break;
        case 2: config.chain.friction_lb = (float)MAT_LB; break;
        case 6: config.chain.mats = 1; break;
        case 7: config.chain.mats = MR_CHAIN_MATS; break;
        case 8:
            config.grit_lb = 0.0f;
            config.chain.friction_lb = 0.0f;
            break;
        case 9: config.thrust_lb_per_g *= 12.0f; break; /* all axles on one strip */
        default: break;
        }
        assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
        mr_predictor_set_survey(&predictor, sum_in);
        for (unsigned n = 0; n < 3; n++) {
            play(&landing, NULL);
            assert_false(zone.basis & MR_PREDICTOR_RESTARTED);
            mr_predictor_end_landing(&predictor);
            assert_sane();
        }
    }
}

TEST(impossible_parameters_are_refused)
{
    struct mr_predictor_config config = rig();
    config.chain.kl_lb_ft *= 10.0f; /* limit: 2/sqrt(4 KL/m) / (1 + ...) falls below the step */
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_NUMERICS);
    config = rig();
    config.chain.mass_slug = NAN;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_USAGE);
    config = rig();
    config.chain.mats = MR_CHAIN_MATS + 1u;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_USAGE);
    config = rig();
    config.thrust_lb_per_g = INFINITY;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_USAGE);
    config = rig();
    config.bump_ft = 0.0f;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_USAGE);
}

/* --- what is kept --- */

TEST(state_survives)
{
    static struct mr_predictor_state kept, again;
    struct landing landing = {.speed_ft_s = 30.0, .braking_ft_s2 = 7.0};
    struct mr_predictor_config config = rig();
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    play(&landing, NULL);
    mr_predictor_end_landing(&predictor);
    mr_predictor_get_zone(&predictor, &zone);
    struct mr_predictor_zone before = zone;
    mr_predictor_save(&predictor, &kept);
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    assert_int_equal(mr_predictor_load(&predictor, &kept), MR_OK);
    mr_predictor_save(&predictor, &again);
    assert_memory_equal(&kept, &again, sizeof kept);
    mr_predictor_arm(&predictor);
    mr_predictor_get_zone(&predictor, &zone);
    assert_int_equal(zone.mats, before.mats);
    assert_true(zone.mats > 5);
    again.gap_counts[17] = 60000;
    assert_int_equal(mr_predictor_load(&predictor, &again), MR_MALFORMED);
    again = kept;
    again.resistance_scale = NAN;
    assert_int_equal(mr_predictor_load(&predictor, &again), MR_MALFORMED);
    again = kept;
    again.mats--;
    assert_int_equal(mr_predictor_load(&predictor, &again), MR_MALFORMED);
    mr_predictor_save(&predictor, &again);
    assert_memory_equal(&kept, &again, sizeof kept); /* refused: nothing has changed */
}

TEST(survey_is_taken_over)
{
    struct landing landing = {.speed_ft_s = 30.0, .braking_ft_s2 = 7.0};
    struct mr_predictor_config config = rig();
    float sum_in[MR_SEGMENTS];
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    for (unsigned pass = 0; pass < 2; pass++) {
        for (unsigned s = 0; s < MR_SEGMENTS; s++)
            sum_in[s] = s == 7 ? NAN : 0.007f * (float)s;
        mr_predictor_set_survey(&predictor, sum_in);
        for (unsigned s = 0; s < MR_SEGMENTS; s++) {
            double sum = 0.0;
            for (unsigned j = 10u * s; j < 10u * (s + 1u); j++)
                sum += 12.0 * (double)predictor.gap_ft[j];
            if (s != 7)
                /* what the reading's error allows is left alone */
                assert_true(fabs(sum - (double)sum_in[s]) <= 0.0101);
        }
        play(&landing, NULL);
        mr_predictor_end_landing(&predictor);
    }
}
