#include "host/landing_series/ensemble.h"

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/base/cli.h"
#include "host/base/parallel_for.h"
#include "host/base/statistics.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/mods.h"
#include "host/sim/sim.h"

/* ---- draw ---- */

/* of the integration of the path, with mats as long as the rig's; else by the root of the scale, */
#define NODE_S       1e-3
#define NODE_FT      (2.0 / 7.0) /* so that a scaled series is the same one */
#define NODE_G_FT_S2 32.174
#define ROW_NODES    10
#define MOST_S       600.0

struct draw draw_from(uint64_t seed, unsigned stream)
{
    uint64_t state = seed;
    state = mr_splitmix64(&state) + 0x632be59bd9b4e019u * (stream + 1u);
    return (struct draw){mr_splitmix64(&state)};
}

static double draw_uniform(struct draw *draw)
{
    return mr_splitmix64_uniform(&draw->state);
}

double draw_between(struct draw *draw, struct series_range range)
{
    return range.low + (range.high - range.low) * draw_uniform(draw);
}

static double profile_ft_s2(const struct series_landing *landing, double drawn_ft_s2,
                            double station_ft)
{
    const struct series_knot *k = landing->profile;
    size_t count = landing->profile_count;
    if (count == 0)
        return drawn_ft_s2;
    if (station_ft <= k[0].station_ft)
        return k[0].deceleration_ft_s2;
    for (size_t i = 1; i < count; i++) {
        if (station_ft < k[i].station_ft)
            return k[i - 1].deceleration_ft_s2 +
                   (k[i].deceleration_ft_s2 - k[i - 1].deceleration_ft_s2) *
                       (station_ft - k[i - 1].station_ft) / (k[i].station_ft - k[i - 1].station_ft);
    }
    return k[count - 1].deceleration_ft_s2;
}

static void add_row(struct draw_path *path, struct sim_path_row row)
{
    xlist_grow(&path->rows, path->count, sizeof row);
    path->rows[path->count++] = row;
}

enum mr_status draw_landing(const struct landing_series *series,
                            const struct series_landing *landing, uint64_t seed, size_t index,
                            struct draw_path *path, struct error *error)
{
    struct draw draw = draw_from(seed, DRAW_LANDING + (unsigned)index);
    double lb_per_ft_s2 = series->weight_lb / (series->axles * landing->scene.g_ft_s2);
    double at_ft = draw_between(&draw, landing->touchdown_ft),
           v_ft_s = draw_between(&draw, landing->speed_ft_s);
    double drawn_ft_s2 = draw_between(&draw, landing->deceleration_ft_s2), from_ft_s = v_ft_s;
    double runway_ft = landing->scene.mats * landing->scene.length_ft, t_s = 0.0, force_lb = 0.0;
    double node_s =
        NODE_S * sqrt(landing->scene.length_ft / NODE_FT * (NODE_G_FT_S2 / landing->scene.g_ft_s2));
    draw_path_free(path);
    path->touchdown_ft = at_ft;
    for (size_t k = 0; v_ft_s > 0.0 && at_ft < runway_ft; k++) {
        t_s = node_s * (double)k;
        double onset = series->onset_s > 0.0 ? fmin(t_s / series->onset_s, 1.0) : 1.0;
        /* towed: the speed is kept from outside */
        double share = onset * onset * (3.0 - 2.0 * onset), a_ft_s2 = 0.0;
        if (!(landing->tow_lb > 0.0))
            a_ft_s2 = share * profile_ft_s2(landing, drawn_ft_s2, at_ft);
        force_lb = landing->tow_lb > 0.0 ? share * landing->tow_lb : lb_per_ft_s2 * a_ft_s2;
        if (k % ROW_NODES == 0)
            add_row(path, (struct sim_path_row){t_s, at_ft, force_lb});
        if (t_s > MOST_S)
            return error_set(
                error, MR_USAGE,
                "no stop: %s: landing %zu still rolls after %g s; give more deceleration",
                series->name, index + 1, MOST_S);
        double rest_s = a_ft_s2 > 0.0 ? fmin(node_s, v_ft_s / a_ft_s2) : node_s;
        at_ft += rest_s * (v_ft_s - 0.5 * a_ft_s2 * rest_s);
        v_ft_s = rest_s < node_s ? 0.0 : v_ft_s - a_ft_s2 * rest_s;
        t_s += rest_s;
    }
    if (t_s <= path->rows[path->count - 1].t_s)
        t_s = path->rows[path->count - 1].t_s + node_s;
    path->stop_ft = at_ft;
    path->mean_ft_s2 = (from_ft_s * from_ft_s - v_ft_s * v_ft_s) /
                       (2.0 * fmax(at_ft - path->touchdown_ft, 1e-9));
    add_row(path, (struct sim_path_row){t_s, at_ft, force_lb});
    add_row(path, (struct sim_path_row){t_s, at_ft, 0.0});
    return MR_OK;
}

void draw_path_free(struct draw_path *path)
{
    free(path->rows);
    *path = (struct draw_path){0};
}

/* ---- failures ---- */

static double station_ft(const double *rise_ft, size_t first, size_t last, double length_ft,
                         const double *met_ft, int met)
{
    size_t crest = first;
    for (int i = 0; i < met; i++) {
        double node = met_ft[i] / length_ft + 1.0;
        if (node > (double)first - 0.5 && node < (double)last + 0.5)
            return met_ft[i];
    }
    for (size_t j = first; j <= last; j++)
        crest = rise_ft[j] > rise_ft[crest] ? j : crest;
    return (double)(crest - 1) * length_ft;
}

int failures_find(const double *rise_ft, size_t nodes, double length_ft, double limit_ft,
                  const double *met_ft, int met, double failure_ft[SERIES_FAILURES_MAX])
{
    int count = 0;
    size_t first = 0;
    for (size_t j = 2; j <= nodes && count < SERIES_FAILURES_MAX; j++) {
        bool high = j < nodes && rise_ft[j] >= limit_ft;
        if (high && first == 0)
            first = j;
        if (high || first == 0)
            continue;
        failure_ft[count++] = station_ft(rise_ft, first, j - 1, length_ft, met_ft, met);
        first = 0;
    }
    return count;
}

/* ---- flatten ---- */

#define CLOSED_FT 1e-12

/* What lies on one side of a joint. */
struct side {
    size_t front;     /* the next joint that is open */
    double resist_lb; /* of the mats up to there, and of closing it */
};

static struct side side_of(const struct flat_runway *r, size_t joint, int step)
{
    struct side side = {joint, 0.0};
    while ((step < 0 && side.front > 0) || (step > 0 && side.front + 1 < r->joints)) {
        side.front = (size_t)((long)side.front + step);
        side.resist_lb += r->rub_lb;
        if (r->gap_ft[side.front] > CLOSED_FT) {
            side.resist_lb += r->closing_lb[side.front];
            return side;
        }
    }
    side.resist_lb = HUGE_VAL; /* the runway's end */
    return side;
}

/* Mats between the joints `low` and `high` move by so much. */
static void shift(const struct flat_runway *r, size_t low, size_t high, double by_ft)
{
    for (size_t mat = low + 1; mat <= high; mat++)
        r->u_ft[mat] += by_ft;
}

void flatten(const struct flat_runway *r)
{
    for (size_t j = 0; j < r->joints; j++) {
        while (r->gap_ft[j] < -CLOSED_FT) {
            struct side left = side_of(r, j, -1), right = side_of(r, j, 1);
            bool to_left = left.resist_lb < right.resist_lb;
            struct side *side = to_left ? &left : &right;
            double over_ft = -r->gap_ft[j] - side->resist_lb / r->kl_lb_ft;
            if (!(over_ft > CLOSED_FT))
                break;
            double by_ft = fmin(over_ft, r->gap_ft[side->front]);
            r->gap_ft[side->front] -= by_ft;
            r->gap_ft[j] += by_ft;
            if (to_left)
                shift(r, side->front, j, -by_ft);
            else
                shift(r, j, side->front, by_ft);
        }
    }
}

/* ---- seeds ---- */

struct work {
    const struct landing_series *series;
    struct series_run *runs;
    atomic_size_t done;
    void (*progress)(void *ctx, size_t done, size_t of);
    void *ctx;
};

static void play_some(void *context, size_t from, size_t every)
{
    struct work *work = context;
    for (size_t i = from; i < work->series->seeds; i += every) {
        series_play(work->series, work->series->first_seed + i, &work->runs[i]);
        size_t done = atomic_fetch_add(&work->done, 1) + 1;
        if (from == 0 && work->progress)
            work->progress(work->ctx, done, work->series->seeds);
    }
}

void series_ensemble(const struct landing_series *series, unsigned jobs,
                     void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                     struct series_run *runs)
{
    struct work work = {.series = series, .runs = runs, .progress = progress, .ctx = ctx};
    parallel_for(jobs < series->seeds ? jobs : (unsigned)series->seeds, play_some, &work);
}

/* ---- play ---- */

#define IN_PER_FT   12.0
#define ZONE_JOINTS 10 /* the rig's gage points are 10 mats apart */
#define ZONE_SHARE  (1.0 / 3.0)
#define MOVED_SHARE (0.001 * 7.0 / 24.0) /* of a mat's length: 0.001 in on the rig */

/* A runway between landings. */
struct runway {
    const struct landing_series *series;
    int mats;
    size_t joints;
    double *storage;
    double *gap_ft, *closing_lb, *ground_ft; /* per joint */
    double laid_ft;                          /* mean opening when it was laid */
    double *u_ft;                            /* per mat: total movement, [0] unused */
    struct sim_mods mods;                    /* as the last landing left them; lists are its own */
};

static void lay(struct runway *r, const struct landing_series *series, uint64_t seed)
{
    *r = (struct runway){.series = series, .mats = series->landings[0].scene.mats};
    r->joints = (size_t)r->mats + 1;
    r->storage = xcalloc(4 * (r->joints + 1), sizeof *r->storage);
    r->gap_ft = r->storage;
    r->closing_lb = r->gap_ft + r->joints;
    r->ground_ft = r->closing_lb + r->joints;
    r->u_ft = r->ground_ft + r->joints;
    struct draw gaps = draw_from(seed, DRAW_GAPS), closing = draw_from(seed, DRAW_CLOSING),
                ground = draw_from(seed, DRAW_GROUND);
    double slack_ft = series->landings[0].scene.slack_ft;
    for (size_t j = 0; j < r->joints; j++) {
        r->gap_ft[j] = fmin(draw_between(&gaps, series->gap_in) / IN_PER_FT, slack_ft);
        r->laid_ft += r->gap_ft[j] / (double)r->joints;
        r->closing_lb[j] = draw_between(&closing, series->closing_lb);
        r->ground_ft[j] = draw_between(&ground, series->irregularity_in) / IN_PER_FT;
    }
}

static double strength_lb(const struct runway *r)
{
    const struct landing_series *c = r->series;
    return c->strength_lb_in * c->strip_ft * IN_PER_FT;
}

static void own_list(struct sim_list *list)
{
    struct sim_list copy = {0};
    sim_scene_set_list(&copy, list->values, list->count);
    *list = copy;
}

/* Modifications as the file has them before a landing; torn joints stay torn. */
static void modify(struct runway *r, const struct sim_scene *scene)
{
    struct sim_list torn = r->mods.torn;
    r->mods.torn = (struct sim_list){0};
    mods_free_lists(&r->mods);
    r->mods = scene->mods;
    struct sim_list *lists[MODS_LISTS];
    mods_lists(&r->mods, lists);
    for (size_t i = 0; i < MODS_LISTS; i++)
        own_list(lists[i]); /* every one, so that none stays the series' */
    if (torn.count > 0) {
        free(r->mods.torn.values);
        r->mods.torn = torn;
    }
}

static void carry(struct runway *r, const struct sim_scene *as_landed,
                  const struct sim_result *result)
{
    struct sim_scene scene = *as_landed;
    scene.mods = r->mods;
    mods_carry(&scene, result);
    r->mods = scene.mods;
}

static void set_scene(const struct runway *r, const struct sim_scene *made, enum sim_model model,
                      const struct sim_path_row *rows, size_t count, struct sim_scene *scene)
{
    *scene = *made; /* lists that this one replaces are the series': copies follow */
    scene->model = model;
    scene->gap0_ft = scene->grit_lb = scene->ground_ft = (struct sim_list){0};
    scene->mods = r->mods; /* only read */
    scene->path = NULL;
    scene->path_count = 0;
    scene->t_dwell_s = r->series->dwell_s;
    sim_scene_set_list(&scene->gap0_ft, r->gap_ft, r->joints);
    sim_scene_set_list(&scene->grit_lb, r->closing_lb, r->joints);
    if (model == SIM_CONSISTENT)
        sim_scene_set_list(&scene->ground_ft, r->ground_ft, r->joints);
    sim_scene_set_path(scene, rows, count);
}

static void drop_scene(struct sim_scene *scene)
{
    free(scene->gap0_ft.values);
    free(scene->grit_lb.values);
    free(scene->ground_ft.values);
    free(scene->path);
}

static enum mr_status run_engine(const struct runway *r, const struct series_landing *landing,
                                 enum sim_model model, const struct sim_path_row *rows,
                                 size_t count, struct sim_result *result, struct error *error)
{
    const struct landing_series *c = r->series;
    const struct sim_options options = {
        .dt_s = model == SIM_CHAIN ? c->chain_dt_s : c->planar_dt_s,
        .single = true,
        .overrun_ft = model == SIM_CONSISTENT ? c->buckle_in / IN_PER_FT : 0.0,
    };
    struct sim_scene scene = {0};
    *result = (struct sim_result){0};
    set_scene(r, &landing->scene, model, rows, count, &scene);
    sim_run(&scene, &options, result, error);
    drop_scene(&scene);
    if (result->status == SIM_FOLDED) /* an outcome, not a failure */
        *error = (struct error){0};
    return error->status;
}

/* Largest lift of a node by the compression of its joint, in weights of a mat: above 1 a vee of two
 * mats rises, as P (2 h_j - h_{j-1} - h_{j+1})/L > W. */
static double lift_ratio(const struct runway *r, const struct sim_scene *scene,
                         const double *push_lb)
{
    double most = 0.0;
    for (size_t j = 1; j + 1 < r->joints; j++) {
        double bend = 2.0 * r->ground_ft[j] - r->ground_ft[j - 1] - r->ground_ft[j + 1];
        most = fmax(most, push_lb[j + 1] * bend / (scene->length_ft * scene->weight_lb));
    }
    return most;
}

/* Mats that a line of stiffeners ties are tipped by a wheel on one end, and their joints rise
 * without any compression. */
static bool tips(const struct sim_scene *scene)
{
    return scene->mods.stiff_span > 1 && scene->mods.stiff_kt_lb_ft_rad > 0.0 &&
           scene->wheel_load_lb > 0.0;
}

static double joint_station_ft(const struct sim_scene *scene, size_t j)
{
    return (double)j * scene->length_ft;
}

static void note_waves(const struct runway *r, const struct sim_scene *scene, const double *rise_ft,
                       struct series_outcome *out)
{
    double limit_ft = r->series->wave_in / IN_PER_FT, highest_ft = 0.0;
    for (size_t j = 1; j + 1 < r->joints; j++) {
        double h = rise_ft[j + 1];
        out->rise_in = fmax(out->rise_in, h * IN_PER_FT);
        if (!(h > limit_ft && h >= rise_ft[j] && h > rise_ft[j + 2]))
            continue;
        out->waves++;
        if (h > highest_ft)
            out->wave_ft = joint_station_ft(scene, j);
        highest_ft = fmax(highest_ft, h);
    }
}

/* `folded`: a mat stood upright. */
static void note_planar(const struct runway *r, const struct sim_scene *scene,
                        const struct sim_result *result, bool folded, struct series_outcome *out)
{
    out->asked_planar = true;
    if (result->first_crest > 0 && result->first_crest_wheel > 0) {
        out->crest_ft = joint_station_ft(scene, (size_t)result->first_crest - 1);
        out->crest_ahead_mats = result->first_crest - result->first_crest_wheel;
    }
    if (folded) {
        out->buckled = true;
        out->buckle_ft = joint_station_ft(scene, (size_t)result->mat);
        out->rise_in = r->series->buckle_in;
        out->failures = 1;
        out->failure_ft[0] = out->buckle_ft;
        return;
    }
    note_waves(r, scene, result->rise_ft, out);
    out->crest_deg = result->crest_deg;
    out->sag_deg = result->sag_deg;
    out->unhinged = result->sag_deg > r->series->unhinge_deg;
    out->buckled = out->unhinged || out->rise_in >= r->series->buckle_in;
    out->overruns = result->overruns;
    for (int i = 0; i < result->overruns; i++)
        out->overrun_ft[i] = joint_station_ft(scene, (size_t)result->overrun[i] - 1);
    if (out->buckled)
        out->buckle_ft = out->overruns > 0 ? out->overrun_ft[0]
                       : out->waves > 0    ? out->wave_ft
                                           : joint_station_ft(scene, (size_t)result->sag_joint - 1);
    out->failures = failures_find(result->rise_ft, r->joints, scene->length_ft,
                                  r->series->buckle_in / IN_PER_FT, out->overrun_ft, out->overruns,
                                  out->failure_ft);
    if (out->buckled && out->failures == 0)
        out->failure_ft[out->failures++] = out->buckle_ft;
}

/* A mat that was torn from both neighbours is no part of the runway any more. */
static bool is_loose(const struct sim_result *result, int mat)
{
    const struct mods_state *s = result->mods;
    return s && s->torn[mat] != 0.0 && s->torn[mat + 1] != 0.0;
}

static void note_movement(struct runway *r, const struct sim_scene *scene,
                          const struct sim_result *result, struct series_outcome *out)
{
    const struct landing_series *c = r->series;
    const double *u_ft = result->u_ft;
    for (int n = 1; n <= r->mats; n++) {
        r->u_ft[n] += u_ft[n];
        if (is_loose(result, n))
            continue;
        out->peak_in = fmax(out->peak_in, fabs(u_ft[n]) * IN_PER_FT);
        double station_ft = (n - 0.5) * scene->length_ft;
        if (fabs(u_ft[n]) > MOVED_SHARE * scene->length_ft &&
            station_ft - out->stop_ft > out->reach_ft)
            out->reach_ft = station_ft - out->stop_ft;
    }
    for (size_t i = 0; i < c->station_count; i++) {
        int mat = (int)fmin(floor(c->stations_ft[i] / scene->length_ft) + 1.0, r->mats);
        out->movement_in[i] = u_ft[mat] * IN_PER_FT;
        out->total_in[i] = r->u_ft[mat] * IN_PER_FT;
    }
}

static void note_joints(const struct runway *r, const struct sim_result *result,
                        struct series_outcome *out)
{
    double most_lb = strength_lb(r);
    for (size_t j = 0; j < r->joints; j++) {
        out->push_lb = fmax(out->push_lb, result->push_lb[j + 1]);
        out->pull_lb = fmax(out->pull_lb, result->pull_lb[j + 1]);
        out->tears += result->pull_lb[j + 1] > most_lb;
    }
}

/* The longest stretch in which any ten joints are open by less than a third of what they were when
 * the runway was laid: what readings of gage points show. */
static void note_zone(const struct runway *r, const struct sim_scene *scene,
                      struct series_outcome *out)
{
    double limit_ft = ZONE_SHARE * r->laid_ft * ZONE_JOINTS, sum_ft = 0.0;
    size_t from = 0;
    bool in = false;
    for (size_t j = 0; j < r->joints; j++) {
        sum_ft += fmax(r->gap_ft[j], 0.0);
        if (j >= ZONE_JOINTS)
            sum_ft -= fmax(r->gap_ft[j - ZONE_JOINTS], 0.0);
        if (j + 1 < ZONE_JOINTS)
            continue;
        if (!(sum_ft < limit_ft)) {
            in = false;
            continue;
        }
        if (!in)
            from = j + 1 - ZONE_JOINTS;
        in = true;
        int mats = (int)(j + 1 - from);
        if (mats > out->zone_mats) {
            out->zone_mats = mats;
            out->zone_from_ft = joint_station_ft(scene, from);
            out->zone_to_ft = joint_station_ft(scene, j);
        }
    }
}

/* A slack segment pulls nothing. */
static void note_bands(const struct sim_scene *scene, const struct mods_state *state,
                       struct series_outcome *out)
{
    size_t segment = 0;
    for (int g = 0; g < SIM_BAND_GROUPS && state; g++) {
        int connections = mods_connections(scene, g);
        for (int i = 0; i <= connections && connections > 0; i++)
            out->band_slack += state->band_least_lb[segment++] <= 0.0;
    }
}

/* The gaps that a movement leaves; a wave that is left is pressed flat when the aircraft is pushed
 * back over it. */
static void open_gaps(struct runway *r, const double *u_ft)
{
    for (size_t j = 0; j < r->joints; j++)
        r->gap_ft[j] += (j < (size_t)r->mats ? u_ft[j + 1] : 0.0) - (j > 0 ? u_ft[j] : 0.0);
}

/* A wave that is left is longer than the joints beside it are open. */
static void press_flat(struct runway *r, const struct sim_scene *scene)
{
    const struct flat_runway flat = {
        r->joints,      r->gap_ft, r->u_ft, r->closing_lb, scene->friction * scene->weight_lb,
        scene->kl_lb_ft};
    flatten(&flat);
}

/* What the mats have come to in a landing. */
static void settle(struct runway *r, const struct sim_scene *scene, const struct sim_result *moved,
                   struct series_outcome *out)
{
    note_movement(r, scene, moved, out);
    open_gaps(r, moved->u_ft);
    if (r->series->press_flat && out->waves > 0)
        press_flat(r, scene);
    note_joints(r, moved, out);
    note_zone(r, scene, out);
    note_bands(scene, moved->mods, out);
    carry(r, scene, moved);
}

static enum mr_status land(struct runway *r, const struct series_landing *landing,
                           const struct draw_path *path, struct series_outcome *out,
                           struct error *error)
{
    const struct landing_series *c = r->series;
    const struct sim_scene *scene = &landing->scene;
    struct sim_result chain = {0}, planar = {0};
    const struct sim_result *moved = &chain;
    if (c->engine != SERIES_PLANAR &&
        run_engine(r, landing, SIM_CHAIN, path->rows, path->count, &chain, error) == MR_OK) {
        out->skip_ratio = lift_ratio(r, scene, chain.push_lb);
    }
    bool ask = c->engine == SERIES_PLANAR ||
               (c->engine == SERIES_AUTO && (out->skip_ratio > c->skip_share || tips(scene)));
    if (error->status == MR_OK && ask &&
        run_engine(r, landing, SIM_CONSISTENT, path->rows, path->count, &planar, error) == MR_OK) {
        note_planar(r, scene, &planar, planar.status == SIM_FOLDED, out);
        if (planar.u_ft && (c->engine == SERIES_PLANAR || out->waves > 0))
            moved = &planar;
    }
    if (error->status == MR_OK && moved->u_ft)
        settle(r, scene, moved, out);
    sim_result_free(&chain);
    sim_result_free(&planar);
    return error->status;
}

static void clear(struct runway *r)
{
    mods_free_lists(&r->mods);
    free(r->storage);
}

void series_play(const struct landing_series *series, uint64_t seed, struct series_run *run)
{
    struct runway runway = {0};
    struct draw_path path = {0};
    *run = (struct series_run){.seed = seed};
    run->outcomes = xcalloc(series->landing_count, sizeof *run->outcomes);
    lay(&runway, series, seed);
    for (size_t i = 0; i < series->landing_count && run->error.status == MR_OK && run->buckled == 0;
         i++) {
        const struct series_landing *landing = &series->landings[i];
        struct series_outcome *out = &run->outcomes[i];
        if (i == 0 || landing->modified)
            modify(&runway, &landing->scene);
        if (draw_landing(series, landing, seed, i, &path, &run->error) != MR_OK)
            break;
        out->stop_ft = path.stop_ft;
        out->deceleration_ft_s2 = path.mean_ft_s2;
        if (land(&runway, landing, &path, out, &run->error) != MR_OK)
            break;
        run->played = i + 1;
        if (out->buckled) {
            run->buckled = (int)i + 1;
            run->buckle_ft = out->buckle_ft;
        }
    }
    draw_path_free(&path);
    clear(&runway);
}

void series_run_free(struct series_run *run)
{
    free(run->outcomes);
    run->outcomes = NULL;
}

/* ---- summary ---- */

static double percentile(const double *sorted, size_t count, double share)
{
    double at = share * (double)(count - 1);
    size_t left = (size_t)at;
    if (left + 1 >= count)
        return sorted[count - 1];
    return sorted[left] + (at - (double)left) * (sorted[left + 1] - sorted[left]);
}

struct series_spread series_spread_of(double *values, size_t count)
{
    if (count == 0)
        return (struct series_spread){(double)NAN, (double)NAN, (double)NAN, 0};
    sort_numbers(values, count);
    return (struct series_spread){percentile(values, count, 0.05), percentile(values, count, 0.5),
                                  percentile(values, count, 0.95), count};
}

struct gather {
    const struct landing_series *series;
    const struct series_run *runs;
    size_t landing;
    double *values;
};

static const struct series_outcome *outcome_at(const struct gather *g, size_t run)
{
    return &g->runs[run].outcomes[g->landing];
}

/* Spread of one number at `offset` in the outcomes of a landing. */
static struct series_spread spread_at(const struct gather *g, size_t offset)
{
    size_t count = 0;
    for (size_t i = 0; i < g->series->seeds; i++) {
        if (g->runs[i].played > g->landing)
            g->values[count++] = *(const double *)((const char *)outcome_at(g, i) + offset);
    }
    return series_spread_of(g->values, count);
}

static struct series_spread zones(const struct gather *g)
{
    size_t count = 0;
    for (size_t i = 0; i < g->series->seeds; i++) {
        if (g->runs[i].played > g->landing)
            g->values[count++] = outcome_at(g, i)->zone_mats;
    }
    return series_spread_of(g->values, count);
}

#define SPREAD(g, field) spread_at(g, offsetof(struct series_outcome, field))

static void summarise_landing(struct series_landing_summary *s, const struct gather *g)
{
    for (size_t i = 0; i < g->series->seeds; i++) {
        if (g->runs[i].played <= g->landing)
            continue;
        const struct series_outcome *out = outcome_at(g, i);
        s->played++;
        s->buckled += g->runs[i].buckled == (int)g->landing + 1;
        s->planar += out->asked_planar;
        s->waved += out->waves > 0;
        s->unhinged += out->unhinged;
        s->torn += out->tears > 0;
    }
    s->stop_ft = SPREAD(g, stop_ft);
    s->peak_in = SPREAD(g, peak_in);
    s->reach_ft = SPREAD(g, reach_ft);
    s->zone_mats = zones(g);
    for (size_t k = 0; k < g->series->station_count; k++) {
        s->movement_in[k] =
            spread_at(g, offsetof(struct series_outcome, movement_in) + k * sizeof(double));
        s->total_in[k] = spread_at(g,
                                   offsetof(struct series_outcome, total_in) + k * sizeof(double));
    }
}

void series_summarise(struct series_summary *s, const struct landing_series *series,
                      const struct series_run *runs)
{
    struct gather g = {.series = series, .runs = runs};
    size_t buckled = 0, before = 0, seeds = series->seeds;
    *s = (struct series_summary){0};
    s->landing = xcalloc(series->landing_count, sizeof *s->landing);
    g.values = xcalloc(4 * seeds, sizeof *g.values);
    for (size_t i = 0; i < seeds; i++) {
        s->failed += runs[i].error.status != MR_OK;
        s->runways += runs[i].error.status == MR_OK;
        s->survived += runs[i].error.status == MR_OK && runs[i].buckled == 0;
        if (runs[i].buckled > 0) {
            g.values[buckled] = runs[i].buckle_ft;
            g.values[seeds + buckled++] = runs[i].buckled;
        }
        if (runs[i].buckled > 1) {
            const struct series_outcome *last = &runs[i].outcomes[runs[i].buckled - 2];
            g.values[2 * seeds + before] = last->zone_mats;
            g.values[3 * seeds + before++] = last->peak_in;
        }
    }
    s->station_ft = series_spread_of(g.values, buckled);
    s->buckle_landing = series_spread_of(g.values + seeds, buckled);
    s->zone_before = series_spread_of(g.values + 2 * seeds, before);
    s->peak_before_in = series_spread_of(g.values + 3 * seeds, before);
    for (g.landing = 0; g.landing < series->landing_count; g.landing++)
        summarise_landing(&s->landing[g.landing], &g);
    free(g.values);
}

void series_summary_free(struct series_summary *summary)
{
    free(summary->landing);
    summary->landing = NULL;
}

/* ---- series answer ---- */

static json_t *spread_json(const struct series_spread *s)
{
    return json_pack("[o,o,o]", cli_json_number(s->low, 6), cli_json_number(s->middle, 6),
                     cli_json_number(s->high, 6));
}

static json_t *spreads_json(const struct series_spread *list, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, spread_json(&list[i]));
    return array;
}

/* As many as show two digits of half the interval, and at most `most`: the median is known no
 * better. */
static int decimals_of(const struct series_spread *s, double factor, int most)
{
    double half = factor * (s->high - s->low) / 2.0;
    int decimals = half > 0.0 && isfinite(half) ? 1 - (int)floor(log10(half)) : most;
    return decimals < 0 ? 0 : decimals > most ? most : decimals;
}

/* People read the median and, in brackets, the 5th and 95th percentiles. */
static void add_spread(struct answer *answer, const char *name, const char *label,
                       enum unit_kind kind, const struct series_spread *s, int decimals)
{
    const struct unit *unit = unit_of(kind, answer_in_si(answer));
    const char *suffix = unit_given(kind)->suffix, *mark = unit->suffix[0] ? ",|" : "";
    char key[40], head[60];
    snprintf(key, sizeof key, "%s%s%s", name, suffix[0] ? "_" : "", suffix);
    answer_json_value(answer, key, spread_json(s));
    if (!label)
        return;
    snprintf(head, sizeof head, "%s%s%s", label, mark, unit->text);
    decimals = decimals_of(s, unit->factor, unit_decimals(kind, answer_in_si(answer), decimals));
    answer_words(answer, NULL, head, s->count > 0 ? "%.*f (%.*f-%.*f)" : "-", decimals,
                 unit->factor * s->middle, decimals, unit->factor * s->low, decimals,
                 unit->factor * s->high);
}

static void add_landing(struct answer *answer, const struct landing_series *c,
                        const struct series_landing_summary *s, size_t number)
{
    bool shown = s->played > 0;
    answer_row(answer);
    answer_count(answer, "landing", shown ? "landing" : NULL, (int64_t)number);
    answer_count(answer, "runways", shown ? "runways" : NULL, (int64_t)s->played);
    add_spread(answer, "stop", shown ? "stop" : NULL, UNIT_STATION, &s->stop_ft, 1);
    add_spread(answer, "peak", shown ? "largest|movement" : NULL, UNIT_DISPLACEMENT, &s->peak_in,
               2);
    add_spread(answer, "reach", shown ? "reach|ahead" : NULL, UNIT_STATION, &s->reach_ft, 1);
    add_spread(answer, "zone_mats", shown ? "closed|zone,|mats" : NULL, UNIT_NUMBER, &s->zone_mats,
               0);
    answer_count(answer, "planar", shown ? "planar|engine" : NULL, (int64_t)s->planar);
    answer_count(answer, "with_waves", shown ? "waves" : NULL, (int64_t)s->waved);
    answer_count(answer, "buckled", shown ? "buckled" : NULL, (int64_t)s->buckled);
    answer_count(answer, "unhinged", shown ? "unhinged" : NULL, (int64_t)s->unhinged);
    answer_count(answer, "torn", shown ? "torn" : NULL, (int64_t)s->torn);
    if (shown && c->landings[number - 1].modified)
        answer_words(answer, NULL, "before it", "modified");
    answer_json_value(answer, "movement_in", spreads_json(s->movement_in, c->station_count));
    answer_json_value(answer, "total_in", spreads_json(s->total_in, c->station_count));
}

static void add_stations(struct answer *answer, const struct landing_series *c,
                         const struct series_landing_summary *s)
{
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer)),
                      *movement = unit_of(UNIT_DISPLACEMENT, answer_in_si(answer));
    char label[80];
    snprintf(label, sizeof label, "movement in all, %s, median, at station, %s", movement->text,
             station->text);
    answer_table(answer, NULL, label);
    for (size_t i = 0; i < c->landing_count && s[i].played > 0; i++) {
        answer_row(answer);
        answer_count(answer, NULL, "landing", (int64_t)i + 1);
        for (size_t k = 0; k < c->station_count; k++) {
            snprintf(label, sizeof label, "%.5g", station->factor * c->stations_ft[k]);
            answer_value(answer, NULL, label, UNIT_NUMBER,
                         movement->factor * s[i].total_in[k].middle,
                         unit_decimals(UNIT_DISPLACEMENT, answer_in_si(answer), 2));
        }
    }
    answer_close(answer);
}

static json_t *stations_json(const double *stations_ft, size_t count)
{
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, cli_json_number(stations_ft[i], 6));
    return array;
}

static json_t *outcome_json(const struct series_outcome *o, size_t number)
{
    json_t *object = json_pack(
        "{s:I,s:o,s:o,s:b,s:o,s:o,s:o,s:i,s:o,s:o,s:o,s:o,s:i,s:i,s:o,s:o,s:o,s:o,s:b,s:b,"
        "s:o,s:o}",
        "landing", (json_int_t)number, "stop_ft", cli_json_number(o->stop_ft, 6),
        "deceleration_ft_s2", cli_json_number(o->deceleration_ft_s2, 4), "planar", o->asked_planar,
        "lift_ratio", cli_json_number(o->skip_ratio, 4), "peak_in", cli_json_number(o->peak_in, 5),
        "reach_ft", cli_json_number(o->reach_ft, 5), "zone_mats", o->zone_mats, "zone_from_ft",
        cli_json_number(o->zone_from_ft, 6), "zone_to_ft", cli_json_number(o->zone_to_ft, 6),
        "push_lb", cli_json_number(o->push_lb, 5), "pull_lb", cli_json_number(o->pull_lb, 5),
        "tears", o->tears, "waves", o->waves, "wave_ft",
        o->waves > 0 ? cli_json_number(o->wave_ft, 6) : json_null(), "rise_in",
        cli_json_number(o->rise_in, 5), "crest_deg", cli_json_number(o->crest_deg, 4), "sag_deg",
        cli_json_number(o->sag_deg, 4), "unhinged", o->unhinged, "buckled", o->buckled,
        "overrun_ft", stations_json(o->overrun_ft, (size_t)o->overruns), "failure_ft",
        stations_json(o->failure_ft, (size_t)o->failures));
    if (o->crest_ft > 0.0) {
        json_object_set_new(object, "crest_ft", cli_json_number(o->crest_ft, 6));
        json_object_set_new(object, "crest_ahead_mats", json_integer(o->crest_ahead_mats));
    }
    if (o->band_slack > 0)
        json_object_set_new(object, "band_slack", json_integer(o->band_slack));
    return object;
}

static json_t *run_json(const struct series_run *run)
{
    json_t *outcomes = json_array();
    for (size_t i = 0; i < run->played; i++)
        json_array_append_new(outcomes, outcome_json(&run->outcomes[i], i + 1));
    json_t *object = json_pack(
        "{s:I,s:o,s:o,s:o}", "seed", (json_int_t)run->seed, "buckled_landing",
        run->buckled > 0 ? json_integer(run->buckled) : json_null(), "buckled_ft",
        run->buckled > 0 ? cli_json_number(run->buckle_ft, 6) : json_null(), "landings", outcomes);
    if (run->error.status != MR_OK)
        json_object_set_new(object, "failed", json_string(run->error.text));
    return object;
}

/* Medians over runways: of the largest value that a runway had in the landings before the one that
 * it buckled in. */
static double largest(const struct landing_series *c, const struct series_run *runs,
                      double (*value)(const struct series_outcome *))
{
    double *values = xcalloc(c->seeds, sizeof *values);
    size_t count = 0;
    for (size_t i = 0; i < c->seeds; i++) {
        double most = (double)NAN;
        for (size_t k = 0; k < runs[i].played; k++) {
            if (!runs[i].outcomes[k].buckled)
                most = fmax(most, value(&runs[i].outcomes[k]));
        }
        if (runs[i].error.status == MR_OK && !isnan(most))
            values[count++] = most;
    }
    struct series_spread spread = series_spread_of(values, count);
    free(values);
    return spread.middle;
}

static double movement_in(const struct series_outcome *outcome)
{
    return outcome->peak_in;
}

static double zone_mats(const struct series_outcome *outcome)
{
    return outcome->zone_mats;
}

/* One number each, for tables and sweeps. */
static void add_medians(struct answer *answer, const struct landing_series *c,
                        const struct series_run *runs, const struct series_summary *s)
{
    /* NaN without a runway: null */
    double share = (double)(s->runways - s->survived) / (double)s->runways;
    answer_value(answer, "buckled_share", NULL, UNIT_NUMBER, share, 2);
    answer_value(answer, "median_landing", NULL, UNIT_NUMBER, s->buckle_landing.middle, 0);
    answer_value(answer, "median_station", NULL, UNIT_STATION, s->station_ft.middle, 1);
    answer_value(answer, "median_zone_mats", NULL, UNIT_NUMBER, largest(c, runs, zone_mats), 0);
    answer_value(answer, "median_movement", NULL, UNIT_DISPLACEMENT, largest(c, runs, movement_in),
                 2);
}

static void add_buckled(struct answer *answer, const struct landing_series *c,
                        const struct series_summary *s)
{
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer));
    char in[200] = "";
    for (size_t i = 0, length = 0; i < c->landing_count && length < sizeof in; i++) {
        if (s->landing[i].buckled > 0)
            length += (size_t)snprintf(in + length, sizeof in - length, ", %zu in landing %zu",
                                       s->landing[i].buckled, i + 1);
    }
    answer_words(answer, NULL, "buckled", "%zu of %zu runways%s", s->runways - s->survived,
                 s->runways, in);
    if (s->station_ft.count > 0)
        answer_remark(answer, "; at station %.1f (%.1f-%.1f) %s",
                      station->factor * s->station_ft.middle, station->factor * s->station_ft.low,
                      station->factor * s->station_ft.high, station->text);
    answer_json_value(answer, "buckled_landing", spread_json(&s->buckle_landing));
    answer_json_value(answer, "buckled_ft", spread_json(&s->station_ft));
}

static void add_told(struct answer *answer, const char *label, const char *text)
{
    if (text[0])
        answer_words(answer, NULL, label, "%s", text);
}

/* What came out of it, and what the answer is worth. */
static void series_answer_outcome(struct answer *answer, const struct landing_series *c,
                                  const struct series_run *runs, const struct series_summary *s)
{
    answer_sentence(answer, NULL, "%s: %zu landings on %zu runways (seeds %llu to %llu), %d mats",
                    c->name, c->landing_count, c->seeds, (unsigned long long)c->first_seed,
                    (unsigned long long)(c->first_seed + c->seeds - 1), c->landings[0].scene.mats);
    answer_words(answer, "name", NULL, "%s", c->name);
    answer_count(answer, "seeds", NULL, (int64_t)c->seeds);
    answer_count(answer, "first_seed", NULL, (int64_t)c->first_seed);
    answer_count(answer, "failed", NULL, (int64_t)s->failed);
    answer_count(answer, "survived", NULL, (int64_t)s->survived);
    answer_words(answer, "observed", NULL, "%s", c->observed);
    for (size_t i = 0; i < c->seeds; i++) {
        if (runs[i].error.status != MR_OK)
            answer_words(answer, NULL, "FAILED", "seed %llu, landing %zu: %s",
                         (unsigned long long)runs[i].seed, runs[i].played + 1, runs[i].error.text);
    }
    char ground[200];
    series_ground_text(c, ground, sizeof ground);
    answer_words(answer, "ground", "ground", "%s", ground);
    add_buckled(answer, c, s);
    add_told(answer, "observed", c->observed);
    add_told(answer, "parameters", c->basis);
    add_told(answer, "put in afterwards, so no prediction", c->afterwards);
}

/* Landing by landing. */
static void series_answer_landings(struct answer *answer, const struct landing_series *c,
                                   const struct series_run *runs, const struct series_summary *s)
{
    json_t *list = json_array();
    answer_table(answer, "landings",
                 "landings: median and, in brackets, 5th to 95th percentile over the runways that "
                 "took the landing");
    for (size_t i = 0; i < c->landing_count; i++)
        add_landing(answer, c, &s->landing[i], i + 1);
    answer_close(answer);
    add_stations(answer, c, s->landing);
    answer_json_value(answer, "stations_ft", stations_json(c->stations_ft, c->station_count));
    for (size_t i = 0; i < c->seeds; i++)
        json_array_append_new(list, run_json(&runs[i]));
    answer_json_value(answer, "runways", list);
    add_medians(answer, c, runs, s);
}

struct answer *series_answer(const struct landing_series *c, const struct series_run *runs,
                             const struct series_summary *s, bool si)
{
    struct answer *answer = answer_new(si);
    answer_as_given(answer);
    series_answer_outcome(answer, c, runs, s);
    series_answer_landings(answer, c, runs, s);
    return answer;
}
