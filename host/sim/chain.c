#include "host/sim/chain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define ARRAYS 7

enum mr_status chain_make(struct chain *chain, const struct sim_scene *scene, int first_mat,
                          struct error *error)
{
    size_t length = (size_t)scene->mats + 2;
    double *storage = calloc(ARRAYS * length, sizeof *storage);
    if (!storage)
        return error_set(error, MR_FULL, "out of memory: a chain of %d mats; use a smaller N", scene->mats);
    *chain = (struct chain){
        .mats = scene->mats,
        .damped = scene->cl_lb_s_ft > 0.0,
        .left_free = scene->left == SIM_FREE,
        .right_free = scene->right == SIM_FREE,
        .friction = scene->friction > 0.0 ? scene->friction_law : SIM_NONE,
        .veps_ft_s = scene->veps_ft_s,
        .mass_slug = scene->weight_lb / scene->g_ft_s2,
        .kl_lb_ft = scene->kl_lb_ft,
        .cl_lb_s_ft = scene->cl_lb_s_ft,
        .slack_ft = scene->slack_ft,
        .weight_limit_lb = scene->friction * scene->weight_lb,
        .load_limit_lb = scene->friction * scene->wheel_load_lb,
        .v0_ft_s = scene->v0_ft_s,
        .v0_mat = scene->v0_mat > 0 ? scene->v0_mat : first_mat,
        .storage = storage,
        .u_ft = storage,
        .v_ft_s = storage + length,
        .gap0_ft = storage + 2 * length,
        .grit_lb = storage + 3 * length,
        .reach_ft = storage + 4 * length,
        .thrust_lb = storage + 5 * length,
        .limit_lb = storage + 6 * length,
    };
    bool grit = false;
    for (int j = 1; j <= chain->mats + 1; j++)
        grit = grit || sim_scene_joint(&scene->grit_lb, j) > 0.0;
    chain->joints = scene->slack_ft <= 0.0 ? CHAIN_LINEAR : grit ? CHAIN_GRIT : CHAIN_SLACK;
    chain_reset(chain, scene);
    return MR_OK;
}

void chain_reset(struct chain *chain, const struct sim_scene *scene)
{
    memset(chain->storage, 0, ARRAYS * ((size_t)chain->mats + 2) * sizeof *chain->storage);
    for (int j = 1; j <= chain->mats + 1; j++) {
        chain->gap0_ft[j] = sim_scene_joint(&scene->gap0_ft, j);
        chain->grit_lb[j] = sim_scene_joint(&scene->grit_lb, j);
        chain->reach_ft[j] = fmin(fmax(chain->gap0_ft[j], 0.0), chain->slack_ft);
    }
    for (int n = 1; n <= chain->mats; n++)
        chain->limit_lb[n] = chain->weight_limit_lb;
    chain->v_ft_s[chain->v0_mat] = chain->v0_ft_s;
}

void chain_free(struct chain *chain)
{
    free(chain->storage);
    *chain = (struct chain){0};
}

void chain_touch(struct chain *chain, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        chain->thrust_lb[touch[i].mat] += touch[i].thrust_lb;
        chain->limit_lb[touch[i].mat] += chain->load_limit_lb * touch[i].load_share;
    }
}

void chain_release(struct chain *chain, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        chain->thrust_lb[touch[i].mat] = 0.0;
        chain->limit_lb[touch[i].mat] = chain->weight_limit_lb;
    }
}

double chain_opening_ft(const struct chain *chain, int joint)
{
    return chain->gap0_ft[joint] + (chain->u_ft[joint] - chain->u_ft[joint - 1]);
}

/* Tension in joint j whose mats move at vl and vr; moves the grit's reach. */
static inline __attribute__((always_inline)) double
joint_lb(struct chain *chain, int j, double vl_ft_s, double vr_ft_s, enum chain_joints joints, bool damped)
{
    double g_ft = chain_opening_ft(chain, j);
    double damper_lb = damped ? chain->cl_lb_s_ft * (vr_ft_s - vl_ft_s) : 0.0;
    if (joints == CHAIN_LINEAR)
        return chain->kl_lb_ft * g_ft + damper_lb;
    if (g_ft > chain->slack_ft) {
        chain->reach_ft[j] = chain->slack_ft;
        return chain->kl_lb_ft * (g_ft - chain->slack_ft) + damper_lb;
    }
    if (joints == CHAIN_GRIT) {
        double grit_lb = chain->grit_lb[j];
        double reach_ft = chain->reach_ft[j];
        if (g_ft >= reach_ft) {
            chain->reach_ft[j] = g_ft;
            return 0.0;
        }
        if (reach_ft > 0.0) {
            double held_lb = chain->kl_lb_ft * (g_ft - reach_ft);
            if (held_lb >= -grit_lb)
                return fmin(0.0, fmax(-grit_lb, held_lb + damper_lb));
            reach_ft = fmax(0.0, g_ft + grit_lb / chain->kl_lb_ft);
            chain->reach_ft[j] = reach_ft;
            if (reach_ft > 0.0)
                return -grit_lb;
        }
    }
    return g_ft < 0.0 ? chain->kl_lb_ft * g_ft + damper_lb : 0.0;
}

/* Speed after h under force x and Coulomb limit c, both constant over h. */
static inline __attribute__((always_inline)) double stick_slip(double v_ft_s, double x_lb, double c_lb,
                                                               double h_s, double mass_slug, unsigned *stops)
{
    if (v_ft_s == 0.0)
        return fabs(x_lb) <= c_lb ? 0.0 : (x_lb - copysign(c_lb, x_lb)) * (h_s / mass_slug);
    double brake_lb = x_lb - copysign(c_lb, v_ft_s);
    double after_ft_s = v_ft_s + brake_lb * (h_s / mass_slug);
    if (after_ft_s * v_ft_s > 0.0)
        return after_ft_s;
    ++*stops;
    if (fabs(x_lb) <= c_lb)
        return 0.0;
    double left_s = h_s + v_ft_s * mass_slug / brake_lb; /* brake and speed have opposite signs */
    return (x_lb - copysign(c_lb, x_lb)) * (left_s / mass_slug);
}

static inline __attribute__((always_inline)) unsigned kick(struct chain *chain, double h_s, int first,
                                                           int last, enum chain_joints joints, bool damped,
                                                           enum sim_friction friction)
{
    double *v = chain->v_ft_s;
    double mass = chain->mass_slug;
    unsigned stops = 0;
    double left_lb =
        first == 1 && chain->left_free ? 0.0 : joint_lb(chain, first, v[first - 1], v[first], joints, damped);
    for (int n = first; n <= last; n++) {
        double right_lb = n == chain->mats && chain->right_free
                              ? 0.0
                              : joint_lb(chain, n + 1, v[n], v[n + 1], joints, damped);
        double x_lb = right_lb - left_lb + chain->thrust_lb[n];
        double c_lb = chain->limit_lb[n];
        left_lb = right_lb;
        switch (friction) {
        case SIM_STICK:
            v[n] = stick_slip(v[n], x_lb, c_lb, h_s, mass, &stops);
            break;
        case SIM_TANH:
            v[n] += (x_lb - c_lb * tanh(v[n] / chain->veps_ft_s)) * (h_s / mass);
            break;
        case SIM_SIGN:
            v[n] += (x_lb - (v[n] > 0.0 ? c_lb : v[n] < 0.0 ? -c_lb : 0.0)) * (h_s / mass);
            break;
        case SIM_NONE:
            v[n] += x_lb * (h_s / mass);
            break;
        }
    }
    return stops;
}

/* The frequent cases get a loop of their own in which everything absent is left out at compile time. */
unsigned chain_kick(struct chain *chain, double h_s, int first, int last)
{
    if (chain->friction != SIM_STICK)
        return kick(chain, h_s, first, last, chain->joints, chain->damped, chain->friction);
    switch (chain->joints) {
    case CHAIN_LINEAR:
        return chain->damped ? kick(chain, h_s, first, last, CHAIN_LINEAR, true, SIM_STICK)
                             : kick(chain, h_s, first, last, CHAIN_LINEAR, false, SIM_STICK);
    case CHAIN_SLACK:
        return chain->damped ? kick(chain, h_s, first, last, CHAIN_SLACK, true, SIM_STICK)
                             : kick(chain, h_s, first, last, CHAIN_SLACK, false, SIM_STICK);
    case CHAIN_GRIT:
        break;
    }
    return chain->damped ? kick(chain, h_s, first, last, CHAIN_GRIT, true, SIM_STICK)
                         : kick(chain, h_s, first, last, CHAIN_GRIT, false, SIM_STICK);
}

/* How far joint j's spring is stretched (or pressed). */
static double stretch_ft(const struct chain *chain, int j)
{
    double g_ft = chain_opening_ft(chain, j);
    if ((j == 1 && chain->left_free) || (j == chain->mats + 1 && chain->right_free))
        return 0.0;
    if (chain->joints == CHAIN_LINEAR)
        return g_ft;
    if (g_ft > chain->slack_ft)
        return g_ft - chain->slack_ft;
    return fmin(0.0, g_ft - (chain->joints == CHAIN_GRIT ? chain->reach_ft[j] : 0.0));
}

double chain_energy_lb_ft(const struct chain *chain, int first, int last)
{
    double kinetic = 0.0, elastic = 0.0;
    for (int n = first; n <= last; n++)
        kinetic += chain->v_ft_s[n] * chain->v_ft_s[n];
    for (int j = first; j <= last + 1; j++) {
        double e_ft = stretch_ft(chain, j);
        elastic += e_ft * e_ft;
    }
    return 0.5 * (chain->mass_slug * kinetic + chain->kl_lb_ft * elastic);
}

/* A mode of rate w and damping d moves by z^2 - (2 - h d - h^2 w^2) z + (1 - h d): inside the unit circle
 * while h^2 w^2 + 2 h d < 4. Largest w^2 and d of a chain of equal mats: 4 KL/m and 4 CL/m, with both ends
 * of every mat joined; a steep tanh adds its own slope. */
double chain_step_limit_s(const struct chain *chain)
{
    int ends = (chain->left_free ? 0 : 1) + (chain->right_free ? 0 : 1);
    double joints = chain->mats > 1 ? 4.0 : ends;
    double rate2 = joints * chain->kl_lb_ft / chain->mass_slug;
    double damping = joints * chain->cl_lb_s_ft / chain->mass_slug;
    if (chain->friction == SIM_TANH)
        damping += (chain->weight_limit_lb + chain->load_limit_lb) / (chain->mass_slug * chain->veps_ft_s);
    return 4.0 / (damping + sqrt(damping * damping + 4.0 * rate2));
}

void chain_describe(const struct chain *chain, const struct sim_scene *scene, struct sim_result *result)
{
    sim_result_leave_out(result, "vertical motion and rotation (model chain)");
    if (chain->friction == SIM_NONE)
        sim_result_leave_out(result, "friction (none)");
    if (!chain->damped)
        sim_result_leave_out(result, "joint damping (CL 0)");
    if (chain->joints == CHAIN_LINEAR)
        sim_result_leave_out(result, "slack (0)");
    if (chain->joints != CHAIN_GRIT)
        sim_result_leave_out(result, scene->slack_ft > 0.0 ? "grit (0 on every joint)"
                                                           : "grit (slack 0: no joint can be open)");
    else
        sim_result_note(result, "grit: an opened joint opens freely and needs its grit again to close");
    if (scene->path_count > 0)
        sim_result_note(result, "path replaces Vac, s0 and F");
    if (scene->v0_ft_s != 0.0)
        sim_result_note(result, "mat %d starts at %g ft/s (v0)", chain->v0_mat, scene->v0_ft_s);
    if (scene->bump_ft.count > 0)
        sim_result_note(result, "bump has no effect on flat mats (model chain)");
    int stressed = 0;
    for (int j = 1; j <= chain->mats + 1; j++)
        stressed += stretch_ft(chain, j) != 0.0;
    if (stressed > 0)
        sim_result_note(result, "%d joints start under load (gap0 below 0 or beyond slack)", stressed);
}
