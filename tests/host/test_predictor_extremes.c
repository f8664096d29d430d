/* Runways and landings at the ends of what there can be: the predictor's chain against the host's
 * in double precision, closed forms, refusals of what is in other units, and inputs that no
 * instrument should give. */

#include <string.h>

#include "tests/host/predictor_case.h"
#include "tests/cmocka_all.h"

static struct mr_predictor predictor;
static struct mr_predictor_zone zone;
static struct error error;

static float all_gaps_in = NAN; /* NaN: as laid */

static enum mr_status start(const struct mr_predictor_config *config)
{
    enum mr_status status = mr_predictor_start(&predictor, config);
    if (status != MR_OK || isnan(all_gaps_in))
        return status;
    static struct mr_predictor_state state;
    mr_predictor_save(&predictor, &state);
    for (unsigned j = 0; j <= config->chain.mats; j++)
        state.gap_counts[j] = (uint16_t)(all_gaps_in * 1e5f + 0.5f);
    return mr_predictor_load(&predictor, &state);
}

struct extreme {
    const char *name;
    double friction;   /* of the mats' weight */
    float gaps_in, kl; /* all joints; of the usual stiffness */
    float step_s;
    uint16_t mats;
    struct braking braking;
    double most_rms_in;
};

static void set_up(const struct extreme *e, struct mr_predictor_config *config)
{
    *config = case_rig();
    config->chain.friction_lb = (float)(e->friction * CASE_MAT_LB);
    config->chain.kl_lb_ft *= e->kl;
    config->chain.step_s = e->step_s;
    config->chain.mats = e->mats;
    all_gaps_in = e->gaps_in;
}

/* rms over stations and milliseconds of the difference to the host's chain, inches; the largest
 * movement of both. */
static double compare(const struct braking *braking, double *most_in, double *true_in)
{
    struct sim_result truth;
    double sum = 0.0, dt_s = fmin(2.5e-5, 0.25 * (double)predictor.config.chain.step_s);
    size_t count = 0;
    *most_in = *true_in = 0.0;
    error = (struct error){0};
    bool good = case_truth(&predictor, braking, dt_s, &truth, &error);
    assert_string_equal(error.text, "");
    assert_true(good);
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms + 1u < truth.sample_count; ms++) {
        const struct mr_predictor_input input = case_input(braking, ms);
        mr_predictor_on_block(&predictor, &input);
        for (unsigned i = 0; i < CASE_STATIONS; i++) {
            double station_ft = fmin(10.0 * i + 5.0,
                                     predictor.config.chain.mats * CASE_MAT_FT - 0.1);
            double u_in = 12.0 *
                          (double)mr_chain_displacement_ft(
                              &predictor.chain, (unsigned)(station_ft / CASE_MAT_FT + 1e-9) + 1u);
            double right_in = 12.0 * truth.sample_u_ft[(ms + 1u) * CASE_STATIONS + i];
            sum += (u_in - right_in) * (u_in - right_in);
            count++;
            *most_in = fmax(*most_in, u_in);
            *true_in = fmax(*true_in, right_in);
        }
    }
    sim_result_free(&truth);
    mr_predictor_get_zone(&predictor, &zone);
    return sqrt(sum / (double)count);
}

TEST(extremes_agree_with_the_hosts_chain)
{
    static const float usual_s = 1e-3f / 6.0f;
    /* afterwards: 0.008 for landing 5; other roundings of either side make 0.003 or 0.005 of it */
    const struct extreme extremes[] = {
        {"usual", 0.5, NAN, 1.0f, usual_s, 420, {33.0, 8.0, 8.0}, 0.005},
        {"gentle", 0.5, NAN, 1.0f, usual_s, 420, {28.0, 4.0, 4.0}, 0.005},
        {"landing 5", 0.5, NAN, 1.0f, usual_s, 420, {35.5, 6.6, 9.2}, 0.008},
        {"braked harder", 0.5, NAN, 1.0f, usual_s, 420, {40.0, 12.0, 20.0}, 0.005},
        {"locked wheels", 0.5, NAN, 1.0f, usual_s, 420, {40.0, 32.0, 32.0}, 0.02},
        {"friction 0.05", 0.05, NAN, 1.0f, usual_s, 420, {28.0, 5.0, 5.0}, 0.02},
        {"friction 1", 1.0, NAN, 1.0f, usual_s, 420, {33.0, 8.0, 8.0}, 0.005},
        {"all gaps 0", 0.5, 0.0f, 1.0f, usual_s, 420, {33.0, 8.0, 8.0}, 0.005},
        {"all gaps full", 0.5, 0.030f, 1.0f, usual_s, 420, {33.0, 8.0, 8.0}, 0.01},
        {"stiffness x 10", 0.5, NAN, 10.0f, 5e-5f, 420, {33.0, 8.0, 8.0}, 0.01},
        {"512 mats", 0.5, NAN, 1.0f, usual_s, 512, {42.0, 8.0, 8.0}, 0.01},
    };
    for (size_t k = 0; k < sizeof extremes / sizeof extremes[0]; k++) {
        struct mr_predictor_config config;
        double most_in, true_in;
        set_up(&extremes[k], &config);
        assert_int_equal(start(&config), MR_OK);
        double rms_in = compare(&extremes[k].braking, &most_in, &true_in);
        print_message(
            "%-16s rms %.4f in of %.3f in; mat updates %.2f million, most in a block %u\n",
            extremes[k].name, rms_in, true_in, (double)predictor.updates / 1e6,
            predictor.block_updates_max);
        assert_true(rms_in < extremes[k].most_rms_in);
        assert_false(zone.basis & MR_PREDICTOR_RESTARTED);
        assert_int_equal(zone.level, MR_PREDICTOR_FULL);
    }
    all_gaps_in = NAN;
}

/* Nothing can move: all is closed, and all of it ahead of the wheel is one zone. */
TEST(all_gaps_0_is_one_zone)
{
    struct mr_predictor_config config = case_rig();
    const struct braking braking = {33.0, 8.0, 8.0};
    all_gaps_in = 0.0f;
    assert_int_equal(start(&config), MR_OK);
    all_gaps_in = NAN;
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms < 1000; ms++) {
        const struct mr_predictor_input input = case_input(&braking, ms);
        mr_predictor_on_block(&predictor, &input);
    }
    mr_predictor_get_zone(&predictor, &zone);
    double wheel_ft = CASE_TOUCHDOWN_FT + 33.0 - 4.0;
    assert_true(fabs((double)zone.end_ft - 420.0 * CASE_MAT_FT) < 0.01);
    assert_true((double)zone.start_ft >= wheel_ft - CASE_MAT_FT &&
                (double)zone.start_ft < wheel_ft + 2.0 * CASE_MAT_FT);
    assert_int_equal(zone.verdict, MR_PREDICTOR_WARNING);
    /* The compression is that of the thrust, W/12 a/g, 26.9 lb; a push that comes all at once makes
     * at most twice its own of it. */
    double thrust_lb = CASE_GEAR_LB / 12.0 * 8.0 / CASE_G_FT_S2;
    assert_true((double)zone.compression_lb > 0.8 * thrust_lb &&
                (double)zone.compression_lb < 2.0 * thrust_lb);
}

/* With nothing but friction, a push F closes what lies ahead as far as n = F / (f w) mats: all open
 * joints of 0.01 in so far, when the wheel stands and pushes. (Static closed form: the push that
 * grows slowly overcomes f w more with each mat.) */
TEST(a_standing_push_closes_f_over_fw)
{
    struct mr_predictor_config config = case_rig();
    config.grit_lb = 0.0f;
    config.level = MR_PREDICTOR_PLOUGH;
    all_gaps_in = 0.01f;
    assert_int_equal(start(&config), MR_OK);
    all_gaps_in = NAN;
    mr_predictor_arm(&predictor);
    struct mr_predictor_input input = case_input(&(struct braking){30.0, 6.0, 6.0}, 1000);
    for (unsigned ms = 0; ms < 100; ms++)
        mr_predictor_on_block(&predictor, &input);
    mr_predictor_get_zone(&predictor, &zone);
    double mats = CASE_GEAR_LB / 12.0 * 6.0 / CASE_G_FT_S2 / (0.5 * CASE_MAT_LB);
    assert_true(fabs(zone.mats - mats) < 2.5);
    unsigned mat = (unsigned)((double)input.wheel_ft / CASE_MAT_FT + 1e-4) + 1u;
    assert_true(fabs(12.0 * (double)mr_chain_displacement_ft(&predictor.chain, mat) - 0.01 * mats) <
                0.025);
}

/* One mat: it is pushed against the ground, u = gap + (F - c f w) / KL at rest, where friction
 * holds back (c = 1) or on (c = -1). */
TEST(one_mat_stops_at_the_ground)
{
    struct mr_predictor_config config = case_rig();
    config.chain.mats = 1;
    config.grit_lb = 0.0f;
    all_gaps_in = 0.01f; /* so that the other joint does not hook */
    assert_int_equal(start(&config), MR_OK);
    all_gaps_in = NAN;
    mr_predictor_arm(&predictor);
    const struct mr_predictor_input input = {.wheel_ft = 0.14f,
                                             .speed_ft_s = 0.01f,
                                             .deceleration_ft_s2 = 8.0f,
                                             .is_braking_known = true,
                                             .is_on_runway = true};
    for (unsigned ms = 0; ms < 500; ms++)
        mr_predictor_on_block(&predictor, &input);
    double thrust_lb = CASE_GEAR_LB / 12.0 * 8.0 / CASE_G_FT_S2, friction_lb = 0.5 * CASE_MAT_LB;
    double off_ft = (double)mr_chain_displacement_ft(&predictor.chain, 1) -
                    (double)predictor.gap_ft[1];
    assert_true(off_ft * 2.9e5 > thrust_lb - 1.05 * friction_lb &&
                off_ft * 2.9e5 < thrust_lb + 1.05 * friction_lb);
    mr_predictor_get_zone(&predictor, &zone);
    assert_int_equal(zone.mats, 0);
    assert_true(zone.compression_lb > 20.0f &&
                zone.critical_lb < 20.0f);              /* 27 lb, and P_c is 18.5 */
    assert_int_equal(zone.verdict, MR_PREDICTOR_QUIET); /* that foretells nothing by itself */
}

/* --- units --- */

TEST(other_units_are_refused)
{
    struct {
        const char *name;
        size_t offset;
        double factor;
    } const wrong[] = {
#define OF(member) offsetof(struct mr_predictor_config, member)
        {"mat length in inches", OF(chain.mat_length_ft), 12.0},
        {"mat length in mm", OF(chain.mat_length_ft), 304.8},
        {"mat length in metres", OF(chain.mat_length_ft), 0.3048},
        {"slack in inches", OF(chain.slack_ft), 12.0},
        {"slack in mm", OF(chain.slack_ft), 304.8},
        {"mass in pounds", OF(chain.mass_slug), 32.174},
        {"mass in kilograms", OF(chain.mass_slug), 14.594},
        {"weight in kilograms", OF(mat_weight_lb), 0.4536},
        {"weight in newtons", OF(mat_weight_lb), 4.448},
        {"friction in newtons", OF(chain.friction_lb), 4.448},
        {"stiffness in lb/in", OF(chain.kl_lb_ft), 1.0 / 12.0},
        {"stiffness in N/m", OF(chain.kl_lb_ft), 14.594},
        {"irregularity in inches", OF(bump_ft), 12.0},
        {"irregularity in mm", OF(bump_ft), 304.8},
        {"step in ms", OF(chain.step_s), 1000.0},
        {"thrust of the full-scale gear", OF(thrust_lb_per_g), 35.0},
        {"a length that is no number", OF(chain.mat_length_ft), (double)NAN},
        {"endless stiffness", OF(chain.kl_lb_ft), (double)INFINITY},
#undef OF
    };
    struct mr_predictor_config config = case_rig();
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    for (size_t k = 0; k < sizeof wrong / sizeof wrong[0]; k++) {
        float value;
        config = case_rig();
        memcpy(&value, (char *)&config + wrong[k].offset, sizeof value);
        value = (float)(wrong[k].factor * (double)value);
        memcpy((char *)&config + wrong[k].offset, &value, sizeof value);
        enum mr_status status = mr_predictor_start(&predictor, &config);
        if (status != MR_USAGE && status != MR_NUMERICS)
            print_message("%s was taken\n", wrong[k].name);
        assert_true(status == MR_USAGE || status == MR_NUMERICS);
    }
    /* All in kilograms agrees with itself: the lighter mats of the same stiffness are refused for
     * the step. */
    config = case_rig();
    config.chain.mass_slug *= 0.4536f;
    config.mat_weight_lb *= 0.4536f;
    config.chain.friction_lb *= 0.4536f;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_NUMERICS);
}

/* Survey in mm: no ten joints are that wide. Readings in mm: no mat follows them. */
TEST(readings_in_other_units_are_left_out)
{
    struct mr_predictor_config config = case_rig();
    const struct braking braking = {35.5, 6.6, 9.2};
    float sum_in[MR_SEGMENTS], before_ft[MR_CHAIN_MATS + 1u];
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = 40.0f + 10.0f * (float)i;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    memcpy(before_ft, predictor.gap_ft, sizeof before_ft);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = s % 2u ? 25.4f * 0.175f : -0.175f;
    mr_predictor_set_survey(&predictor, sum_in);
    assert_memory_equal(before_ft, predictor.gap_ft, sizeof before_ft);
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms < 3500; ms++) {
        struct mr_predictor_input input = case_input(&braking, ms);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            input.displacement_in[i] =
                25.4f * (input.wheel_ft > config.station_ft[i] - 12.0f ? 0.3f : 0.0f);
        mr_predictor_on_block(&predictor, &input);
        mr_predictor_get_zone(&predictor, &zone);
        assert_false(zone.basis & (MR_PREDICTOR_SURVEY | MR_PREDICTOR_RESTARTED));
    }
    unsigned left_out = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        left_out += predictor.doubt[i] == MR_PREDICTOR_DISAGREES;
    assert_true(left_out >= 4); /* those that the gear has come to */
}

/* --- inputs --- */

/* All readings jump over their whole range every block: the springs' limit bounds what it does, and
 * they are left out in the end. */
TEST(jumping_transducers_do_no_harm)
{
    struct mr_predictor_config config = case_rig();
    const struct braking braking = {35.5, 6.6, 9.2};
    float most_ft = 0.0f;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = 40.0f + 10.0f * (float)i;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms < 4500; ms++) {
        struct mr_predictor_input input = case_input(&braking, ms);
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            input.displacement_in[i] = (ms + i) % 2u ? 5.0f : -5.0f;
        mr_predictor_on_block(&predictor, &input);
        for (unsigned n = 1; n <= 420; n++) {
            float u_ft = mr_chain_displacement_ft(&predictor.chain, n);
            assert_true(u_ft < MR_CHAIN_RUNAWAY_FT && u_ft > -MR_CHAIN_RUNAWAY_FT);
            most_ft = fmaxf(most_ft, fabsf(u_ft));
        }
    }
    mr_predictor_get_zone(&predictor, &zone);
    assert_true(most_ft < 0.25f);
    assert_true(zone.basis & MR_PREDICTOR_NO_TRANSDUCER);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        assert_true(predictor.doubt[i] == MR_PREDICTOR_DISAGREES ||
                    predictor.doubt[i] == MR_PREDICTOR_DRIFTS);
}

/* Time stands still for the gear: one place and speed told for ten seconds. The mats come to rest
 * under the standing push. */
TEST(time_standing_still_comes_to_rest)
{
    struct mr_predictor_config config = case_rig();
    const struct mr_predictor_input input = case_input(&(struct braking){35.5, 8.0, 8.0}, 1500);
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    float before_ft = 0.0f;
    unsigned mat = (unsigned)((double)input.wheel_ft / CASE_MAT_FT + 1e-4) + 1u;
    for (unsigned ms = 0; ms < 10000; ms++) {
        mr_predictor_on_block(&predictor, &input);
        if (ms == 2000)
            before_ft = mr_chain_displacement_ft(&predictor.chain, mat);
    }
    assert_true(before_ft > 0.005f);
    assert_true(fabsf(mr_chain_displacement_ft(&predictor.chain, mat) - before_ft) < 0.0005f);
    for (unsigned n = 1; n <= 420; n++)
        assert_true(fabsf(predictor.chain.v_ft_s[n]) < 1e-3f);
}

/* The gear is taken to stand: what is left of its speed may be rounded below 0. The motion is known
 * all the same. */
TEST(a_speed_rounded_below_zero_is_rest)
{
    struct mr_predictor_config config = case_rig();
    const struct braking braking = {35.5, 8.0, 8.0};
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0; ms < 2000; ms++) {
        struct mr_predictor_input input = case_input(&braking, ms);
        input.speed_ft_s = ms < 1000 ? input.speed_ft_s : -1e-6f;
        mr_predictor_on_block(&predictor, &input);
        mr_predictor_get_zone(&predictor, &zone);
        assert_false(zone.basis & MR_PREDICTOR_NO_MOTION);
        assert_int_equal(zone.level, MR_PREDICTOR_FULL);
    }
    assert_true(zone.future_mats == 0 && isnan(zone.lead_s));
}

/* A bit of memory falls over: a mat at the speed of nothing, or far away. It is noticed, said, and
 * the landing goes on; after the fourth time without the model. */
TEST(a_spoilt_chain_falls_back)
{
    struct mr_predictor_config config = case_rig();
    const struct braking braking = {35.5, 6.6, 9.2};
    const float bad[] = {NAN, INFINITY, 5.0f, -1e20f, 1e9f};
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    for (unsigned ms = 0, k = 0; ms < 3000; ms++) {
        const struct mr_predictor_input input = case_input(&braking, ms);
        if (ms % 500u == 499u && k < 5u) {
            unsigned mat = (unsigned)((double)input.wheel_ft / CASE_MAT_FT) + 2u;
            predictor.chain.u_ft[mat] = bad[k];
            predictor.chain.is_awake[(mat - 1u) / MR_CHAIN_BAY_GROUPS + 1u] = true;
            mr_predictor_on_block(&predictor, &input);
            k++;
            assert_int_equal(predictor.failures, k < 4u ? k : 4u);
            mr_predictor_get_zone(&predictor, &zone);
            assert_true(zone.basis & MR_PREDICTOR_RESTARTED);
            assert_int_equal(zone.level, k < 4u ? MR_PREDICTOR_FULL : MR_PREDICTOR_KINEMATIC);
            continue;
        }
        mr_predictor_on_block(&predictor, &input);
    }
    mr_predictor_end_landing(&predictor);
    for (unsigned j = 0; j <= 420; j++)
        assert_true(predictor.gap_ft[j] >= 0.0f && predictor.gap_ft[j] <= config.chain.slack_ft);
    mr_predictor_arm(&predictor); /* the next landing has the model again */
    mr_predictor_get_zone(&predictor, &zone);
    assert_int_equal(zone.level, MR_PREDICTOR_FULL);
    assert_false(zone.basis & MR_PREDICTOR_RESTARTED);
}

/* However often it is begun again, what the transducers have moved closes joints once. Stations 40
 * to 60 approach each other by 0.1 in. */
TEST(falling_back_again_closes_nothing_more)
{
    struct mr_predictor_config config = case_rig();
    struct mr_predictor_input input = {.wheel_ft = 5.0f,
                                       .speed_ft_s = 30.0f,
                                       .deceleration_ft_s2 = 5.0f,
                                       .is_braking_known = true};
    float sum_in[MR_SEGMENTS], once_ft = 0.0f;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = 0.1f;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = i < 3 ? 40.0f + 10.0f * (float)i : NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        input.displacement_in[i] = i < 3 ? 0.2f - 0.1f * (float)i : NAN;
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_set_survey(&predictor, sum_in);
    mr_predictor_arm(&predictor);
    for (unsigned k = 1; k <= 5; k++) {
        if (k < 5) {
            predictor.chain.u_ft[20] = NAN;
            predictor.chain.is_awake[3] = true;
            predictor.chain.low_bay = 3;
            predictor.chain.high_bay = 3;
            mr_predictor_on_block(&predictor, &input);
            assert_int_equal(predictor.failures, k);
        } else {
            mr_predictor_end_landing(&predictor);
        }
        float now_ft = 0.0f;
        for (unsigned j = 130; j < 220; j++)
            now_ft += predictor.gap_ft[j];
        if (k == 1)
            once_ft = now_ft;
        assert_true(fabsf(12.0f * once_ft - (0.9f - 0.2f)) < 0.02f);
        assert_true(fabsf(now_ft - once_ft) < 1e-5f);
    }
}
