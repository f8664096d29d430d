#include "host/sim/models/chains.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/sim/elements/lanes.h"

struct chains {
    unsigned mats, bays;
    /* range of bays (groups of mats) that are computed in any lane; low > high: none */
    unsigned awake_low, awake_high;
    lanes kl_lb_ft, cl_lb_s_ft, slack_ft, friction_lb, step_per_mass, step_s;
    /* for each bay and lane: -1 awake (computed), 0 asleep (at rest) */
    words awake[MR_CHAIN_BAYS + 2u];
    lanes u_ft[MR_CHAIN_INDICES], v_ft_s[MR_CHAIN_INDICES];
    lanes gap_ft[MR_CHAIN_INDICES], grit_extent_ft[MR_CHAIN_INDICES];
    lanes grit_lb[MR_CHAIN_INDICES];
    /* compression at which the grit yields: force of the grit / stiffness */
    lanes grit_yield_ft[MR_CHAIN_INDICES];
    lanes push_lb[MR_CHAIN_INDICES]; /* thrust of the wheel during a step */
    words diverged;
};

#define LANES_FILE "host/sim/models/chains_kernel.h"
#include "host/sim/elements/lanes_each.h"

void chains_step(struct chains *c, const unsigned mat[CHAINS_LANES],
                 const float thrust_lb[CHAINS_LANES])
{
    LANES_CALL(step, c, mat, thrust_lb);
}

unsigned chains_end_block(struct chains *c)
{
    return LANES_CALL(end_block, c);
}

struct chains *chains_make(const struct mr_chain_params params[CHAINS_LANES],
                           const float *const gap_ft[CHAINS_LANES],
                           const float *const grit_lb[CHAINS_LANES], enum mr_status *status)
{
    struct mr_chain *one = xmalloc(sizeof *one);
    struct chains *c = xaligned_alloc(64, (sizeof *c + 63u) / 64u * 64u);
    *status = MR_OK;
    memset(c, 0, sizeof *c);
    c->mats = params[0].mats;
    c->bays = (c->mats + MR_CHAIN_BAY_GROUPS - 1u) / MR_CHAIN_BAY_GROUPS;
    c->awake_low = MR_CHAIN_BAYS + 1u;
    for (unsigned k = 0; k < CHAINS_LANES && *status == MR_OK; k++) {
        struct mr_chain_params p = params[k];
        p.mats = params[0].mats;
        p.step_s = params[0].step_s;
        *status = mr_chain_start(one, &p, 1, gap_ft[k], grit_lb[k]);
        c->kl_lb_ft[k] = one->kl_lb_ft;
        c->cl_lb_s_ft[k] = p.cl_lb_s_ft;
        c->slack_ft[k] = one->slack_ft;
        c->friction_lb[k] = one->friction_lb;
        c->step_per_mass[k] = one->step_per_mass;
        c->step_s[k] = one->step_s;
        for (unsigned j = 1; j <= c->mats + 1u && *status == MR_OK; j++) {
            c->gap_ft[j][k] = one->gap_ft[j];
            c->grit_extent_ft[j][k] = one->grit_extent_ft[j];
            c->grit_lb[j][k] = one->grit_lb[j];
            c->grit_yield_ft[j][k] = one->grit_lb[j] / one->kl_lb_ft;
        }
    }
    free(one);
    if (*status == MR_OK)
        return c;
    free(c);
    return NULL;
}

void chains_free(struct chains *chains)
{
    free(chains);
}

float chains_opening_ft(const struct chains *c, unsigned lane, unsigned joint)
{
    return c->gap_ft[joint][lane] + (c->u_ft[joint][lane] - c->u_ft[joint - 1u][lane]);
}

float chains_displacement_ft(const struct chains *c, unsigned lane, unsigned mat)
{
    return c->u_ft[mat][lane];
}

unsigned chains_active_mats(const struct chains *c)
{
    unsigned mats = 0;
    for (unsigned bay = c->awake_low; bay <= c->awake_high; bay++)
        mats += any_plain(c->awake[bay]) ? last_mat_plain(c, bay) - first_mat_plain(bay) + 1u : 0u;
    return mats;
}
