#include "host/study/fit/beside.h"
#include "host/base/xmalloc.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/elements/wheel.h"
#include "host/sim/scene/scene.h"

#define SETTLE_S 1e-3
#define CLEAR    0.98 /* of the chain's longest step: its check is in other roundings */

bool beside_can(const struct sim_scene *scene)
{
    bool plain = scene->model == SIM_CHAIN && scene->thrust == SIM_JUMP && scene->slack_ft > 0.0 &&
                 scene->left == SIM_FIXED && scene->right == SIM_FIXED && scene->cl_lb_s_ft > 0.0 &&
                 (scene->friction_law == SIM_STICK || scene->friction_law == SIM_SIGN) &&
                 scene->friction_normal == SIM_WEIGHT && !mods_any(scene);
    for (int i = 0; i < SIM_ELEMENTS_MAX; i++)
        plain = plain && !(scene->element[i] > 0.0);
    return plain && !(scene->wheel_load_lb > 0.0) && !(fabs(scene->v0_ft_s) > 0.0) &&
           scene->path_count > 1 && !(scene->path[0].t_s < 0.0) && scene->ground_ft.count == 0 &&
           isinf(scene->force_stop_s) && scene->mats >= 2 && scene->mats <= (int)MR_CHAIN_MATS &&
           isfinite(sim_scene_end_s(scene));
}

size_t beside_samples(const struct sim_scene *scene, double dt_s)
{
    return (size_t)(sim_scene_end_s(scene) / dt_s + 1e-9) + 1;
}

struct playing {
    const struct sim_scene *scene;
    struct beside_lane *lane;
    struct chains *chains;
    struct sim_wheel wheel;
    double step_s;
    unsigned steps; /* until bays at rest go to sleep */
    unsigned station_mat[MR_CHAIN_MATS];
    size_t stations;
};

static struct mr_chain_params params_of(const struct sim_scene *scene,
                                        const struct beside_lane *lane)
{
    return (struct mr_chain_params){
        .mats = (uint16_t)scene->mats,
        .mat_length_ft = (float)scene->length_ft,
        .mass_slug = (float)(scene->weight_lb / scene->g_ft_s2),
        .friction_lb = (float)(lane->friction * scene->weight_lb),
        .kl_lb_ft = (float)lane->kl_lb_ft,
        .cl_lb_s_ft = (float)scene->cl_lb_s_ft,
        .slack_ft = (float)scene->slack_ft,
    };
}

static bool start(struct playing *p)
{
    size_t joints = (size_t)p->scene->mats + 1;
    struct mr_chain_params params[CHAINS_LANES];
    const float *gap[CHAINS_LANES], *grit[CHAINS_LANES];
    enum mr_status status;
    double limit_s = (double)INFINITY;
    float *values = xcalloc(2 * CHAINS_LANES * joints, sizeof *values);
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        float *gap_ft = values + 2 * k * joints, *grit_lb = gap_ft + joints;
        params[k] = params_of(p->scene, &p->lane[k]);
        limit_s = fmin(limit_s, (double)mr_chain_step_limit_s(&params[k]));
        for (size_t j = 0; j < joints; j++) {
            gap_ft[j] = (float)p->lane[k].gap_ft[j];
            grit_lb[j] = (float)p->lane[k].grit_lb[j];
        }
        gap[k] = gap_ft;
        grit[k] = grit_lb;
    }
    p->steps = (unsigned)ceil(SETTLE_S / (CLEAR * (double)MR_CHAIN_STEP_MARGIN * limit_s));
    p->step_s = SETTLE_S / p->steps;
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        params[k].step_s = (float)p->step_s;
    p->chains = isfinite(limit_s) ? chains_new(params, gap, grit, &status) : NULL;
    free(values);
    return p->chains != NULL;
}

/* Where the thrust of a step goes: to the mat that has most of it. Gives the path's thrust. */
static double thrust_of(struct playing *p, double from_s, unsigned *mat)
{
    struct sim_touch touch[SIM_WHEEL_TOUCHES];
    int count = sim_wheel_span(&p->wheel, from_s, from_s + p->step_s, touch);
    double sum = 0.0, most = -1.0;
    *mat = 1;
    for (int i = 0; i < count; i++) {
        sum += touch[i].thrust_lb;
        if (touch[i].load_share > most) {
            most = touch[i].load_share;
            *mat = (unsigned)touch[i].mat;
        }
    }
    return sum;
}

static void take_sample(const struct playing *p, size_t row)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        for (size_t s = 0; s < p->stations; s++)
            p->lane[k].sample_u_ft[row * p->stations + s] =
                (double)chains_displacement_ft(p->chains, k, p->station_mat[s]);
    }
}

/* Nothing moves any more: what is left is as it is. */
static bool is_over(const struct playing *p, double t_s)
{
    return sim_wheel_is_over(&p->wheel, t_s) && chains_mats_awake(p->chains) == 0;
}

static unsigned march(struct playing *p, size_t samples, unsigned each)
{
    unsigned away = 0, mat[CHAINS_LANES];
    float thrust_lb[CHAINS_LANES];
    bool over = false;
    take_sample(p, 0);
    for (size_t row = 1; row < samples; row++) {
        for (unsigned n = 0; n < each && !over; n++) {
            size_t block = (row - 1) * each + n;
            for (unsigned i = 0; i < p->steps; i++) {
                double t_s = SETTLE_S * (double)block + p->step_s * i, lb;
                lb = thrust_of(p, t_s, &mat[0]);
                for (unsigned k = 0; k < CHAINS_LANES; k++) {
                    mat[k] = mat[0];
                    thrust_lb[k] = (float)(lb * p->lane[k].thrust);
                }
                chains_step(p->chains, mat, thrust_lb);
            }
            away |= chains_settle(p->chains);
            over = is_over(p, SETTLE_S * (double)(block + 1));
        }
        take_sample(p, row);
    }
    return away;
}

bool beside_run(const struct sim_scene *scene, const double *station_ft, size_t stations,
                double sample_dt_s, struct beside_lane lane[CHAINS_LANES])
{
    struct playing p = {.scene = scene, .lane = lane, .stations = stations};
    if (stations > MR_CHAIN_MATS || !start(&p))
        return false;
    sim_wheel_start(&p.wheel, scene);
    for (size_t s = 0; s < stations; s++) {
        int mat = (int)floor(station_ft[s] / scene->length_ft + 1e-9) + 1;
        p.station_mat[s] = (unsigned)(mat > scene->mats ? scene->mats : mat);
    }
    unsigned away = march(&p, beside_samples(scene, sample_dt_s),
                          (unsigned)(sample_dt_s / SETTLE_S + 0.5));
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        lane[k].good = !(away >> k & 1u);
        for (int j = 0; j <= scene->mats; j++)
            lane[k].gap_ft[j] = fmax((double)chains_opening_ft(p.chains, k, (unsigned)j + 1u), 0.0);
    }
    chains_free(p.chains);
    return true;
}
