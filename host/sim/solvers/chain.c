#include "host/sim/solvers/chain.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/elementary.h"
#include "host/base/monotonic_clock.h"
#include "host/base/parallel_for.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/element.h"
#include "host/sim/elements/law.h"
#include "host/sim/elements/gear.h"
#include "host/sim/elements/mods.h"
#include "host/sim/elements/wheel.h"
#include "host/sim/scene/result.h"
#include "host/sim/solvers/chain_event.h"

#define LANES_DOUBLE
#include "host/sim/elements/lanes.h"

/* The horizontal equations of a whole runway: README.md, "Common pieces" with theta = 0, and "Chain
 * and landings". Mats 1..N; the ground is at 0 and N+1 and never moves. Joints 1..N+1. */

struct chain {
    int mats;
    int block_size; /* number of mats that the kernels process at once */
    enum joint_law joint_law;
    struct law_joint joint_constants;
    bool is_left_free;
    bool is_right_free;
    enum sim_friction friction;
    /* the friction law is stick, and no other force depends on the speed of a mat */
    bool can_stick;
    bool is_varied; /* joints or mats have different properties (sim_scene_is_varied) */
    /* can_stick is true, the ends are fixed, all mats are equal, and there are no modifications */
    bool has_only_joint_forces;
    double veps_ft_s;
    double mass_slug;
    const struct sim_scene *scene;
    double weight_friction_lb; /* Coulomb limit of a mat without the wheel, f W */
    double load_friction_lb;   /* limit that the wheel adds to a mat, f wheel_load */
    int v0_mat;
    /* memory of all arrays below, each with ARRAY_PADDING unused entries at both ends */
    double *storage;
    size_t array_length; /* length of one array */
    double *u_ft;
    double *v_ft_s;
    double *gap0_ft;
    double *grit_lb;
    double *grit_extent_ft;
    double *thrust_lb;
    double *limit_lb;        /* Coulomb limit of each mat */
    double *grit_yield_ft;   /* compression at which the grit yields: grit/KL */
    double *tension_lb;      /* tension of each joint in the last kick (update of the speeds) */
    double *last_tension_lb; /* tension in the last kick and in the kick before it */
    double *earlier_tension_lb;
    double *previous_v_ft_s;          /* speed of each mat before the last kick */
    double *kl_lb_ft, *mat_mass_slug; /* stiffness of each joint and mass of each mat */
    double *max_compression_lb;       /* largest compression and tension of each joint so far */
    double *max_tension_lb;
    double half_max_tension_lb; /* half of the largest tension so far */
    struct mods *mods;          /* NULL: the scene has no modifications */
    struct element_set elements;
    struct gear *gear; /* NULL: the scene has one axle on rigid ground */
};

#define ARRAY_COUNT 16
#define ARRAY_PADDING \
    8 /* number of unused entries at both ends of an array: the widest block (chain_kernel.h) */
#define ARRAY_ALIGNMENT 64

#define LANES_FILE "host/sim/solvers/chain_kernel.h"
#include "host/sim/elements/lanes_each.h"

/* Coulomb limit of a mat without the wheel. */
static double unloaded_friction_limit_lb(const struct chain *chain, int mat)
{
    double weight_lb = sim_scene_weight_lb(chain->scene, mat);
    return chain->scene->friction * weight_lb +
           (chain->mods ? mods_cleat_hold_lb(chain->mods, mat) : 0.0);
}

static void chain_reset(struct chain *chain, const struct sim_scene *scene)
{
    chain->half_max_tension_lb = 0.0;
    memset(chain->storage, 0, ARRAY_COUNT * chain->array_length * sizeof *chain->storage);
    for (int j = 1; j <= chain->mats + 1; j++) {
        chain->gap0_ft[j] = sim_scene_joint_value(&scene->gap0_ft, j);
        double grit_lb = sim_scene_joint_value(&scene->grit_lb, j);
        chain->grit_lb[j] = grit_lb;
        chain->kl_lb_ft[j] = sim_scene_local_value(scene, SIM_VARIED_KL, scene->kl_lb_ft, j);
        chain->grit_yield_ft[j] = grit_lb / chain->kl_lb_ft[j];
        chain->grit_extent_ft[j] = joint_initial_grit_extent_ft(chain->gap0_ft[j],
                                                                chain->joint_constants.slack_ft);
    }
    for (size_t i = 0; i < chain->array_length; i++) {
        /* entries beyond the mats must never move: their limit is infinite */
        (chain->limit_lb - ARRAY_PADDING)[i] = (double)INFINITY;
        (chain->mat_mass_slug - ARRAY_PADDING)[i] = chain->mass_slug;
    }
    if (chain->mods)
        mods_reset(chain->mods);
    for (int n = 1; n <= chain->mats; n++) {
        chain->limit_lb[n] = unloaded_friction_limit_lb(chain, n);
        chain->mat_mass_slug[n] = sim_scene_weight_lb(scene, n) / scene->g_ft_s2;
        chain->v_ft_s[n] = sim_scene_local_value(scene, SIM_VARIED_V0,
                                                 n == chain->v0_mat ? scene->v0_ft_s : 0.0, n);
    }
}

/* Makes the chain of a scene. `first_mat`: mat under the wheel at t = 0. */
static void chain_make(struct chain *chain, const struct sim_scene *scene, int first_mat)
{
    size_t length = ((size_t)scene->mats + 2 + ARRAY_PADDING - 1) / ARRAY_PADDING * ARRAY_PADDING +
                    2 * ARRAY_PADDING;
    double *storage = xaligned_alloc(ARRAY_ALIGNMENT, ARRAY_COUNT * length * sizeof *storage);
    *chain = (struct chain){
        .scene = scene,
        .mats = scene->mats,
        .is_varied = sim_scene_is_varied(scene),
        .block_size = LANES_CALL(block, ),
        .is_left_free = scene->left_end != SIM_END_FIXED,
        .is_right_free = scene->right_end != SIM_END_FIXED,
        .friction = scene->friction > 0.0 ? scene->friction_law : SIM_FRICTION_NONE,
        .veps_ft_s = scene->veps_ft_s,
        .mass_slug = scene->weight_lb / scene->g_ft_s2,
        .joint_constants = {scene->kl_lb_ft, scene->cl_lb_s_ft, scene->slack_ft},
        .weight_friction_lb = scene->friction * scene->weight_lb,
        .load_friction_lb = scene->friction * scene->wheel_load_lb,
        .v0_mat = scene->v0_mat > 0 ? scene->v0_mat : first_mat,
        .elements = element_set_from_scene(scene),
        .storage = storage,
        .array_length = length,
    };
    double **arrays[ARRAY_COUNT] = {&chain->u_ft,
                                    &chain->v_ft_s,
                                    &chain->gap0_ft,
                                    &chain->grit_lb,
                                    &chain->grit_extent_ft,
                                    &chain->thrust_lb,
                                    &chain->limit_lb,
                                    &chain->grit_yield_ft,
                                    &chain->tension_lb,
                                    &chain->previous_v_ft_s,
                                    &chain->max_compression_lb,
                                    &chain->max_tension_lb,
                                    &chain->last_tension_lb,
                                    &chain->earlier_tension_lb,
                                    &chain->kl_lb_ft,
                                    &chain->mat_mass_slug};
    for (size_t i = 0; i < ARRAY_COUNT; i++)
        /* index 0 of each array belongs to mat 0 */
        *arrays[i] = storage + ARRAY_PADDING + i * length;
    bool grit = false;
    for (int j = 1; j <= chain->mats + 1; j++)
        grit = grit || sim_scene_joint_value(&scene->grit_lb, j) > 0.0;
    chain->joint_law = joint_law(scene->slack_ft, grit);
    chain->mods = mods_make(scene);
    chain->gear = gear_make(scene);
    chain->can_stick = chain->friction == SIM_FRICTION_STICK && chain->elements.count == 0 &&
                       !chain->gear;
    chain->has_only_joint_forces = chain->can_stick && !chain->mods && !chain->is_varied &&
                                   !chain->is_left_free && !chain->is_right_free;
    chain_reset(chain, scene);
}

static void chain_free(struct chain *chain)
{
    mods_free(chain->mods);
    gear_free(chain->gear);
    free(chain->storage);
    *chain = (struct chain){0};
}

/* Adds the wheel's thrust and limits to its mats. chain_remove_load removes them again. */
static void chain_apply_load(struct chain *chain, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        chain->thrust_lb[touch[i].mat] += touch[i].thrust_lb;
        chain->limit_lb[touch[i].mat] += chain->load_friction_lb * touch[i].load_share;
    }
}

static void chain_remove_load(struct chain *chain, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        chain->thrust_lb[touch[i].mat] = 0.0;
        chain->limit_lb[touch[i].mat] = unloaded_friction_limit_lb(chain, touch[i].mat);
    }
}

/* Force on mat n without its friction. */
static inline __attribute__((always_inline)) double push_lb(const struct chain *chain, int n)
{
    return chain->tension_lb[n + 1] - chain->tension_lb[n] + chain->thrust_lb[n];
}

static struct mods_view chain_view(const struct chain *chain)
{
    return (struct mods_view){chain->u_ft, chain->v_ft_s, 1, 0, chain->tension_lb, 0};
}

/* For scenes with modifications. Call before a kick of mats first..last over h_s and after
 * chain_apply_load. Adds the forces of the bands to the riveted mats and reduces the hold of worn
 * cleats. Extends first..last to include riveted mats that now move. Call chain_remove_braces after
 * the kick. */
static void chain_apply_braces(struct chain *chain, double h_s, const struct sim_touch *touch,
                               int count, int *first, int *last)
{
    struct mods *mods = chain->mods;
    struct mods_view view = chain_view(chain);
    if (mods->has_cleats) {
        mods_wear_cleats(mods, &view, h_s, *first, *last);
        for (int i = 0; i < mods->cleat_count; i++) {
            int mat = (int)mods->state->cleat_mat[i];
            bool loaded = false;
            for (int k = 0; k < count; k++)
                /* the limit of a loaded mat need not be restored, because it is set again in every
                 * step */
                loaded = loaded || touch[k].mat == mat;
            if (mat >= *first && mat <= *last && !loaded)
                chain->limit_lb[mat] = unloaded_friction_limit_lb(chain, mat);
        }
    }
    if (!mods->has_bands)
        return;
    mods_apply_bands(mods, &view, touch, count);
    for (int c = 0; c < mods->brace_count; c++) {
        int mat = mods->brace_mat[c];
        mods->saved_thrust_lb[mat] = chain->thrust_lb[mat];
        chain->thrust_lb[mat] += mods->brace_force_lb[mat];
        if ((mat < *first || mat > *last) && fabs(push_lb(chain, mat)) > chain->limit_lb[mat]) {
            *first = mat - 1 < *first ? (mat > 1 ? mat - 1 : 1) : *first;
            *last = mat + 1 > *last ? (mat < chain->mats ? mat + 1 : mat) : *last;
        }
    }
}

static void chain_remove_braces(struct chain *chain)
{
    struct mods *mods = chain->mods;
    for (int c = 0; mods->has_bands && c < mods->brace_count; c++)
        chain->thrust_lb[mods->brace_mat[c]] = mods->saved_thrust_lb[mods->brace_mat[c]];
}

static double chain_opening_ft(const struct chain *chain, int joint)
{
    return chain->gap0_ft[joint] + (chain->u_ft[joint] - chain->u_ft[joint - 1]);
}

/* First index of the block that contains i. */
static int block_start(const struct chain *chain, int i)
{
    return i & -chain->block_size;
}

/* Updates the speeds of a block of mats under the friction laws tanh and sign, or without friction.
 * These laws do not stop a mat. */
static void kick_sliding_block(const struct chain *chain, double h_s, int first, int last)
{
    double *v = chain->v_ft_s;
    for (int n = first; n <= last; n++) {
        double smooth = chain->friction == SIM_FRICTION_TANH
                          ? elementary_tanh(v[n] / chain->veps_ft_s)
                          : 0.0;
        v[n] += (push_lb(chain, n) -
                 friction_force_lb(chain->friction, chain->limit_lb[n], v[n], 0, smooth)) *
                (h_s / chain->mat_mass_slug[n]);
    }
}

/* Computes the speed of each mat under the gear again, from its speed before the kick, with the
 * elastic ground in place of Coulomb friction. */
static void kick_mats_under_gear(const struct chain *chain, double h_s)
{
    struct gear *gear = chain->gear;
    for (int i = 0; i < gear->loaded_count; i++) {
        int n = gear->loaded_mats[i];
        double v_ft_s = chain->previous_v_ft_s[n];
        struct element_step step = {1.0, h_s, 0.0};
        gear->mass_slug = chain->mat_mass_slug[n];
        if (chain->elements.count > 0)
            step = element_make_step(&chain->elements, (struct element_mat){v_ft_s, true}, h_s,
                                     gear->mass_slug);
        double limit_lb = chain->friction == SIM_FRICTION_NONE ? 0.0 : chain->limit_lb[n];
        chain->v_ft_s[n] = gear_solve_mat_speed_ft_s(gear, n, step.speed_factor * v_ft_s,
                                                     push_lb(chain, n) + step.push_lb, limit_lb,
                                                     step.equivalent_s);
    }
}

/* Kick of a scene with elements: each mat is computed separately. */
static __attribute__((noinline)) unsigned kick_mats_with_elements(const struct chain *chain,
                                                                  double h_s, int first, int last)
{
    double *v = chain->v_ft_s;
    unsigned stops = 0;
    const struct element_set *set = &chain->elements;
    if (chain->gear && set->count == 0 && chain->friction == SIM_FRICTION_STICK) {
        stops = LANES_CALL(kick_with_sticking, chain, h_s, h_s, block_start(chain, first),
                           block_start(chain, last));
        kick_mats_under_gear(chain, h_s);
        return stops;
    }
    for (int n = first; n <= last; n++) {
        double mass = chain->mat_mass_slug[n];
        struct element_step step = element_make_step(set, (struct element_mat){v[n], true}, h_s,
                                                     mass);
        double x_lb = push_lb(chain, n) + step.push_lb, kept = step.speed_factor * v[n];
        double smooth = chain->friction == SIM_FRICTION_TANH
                          ? elementary_tanh(v[n] / chain->veps_ft_s)
                          : 0.0;
        chain->previous_v_ft_s[n] = v[n];
        if (chain->friction == SIM_FRICTION_STICK)
            v[n] = friction_speed_ft_s(kept, x_lb, chain->limit_lb[n], step.equivalent_s, mass,
                                       &stops);
        else
            v[n] = kept + (x_lb - friction_force_lb(chain->friction, chain->limit_lb[n], v[n], 0,
                                                    smooth)) *
                              (step.equivalent_s / mass);
    }
    if (chain->gear)
        kick_mats_under_gear(chain, h_s);
    return stops;
}

static __attribute__((noinline)) void add_joint_mod_forces(const struct chain *chain, int first,
                                                           int last)
{
    struct mods_view view = chain_view(chain);
    if (chain->mods->has_joint_springs)
        mods_add_joint_forces(chain->mods, &view, first, last);
}

/* Kick: updates the speeds of mats first..last over h_s with the forces at the present joint
 * openings. Sticking is exact: a mat at rest whose force is within its limit keeps the speed 0, and
 * a mat whose speed would cross 0 stops there and is tested again. Mats outside first..last must be
 * at rest and remain at rest. Returns the number of mats that stopped. */
static unsigned chain_kick(struct chain *chain, double kick_s, double h_s, int first, int last)
{
    int block = block_start(chain, first);
    LANES_CALL(pull_joints, chain, block, block_start(chain, last + 1));
    if (chain->is_left_free)
        chain->tension_lb[1] = 0.0;
    if (chain->is_right_free)
        chain->tension_lb[chain->mats + 1] = 0.0;
    if (chain->mods)
        add_joint_mod_forces(chain, block, block_start(chain, last + 1) + chain->block_size - 1);
    if (chain->can_stick)
        return LANES_CALL(kick_with_sticking, chain, kick_s, h_s, block, block_start(chain, last));
    if (chain->elements.count > 0 || chain->gear)
        return kick_mats_with_elements(chain, kick_s, first, last);
    kick_sliding_block(chain, kick_s, first, last);
    return 0;
}

static double largest_tension_lb(const struct chain *chain, int first, int last)
{
    double most_lb = 2.0 * chain->half_max_tension_lb;
    for (int j = first; j <= last + 1; j++)
        most_lb = law_max(most_lb, law_max(chain->max_compression_lb[j], chain->max_tension_lb[j]));
    return 0.5 * most_lb;
}

/* Extension of joint j's spring; negative: compression. */
static double joint_spring_stretch_ft(const struct chain *chain, int j)
{
    double g_ft = chain_opening_ft(chain, j);
    if ((j == 1 && chain->is_left_free) || (j == chain->mats + 1 && chain->is_right_free))
        return 0.0;
    bool torn = chain->mods && mods_is_torn(chain->mods, j);
    if (torn && g_ft > fmax(0.0, chain->joint_constants.slack_ft))
        return 0.0;
    return joint_stretch_ft(chain->joint_law, g_ft, chain->joint_constants.slack_ft,
                            chain->grit_extent_ft[j]);
}

/* Kinetic energy and elastic energy of mats first..last and their joints, lb ft. */
static double chain_energy_lb_ft(const struct chain *chain, int first, int last)
{
    double kinetic = 0.0, elastic = 0.0;
    for (int n = first; n <= last; n++)
        kinetic += chain->v_ft_s[n] * chain->v_ft_s[n] *
                   (chain->mat_mass_slug[n] / chain->mass_slug);
    for (int j = first; j <= last + 1; j++) {
        double e_ft = joint_spring_stretch_ft(chain, j);
        elastic += e_ft * e_ft * (chain->kl_lb_ft[j] / chain->joint_constants.kl_lb_ft);
    }
    double braced = 0.0;
    if (chain->mods) {
        struct mods_view view = chain_view(chain);
        braced = mods_energy_lb_ft(chain->mods, &view);
    }
    return 0.5 * (chain->mass_slug * kinetic + chain->joint_constants.kl_lb_ft * elastic) + braced;
}

/* Returns the largest stable step h. A mode with rate w and damping d has the characteristic
 * polynomial z^2 - (2 - h d - h^2 w^2) z + (1 - h d). Its roots are inside the unit circle while
 * h^2 w^2 + 2 h d < 4. Largest w^2 and d of a chain of equal mats: 4 KL/m and 4 CL/m, with both
 * ends of every mat joined. The friction law tanh adds its slope to d. Elements of the table are
 * integrated exactly within the kick and do not reduce the limit. */
static double chain_step_limit_s(const struct chain *chain)
{
    int ends = (chain->is_left_free ? 0 : 1) + (chain->is_right_free ? 0 : 1);
    double joints = chain->mats > 1 ? 4.0 : ends;
    struct law_joint stiffest = chain->joint_constants;
    stiffest.kl_lb_ft = sim_scene_step_limiting_value(chain->scene, SIM_VARIED_KL,
                                                      stiffest.kl_lb_ft);
    double lightest_slug = sim_scene_step_limiting_value(chain->scene, SIM_VARIED_W,
                                                         chain->scene->weight_lb) /
                           chain->scene->g_ft_s2;
    struct law_rate_bound pulled = joint_rate_bound(&stiffest, joints, lightest_slug);
    struct law_rate_bound rubbed =
        friction_rate_bound(chain->friction, chain->weight_friction_lb + chain->load_friction_lb,
                            lightest_slug, chain->veps_ft_s);
    double rate_squared = pulled.rate_squared, damping = pulled.damping + rubbed.damping;
    if (chain->mods)
        rate_squared += mods_stiffness_lb_ft(chain->mods) / lightest_slug;
    if (chain->mods)
        damping += mods_damping_lb_s_ft(chain->mods) / lightest_slug;
    return 4.0 / (damping + sqrt(damping * damping + 4.0 * rate_squared));
}

static void chain_describe(const struct chain *chain, const struct sim_scene *scene,
                           struct sim_result *result)
{
    sim_result_add_omitted_effect(result, "vertical motion and rotation (model chain)");
    if (chain->friction == SIM_FRICTION_NONE)
        sim_result_add_omitted_effect(result, "friction (none)");
    if (scene->cl_lb_s_ft == 0.0)
        sim_result_add_omitted_effect(result, "joint damping (CL 0)");
    if (chain->joint_law == JOINT_LINEAR)
        sim_result_add_omitted_effect(result, "slack (0)");
    if (chain->joint_law != JOINT_GRIT)
        sim_result_add_omitted_effect(
            result, scene->slack_ft > 0.0 ? "grit (0 on every joint)"
                                          : "grit, because no joint can be open with slack 0");
    else
        sim_result_add_note(
            result, "grit: a joint opens freely, but must overcome its grit each time it closes");
    if (chain->mods)
        mods_describe(chain->mods, result);
    if (scene->path_count > 0)
        sim_result_add_note(result, "path replaces Vac, s0 and F");
    if (scene->v0_ft_s != 0.0)
        sim_result_add_note(result, "mat %d starts at %g ft/s (v0)", chain->v0_mat, scene->v0_ft_s);
    if (scene->bump_ft.count > 0)
        sim_result_add_note(result, "bump has no effect on flat mats (model chain)");
    element_describe(scene, result);
    if (chain->is_varied)
        sim_result_add_note(result,
                            "KL, W or v0 differs from mat to mat, or an end carries a weight");
    int stressed = 0;
    for (int j = 1; j <= chain->mats + 1; j++)
        stressed += joint_spring_stretch_ft(chain, j) != 0.0;
    if (stressed > 0)
        sim_result_add_note(
            result, "%d joints start under load, because gap0 is below 0 or above slack", stressed);
}

/* ---- runs ---- */

/* First step / stability limit if no step is given. The coarser pass then uses exactly the
 * limit. */
#define FIRST_STEP_SHARE          0.5
/* Largest part of a mat that the aircraft may cross in one step if no step is given. */
#define CROSSED_MAT_SHARE_MAX     0.25
#define SHORTEST_TIME_SHARE_MAX   0.125 /* largest step / shortest time that a step must resolve */
#define MIN_STEPS                 1000
#define MAX_STEPS                 400000000u
#define MAX_HALVINGS              8
/* Ratio of the steps of two passes. With the ratio 2, both passes would sample switches at the same
 * times. */
#define STEP_RATIO                1.9
/* Error estimate / difference of two passes. A method of order 1 would require 1.11. */
#define ERROR_FACTOR              2.0
#define ERROR_FLOOR               1e-10 /* smallest error estimate / mat length */
#define CHANCE_AGREEMENT_MATS_MAX 32  /* up to this number of mats, two runs can agree by chance */
#define THIRD_ERROR_FACTOR        4.0 /* error estimate / largest difference between three passes */
/* number of steps of a third pass / number of steps of the coarser pass */
#define THIRD_STEP_RATIO          1.37
#define ENERGY_RATIO_MAX          4.0
#define STEPS_PER_CALLBACK        1024 /* number of steps between calls of may_continue */
/* Number of steps between energy checks. Odd, so that errors of alternating sign are detected. */
#define STEPS_PER_ENERGY_CHECK    61
#define MAX_DISAGREEMENT          0.1
/* Number of steps for which a mat must be at rest before it leaves the window: one for its damper,
 * one for the grit, one in reserve. */
#define REST_STEPS_MIN            3

/* The window: the mats that are integrated, which are all moving mats and one mat at rest on either
 * side. */
struct window {
    int first;
    int last;
    int first_rest_steps; /* number of steps for which the two mats at each end have been at rest */
    int last_rest_steps;
};

/* One pass: a run over the whole duration with one step. */
struct pass {
    uint64_t step_count;
    /* fewer than `step_count` if the pass failed, or ended early because all mats came to rest */
    uint64_t completed_step_count;
    double h_s;
    double ms;
    uint64_t events;
    uint64_t active_mat_steps;
    int active_mats_max;
    int pass_number; /* number of the pass, an argument of may_continue */
    bool is_interrupted;
    bool is_failed;
    int mat; /* mat at which the pass failed */
    double t_s;
    double speed_end_ft_s;
    struct sim_record record;
    double *max_compression_lb, *max_tension_lb; /* largest compression and tension of each joint */
    struct mods_state *mods; /* state at the end of the pass; NULL without modifications */
};

/* True if nothing in the window has moved for REST_STEPS_MIN. */
static bool is_window_at_rest(const struct window *window)
{
    return window->last - window->first <= 3 && window->first_rest_steps >= REST_STEPS_MIN &&
           window->last_rest_steps >= REST_STEPS_MIN;
}

/* Extends the window to the mats under the wheel. If nothing in the window has moved for
 * REST_STEPS_MIN, moves it to the wheel instead. */
static void extend_window(struct window *window, const struct chain *chain,
                          const struct sim_touch *touch, int count)
{
    if (count > 0 && is_window_at_rest(window))
        window->first = window->last = touch[0].mat;
    for (int i = 0; i < count; i++) {
        if (touch[i].mat <= window->first && window->first > 1)
            window->first = touch[i].mat > 1 ? touch[i].mat - 1 : 1;
        if (touch[i].mat >= window->last && window->last < chain->mats)
            window->last = touch[i].mat < chain->mats ? touch[i].mat + 1 : chain->mats;
    }
}

/* Updates the window after a kick. The window grows if the mat at its end moves, because this mat
 * then loads the next one. It shrinks with a delay. */
static void update_window(struct window *window, const struct chain *chain)
{
    if (chain->v_ft_s[window->first] != 0.0 && window->first > 1)
        window->first--;
    if (chain->v_ft_s[window->last] != 0.0 && window->last < chain->mats)
        window->last++;
    bool first_rests = chain->v_ft_s[window->first] == 0.0 &&
                       chain->v_ft_s[window->first + 1] == 0.0;
    bool last_rests = chain->v_ft_s[window->last] == 0.0 && chain->v_ft_s[window->last - 1] == 0.0;
    window->first_rest_steps = first_rests ? window->first_rest_steps + 1 : 0;
    window->last_rest_steps = last_rests ? window->last_rest_steps + 1 : 0;
    if (window->first_rest_steps >= REST_STEPS_MIN && window->last - window->first > 2) {
        window->first++;
        window->first_rest_steps = 0;
    }
    if (window->last_rest_steps >= REST_STEPS_MIN && window->last - window->first > 2) {
        window->last--;
        window->last_rest_steps = 0;
    }
}

/* Sets the window after the first kick, which covers all mats. Mats that are still at rest are
 * excluded. */
static void shrink_window(struct window *window, const struct chain *chain)
{
    int first = 1, last = chain->mats;
    while (first < chain->mats && chain->v_ft_s[first] == 0.0)
        first++;
    while (last > first && chain->v_ft_s[last] == 0.0)
        last--;
    if (chain->v_ft_s[first] == 0.0)
        first = last = 2; /* no mat moves, so any position of the window is valid */
    window->first = first > 1 ? first - 1 : 1;
    window->last = last < chain->mats ? last + 1 : chain->mats;
}

static int find_fastest_mat(const struct chain *chain)
{
    int mat = 1;
    for (int n = 1; n <= chain->mats; n++) {
        if (!isfinite(chain->v_ft_s[n]) || !isfinite(chain->u_ft[n]))
            return n;
        if (fabs(chain->v_ft_s[n]) > fabs(chain->v_ft_s[mat]))
            mat = n;
    }
    return mat;
}

static void run_pass(struct pass *pass, struct chain *chain, const struct sim_scene *scene,
                     const struct sim_options *options)
{
    struct sim_touch touch[SIM_TOUCH_MAX];
    bool prune = !options->integrates_all_mats && scene->mats > 4 &&
                 element_allows_rest(&chain->elements);
    struct sim_wheel wheel;
    struct window window = {1, chain->mats, 0, 0};
    double h = pass->h_s;
    double begin_s = monotonic_s();
    double put_in_lb_ft;
    int count = 0;

    chain_reset(chain, scene);
    put_in_lb_ft = chain_energy_lb_ft(chain, 1, chain->mats);
    sim_wheel_start(&wheel, scene);
    if (chain->gear)
        gear_reset(chain->gear, h);
    sim_record_add(&pass->record, 0.0, chain->u_ft, chain->v_ft_s);
    for (uint64_t i = 0; i < pass->step_count; i++) {
        double from_s = i == 0 ? 0.0 : ((double)i - 0.5) * h;
        double to_s = ((double)i + 0.5) * h;

        chain_remove_load(chain, touch, count);
        count = chain->gear ? gear_compute_action(chain->gear, from_s, to_s, touch)
                            : sim_wheel_compute_action(&wheel, from_s, to_s, touch);
        extend_window(&window, chain, touch, count);
        chain_apply_load(chain, touch, count);
        if (chain->mods)
            chain_apply_braces(chain, to_s - from_s, touch, count, &window.first, &window.last);
        if (chain->has_only_joint_forces)
            pass->events += LANES_CALL(step, chain, to_s - from_s, h,
                                       block_start(chain, window.first), window.last);
        else
            pass->events += chain_kick(chain, to_s - from_s, h, window.first, window.last);
        if (chain->mods)
            chain_remove_braces(chain);
        if (prune && i == 0)
            shrink_window(&window, chain);
        else if (prune)
            update_window(&window, chain);
        /* true if all mats are at rest and the forces no longer change */
        bool still = prune && i > 0 && is_window_at_rest(&window) &&
                     sim_wheel_is_past_path(&wheel, from_s);
        bool last = still || i + 1 == pass->step_count;
        pass->completed_step_count = i + 1;
        int awake = window.last - window.first + 1;
        pass->active_mat_steps += (uint64_t)awake;
        pass->active_mats_max = awake > pass->active_mats_max ? awake : pass->active_mats_max;
        for (int k = 0; k < count; k++)
            put_in_lb_ft += fabs(touch[k].thrust_lb * chain->v_ft_s[touch[k].mat]) * h;
        if (!chain->has_only_joint_forces)
            LANES_CALL(drift, chain, h, block_start(chain, window.first),
                       block_start(chain, window.last + 1));

        double t_s = (double)(i + 1) * h;
        if (i % STEPS_PER_ENERGY_CHECK == 0 || last) {
            chain->half_max_tension_lb = largest_tension_lb(chain, window.first, window.last);
            double energy_lb_ft = chain_energy_lb_ft(chain, window.first, window.last);
            if (!(energy_lb_ft <= ENERGY_RATIO_MAX * put_in_lb_ft)) {
                pass->is_failed = true;
                pass->mat = find_fastest_mat(chain);
                pass->t_s = t_s;
                break;
            }
        }
        if (last)
            /* slightly longer, so that rounding does not skip outputs at the end */
            t_s = (double)pass->step_count * h * (1.0 + 1e-11);
        if (pass->record.next_record_s <= t_s)
            sim_record_add(&pass->record, t_s, chain->u_ft, chain->v_ft_s);
        if (i % STEPS_PER_CALLBACK == 0 && options->may_continue &&
            !options->may_continue(options->may_continue_ctx, pass->pass_number,
                                   (double)i / (double)pass->step_count)) {
            pass->is_interrupted = true;
            pass->mat = find_fastest_mat(chain);
            pass->t_s = t_s;
            break;
        }
        if (still) {
            pass->active_mat_steps += (uint64_t)awake *
                                      (pass->step_count - pass->completed_step_count);
            break;
        }
    }
    if (chain->mods) {
        struct mods_view view = chain_view(chain);
        pass->mods = mods_copy_end_state(chain->mods, &view);
    }
    size_t size = ((size_t)chain->mats + 2) * sizeof *chain->max_compression_lb;
    pass->max_compression_lb = xmemdup(chain->max_compression_lb, size);
    pass->max_tension_lb = xmemdup(chain->max_tension_lb, size);
    pass->speed_end_ft_s = fabs(chain->v_ft_s[find_fastest_mat(chain)]);
    pass->ms = 1e3 * (monotonic_s() - begin_s);
}

static void free_pass(struct pass *pass)
{
    sim_record_free(&pass->record);
    free(pass->max_compression_lb);
    free(pass->max_tension_lb);
    free(pass->mods);
    *pass = (struct pass){0};
}

static void make_pass(struct pass *pass, const struct sim_scene *scene,
                      const struct sim_options *options, uint64_t steps, struct sim_result *result)
{
    *pass = (struct pass){.step_count = steps,
                          .h_s = sim_scene_end_s(scene) / (double)steps,
                          .pass_number = ++result->pass_count};
    sim_record_make(&pass->record, scene, options);
}

static void add_pass_cost(const struct pass *pass, struct sim_result *result)
{
    result->evaluations += pass->completed_step_count;
    /* these steps count as rejected unless this pass becomes the result */
    result->other_steps += pass->completed_step_count;
}

static void start_pass(struct pass *pass, struct chain *chain, const struct sim_scene *scene,
                       const struct sim_options *options, uint64_t steps, struct sim_result *result)
{
    make_pass(pass, scene, options, steps, result);
    run_pass(pass, chain, scene, options);
    add_pass_cost(pass, result);
}

/* Two passes that run in parallel. Only the first calls may_continue. If the first stops, the
 * second stops too. */
struct parallel_passes {
    struct pass *pass[2];
    struct chain *chain[2];
    const struct sim_scene *scene;
    struct sim_options options[2];
    atomic_bool stopped;
};

static bool can_passes_continue(void *context, int pass_from_1, double part)
{
    struct parallel_passes *both = context;
    (void)pass_from_1, (void)part;
    return !atomic_load(&both->stopped);
}

static void run_thread_passes(void *context, size_t from, size_t every)
{
    struct parallel_passes *both = context;
    for (size_t i = from; i < 2; i += every) {
        run_pass(both->pass[i], both->chain[i], both->scene, &both->options[i]);
        if (both->pass[i]->is_interrupted)
            atomic_store(&both->stopped, true);
    }
}

static void run_both_passes(struct pass *fine, struct pass *coarse, struct chain *chain,
                            const struct sim_scene *scene, const struct sim_options *options,
                            uint64_t fine_steps, uint64_t coarse_steps, struct sim_result *result)
{
    struct chain other;
    struct parallel_passes both = {.pass = {fine, coarse},
                                   .chain = {chain, &other},
                                   .scene = scene,
                                   .options = {*options, *options}};
    both.options[1].may_continue = can_passes_continue;
    both.options[1].may_continue_ctx = &both;
    chain_make(&other, scene, chain->v0_mat);
    make_pass(coarse, scene, options, coarse_steps, result);
    make_pass(fine, scene, options, fine_steps, result);
    parallel_for(2, run_thread_passes, &both);
    add_pass_cost(coarse, result);
    add_pass_cost(fine, result);
    chain_free(&other);
}

static void fill_result(struct chain *chain, struct pass *pass, const struct pass *other,
                        struct sim_result *result)
{
    result->dt_s = pass->h_s;
    result->checked_dt_s = other->h_s;
    result->pass_ms = pass->ms;
    result->steps = pass->completed_step_count;
    result->other_steps -= pass->completed_step_count;
    result->events = pass->events;
    result->integrated_mats_max = pass->active_mats_max;
    result->integrated_mats_mean = (double)pass->active_mat_steps /
                                   (double)(pass->is_failed || pass->is_interrupted
                                                ? pass->completed_step_count
                                                : pass->step_count);
    if (result->status != SIM_OK && result->status != SIM_INTERRUPTED)
        return;
    if (pass->mods && other->mods)
        pass->mods->band_error_lb = mods_difference_lb(pass->mods, other->mods);
    result->speed_end_ft_s = pass->speed_end_ft_s;
    result->mods = pass->mods;
    pass->mods = NULL;
    if (result->status == SIM_OK)
        memcpy(chain->u_ft, pass->record.snapshots[pass->record.snapshot_count - 1].u_ft,
               ((size_t)chain->mats + 1) * sizeof *chain->u_ft);
    sim_record_move_chain_to_result(&pass->record, chain->u_ft, pass->max_compression_lb,
                                    pass->max_tension_lb, result);
    for (int j = 1; j <= chain->mats + 1; j++)
        result->gap_ft[j] = chain_opening_ft(chain, j);
}

/* Makes the finer pass the coarser pass of the next pair. */
static void move_pass(struct pass *to, struct pass *from)
{
    free_pass(to);
    *to = *from;
    *from = (struct pass){0};
}

static void run_single_pass(struct chain *chain, const struct sim_scene *scene,
                            const struct sim_options *options, uint64_t steps,
                            struct sim_result *result)
{
    struct pass only = {0};
    start_pass(&only, chain, scene, options, steps, result);
    if (only.is_failed || only.is_interrupted)
        sim_result_set_status(result, only.is_failed ? SIM_UNSTABLE : SIM_INTERRUPTED, only.mat,
                              only.t_s);
    fill_result(chain, &only, &only, result);
    free_pass(&only);
}

/* True if two runs can agree by chance: joints can tear, which depends on a single peak of tension;
 * there is no friction to stop mats that have separated; or few mats move. In these cases a third
 * run, with a step between those of the two, is included in the error estimate. */
static bool needs_third_pass(const struct chain *chain, const struct sim_scene *scene)
{
    return scene->mods.tear_lb < HUGE_VAL || chain->friction == SIM_FRICTION_NONE ||
           chain->mats <= CHANCE_AGREEMENT_MATS_MAX;
}

/* Error estimate with a third run: THIRD_ERROR_FACTOR times the largest difference of any two runs.
 * Returns 0 if the third run failed or was interrupted (*interrupted). */
static double third_pass_error_ft(struct chain *chain, const struct sim_scene *scene,
                                  const struct sim_options *options, const struct pass *coarse,
                                  const struct pass *fine, struct sim_result *result,
                                  bool *interrupted)
{
    struct pass third = {0};
    double most_ft = 0.0;
    start_pass(&third, chain, scene, options,
               (uint64_t)ceil(THIRD_STEP_RATIO * (double)coarse->step_count), result);
    *interrupted = third.is_interrupted;
    if (!third.is_failed && !third.is_interrupted)
        most_ft = fmax(sim_record_difference(&coarse->record, &fine->record).u_ft,
                       fmax(sim_record_difference(&coarse->record, &third.record).u_ft,
                            sim_record_difference(&fine->record, &third.record).u_ft));
    free_pass(&third);
    return THIRD_ERROR_FACTOR * most_ft;
}

/* Runs two passes, with `steps` and `steps`/STEP_RATIO steps (if the result is to be the coarser
 * pass, with STEP_RATIO times `steps` and `steps`). Unless the step is given, repeats this with
 * shorter steps while the two differ too much. One of the two passes becomes the result. */
static void run_pass_pairs(struct chain *chain, const struct sim_scene *scene,
                           const struct sim_options *options, uint64_t steps, bool coarser_answers,
                           struct sim_result *result)
{
    struct pass coarse = {0}, fine = {0};
    struct sim_difference apart = {0};
    double tolerance = options->rtol > 0.0 ? options->rtol : MAX_DISAGREEMENT;
    bool refine = options->rtol > 0.0 || options->dt_s == 0.0;
    uint64_t finer = coarser_answers ? (uint64_t)ceil(STEP_RATIO * (double)steps) : steps;
    uint64_t coarser = coarser_answers ? steps : (uint64_t)ceil((double)steps / STEP_RATIO);
    bool both = options->in_parallel;
    if (both)
        run_both_passes(&fine, &coarse, chain, scene, options, finer, coarser, result);
    else
        start_pass(&coarse, chain, scene, options, coarser, result);
    for (int halvings = 0;; halvings++, both = false) {
        if (coarse.is_interrupted && !both) {
            move_pass(&fine, &coarse);
            break;
        }
        if (!both)
            start_pass(&fine, chain, scene, options, finer, result);
        finer = (uint64_t)ceil(STEP_RATIO * (double)finer);
        if (fine.is_interrupted)
            break;
        bool near_limit = refine && coarse.h_s > 0.54 * result->dt_limit_s;
        if (coarse.is_failed && !fine.is_failed && near_limit) {
            move_pass(&coarse, &fine);
            continue;
        }
        if (coarse.is_failed || fine.is_failed) {
            const struct pass *failed = fine.is_failed ? &fine : &coarse;
            sim_result_set_status(result, SIM_UNSTABLE, failed->mat, failed->t_s);
            break;
        }
        apart = sim_record_difference(&coarse.record, &fine.record);
        double peak_ft = sim_record_peak(&fine.record).u_ft;
        double apart_ft = apart.u_ft * (coarser_answers ? STEP_RATIO : 1.0);
        result->error_u_ft = fmax(ERROR_FACTOR * apart_ft, ERROR_FLOOR * scene->length_ft);
        bool agree = apart_ft <= tolerance * peak_ft;
        if (agree && needs_third_pass(chain, scene)) {
            result->error_u_ft = fmax(result->error_u_ft,
                                      third_pass_error_ft(chain, scene, options, &coarse, &fine,
                                                          result, &fine.is_interrupted));
            if (fine.is_interrupted)
                break;
        }
        if (agree && (options->rtol == 0.0 || result->error_u_ft <= tolerance * peak_ft))
            break;
        if (!refine) {
            sim_result_set_status(result, SIM_UNSTABLE, apart.mat, apart.t_s);
            break;
        }
        if (halvings == MAX_HALVINGS || 4 * coarse.step_count > MAX_STEPS) {
            sim_result_set_status(result, SIM_STEP_UNDERFLOW, apart.mat, apart.t_s);
            break;
        }
        move_pass(&coarse, &fine);
    }
    if (fine.is_interrupted) {
        sim_result_set_status(result, SIM_INTERRUPTED, fine.mat, fine.t_s);
        coarser_answers = false;
    }
    fill_result(chain, coarser_answers ? &coarse : &fine, coarser_answers ? &fine : &coarse,
                result);
    free_pass(&coarse);
    free_pass(&fine);
}

enum mr_status chain_run(const struct sim_scene *scene, const struct sim_options *options,
                         struct sim_result *result, struct error *error)
{
    struct chain chain = {0};
    struct sim_wheel wheel;
    double end_s = sim_scene_end_s(scene);
    double begin_s = monotonic_s();

    sim_wheel_start(&wheel, scene);
    chain_make(&chain, scene, sim_wheel_first_mat(&wheel));
    double crossing_s =
        /* INFINITY if the aircraft is at rest */
        scene->length_ft / sim_wheel_max_speed_ft_s(&wheel);
    result->solver = "staggered";
    result->mats = scene->mats;
    result->t_end_s = end_s;
    double shortest_s = sim_scene_shortest_time_s(scene);
    result->dt_limit_s = fmin(chain_step_limit_s(&chain), fmin(crossing_s, shortest_s));
    chain_describe(&chain, scene, result);

    bool given = options->dt_s > 0.0;
    bool event = options->solver && strcmp(options->solver, "event") == 0;
    bool fixed = options->solver && strcmp(options->solver, "staggered") == 0;
    if (given && event) {
        chain_free(&chain);
        return error_set(error, MR_USAGE,
                         "solver event chooses its own step and ignores --dt; give --rtol, or "
                         "--solver staggered");
    }
    if (!given && !fixed && (event || !options->is_single_pass) &&
        chain_event_is_supported(scene)) {
        chain_event_run(scene, options, result, error);
        chain_free(&chain);
        return error->status;
    }
    double h = given ? options->dt_s
                     : fmin(FIRST_STEP_SHARE * result->dt_limit_s,
                            fmin(fmin(CROSSED_MAT_SHARE_MAX * crossing_s,
                                      SHORTEST_TIME_SHARE_MAX * shortest_s),
                                 end_s / MIN_STEPS));
    double steps = ceil(end_s / h * (1.0 - 1e-12));
    bool coarser_answers = given && options->rtol == 0.0 &&
                           STEP_RATIO * h > 0.95 * result->dt_limit_s;
    if (h > result->dt_limit_s) {
        result->dt_s = h;
        sim_result_set_status(result, SIM_UNSTABLE, sim_wheel_first_mat(&wheel), 0.0);
    } else if (!(steps <= MAX_STEPS)) {
        error_set(error, MR_USAGE,
                  "too many steps: %s: tend is %g s and the step is %g s; give a smaller tend or a "
                  "larger dt",
                  sim_scene_name(scene), end_s, h);
    } else if (options->is_single_pass) {
        run_single_pass(&chain, scene, options, (uint64_t)steps, result);
    } else {
        run_pass_pairs(&chain, scene, options, (uint64_t)steps, coarser_answers, result);
    }
    result->run_ms = 1e3 * (monotonic_s() - begin_s);
    chain_free(&chain);
    return error->status;
}
