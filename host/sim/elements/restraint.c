#include "host/sim/elements/restraint.h"

#include <math.h>

/* How kinds differ. `ends`: entries of a mat's row, as of a spring to the ground or to two
 * neighbours. */
static const struct kind {
    bool pulls_out, only_pulls;
    double ends;
} kinds[SIM_RESTRAINTS] = {
    [SIM_ANCHORS] = {true, false, 1.0},
    [SIM_TIES] = {true, true, 1.0},
    [SIM_ABSORBERS] = {false, false, 4.0},
};

void restraints_reset(struct restraints *r, const struct sim_scene *scene)
{
    const struct sim_list *zero = &r->made->zero_ft;
    for (int i = 0; i < r->count; i++) {
        int at = mods_restraint_at(scene, r->kind, i);
        double start_ft = r->kind == SIM_ABSORBERS ? sim_scene_joint(&scene->gap0_ft, at) : 0.0;
        r->zero_ft[i] = zero->count > 0 ? sim_scene_joint(zero, i + 1) : start_ft;
        r->at[i] = at;
        r->load_lb[i] = 0.0;
        r->stretch_ft[i] = start_ft - r->zero_ft[i];
    }
}

double restraint_lb(struct restraints *r, int i, double x_ft, double rate_ft_s)
{
    const struct sim_restraint *s = r->made;
    const struct kind *kind = &kinds[r->kind];
    double spring_lb = s->k_lb_ft * (x_ft - r->zero_ft[i]);
    r->stretch_ft[i] = 0.0;
    if (kind->only_pulls && !(spring_lb > 0.0))
        return 0.0;
    if (kind->pulls_out && fabs(spring_lb) > s->grip_lb) {
        spring_lb = copysign(s->grip_lb, spring_lb);
        r->zero_ft[i] = x_ft - spring_lb / s->k_lb_ft;
    }
    double lb = spring_lb + s->c_lb_s_ft * rate_ft_s;
    lb = fmax(kind->only_pulls ? 0.0 : -s->grip_lb, fmin(lb, s->grip_lb));
    r->load_lb[i] = fmax(r->load_lb[i], fabs(lb));
    r->stretch_ft[i] = x_ft - r->zero_ft[i];
    return lb;
}

int restraint_of(const struct restraints *r, int at)
{
    if (r->count == 0 || at < (int)r->at[0] || (at - (int)r->at[0]) % r->made->every != 0)
        return -1;
    int i = (at - (int)r->at[0]) / r->made->every;
    return i < r->count ? i : -1;
}

double restraints_energy_lb_ft(const struct restraints *r)
{
    const struct sim_restraint *s = r->made;
    double energy = 0.0;
    for (int i = 0; i < r->count; i++) {
        double stretch_ft = fabs(r->stretch_ft[i]),
               elastic_ft = fmin(stretch_ft, s->grip_lb / s->k_lb_ft);
        energy += s->k_lb_ft * elastic_ft * (stretch_ft - 0.5 * elastic_ft);
    }
    return energy;
}

double restraints_stiffness_lb_ft(const struct restraints *r)
{
    return r->count > 0 ? kinds[r->kind].ends * r->made->k_lb_ft : 0.0;
}

double restraints_damping_lb_s_ft(const struct restraints *r)
{
    return r->count > 0 ? kinds[r->kind].ends * r->made->c_lb_s_ft : 0.0;
}
