#include "tests/double/double.h"

#include "common/predictor.h"

static struct mr_predictor predictor;

bool double_start(const struct double_config *config)
{
    struct mr_predictor_config own = {.chain = {.mats = (uint16_t)config->mats,
                                                .mat_length_ft = config->mat_length_ft,
                                                .mass_slug = config->mass_slug,
                                                .friction_lb = config->friction_lb,
                                                .kl_lb_ft = config->kl_lb_ft,
                                                .cl_lb_s_ft = config->cl_lb_s_ft,
                                                .slack_ft = config->slack_ft,
                                                .step_s = config->step_s},
                                      .grit_lb = config->grit_lb,
                                      .thrust_lb_per_g = config->thrust_lb_per_g,
                                      .deceleration_ft_s2 = config->deceleration_ft_s2,
                                      .bump_ft = config->bump_ft,
                                      .mat_weight_lb = config->mat_weight_lb,
                                      .updates_per_block = 1u << 20,
                                      .level = MR_PREDICTOR_FULL};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        own.station_ft[i] = config->station_ft[i];
    if (mr_predictor_start(&predictor, &own) != MR_OK)
        return false;
    mr_predictor_arm(&predictor);
    return true;
}

void double_block(double wheel_ft, double speed_ft_s, double deceleration_ft_s2,
                  const double displacement_in[8])
{
    struct mr_predictor_input input = {.wheel_ft = wheel_ft,
                                       .speed_ft_s = speed_ft_s,
                                       .deceleration_ft_s2 = deceleration_ft_s2,
                                       .is_braking_known = true,
                                       .is_on_runway = true};
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        input.displacement_in[i] = displacement_in[i];
    mr_predictor_on_block(&predictor, &input);
}

double double_displacement_ft(unsigned mat)
{
    return mr_chain_displacement_ft(&predictor.chain, mat);
}

unsigned double_size(void)
{
    return sizeof predictor.chain.u_ft[0];
}
