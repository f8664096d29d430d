#include "host/landing_series/ensemble.h"

#include <math.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/splitmix.h"
#include "host/base/parallel_for.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/mods.h"
#include "host/sim/sim.h"

/* ---- draw ---- */

/* Integration step of the path on the rig, s. On a scaled runway it is proportional to the square
 * root of the mat length. */
#define PATH_STEP_S         1e-3
#define PATH_STEP_MAT_FT    (2.0 / 7.0) /* length of a mat of the rig, ft */
#define G_FT_S2             32.174
#define PATH_STEPS_PER_ROW  10
#define PATH_MAX_DURATION_S 600.0

struct draw_generator draw_generator_init(uint64_t seed, unsigned stream)
{
    uint64_t state = seed;
    state = mr_splitmix64(&state) + 0x632be59bd9b4e019u * (stream + 1u);
    return (struct draw_generator){mr_splitmix64(&state)};
}

static double draw_uniform(struct draw_generator *draw)
{
    return mr_splitmix64_uniform(&draw->state);
}

double draw_from_range(struct draw_generator *draw, struct series_range range)
{
    return range.low + (range.high - range.low) * draw_uniform(draw);
}

static double get_profile_deceleration_ft_s2(const struct series_landing *landing,
                                             double drawn_ft_s2, double station_ft)
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

static void add_path_row(struct draw_path *path, struct sim_path_row row)
{
    xlist_grow(&path->rows, path->count, sizeof row);
    path->rows[path->count++] = row;
}

enum mr_status draw_landing_path(const struct landing_series *series,
                                 const struct series_landing *landing, uint64_t seed, size_t index,
                                 struct draw_path *path, struct error *error)
{
    struct draw_generator draw = draw_generator_init(seed, DRAW_LANDING + (unsigned)index);
    double lb_per_ft_s2 = series->weight_lb / (series->axles * landing->scene.g_ft_s2);
    double at_ft = draw_from_range(&draw, landing->touchdown_ft),
           v_ft_s = draw_from_range(&draw, landing->speed_ft_s);
    double drawn_ft_s2 = draw_from_range(&draw, landing->deceleration_ft_s2), from_ft_s = v_ft_s;
    double runway_ft = landing->scene.mats * landing->scene.length_ft, t_s = 0.0, force_lb = 0.0;
    double node_s = PATH_STEP_S * sqrt(landing->scene.length_ft / PATH_STEP_MAT_FT *
                                       (G_FT_S2 / landing->scene.g_ft_s2));
    draw_path_free(path);
    path->touchdown_ft = at_ft;
    for (size_t k = 0; v_ft_s > 0.0 && at_ft < runway_ft; k++) {
        t_s = node_s * (double)k;
        double onset = series->onset_s > 0.0 ? fmin(t_s / series->onset_s, 1.0) : 1.0;
        /* a towed model moves at constant speed */
        double share = onset * onset * (3.0 - 2.0 * onset), a_ft_s2 = 0.0;
        if (!(landing->tow_lb > 0.0))
            a_ft_s2 = share * get_profile_deceleration_ft_s2(landing, drawn_ft_s2, at_ft);
        force_lb = landing->tow_lb > 0.0 ? share * landing->tow_lb : lb_per_ft_s2 * a_ft_s2;
        if (k % PATH_STEPS_PER_ROW == 0)
            add_path_row(path, (struct sim_path_row){t_s, at_ft, force_lb});
        if (t_s > PATH_MAX_DURATION_S)
            return error_set(error, MR_USAGE,
                             "no stop: %s: in landing %zu the gear still rolls after %g s; give a "
                             "higher deceleration",
                             series->name, index + 1, PATH_MAX_DURATION_S);
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
    add_path_row(path, (struct sim_path_row){t_s, at_ft, force_lb});
    add_path_row(path, (struct sim_path_row){t_s, at_ft, 0.0});
    return MR_OK;
}

void draw_path_free(struct draw_path *path)
{
    free(path->rows);
    *path = (struct draw_path){0};
}

/* ---- failures ---- */

static double find_failure_station_ft(const double *rise_ft, size_t first, size_t last,
                                      double length_ft, const double *reached_ft, int reached_count)
{
    size_t crest = first;
    for (int i = 0; i < reached_count; i++) {
        double node = reached_ft[i] / length_ft + 1.0;
        if (node > (double)first - 0.5 && node < (double)last + 0.5)
            return reached_ft[i];
    }
    for (size_t j = first; j <= last; j++)
        crest = rise_ft[j] > rise_ft[crest] ? j : crest;
    return (double)(crest - 1) * length_ft;
}

int series_find_failures(const double *rise_ft, size_t nodes, double length_ft, double limit_ft,
                         const double *reached_ft, int reached_count,
                         double failure_ft[SERIES_FAILURES_MAX])
{
    int count = 0;
    size_t first = 0;
    for (size_t j = 2; j <= nodes && count < SERIES_FAILURES_MAX; j++) {
        bool high = j < nodes && rise_ft[j] >= limit_ft;
        if (high && first == 0)
            first = j;
        if (high || first == 0)
            continue;
        failure_ft[count++] = find_failure_station_ft(rise_ft, first, j - 1, length_ft, reached_ft,
                                                      reached_count);
        first = 0;
    }
    return count;
}

/* ---- flatten ---- */

#define CLOSED_FT 1e-12

/* One side of a joint that is being flattened. */
struct joint_side {
    size_t next_open_joint; /* index of the next open joint on this side */
    /* friction of the mats from the joint to `front`, plus the closing resistance of the joint
     * there */
    double resistance_lb;
};

static struct joint_side find_joint_side(const struct runway_flattening *r, size_t joint, int step)
{
    struct joint_side side = {joint, 0.0};
    while ((step < 0 && side.next_open_joint > 0) ||
           (step > 0 && side.next_open_joint + 1 < r->joint_count)) {
        side.next_open_joint = (size_t)((long)side.next_open_joint + step);
        side.resistance_lb += r->friction_force_lb;
        if (r->gap_ft[side.next_open_joint] > CLOSED_FT) {
            side.resistance_lb += r->closing_resistance_lb[side.next_open_joint];
            return side;
        }
    }
    side.resistance_lb = HUGE_VAL; /* the end of the runway is fixed */
    return side;
}

/* Moves the mats between the joints `low` and `high`. */
static void shift_mats(const struct runway_flattening *r, size_t low, size_t high, double by_ft)
{
    for (size_t mat = low + 1; mat <= high; mat++)
        r->u_ft[mat] += by_ft;
}

void flatten_waves(const struct runway_flattening *r)
{
    for (size_t j = 0; j < r->joint_count; j++) {
        while (r->gap_ft[j] < -CLOSED_FT) {
            struct joint_side left = find_joint_side(r, j, -1), right = find_joint_side(r, j, 1);
            bool to_left = left.resistance_lb < right.resistance_lb;
            struct joint_side *side = to_left ? &left : &right;
            double over_ft = -r->gap_ft[j] - side->resistance_lb / r->kl_lb_ft;
            if (!(over_ft > CLOSED_FT))
                break;
            double by_ft = fmin(over_ft, r->gap_ft[side->next_open_joint]);
            r->gap_ft[side->next_open_joint] -= by_ft;
            r->gap_ft[j] += by_ft;
            if (to_left)
                shift_mats(r, side->next_open_joint, j, -by_ft);
            else
                shift_mats(r, j, side->next_open_joint, by_ft);
        }
    }
}

/* ---- seeds ---- */

struct ensemble_work {
    const struct landing_series *series;
    struct series_run *runs;
    atomic_size_t started_run_count, completed_run_count;
    void (*progress)(void *ctx, size_t done, size_t total);
    void *ctx;
};

/* Simulates runs in a thread. Each thread takes the next seed that no thread has started, because
 * run times differ. */
static void simulate_runs(void *context, size_t from, size_t every)
{
    struct ensemble_work *work = context;
    (void)every;
    for (size_t i;
         (i = atomic_fetch_add(&work->started_run_count, 1)) < work->series->seed_count;) {
        series_simulate(work->series, work->series->first_seed + i, &work->runs[i]);
        size_t done = atomic_fetch_add(&work->completed_run_count, 1) + 1;
        if (from == 0 && work->progress)
            work->progress(work->ctx, done, work->series->seed_count);
    }
}

void series_simulate_all(const struct landing_series *series, unsigned jobs,
                         void (*progress)(void *ctx, size_t done, size_t total), void *ctx,
                         struct series_run *runs)
{
    struct ensemble_work work = {.series = series, .runs = runs, .progress = progress, .ctx = ctx};
    parallel_for(jobs < series->seed_count ? jobs : (unsigned)series->seed_count, simulate_runs,
                 &work);
    series_compute_errors(series, runs);
}

/* ---- simulation of a series of landings ---- */

#define IN_PER_FT           12.0
#define ZONE_JOINTS         10 /* number of joints between two gage points of the rig */
#define ZONE_OPEN_SHARE_MAX (1.0 / 3.0)
/* smallest movement that counts, as a fraction of a mat's length: 0.001 in on the rig */
#define MOVED_SHARE_MIN     (0.001 * 7.0 / 24.0)

/* The state of a runway between landings. */
struct runway {
    const struct landing_series *series;
    int mat_count;
    size_t joint_count;
    double *storage;
    double *gap_ft, *closing_resistance_lb, *ground_ft; /* arrays by joint */
    double laid_gap_ft; /* mean opening of the joints when the runway was laid */
    double *u_ft;       /* total movement of each mat; [0] is unused */
    /* state of the modifications after the last landing; this struct owns the lists */
    struct sim_mods mods;
};

static void make_runway(struct runway *r, const struct landing_series *series, uint64_t seed)
{
    *r = (struct runway){.series = series, .mat_count = series->landings[0].scene.mats};
    r->joint_count = (size_t)r->mat_count + 1;
    r->storage = xcalloc(4 * (r->joint_count + 1), sizeof *r->storage);
    r->gap_ft = r->storage;
    r->closing_resistance_lb = r->gap_ft + r->joint_count;
    r->ground_ft = r->closing_resistance_lb + r->joint_count;
    r->u_ft = r->ground_ft + r->joint_count;
    struct draw_generator gaps = draw_generator_init(seed, DRAW_GAPS),
                          closing = draw_generator_init(seed, DRAW_CLOSING),
                          ground = draw_generator_init(seed, DRAW_GROUND);
    double slack_ft = series->landings[0].scene.slack_ft;
    for (size_t j = 0; j < r->joint_count; j++) {
        r->gap_ft[j] = fmin(draw_from_range(&gaps, series->gap_in) / IN_PER_FT, slack_ft);
        r->laid_gap_ft += r->gap_ft[j] / (double)r->joint_count;
        r->closing_resistance_lb[j] = draw_from_range(&closing, series->closing_lb);
        r->ground_ft[j] = draw_from_range(&ground, series->irregularity_in) / IN_PER_FT;
    }
}

static double get_joint_strength_lb(const struct runway *r)
{
    const struct landing_series *c = r->series;
    return c->strength_lb_in * c->strip_ft * IN_PER_FT;
}

static void copy_scene_list(struct sim_list *list)
{
    struct sim_list copy = {0};
    sim_scene_set_list(&copy, list->values, list->count);
    *list = copy;
}

/* Applies the modifications that the file has before a landing. Torn joints stay torn. */
static void apply_scene_mods(struct runway *r, const struct sim_scene *scene)
{
    struct sim_list torn = r->mods.torn;
    r->mods.torn = (struct sim_list){0};
    mods_free_lists(&r->mods);
    r->mods = scene->mods;
    struct sim_list *lists[MODS_LIST_COUNT];
    mods_collect_lists(&r->mods, lists);
    for (size_t i = 0; i < MODS_LIST_COUNT; i++)
        copy_scene_list(lists[i]); /* copy every list: the originals belong to the series */
    if (torn.count > 0) {
        free(r->mods.torn.values);
        r->mods.torn = torn;
    }
}

static void store_mods_state(struct runway *r, const struct sim_scene *as_landed,
                             const struct sim_result *result)
{
    struct sim_scene scene = *as_landed;
    scene.mods = r->mods;
    mods_carry_over(&scene, result);
    r->mods = scene.mods;
}

static void make_scene(const struct runway *r, const struct sim_scene *made, enum sim_model model,
                       const struct sim_path_row *rows, size_t count, struct sim_scene *scene)
{
    *scene = *made; /* the lists still belong to the series; they are replaced by copies below */
    scene->model = model;
    scene->gap0_ft = scene->grit_lb = scene->ground_ft = (struct sim_list){0};
    scene->mods = r->mods; /* the scene can share the lists, because it only reads them */
    scene->path = NULL;
    scene->path_count = 0;
    scene->t_dwell_s = r->series->dwell_s;
    sim_scene_set_list(&scene->gap0_ft, r->gap_ft, r->joint_count);
    sim_scene_set_list(&scene->grit_lb, r->closing_resistance_lb, r->joint_count);
    if (model == SIM_MODEL_CONSISTENT)
        sim_scene_set_list(&scene->ground_ft, r->ground_ft, r->joint_count);
    sim_scene_set_path(scene, rows, count);
}

static void free_scene(struct sim_scene *scene)
{
    free(scene->gap0_ft.values);
    free(scene->grit_lb.values);
    free(scene->ground_ft.values);
    free(scene->path);
}

/* Simulates a landing. `first`: NULL in the first simulation; when it is repeated with another time
 * step, the outcome of the same landing in the first simulation. */
static enum mr_status run_engine(const struct runway *r, const struct series_landing *landing,
                                 enum sim_model model, const struct draw_path *path,
                                 const struct series_outcome *first, struct series_outcome *out,
                                 struct sim_result *result, struct error *error)
{
    const struct landing_series *c = r->series;
    bool chain = model == SIM_MODEL_CHAIN;
    const struct sim_options options = {
        .dt_s = first ? first->check_step_s[!chain]
              : chain ? c->chain_dt_s
                      : c->planar_dt_s,
        .is_single_pass = true,
        .wave_encounter_height_ft = model == SIM_MODEL_CONSISTENT ? c->buckle_in / IN_PER_FT : 0.0,
    };
    struct sim_scene scene = {0};
    *result = (struct sim_result){0};
    make_scene(r, &landing->scene, model, path->rows, path->count, &scene);
    sim_run(&scene, &options, result, error);
    free_scene(&scene);
    double longer_s = SERIES_CHECK_STEP_RATIO * result->dt_s;
    out->check_step_s[!chain] = longer_s < result->dt_limit_s
                                  ? longer_s
                                  : result->dt_s / SERIES_CHECK_STEP_RATIO;
    if (result->status == SIM_FOLDED) /* a folded runway is an outcome, not a failure */
        *error = (struct error){0};
    return error->status;
}

/* Returns the largest lift force on a node due to the compression P of its joint, in weights of a
 * mat. Two mats rise and form an inverted V if P (2 h_j - h_{j-1} - h_{j+1})/L > W. */
static double compute_lift_ratio(const struct runway *r, const struct sim_scene *scene,
                                 const double *push_lb)
{
    double most = 0.0;
    for (size_t j = 1; j + 1 < r->joint_count; j++) {
        double bend = 2.0 * r->ground_ft[j] - r->ground_ft[j - 1] - r->ground_ft[j + 1];
        most = fmax(most, push_lb[j + 1] * bend / (scene->length_ft * scene->weight_lb));
    }
    return most;
}

/* Returns true if the scene has stiffeners that connect mats. A wheel at one end of such mats tips
 * them, and their joints rise without compression. */
static bool has_tipping_stiffeners(const struct sim_scene *scene)
{
    return scene->mods.stiffener_span_mats > 1 && scene->mods.stiffener_kt_lb_ft_rad > 0.0 &&
           scene->wheel_load_lb > 0.0;
}

static double get_joint_station_ft(const struct sim_scene *scene, size_t j)
{
    return (double)j * scene->length_ft;
}

static void record_waves(const struct runway *r, const struct sim_scene *scene,
                         const double *rise_ft, struct series_outcome *out)
{
    double limit_ft = r->series->wave_in / IN_PER_FT, highest_ft = 0.0;
    for (size_t j = 1; j + 1 < r->joint_count; j++) {
        double h = rise_ft[j + 1];
        out->wave_rise_in = fmax(out->wave_rise_in, h * IN_PER_FT);
        if (!(h > limit_ft && h >= rise_ft[j] && h > rise_ft[j + 2]))
            continue;
        out->wave_count++;
        if (h > highest_ft)
            out->wave_station_ft = get_joint_station_ft(scene, j);
        highest_ft = fmax(highest_ft, h);
    }
}

/* Records the outcome of the planar engine. `folded`: a mat has turned upright. */
static void record_planar(const struct runway *r, const struct sim_scene *scene,
                          const struct sim_result *result, bool folded, struct series_outcome *out)
{
    out->has_planar_run = true;
    if (result->first_crest_node > 0 && result->first_crest_wheel_mat > 0) {
        out->first_buckle_station_ft = get_joint_station_ft(scene,
                                                            (size_t)result->first_crest_node - 1);
        out->first_buckle_ahead_mats = result->first_crest_node - result->first_crest_wheel_mat;
    }
    if (folded) {
        out->is_buckled = true;
        out->buckle_station_ft = get_joint_station_ft(scene, (size_t)result->mat);
        out->wave_rise_in = r->series->buckle_in;
        out->failure_count = 1;
        out->failure_station_ft[0] = out->buckle_station_ft;
        return;
    }
    record_waves(r, scene, result->max_rise_ft, out);
    out->crest_angle_deg = result->crest_deg;
    out->sag_angle_deg = result->sag_deg;
    out->is_unhinged = result->sag_deg > r->series->unhinge_deg;
    out->is_buckled = out->is_unhinged || out->wave_rise_in >= r->series->buckle_in;
    out->wave_encounter_count = result->wave_encounter_count;
    for (int i = 0; i < result->wave_encounter_count; i++)
        out->wave_encounter_station_ft[i] =
            get_joint_station_ft(scene, (size_t)result->wave_encounter_nodes[i] - 1);
    if (out->is_buckled)
        out->buckle_station_ft = out->wave_encounter_count > 0 ? out->wave_encounter_station_ft[0]
                               : out->wave_count > 0
                                   ? out->wave_station_ft
                                   : get_joint_station_ft(scene, (size_t)result->sag_joint - 1);
    out->failure_count = series_find_failures(
        result->max_rise_ft, r->joint_count, scene->length_ft, r->series->buckle_in / IN_PER_FT,
        out->wave_encounter_station_ft, out->wave_encounter_count, out->failure_station_ft);
    if (out->is_buckled && out->failure_count == 0)
        out->failure_station_ft[out->failure_count++] = out->buckle_station_ft;
}

/* Returns true if a mat is torn from both neighbours; it then no longer belongs to the runway. */
static bool is_mat_torn_off(const struct sim_result *result, int mat)
{
    const struct mods_state *s = result->mods;
    return s && s->torn[mat] != 0.0 && s->torn[mat + 1] != 0.0;
}

static void record_movement(struct runway *r, const struct sim_scene *scene,
                            const struct sim_result *result, struct series_outcome *out)
{
    const struct landing_series *c = r->series;
    const double *u_ft = result->u_ft;
    for (int n = 1; n <= r->mat_count; n++) {
        r->u_ft[n] += u_ft[n];
        if (is_mat_torn_off(result, n))
            continue;
        out->peak_movement_in = fmax(out->peak_movement_in, fabs(u_ft[n]) * IN_PER_FT);
        double station_ft = (n - 0.5) * scene->length_ft;
        if (fabs(u_ft[n]) > MOVED_SHARE_MIN * scene->length_ft &&
            station_ft - out->stop_ft > out->moved_length_beyond_stop_ft)
            out->moved_length_beyond_stop_ft = station_ft - out->stop_ft;
    }
    for (size_t i = 0; i < c->station_count; i++) {
        int mat = (int)fmin(floor(c->stations_ft[i] / scene->length_ft) + 1.0, r->mat_count);
        out->movement_in[i] = u_ft[mat] * IN_PER_FT;
        out->total_movement_in[i] = r->u_ft[mat] * IN_PER_FT;
    }
}

static void record_joints(const struct runway *r, const struct sim_result *result,
                          struct series_outcome *out)
{
    double most_lb = get_joint_strength_lb(r);
    for (size_t j = 0; j < r->joint_count; j++) {
        out->compression_lb = fmax(out->compression_lb, result->max_compression_lb[j + 1]);
        out->tension_lb = fmax(out->tension_lb, result->max_tension_lb[j + 1]);
        out->torn_joint_count += result->max_tension_lb[j + 1] > most_lb;
    }
}

/* Finds the longest stretch in which the openings of any ten consecutive joints add up to less than
 * a third of their sum when laid. Measurements at the gage points would show such a zone. */
static void record_zone(const struct runway *r, const struct sim_scene *scene,
                        struct series_outcome *out)
{
    double limit_ft = ZONE_OPEN_SHARE_MAX * r->laid_gap_ft * ZONE_JOINTS, sum_ft = 0.0;
    size_t from = 0;
    bool in = false;
    for (size_t j = 0; j < r->joint_count; j++) {
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
            out->zone_start_ft = get_joint_station_ft(scene, from);
            out->zone_end_ft = get_joint_station_ft(scene, j);
        }
    }
}

/* Counts the band segments that have no tension. */
static void record_bands(const struct sim_scene *scene, const struct mods_state *state,
                         struct series_outcome *out)
{
    size_t segment = 0;
    for (int g = 0; g < SIM_BAND_GROUPS && state; g++) {
        int connections = mods_connection_count(scene, g);
        for (int i = 0; i <= connections && connections > 0; i++)
            out->slack_band_segment_count += state->band_min_lb[segment++] <= 0.0;
    }
}

/* Updates the gaps of the joints after a movement of the mats. */
static void update_gaps(struct runway *r, const double *u_ft)
{
    for (size_t j = 0; j < r->joint_count; j++)
        r->gap_ft[j] += (j < (size_t)r->mat_count ? u_ft[j + 1] : 0.0) - (j > 0 ? u_ft[j] : 0.0);
}

/* Presses remaining waves flat, as the aircraft does when it is pushed back over them. The excess
 * length of the mats closes neighbouring joints. */
static void flatten_remaining_waves(struct runway *r, const struct sim_scene *scene)
{
    const struct runway_flattening flat = {r->joint_count,
                                           r->gap_ft,
                                           r->u_ft,
                                           r->closing_resistance_lb,
                                           scene->friction * scene->weight_lb,
                                           scene->kl_lb_ft};
    flatten_waves(&flat);
}

/* Updates the runway and the outcome after a landing. */
static void update_runway(struct runway *r, const struct sim_scene *scene,
                          const struct sim_result *moved, struct series_outcome *out)
{
    record_movement(r, scene, moved, out);
    update_gaps(r, moved->u_ft);
    if (r->series->flattens_waves && out->wave_count > 0)
        flatten_remaining_waves(r, scene);
    record_joints(r, moved, out);
    record_zone(r, scene, out);
    record_bands(scene, moved->mods, out);
    store_mods_state(r, scene, moved);
}

static enum mr_status simulate_landing_once(struct runway *r, const struct series_landing *landing,
                                            const struct draw_path *path,
                                            const struct series_outcome *first,
                                            struct series_outcome *out, struct error *error)
{
    const struct landing_series *c = r->series;
    const struct sim_scene *scene = &landing->scene;
    struct sim_result chain = {0}, planar = {0};
    if (c->engine != SERIES_ENGINE_PLANAR &&
        run_engine(r, landing, SIM_MODEL_CHAIN, path, first, out, &chain, error) == MR_OK)
        out->lift_ratio = compute_lift_ratio(r, scene, chain.max_compression_lb);
    bool asked = c->engine == SERIES_ENGINE_PLANAR ||
                 (c->engine == SERIES_ENGINE_AUTO &&
                  (out->lift_ratio > c->planar_min_lift_share || has_tipping_stiffeners(scene)));
    if (error->status == MR_OK && (first ? first->is_planar : asked) &&
        run_engine(r, landing, SIM_MODEL_CONSISTENT, path, first, out, &planar, error) == MR_OK) {
        record_planar(r, scene, &planar, planar.status == SIM_FOLDED, out);
        out->is_planar = planar.u_ft && (c->engine == SERIES_ENGINE_PLANAR || out->wave_count > 0);
    }
    const struct sim_result *moved = out->is_planar ? &planar : &chain;
    if (error->status == MR_OK && moved->u_ft)
        update_runway(r, scene, moved, out);
    sim_result_free(&chain);
    sim_result_free(&planar);
    return error->status;
}

static void free_runway(struct runway *r)
{
    mods_free_lists(&r->mods);
    free(r->storage);
}

static void simulate_run(const struct landing_series *series, uint64_t seed,
                         const struct series_run *first, struct series_run *run)
{
    struct runway runway = {0};
    struct draw_path path = {0};
    size_t landings = first ? first->simulated_landing_count : series->landing_count;
    *run = (struct series_run){.seed = seed};
    run->outcomes = xcalloc(series->landing_count, sizeof *run->outcomes);
    make_runway(&runway, series, seed);
    for (size_t i = 0; i < landings && run->buckled_landing == 0; i++) {
        const struct series_landing *landing = &series->landings[i];
        struct series_outcome *out = &run->outcomes[i];
        if (i == 0 || landing->is_modified)
            apply_scene_mods(&runway, &landing->scene);
        if (draw_landing_path(series, landing, seed, i, &path, &run->error) != MR_OK)
            break;
        out->stop_ft = path.stop_ft;
        out->deceleration_ft_s2 = path.mean_ft_s2;
        if (simulate_landing_once(&runway, landing, &path, first ? &first->outcomes[i] : NULL, out,
                                  &run->error) != MR_OK)
            break;
        run->simulated_landing_count = i + 1;
        if (out->is_buckled) {
            run->buckled_landing = (int)i + 1;
            run->buckle_station_ft = out->buckle_station_ft;
        }
    }
    draw_path_free(&path);
    free_runway(&runway);
}

void series_simulate(const struct landing_series *series, uint64_t seed, struct series_run *run)
{
    struct series_run other;
    size_t index = (size_t)(seed - series->first_seed);
    simulate_run(series, seed, NULL, run);
    if (index % SERIES_CHECK_EVERY != SERIES_CHECK_EVERY - 1)
        return;
    simulate_run(series, seed, run, &other);
    run->check_outcomes = other.outcomes;
    run->check_landing_count = other.simulated_landing_count;
}

void series_run_free(struct series_run *run)
{
    free(run->outcomes);
    free(run->check_outcomes);
    run->outcomes = run->check_outcomes = NULL;
}
