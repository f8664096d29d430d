#include "host/advise/waves.h"

#include <stdlib.h>

#include "host/base/shared.h"
#include "host/base/wilson.h"
#include "host/sim/sim.h"

#define STREAM       3u
#define STEP_S       5e-5
#define ROW_S        5e-3
#define AFTER_STOP_S 0.3
#define ROWS_MOST    8000u
/* R* to 1/7 and soft, over-damped soil, as host/scenes/model_runway_planar.json has it */
#define INERTIA      1.19e-4
#define KV_LB_FT     1.3e4
#define CV_LB_S_FT   60.0
#define KT_LB_FT     41.6
#define CT_LB_FT_S   1.6e-4
#define TAD_DEG      7.0

/* The gear's way and thrust. How many rows. */
static size_t roll(const struct advise_members *members, size_t member,
                   const struct advise_braking *braking, struct sim_path_row *rows)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double end_ft = (double)chain->mat_length_ft * chain->mats - 1e-6;
    double per_ft_s2 = exp(members->member[member].unknown[ADVISE_SHARE]) *
                       members->runway.thrust_lb_per_g / ADVISE_G_FT_S2;
    double at_ft = braking->touchdown_ft, v = braking->speed_ft_s, t_s = 0.0;
    size_t count = 0;
    while (v > 0.0 && at_ft < end_ft && count + 1 < ROWS_MOST) {
        double a = advise_braking_ft_s2(braking, t_s),
               mid = advise_braking_ft_s2(braking, t_s + 0.5 * ROW_S);
        rows[count++] = (struct sim_path_row){t_s, at_ft, per_ft_s2 * a};
        at_ft += v * ROW_S - 0.5 * mid * ROW_S * ROW_S;
        v -= mid * ROW_S;
        t_s += ROW_S;
    }
    rows[count++] = (struct sim_path_row){t_s, fmin(at_ft, end_ft), 0.0};
    return count;
}

static enum mr_status lay(struct sim_scene *scene, const struct advise_members *members,
                          size_t member, const struct advise_braking *braking, uint64_t seed,
                          struct error *error)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    const struct advise_member *m = &members->member[member];
    double gap_ft[ADVISE_JOINTS], grit_lb[ADVISE_JOINTS], ground_ft[ADVISE_JOINTS];
    struct chance chance = chance_from(seed, 1000u * STREAM + member);
    struct sim_path_row *rows = calloc(ROWS_MOST, sizeof *rows);
    if (!rows)
        return error_set(error, MR_FULL,
                         "no memory for a path: matrig advise; close other programs");
    for (unsigned j = 0; j <= chain->mats; j++) {
        gap_ft[j] = (double)m->gap_ft[j];
        grit_lb[j] = exp(m->unknown[ADVISE_RESISTANCE]) * (double)m->grit[j];
        ground_ft[j] = members->runway.bump_ft * chance_uniform(&chance);
    }
    scene->model = SIM_CONSISTENT;
    scene->mats = (int)chain->mats;
    scene->length_ft = (double)chain->mat_length_ft;
    scene->weight_lb = (double)chain->mass_slug * ADVISE_G_FT_S2;
    scene->friction = exp(m->unknown[ADVISE_FRICTION]) / scene->weight_lb;
    scene->kl_lb_ft = exp(m->unknown[ADVISE_STIFFNESS]);
    scene->cl_lb_s_ft = exp(m->unknown[ADVISE_DAMPING]);
    scene->slack_ft = (double)chain->slack_ft;
    scene->left = scene->right = SIM_FIXED;
    scene->v0_ft_s = 0.0;
    scene->t_dwell_s = AFTER_STOP_S;
    scene->inertia_slug_ft2 = INERTIA;
    scene->kv_lb_ft = KV_LB_FT;
    scene->cv_lb_s_ft = CV_LB_S_FT;
    scene->kt_lb_ft_rad = KT_LB_FT;
    scene->ct_lb_ft_s_rad = CT_LB_FT_S;
    scene->tad_deg = TAD_DEG;
    size_t count = roll(members, member, braking, rows);
    enum mr_status status = sim_scene_set_list(&scene->gap0_ft, gap_ft, chain->mats + 1u, error);
    if (status == MR_OK)
        status = sim_scene_set_list(&scene->grit_lb, grit_lb, chain->mats + 1u, error);
    if (status == MR_OK)
        status = sim_scene_set_list(&scene->ground_ft, ground_ft, chain->mats + 1u, error);
    if (status == MR_OK)
        status = sim_scene_set_path(scene, rows, count, error);
    free(rows);
    return status;
}

enum mr_status advise_wave(const struct advise_members *members, size_t member,
                           const struct advise_braking *braking, uint64_t seed, bool *wave,
                           struct error *error)
{
    /* one pass: draws differ by far more than a pass errs; a finer step is for what it lacks */
    const struct sim_options options = {.dt_s = STEP_S, .single = true};
    struct sim_scene scene;
    struct sim_result result = {0};
    sim_scene_defaults(&scene);
    enum mr_status status = lay(&scene, members, member, braking, seed, error);
    if (status == MR_OK)
        status = sim_run(&scene, &options, &result, error);
    /* a wave that grows until a mat stands upright ends the run without numbers */
    bool folded = status == MR_NUMERICS && result.status == SIM_FOLDED;
    *wave = folded || (status == MR_OK && result.bow_wave);
    if (folded)
        *error = (struct error){0};
    sim_result_free(&result);
    sim_scene_free(&scene);
    return folded ? MR_OK : status;
}

/* --- rows --- */

/* Members on all rows that are asked for. */
struct search {
    const struct advise_members *members;
    const struct advise_plan *plan;
    const struct advise_row *row;
    size_t rows, plan_row, count;
    unsigned char *found; /* [count][rows]: 0 not asked, 1 no answer, 2 no wave, 3 a wave */
    _Atomic size_t played;
    _Atomic bool full;
};

/* Every second row and the plan's: a run of the planar model costs as much as fifty members'. */
static bool asked(size_t row, size_t plan_row)
{
    return row % 2 == 0 || row == plan_row;
}

static void search_some(void *context, size_t from, size_t every)
{
    struct search *s = context;
    struct advise_braking *braking = calloc(s->members->count, sizeof *braking);
    if (!braking)
        s->full = true;
    for (size_t r = 0; braking && r < s->rows; r++) {
        if (!asked(r, s->plan_row))
            continue;
        advise_draw_braking(s->members, s->plan, s->row[r].mean_ft_s2, braking);
        for (size_t m = from; m < s->count; m += every) {
            struct error error = {0};
            bool wave = false;
            enum mr_status status = advise_wave(s->members, m, &braking[m], s->plan->seed, &wave,
                                                &error);
            s->found[m * s->rows + r] = status != MR_OK ? 1 : wave ? 3 : 2;
            if (status == MR_FULL)
                s->full = true;
            s->played++;
        }
    }
    free(braking);
}

/* Some row has an answer. */
static bool count_up(const unsigned char *found, size_t count, struct advise_row *row, size_t rows)
{
    bool any = false;
    for (size_t r = 0; r < rows; r++) {
        size_t waves = 0, answered = 0;
        for (size_t m = 0; m < count; m++) {
            answered += found[m * rows + r] >= 2;
            waves += found[m * rows + r] == 3;
        }
        if (!answered)
            continue;
        any = true;
        struct wilson share = wilson_of(waves, answered);
        row[r].played = (struct advise_chance){(double)waves / (double)answered, share.low,
                                               share.high};
    }
    return any;
}

enum mr_status advise_waves_played(const struct advise_members *members,
                                   const struct advise_plan *plan, size_t count,
                                   struct advise_row *row, size_t rows, size_t plan_row,
                                   size_t *played, struct error *error)
{
    size_t used = count < members->count ? count : members->count;
    struct search search = {.members = members,
                            .plan = plan,
                            .row = row,
                            .rows = rows,
                            .plan_row = plan_row,
                            .count = used,
                            .found = calloc(used * rows + 1, sizeof *search.found)};
    if (search.found)
        shared_run(members->threads, search_some, &search);
    *played = search.played;
    bool full = search.full || !search.found;
    bool any = !full && count_up(search.found, used, row, rows);
    free(search.found);
    if (full)
        return error_set(error, MR_FULL,
                         "no memory for bow waves: matrig advise; leave them out (--waves 0)");
    return any ? MR_OK
               : error_set(error, MR_NUMERICS,
                           "no answer of the planar model for any member: matrig advise; leave bow "
                           "waves out (--waves 0)");
}
