/* The predictor by itself, from the firmware's own objects: a landing of even braking (33 ft/s, 8
 * ft/s2), readings of 0. control[0]: the level; control[1]: blocks; control[2]: bits: 1 no
 * transducer is fitted, 2 a survey is read before, 4 transducer 1 alone is fitted. results: 5
 * begun; 0 blocks done; 1 mat updates; 2 visits; 3 most in a block, visits counted in; 4 blocks
 * done while a mat moved; 55: done. */
#include "common/predictor.h"
#include "tests/hil/images/image.h"

void *memset(void *to, int value, __SIZE_TYPE__ n);
void *memcpy(void *to, const void *from, __SIZE_TYPE__ n);

void *memset(void *to, int value, __SIZE_TYPE__ n)
{
    unsigned char *p = to;
    while (n--)
        *p++ = (unsigned char)value;
    return to;
}

void *memcpy(void *to, const void *from, __SIZE_TYPE__ n)
{
    unsigned char *p = to;
    const unsigned char *q = from;
    while (n--)
        *p++ = *q++;
    return to;
}

static struct mr_predictor predictor;
static struct mr_predictor_config config;
static struct mr_predictor_input input;
static struct mr_predictor_zone zone;
static float sum_in[MR_SEGMENTS];

static void set_up(uint32_t level, uint32_t lacks)
{
    config.chain = (struct mr_chain_params){.mats = 420,
                                            .mat_length_ft = 2.0f / 7.0f,
                                            .mass_slug = 0.466f / 32.174f,
                                            .friction_lb = 0.5f * 0.466f,
                                            .kl_lb_ft = 2.9e5f,
                                            .cl_lb_s_ft = 5.0f,
                                            .slack_ft = 0.0025f,
                                            .step_s = 1e-3f / 6.0f};
    config.grit_lb = 10.0f;
    config.thrust_lb_per_g = 1300.0f / 12.0f;
    config.deceleration_ft_s2 = 5.0f;
    config.bump_ft = 0.0036f;
    config.mat_weight_lb = 0.466f;
    config.updates_per_block = 1u << 20;
    config.level = (enum mr_predictor_level)level;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        config.station_ft[i] = lacks & 1u || (lacks & 4u && i > 0) ? __builtin_nanf("")
                                                                   : 40.0f + 10.0f * (float)i;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        sum_in[s] = 0.17f;
}

static void play(uint32_t blocks)
{
    float wheel_ft = 3.0f, speed_ft_s = 33.0f;
    input.deceleration_ft_s2 = 8.0f;
    input.is_braking_known = input.is_on_runway = true;
    mr_predictor_arm(&predictor);
    for (uint32_t k = 0; k < blocks; k++) {
        for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
            input.displacement_in[i] = config.station_ft[i] - wheel_ft > 15.0f ? 0.0f
                                                                               : __builtin_nanf("");
        input.wheel_ft = wheel_ft;
        input.speed_ft_s = speed_ft_s;
        uint32_t before = predictor.updates;
        mr_predictor_on_block(&predictor, &input);
        results[4] += predictor.updates != before;
        if (k % MR_PREDICTOR_INTERVAL_BLOCKS == 0)
            mr_predictor_get_zone(&predictor, &zone);
        wheel_ft += 1e-3f * speed_ft_s;
        speed_ft_s -= speed_ft_s > 0.0f ? 8e-3f : 0.0f;
        results[0] = k + 1u;
    }
}

static __attribute__((noinline)) int measure(void)
{
    set_up(control[0], control[2]);
    if (mr_predictor_start(&predictor, &config) != MR_OK)
        return 1;
    if (control[2] & 2u)
        mr_predictor_set_survey(&predictor, sum_in);
    results[5] = 1; /* the test begins to count */
    play(control[1]);
    results[1] = predictor.updates;
    results[2] = predictor.examined_joints;
    results[3] = predictor.block_updates_max;
    results[55] = 1;
    return 0;
}

int main(void) /* saves no floating-point registers before there are any */
{
    for (unsigned i = 0; i < 56; i++)
        results[i] = 0;
    enable_fpu();
    return measure();
}
