#include "common/matchain.h"

#include <string.h>

static float square_root(float x)
{
    return __builtin_sqrtf(x);
}

#define LAW(name)                one_##name
#define LAW_REAL                 float
#define LAW_ABS(x)               __builtin_fabsf(x)
#define LAW_COPYSIGN(size, sign) __builtin_copysignf(size, sign)
#include "common/chain_law.h"

float mr_chain_step_limit_s(const struct mr_chain_params *params)
{
    float rate2 = 4.0f * params->kl_lb_ft / params->mass_slug;
    float damping = 4.0f * params->cl_lb_s_ft / params->mass_slug;
    return 4.0f / (damping + square_root(damping * damping + 4.0f * rate2));
}

static bool is_positive(float x)
{
    return x > 0.0f && x < 1e30f;
}

static bool is_not_negative(float x)
{
    return x >= 0.0f && x < 1e30f;
}

enum mr_status mr_chain_start(struct mr_chain *chain, const struct mr_chain_params *params,
                              unsigned group, const float *gap_ft, const float *grit_lb)
{
    if (params->mats < 1 || params->mats > MR_CHAIN_MATS ||
        (group != 1 && group != 2 && group != 4) || !is_positive(params->mat_length_ft) ||
        !is_positive(params->mass_slug) || !is_positive(params->kl_lb_ft) ||
        !is_positive(params->step_s) || !is_not_negative(params->friction_lb) ||
        !is_not_negative(params->cl_lb_s_ft) || !is_not_negative(params->slack_ft))
        return MR_USAGE;
    if (params->step_s > MR_CHAIN_STEP_MARGIN * mr_chain_step_limit_s(params))
        return MR_NUMERICS;

    memset(chain, 0, sizeof *chain);
    chain->params = *params;
    chain->mats_per_group = group;
    chain->group_count = (params->mats + group - 1u) / group;
    chain->mass_slug = params->mass_slug * (float)group;
    chain->friction_lb = params->friction_lb * (float)group;
    chain->kl_lb_ft = params->kl_lb_ft / (float)group;
    chain->slack_ft = params->slack_ft * (float)group;
    chain->step_s = params->step_s * (float)group;
    chain->step_per_mass = chain->step_s / chain->mass_slug;
    chain->low_bay = MR_CHAIN_BAYS + 1u;
    chain->bay_count = (chain->group_count + MR_CHAIN_BAY_GROUPS - 1u) / MR_CHAIN_BAY_GROUPS;
    for (unsigned j = 1; j <= chain->group_count + 1u; j++) {
        float opening_ft = 0.0f, held_lb = 0.0f;
        unsigned inside = 0;
        for (unsigned i = 0; i < group; i++) {
            /* index, in the list of all joints of the runway, of the joint after joint `single` */
            unsigned single = (j - 1u) * group + i;
            if (single > params->mats)
                break;
            opening_ft += __builtin_isnan(gap_ft[single]) ? 0.5f * params->slack_ft
                                                          : gap_ft[single];
            held_lb += !grit_lb || __builtin_isnan(grit_lb[single]) ? 0.0f : grit_lb[single];
            inside++;
        }
        chain->gap_ft[j] = opening_ft;
        chain->grit_lb[j] = inside ? held_lb / (float)inside : 0.0f;
        chain->grit_extent_ft[j] = opening_ft < 0.0f            ? 0.0f
                                 : opening_ft > chain->slack_ft ? chain->slack_ft
                                                                : opening_ft;
    }
    return MR_OK;
}

/* Values that are the same for all joints and mats of a chain, in a small struct that the compiler
 * keeps in registers during the step of a bay. */
struct chain_constants {
    struct one_joint joint;
    float friction_lb, step_per_mass, step_s;
};

static inline struct chain_constants get_chain_constants(const struct mr_chain *chain)
{
    return (struct chain_constants){{chain->kl_lb_ft, chain->params.cl_lb_s_ft, chain->slack_ft},
                                    chain->friction_lb,
                                    chain->step_per_mass,
                                    chain->step_s};
}

/* Returns the tension of joint j with opening g_ft and opening speed opening_ft_s. Also updates the
 * reach of its grit. */
static inline float update_joint_pull(struct mr_chain *chain,
                                      const struct chain_constants *constants, unsigned j,
                                      float g_ft, float opening_ft_s)
{
    float grit_lb = chain->grit_lb[j];
    struct one_pull pull = one_joint_pull(constants->joint, grit_lb,
                                          grit_lb / constants->joint.kl_lb_ft,
                                          chain->grit_extent_ft[j], g_ft, opening_ft_s);
    if (!pull.kept)
        chain->grit_extent_ft[j] = pull.grit_extent_ft;
    return pull.lb;
}

static inline float update_joint_at_present_gap(struct mr_chain *chain,
                                                const struct chain_constants *constants, unsigned j)
{
    return update_joint_pull(chain, constants, j,
                             chain->gap_ft[j] + (chain->u_ft[j] - chain->u_ft[j - 1u]),
                             chain->v_ft_s[j] - chain->v_ft_s[j - 1u]);
}

static unsigned get_group_index(const struct mr_chain *chain, unsigned mat)
{
    return (mat - 1u) / chain->mats_per_group + 1u;
}

static unsigned get_first_group_of_bay(unsigned bay)
{
    return (bay - 1u) * MR_CHAIN_BAY_GROUPS + 1u;
}

static unsigned get_last_group_of_bay(const struct mr_chain *chain, unsigned bay)
{
    return bay == chain->bay_count ? chain->group_count : bay * MR_CHAIN_BAY_GROUPS;
}

/* Moves the mats of a bay by one step. `left_lb`: tension of the bay's first joint. Returns the
 * tension of the first joint of the next bay. */
static float step_bay(struct mr_chain *chain, const struct chain_constants *constants, unsigned bay,
                      float left_lb)
{
    unsigned first = get_first_group_of_bay(bay), last = get_last_group_of_bay(chain, bay);
    float u_ft = chain->u_ft[first], v_ft_s = chain->v_ft_s[first];
    for (unsigned n = first; n <= last; n++) {
        float next_ft = chain->u_ft[n + 1u], next_ft_s = chain->v_ft_s[n + 1u];
        float right_lb = update_joint_pull(
            chain, constants, n + 1u, chain->gap_ft[n + 1u] + (next_ft - u_ft), next_ft_s - v_ft_s);
        float x_lb = right_lb - left_lb + chain->push_lb[n];
        if (v_ft_s != 0.0f || __builtin_fabsf(x_lb) > constants->friction_lb) {
            v_ft_s =
                one_mat_slip(v_ft_s, x_lb, constants->friction_lb, constants->step_per_mass).v_ft_s;
            chain->v_ft_s[n] = v_ft_s;
            chain->u_ft[n] = u_ft + constants->step_s * v_ft_s;
        }
        left_lb = right_lb;
        u_ft = next_ft;
        v_ft_s = next_ft_s;
    }
    chain->updates += last - first + 1u;
    return left_lb;
}

static void wake_bay(struct mr_chain *chain, unsigned bay)
{
    chain->is_awake[bay] = true;
    if (bay < chain->low_bay)
        chain->low_bay = bay;
    if (bay > chain->high_bay)
        chain->high_bay = bay;
}

void mr_chain_step(struct mr_chain *chain, unsigned mat, float thrust_lb)
{
    const struct chain_constants constants = get_chain_constants(chain);
    unsigned wheel = thrust_lb != 0.0f && mat >= 1 && mat <= chain->params.mats
                       ? get_group_index(chain, mat)
                       : 0;
    float left_lb = 0.0f;
    /* true if left_lb is valid: the tension of the bay's first joint, computed with the bay on its
     * left */
    bool carried = false;
    float pushed_lb = chain->push_lb[wheel];
    if (wheel) {
        wake_bay(chain, (wheel - 1u) / MR_CHAIN_BAY_GROUPS + 1u);
        chain->push_lb[wheel] = pushed_lb + thrust_lb;
    }
    for (unsigned bay = chain->low_bay; bay <= chain->high_bay; bay++) {
        if (chain->is_awake[bay])
            left_lb = step_bay(chain, &constants, bay,
                               carried ? left_lb
                                       : update_joint_at_present_gap(chain, &constants,
                                                                     get_first_group_of_bay(bay)));
        carried = chain->is_awake[bay];
    }
    chain->push_lb[wheel] = pushed_lb;
    for (unsigned bay = chain->low_bay, high = chain->high_bay; bay <= high; bay++) {
        if (!chain->is_awake[bay])
            continue;
        if (bay > 1u && !chain->is_awake[bay - 1u] &&
            chain->v_ft_s[get_first_group_of_bay(bay)] != 0.0f)
            wake_bay(chain, bay - 1u);
        if (bay < chain->bay_count && !chain->is_awake[bay + 1u] &&
            chain->v_ft_s[get_last_group_of_bay(chain, bay)] != 0.0f)
            wake_bay(chain, bay + 1u);
    }
}

void mr_chain_set_force(struct mr_chain *chain, unsigned mat, float push_lb)
{
    unsigned n = get_group_index(chain, mat);
    chain->push_lb[n] = push_lb;
    if (push_lb > chain->friction_lb || push_lb < -chain->friction_lb)
        wake_bay(chain, (n - 1u) / MR_CHAIN_BAY_GROUPS + 1u);
}

bool mr_chain_end_block(struct mr_chain *chain)
{
    unsigned low = chain->low_bay, high = chain->high_bay;
    chain->low_bay = MR_CHAIN_BAYS + 1u;
    chain->high_bay = 0;
    for (unsigned bay = low; bay <= high; bay++) {
        unsigned first = get_first_group_of_bay(bay), last = get_last_group_of_bay(chain, bay);
        if (!chain->is_awake[bay])
            continue;
        bool moves = chain->v_ft_s[first - 1u] != 0.0f || chain->v_ft_s[last + 1u] != 0.0f;
        for (unsigned n = first; n <= last; n++) {
            float u_ft = chain->u_ft[n], v_ft_s = chain->v_ft_s[n];
            moves = moves || v_ft_s != 0.0f;
            if (!(__builtin_fabsf(u_ft) < MR_CHAIN_RUNAWAY_FT &&
                  __builtin_fabsf(v_ft_s) < MR_CHAIN_RUNAWAY_FT_S))
                chain->has_diverged = true;
        }
        chain->is_awake[bay] = moves;
        if (moves)
            wake_bay(chain, bay);
    }
    return !chain->has_diverged;
}

float mr_chain_displacement_ft(const struct mr_chain *chain, unsigned mat)
{
    return chain->u_ft[get_group_index(chain, mat)];
}

uint32_t mr_chain_reset_updates(struct mr_chain *chain)
{
    uint32_t updates = chain->updates;
    chain->updates = 0;
    return updates;
}
