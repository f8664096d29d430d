/* Single against double precision: the same predictor compiled twice (tests/double), on landing 5
 * of the report as the host's chain computes it, with transducers and blind. */

#include "tests/double/double.h"
#include "tests/host/predictor_case.h"
#include "tests/cmocka_all.h"

static struct mr_predictor predictor;

static struct double_config as_doubles(const struct mr_predictor_config *config)
{
    const struct mr_chain_params *chain = &config->chain;
    struct double_config out = {.mats = chain->mats,
                                .mat_length_ft = (double)chain->mat_length_ft,
                                .mass_slug = (double)chain->mass_slug,
                                .friction_lb = (double)chain->friction_lb,
                                .kl_lb_ft = (double)chain->kl_lb_ft,
                                .cl_lb_s_ft = (double)chain->cl_lb_s_ft,
                                .slack_ft = (double)chain->slack_ft,
                                .step_s = (double)chain->step_s,
                                .grit_lb = (double)config->grit_lb,
                                .thrust_lb_per_g = (double)config->thrust_lb_per_g,
                                .deceleration_ft_s2 = (double)config->deceleration_ft_s2,
                                .bump_ft = (double)config->bump_ft,
                                .mat_weight_lb = (double)config->mat_weight_lb};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        out.station_ft[i] = (double)config->station_ft[i];
    return out;
}

/* rms over all mats and blocks of the landing, inches, and the largest movement. Readings: another
 * runway's, of the host's chain. */
static double rms_in(const struct braking *braking, const struct sim_result *readings,
                     double *most_in)
{
    struct mr_predictor_config config = case_rig();
    double sum = 0.0, reading_in[MR_TRANSDUCERS];
    size_t count = 0, blocks = readings->sample_count - 1u;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = readings->sample_u_ft ? 45.0f + 10.0f * (float)i : NAN;
    const struct double_config doubles = as_doubles(&config);
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    mr_predictor_arm(&predictor);
    assert_true(double_start(&doubles));
    *most_in = 0.0;
    for (unsigned ms = 0; ms < blocks; ms++) {
        struct mr_predictor_input input = case_input(braking, ms);
        /* samples lie at 5, 15 .. */
        for (unsigned i = 0; i < MR_TRANSDUCERS && readings->sample_u_ft; i++)
            input.displacement_in[i] =
                i < 7 ? (float)(12.0 * readings->sample_u_ft[ms * CASE_STATIONS + 4u + i]) : NAN;
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            reading_in[i] = (double)input.displacement_in[i];
        mr_predictor_on_block(&predictor, &input);
        double_block((double)input.wheel_ft, (double)input.speed_ft_s,
                     (double)input.deceleration_ft_s2, reading_in);
        for (unsigned n = 1; n <= config.chain.mats; n++) {
            double off_in = 12.0 * ((double)mr_chain_displacement_ft(&predictor.chain, n) -
                                    double_displacement_ft(n));
            sum += off_in * off_in;
            *most_in = fmax(*most_in, 12.0 * double_displacement_ft(n));
            count++;
        }
    }
    return sqrt(sum / (double)count);
}

TEST(single_precision_is_enough)
{
    const struct braking fifth = {35.5, 6.6, 9.2};
    struct mr_predictor_config config = case_rig();
    struct error error = {0};
    struct sim_result truth;
    double most_in;
    assert_int_equal(double_size(), 8);
    assert_int_equal(mr_predictor_start(&predictor, &config), MR_OK);
    for (unsigned j = 1; j <= 421; j++) /* another runway */
        predictor.chain.grit_lb[j] = 0.7f * predictor.chain.grit_lb[422u - j];
    assert_true(case_truth(&predictor, &fifth, 5e-5, &truth, &error));
    double drawn_in = rms_in(&fifth, &truth, &most_in);
    print_message("landing 5, drawn to transducers: rms %.5f in of at most %.3f in\n", drawn_in,
                  most_in);
    assert_true(most_in > 0.3);
    assert_true(drawn_in > 0.0 && drawn_in < 0.005);
    struct sim_result blind = truth;
    blind.sample_u_ft = NULL;
    double blind_in = rms_in(&fifth, &blind, &most_in);
    print_message("landing 5, blind: rms %.5f in of at most %.3f in\n", blind_in, most_in);
    assert_true(blind_in > 0.0 && blind_in < 0.005);
    sim_result_free(&truth);
}
