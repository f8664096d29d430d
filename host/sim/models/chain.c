#include "host/sim/models/chain.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/sim/elements/friction.h"

#define ARRAYS    12
#define BLOCK     4 /* mats and joints are computed in whole blocks, with padding at both ends */
#define PADDING   8
#define ALIGNMENT 64

/* The same arithmetic four mats at a time where the processor can, two at a time where not. */
#if defined __x86_64__ && defined __GNUC__ && !defined __clang__
#define CHAIN_CLONES __attribute__((target_clones("avx2", "default")))
#define VECTORS      _Pragma("GCC ivdep")
#else
#define CHAIN_CLONES
#define VECTORS
#endif
void chain_make(struct chain *chain, const struct sim_scene *scene, int first_mat)
{
    size_t length = ((size_t)scene->mats + 2 + PADDING - 1) / PADDING * PADDING + 2 * PADDING;
    double *storage = xaligned_alloc(ALIGNMENT, ARRAYS * length * sizeof *storage);
    double *first = storage + PADDING; /* mat 0 */
    *chain = (struct chain){
        .mats = scene->mats,
        .damped = scene->cl_lb_s_ft > 0.0,
        .left_free = scene->left == SIM_FREE,
        .right_free = scene->right == SIM_FREE,
        .friction = scene->friction > 0.0 ? scene->friction_law : SIM_NONE,
        .veps_ft_s = scene->veps_ft_s,
        .mass_slug = scene->weight_lb / scene->g_ft_s2,
        .joint = {scene->kl_lb_ft, scene->cl_lb_s_ft, scene->slack_ft},
        .weight_limit_lb = scene->friction * scene->weight_lb,
        .load_limit_lb = scene->friction * scene->wheel_load_lb,
        .v0_ft_s = scene->v0_ft_s,
        .v0_mat = scene->v0_mat > 0 ? scene->v0_mat : first_mat,
        .elements = element_set_of(scene),
        .storage = storage,
        .length = length,
        .u_ft = first,
        .v_ft_s = first + length,
        .gap0_ft = first + 2 * length,
        .hold_lb = first + 3 * length,
        .reach_ft = first + 4 * length,
        .thrust_lb = first + 5 * length,
        .limit_lb = first + 6 * length,
        .give_ft = first + 7 * length,
        .tension_lb = first + 8 * length,
        .before_ft_s = first + 9 * length,
        .push_lb = first + 10 * length,
        .pull_lb = first + 11 * length,
    };
    bool grit = false;
    for (int j = 1; j <= chain->mats + 1; j++)
        grit = grit || sim_scene_joint(&scene->grit_lb, j) > 0.0;
    chain->joints = joint_law(scene->slack_ft, grit);
    chain->sticks = chain->friction == SIM_STICK && chain->elements.count == 0;
    chain->mods = mods_make(scene);
    chain->gear = gear_make(scene);
    chain_reset(chain, scene);
}

/* Coulomb limit of a mat without the wheel. */
static double bare_limit_lb(const struct chain *chain, int mat)
{
    return chain->weight_limit_lb + (chain->mods ? mods_cleat_lb(chain->mods, mat) : 0.0);
}

void chain_reset(struct chain *chain, const struct sim_scene *scene)
{
    memset(chain->storage, 0, ARRAYS * chain->length * sizeof *chain->storage);
    for (int j = 1; j <= chain->mats + 1; j++) {
        chain->gap0_ft[j] = sim_scene_joint(&scene->gap0_ft, j);
        double grit_lb = sim_scene_joint(&scene->grit_lb, j);
        chain->hold_lb[j] = -grit_lb;
        chain->give_ft[j] = grit_lb / chain->joint.kl_lb_ft;
        chain->reach_ft[j] = joint_first_reach_ft(chain->gap0_ft[j], chain->joint.slack_ft);
    }
    for (size_t i = 0; i < chain->length; i++)
        (chain->limit_lb - PADDING)[i] = (double)INFINITY; /* what is no mat never moves */
    if (chain->mods)
        mods_reset(chain->mods);
    for (int n = 1; n <= chain->mats; n++)
        chain->limit_lb[n] = bare_limit_lb(chain, n);
    chain->v_ft_s[chain->v0_mat] = chain->v0_ft_s;
}

void chain_free(struct chain *chain)
{
    mods_free(chain->mods);
    gear_free(chain->gear);
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

static __attribute__((noinline)) void release_cleats(struct chain *chain,
                                                     const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++)
        chain->limit_lb[touch[i].mat] = bare_limit_lb(chain, touch[i].mat);
}

void chain_release(struct chain *chain, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        chain->thrust_lb[touch[i].mat] = 0.0;
        chain->limit_lb[touch[i].mat] = chain->weight_limit_lb;
    }
    if (chain->mods)
        release_cleats(chain, touch, count);
}

/* Force on mat n without its friction. */
static inline __attribute__((always_inline)) double push_lb(const struct chain *chain, int n)
{
    return chain->tension_lb[n + 1] - chain->tension_lb[n] + chain->thrust_lb[n];
}

struct mods_view chain_view(const struct chain *chain)
{
    return (struct mods_view){chain->u_ft, chain->v_ft_s, 1, 0, chain->tension_lb, 0};
}

void chain_brace(struct chain *chain, double h_s, const struct sim_touch *touch, int count,
                 int *first, int *last)
{
    struct mods *mods = chain->mods;
    struct mods_view view = chain_view(chain);
    if (mods->cleated) {
        mods_wear_cleats(mods, &view, h_s, *first, *last);
        for (int i = 0; i < mods->cleats; i++) {
            int mat = mods_cleat_mat(mods->scene, i);
            bool loaded = false;
            for (int k = 0; k < count; k++)
                loaded = loaded || touch[k].mat == mat; /* has its limit anew at every step */
            if (mat >= *first && mat <= *last && !loaded)
                chain->limit_lb[mat] = bare_limit_lb(chain, mat);
        }
    }
    if (!mods->banded)
        return;
    mods_pull_bands(mods, &view, touch, count);
    for (int c = 0; c < mods->braces; c++) {
        int mat = mods->brace_mat[c];
        mods->saved_lb[c] = chain->thrust_lb[mat];
        chain->thrust_lb[mat] += mods->carried_lb[c];
        if ((mat < *first || mat > *last) && fabs(push_lb(chain, mat)) > chain->limit_lb[mat]) {
            *first = mat - 1 < *first ? (mat > 1 ? mat - 1 : 1) : *first;
            *last = mat + 1 > *last ? (mat < chain->mats ? mat + 1 : mat) : *last;
        }
    }
}

void chain_unbrace(struct chain *chain)
{
    struct mods *mods = chain->mods;
    for (int c = 0; mods->banded && c < mods->braces; c++)
        chain->thrust_lb[mods->brace_mat[c]] = mods->saved_lb[c];
}

double chain_opening_ft(const struct chain *chain, int joint)
{
    return chain->gap0_ft[joint] + (chain->u_ft[joint] - chain->u_ft[joint - 1]);
}

/* First of the block that index i lies in. */
static int block_of(int i)
{
    return i / BLOCK * BLOCK;
}

/* Tensions of `count` joints (whole blocks) from the present openings and speeds; moves the grit's
 * reach. No joint depends on another's result. */
LAW_INLINE void pull(const struct chain *chain, int first, size_t count, enum joint_law joints,
                     bool damped)
{
    const double *u = chain->u_ft + first, *left_u = u - 1;
    const double *v = chain->v_ft_s + first, *left_v = v - 1;
    const double *gap0 = chain->gap0_ft + first, *hold = chain->hold_lb + first;
    const double *give = chain->give_ft + first;
    double *reach = chain->reach_ft + first, *tension = chain->tension_lb + first;
    const struct joint joint = chain->joint;
    VECTORS
    for (size_t j = 0; j < count / BLOCK * BLOCK; j++) {
        double g_ft = gap0[j] + (u[j] - left_u[j]);
        double damper_lb = damped ? joint.cl_lb_s_ft * (v[j] - left_v[j]) : 0.0;
        bool gritty = joints == JOINT_GRIT;
        struct joint_grit grit = {gritty ? hold[j] : 0.0, gritty ? give[j] : 0.0,
                                  gritty ? reach[j] : 0.0};
        struct joint_pull pulled = joint_pull(joints, &joint, g_ft, damper_lb, grit);
        tension[j] = pulled.lb;
        if (gritty)
            reach[j] = pulled.reach_ft;
    }
}

/* Every law that occurs gets a loop of its own, in which all that is absent is left out. */
CHAIN_CLONES static void pull_joints(const struct chain *chain, int first, size_t count)
{
    if (chain->joints == JOINT_LINEAR && chain->damped)
        pull(chain, first, count, JOINT_LINEAR, true);
    else if (chain->joints == JOINT_LINEAR)
        pull(chain, first, count, JOINT_LINEAR, false);
    else if (chain->joints == JOINT_SLACK && chain->damped)
        pull(chain, first, count, JOINT_SLACK, true);
    else if (chain->joints == JOINT_SLACK)
        pull(chain, first, count, JOINT_SLACK, false);
    else if (chain->damped)
        pull(chain, first, count, JOINT_GRIT, true);
    else
        pull(chain, first, count, JOINT_GRIT, false);
}

struct stops {
    int64_t all;
    int64_t thrown_back; /* of them: those whose speed is not yet right */
};

/* Friction stick: mats at rest, moving and stopping, like the joints without a branch. */
CHAIN_CLONES static struct stops stick_mats(const struct chain *chain, double h_s, int first,
                                            size_t count)
{
    const double *left = chain->tension_lb + first, *right = left + 1;
    const double *thrust = chain->thrust_lb + first, *limit = chain->limit_lb + first;
    double *v = chain->v_ft_s + first, *before = chain->before_ft_s + first;
    double per_lb = h_s / chain->mass_slug;
    int64_t all = 0, at_rest = 0;
    VECTORS
    for (size_t n = 0; n < count / BLOCK * BLOCK; n++) {
        double v_ft_s = v[n];
        double x_lb = right[n] - left[n] + thrust[n];
        struct friction_step step = friction_step(v_ft_s, x_lb, limit[n], per_lb);
        before[n] = v_ft_s;
        v[n] = step.after_ft_s;
        all += step.stops;
        at_rest += step.stops & step.held;
    }
    return (struct stops){all, all - at_rest};
}

static unsigned stick(const struct chain *chain, double h_s, int first, int last)
{
    int block = block_of(first);
    struct stops stops = stick_mats(chain, h_s, block, (size_t)(block_of(last) + BLOCK - block));
    for (int n = first; stops.thrown_back > 0 && n <= last; n++) {
        double v_ft_s = chain->before_ft_s[n];
        double x_lb = push_lb(chain, n);
        bool stopped = v_ft_s != 0.0 && !(chain->v_ft_s[n] * v_ft_s > 0.0);
        if (!stopped || fabs(x_lb) <= chain->limit_lb[n])
            continue;
        chain->v_ft_s[n] = friction_thrown_back_ft_s(v_ft_s, x_lb, chain->limit_lb[n], h_s,
                                                     chain->mass_slug);
        stops.thrown_back--;
    }
    return (unsigned)stops.all;
}

/* Rates under the other laws do not stop a mat. */
static void slide(const struct chain *chain, double h_s, int first, int last)
{
    double *v = chain->v_ft_s;
    double per_lb = h_s / chain->mass_slug;
    for (int n = first; n <= last; n++) {
        double smooth = chain->friction == SIM_TANH ? tanh(v[n] / chain->veps_ft_s) : 0.0;
        v[n] += (push_lb(chain, n) -
                 friction_rub_lb(chain->friction, chain->limit_lb[n], v[n], 0, smooth)) *
                per_lb;
    }
}

/* Each mat under the gear again, from its speed before the kick, with the ground that holds it in
 * Coulomb's place. */
static void ride(const struct chain *chain, double h_s)
{
    struct gear *gear = chain->gear;
    for (int i = 0; i < gear->loaded_count; i++) {
        int n = gear->loaded[i];
        double v_ft_s = chain->before_ft_s[n];
        struct element_step step = {1.0, h_s, 0.0};
        if (gear->others.count > 0)
            step = element_step(&gear->others, (struct element_mat){v_ft_s, true}, h_s,
                                chain->mass_slug);
        double limit_lb = chain->friction == SIM_NONE ? 0.0 : chain->limit_lb[n];
        chain->v_ft_s[n] = gear_speed_ft_s(
            gear, n, step.keep * v_ft_s, push_lb(chain, n) + step.push_lb, limit_lb, step.as_if_s);
    }
}

/* With elements: every mat by itself. */
static __attribute__((noinline)) unsigned kick_elements(const struct chain *chain, double h_s,
                                                        int first, int last)
{
    double *v = chain->v_ft_s, mass = chain->mass_slug;
    unsigned stops = 0;
    const struct element_set *set = chain->gear ? &chain->gear->others : &chain->elements;
    if (chain->gear && set->count == 0 && chain->friction == SIM_STICK) {
        stops = stick(chain, h_s, first, last);
        ride(chain, h_s);
        return stops;
    }
    for (int n = first; n <= last; n++) {
        struct element_step step = element_step(set, (struct element_mat){v[n], true}, h_s, mass);
        double x_lb = push_lb(chain, n) + step.push_lb, kept = step.keep * v[n];
        double smooth = chain->friction == SIM_TANH ? tanh(v[n] / chain->veps_ft_s) : 0.0;
        chain->before_ft_s[n] = v[n];
        if (chain->friction == SIM_STICK)
            v[n] = friction_speed_ft_s(kept, x_lb, chain->limit_lb[n], step.as_if_s, mass, &stops);
        else
            v[n] = kept +
                   (x_lb - friction_rub_lb(chain->friction, chain->limit_lb[n], v[n], 0, smooth)) *
                       (step.as_if_s / mass);
    }
    if (chain->gear)
        ride(chain, h_s);
    return stops;
}

static __attribute__((noinline)) void brace_joints(const struct chain *chain, int first, int last)
{
    struct mods_view view = chain_view(chain);
    if (chain->mods->jointed)
        mods_pull_joints(chain->mods, &view, first, last);
}

unsigned chain_kick(struct chain *chain, double h_s, int first, int last)
{
    int block = block_of(first);
    pull_joints(chain, block, (size_t)(block_of(last + 1) + BLOCK - block));
    if (chain->left_free)
        chain->tension_lb[1] = 0.0;
    if (chain->right_free)
        chain->tension_lb[chain->mats + 1] = 0.0;
    if (chain->mods)
        brace_joints(chain, block, block_of(last + 1) + BLOCK - 1);
    if (chain->sticks)
        return stick(chain, h_s, first, last);
    if (chain->elements.count > 0)
        return kick_elements(chain, h_s, first, last);
    slide(chain, h_s, first, last);
    return 0;
}

CHAIN_CLONES void chain_drift(struct chain *chain, double h_s, int first, int last)
{
    int block = block_of(first);
    size_t count = (size_t)(block_of(last) + BLOCK - block);
    double *u = chain->u_ft + block;
    const double *v = chain->v_ft_s + block;
    VECTORS
    for (size_t n = 0; n < count / BLOCK * BLOCK; n++)
        u[n] += h_s * v[n];
}

CHAIN_CLONES void chain_note(struct chain *chain, int first, int last)
{
    const double *tension = chain->tension_lb;
    double *push = chain->push_lb, *pull_lb = chain->pull_lb;
    VECTORS
    for (int j = first; j <= last + 1; j++) {
        push[j] = law_most(push[j], -tension[j]);
        pull_lb[j] = law_most(pull_lb[j], tension[j]);
    }
}

/* How far joint j's spring is stretched (or pressed). */
static double stretch_ft(const struct chain *chain, int j)
{
    double g_ft = chain_opening_ft(chain, j);
    if ((j == 1 && chain->left_free) || (j == chain->mats + 1 && chain->right_free))
        return 0.0;
    bool torn = chain->mods && mods_is_torn(chain->mods, j);
    if (torn && g_ft > fmax(0.0, chain->joint.slack_ft))
        return 0.0;
    return joint_stretch_ft(chain->joints, g_ft, chain->joint.slack_ft, chain->reach_ft[j]);
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
    double braced = 0.0;
    if (chain->mods) {
        struct mods_view view = chain_view(chain);
        braced = mods_energy_lb_ft(chain->mods, &view);
    }
    return 0.5 * (chain->mass_slug * kinetic + chain->joint.kl_lb_ft * elastic) + braced;
}

/* A mode of rate w and damping d moves by z^2 - (2 - h d - h^2 w^2) z + (1 - h d): inside the unit
 * circle while h^2 w^2 + 2 h d < 4. Largest w^2 and d of a chain of equal mats: 4 KL/m and 4 CL/m,
 * with both ends of every mat joined; a steep tanh adds its own slope. Elements of the table are
 * exact within the kick and set no limit: the factor keep on the speed and the shorter as_if_s make
 * the left side smaller. */
double chain_step_limit_s(const struct chain *chain)
{
    int ends = (chain->left_free ? 0 : 1) + (chain->right_free ? 0 : 1);
    double joints = chain->mats > 1 ? 4.0 : ends;
    struct law_bound pulled = joint_bound(&chain->joint, joints, chain->mass_slug);
    struct law_bound rubbed = friction_bound(chain->friction,
                                             chain->weight_limit_lb + chain->load_limit_lb,
                                             chain->mass_slug, chain->veps_ft_s);
    double rate2 = pulled.rate2, damping = pulled.damping + rubbed.damping;
    if (chain->mods)
        rate2 += mods_stiffness_lb_ft(chain->mods) / chain->mass_slug;
    return 4.0 / (damping + sqrt(damping * damping + 4.0 * rate2));
}

void chain_describe(const struct chain *chain, const struct sim_scene *scene,
                    struct sim_result *result)
{
    sim_result_leave_out(result, "vertical motion and rotation (model chain)");
    if (chain->friction == SIM_NONE)
        sim_result_leave_out(result, "friction (none)");
    if (!chain->damped)
        sim_result_leave_out(result, "joint damping (CL 0)");
    if (chain->joints == JOINT_LINEAR)
        sim_result_leave_out(result, "slack (0)");
    if (chain->joints != JOINT_GRIT)
        sim_result_leave_out(result, scene->slack_ft > 0.0
                                         ? "grit (0 on every joint)"
                                         : "grit (slack 0: no joint can be open)");
    else
        sim_result_note(result,
                        "grit: an opened joint opens freely and needs its grit again to close");
    if (chain->mods)
        mods_describe(chain->mods, result);
    if (scene->path_count > 0)
        sim_result_note(result, "path replaces Vac, s0 and F");
    if (scene->v0_ft_s != 0.0)
        sim_result_note(result, "mat %d starts at %g ft/s (v0)", chain->v0_mat, scene->v0_ft_s);
    if (scene->bump_ft.count > 0)
        sim_result_note(result, "bump has no effect on flat mats (model chain)");
    element_describe(&chain->elements, result);
    int stressed = 0;
    for (int j = 1; j <= chain->mats + 1; j++)
        stressed += stretch_ft(chain, j) != 0.0;
    if (stressed > 0)
        sim_result_note(result, "%d joints start under load (gap0 below 0 or beyond slack)",
                        stressed);
}
