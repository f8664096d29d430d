#include "host/sim/solvers/landing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/solvers/pass.h"
#include "host/sim/solvers/planar_engine.h"
#include "host/sim/elements/law.h"

/* ---- one run ---- */

#define FOLDED_DEG           85.0
#define DEGREES              (180.0 / 3.14159265358979323846)
/* of an overrun's rise: lower, the wheel has left that wave, and the next is another */
#define OFF_WAVE_SHARE       0.5
#define SLIGHT_TURN          0.01 /* of a joint, in sines: smaller ones are not worth an arc sine */
#define STEPS_BETWEEN_ASKING 1024 /* whether to go on */
#define LOOK_STEPS           4    /* between looks at lifts and angles */
#define LANDING_PARTS        16   /* of a step in which a node lands */
#define GENTLE               1e-4 /* of sqrt(g L): what lands slower lifts nobody */

/* One run over the whole landing; the record is made before. */
struct march {
    uint64_t steps, done, events;
    double h_s, ms;
    enum sim_status status;
    int mat;
    double t_s;
    double max_lift_ft;
    double jolt_ft_s; /* the soil's largest: what a node's speed has changed by in a step */
    double speed_end_ft_s;
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    int overrun[SIM_OVERRUNS_MAX], overruns;
    bool on_wave; /* the wheel, since it met the last of them */
    int first_crest, first_crest_wheel;
    double awake_s;
    int mats_max;
    struct sim_record record;
    struct mods_state *mods; /* at its end; NULL without modifications */
    int number;              /* of this march, for go_on */
};

/* The mat that carries most of the wheel; -1: none. */
static int under_wheel(const struct sim_touch *touch, int count)
{
    double most = 0.0;
    int mat = -1;
    for (int i = 0; i < count; i++) {
        if (touch[i].load_share > most) {
            most = touch[i].load_share;
            mat = touch[i].mat - 1;
        }
    }
    return mat;
}

/* The largest lift `back_s` before the present step's end, and its node. */
static double lift_ft(const struct planar_engine *l, double back_s, int *node_from_1)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    double most_ft = 0.0;
    *node_from_1 = 1;
    for (int j = l->heaves.first; j <= l->heaves.last + 1 && l->heaves.last >= l->heaves.first;
         j++) {
        double up_ft = v[2 * j] * back_s - l->z[2 * j];
        if (up_ft > most_ft && up_ft > SOIL_TOUCH_FT) {
            most_ft = up_ft;
            *node_from_1 = j + 1;
        }
    }
    return most_ft;
}

/* All that is wanted up to t_s, each at its own time: speeds are those of the step that ends at
 * t_s. */
static void take(struct planar_engine *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    while (march->record.next_s <= t_s) {
        double at_s = march->record.next_s, back_s = t_s - at_s;
        for (int n = 0; n < m->mats; n++) {
            l->v[n + 1] = v[2 * n + 1];
            l->u[n + 1] = l->z[2 * n + 1] - v[2 * n + 1] * back_s;
            l->height[n + 1] = v[2 * n] * back_s - l->z[2 * n];
        }
        march->record.height_ft = l->height;
        march->record.lift_ft = lift_ft(l, back_s, &march->record.lift_node);
        march->max_lift_ft = fmax(march->max_lift_ft, march->record.lift_ft);
        sim_record_take(&march->record, at_s, l->u, l->v);
    }
}

/* What each node and joint of the heaving part has come to. */
static void note_shape(struct planar_engine *l, struct march *march)
{
    const struct model *m = &l->model;
    const double *p = l->z;
    double left = 0.0;
    for (int j = l->heaves.first; j <= l->heaves.last + 1; j++) {
        double tilt = j <= l->heaves.last && m->tilt_ft ? m->tilt_ft[j] : 0.0;
        double right = j <= l->heaves.last ? (p[2 * j + 2] - p[2 * j] + tilt) / m->length_ft : 0.0;
        l->rise_ft[j] = -p[2 * j] > l->rise_ft[j] ? -p[2 * j] : l->rise_ft[j];
        if (fabs(right - left) > SLIGHT_TURN && fabs(right) < 1.0 && fabs(left) < 1.0) {
            double turn_deg = (asin(right) - asin(left)) * DEGREES;
            if (turn_deg > march->crest_deg) {
                march->crest_deg = turn_deg;
                march->crest_joint = j + 1;
            }
            if (-turn_deg > march->sag_deg) {
                march->sag_deg = -turn_deg;
                march->sag_joint = j + 1;
            }
        }
        left = right;
    }
}

/* The highest node, when the first of them has risen so far. */
static void note_crest(const struct planar_engine *l, struct march *march, double lift_ft)
{
    int highest = l->heaves.first;
    for (int j = l->heaves.first + 1; j <= l->heaves.last + 1 && j <= l->model.mats; j++)
        highest = l->z[2 * j] < l->z[2 * highest] ? j : highest;
    if (l->heaves.last >= l->heaves.first && -l->z[2 * highest] >= lift_ft) {
        march->first_crest = highest + 1;
        march->first_crest_wheel = l->model.span.mat + 1;
    }
}

/* The wheel at a wave that has risen too far to be pressed flat. */
static void note_overrun(const struct planar_engine *l, struct march *march, double lift_ft)
{
    int mat = l->model.span.mat;
    if (march->first_crest == 0)
        note_crest(l, march, lift_ft);
    if (mat < 0)
        return;
    double left_ft = -l->z[2 * mat], right_ft = -l->z[2 * mat + 2];
    int node = (left_ft > right_ft ? mat : mat + 1) + 1;
    bool meets = fmax(left_ft, right_ft) >= lift_ft;
    if (meets && !march->on_wave && march->overruns < SIM_OVERRUNS_MAX)
        march->overrun[march->overruns++] = node;
    march->on_wave = meets ||
                     (march->on_wave && fmax(left_ft, right_ft) >= OFF_WAVE_SHARE * lift_ft);
}

static bool sound(struct planar_engine *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    int mat = l->slides.first + 1, node;
    double sum = 0.0;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        sum += fabs(l->z[2 * n + 1]) + fabs(l->z[m->size + 2 * n + 1]);
    if (l->heaves.last >= l->heaves.first) {
        double angle = model_worst_angle_deg(m, l->z, &mat);
        march->max_lift_ft = fmax(march->max_lift_ft, model_lift_ft(m, l->z, &node));
        note_shape(l, march);
        if (angle > FOLDED_DEG)
            march->status = SIM_FOLDED;
        if (!isfinite(angle))
            march->status = SIM_UNSTABLE;
    }
    if (!(sum < 1e6 * m->mats * m->length_ft))
        march->status = SIM_UNSTABLE;
    march->mat = mat;
    march->t_s = t_s;
    return march->status == SIM_OK;
}

static void begin(struct planar_engine *l, bool prunes)
{
    struct model *m = &l->model;
    model_start(m, l->z);
    l->slides = l->heaves = (struct part){0, m->mats - 1, 0, 0};
    for (int j = 0; j <= m->mats; j++)
        l->reach_ft[j] = joint_first_reach_ft(l->gap0_ft[j], l->slack_ft);
    memset(l->push_lb, 0, 3 * ((size_t)m->mats + 2) * sizeof *l->push_lb);
    if (l->mods)
        mods_reset(l->mods);
    if (!prunes)
        return;
    engine_stretch_joints(l);
    l->slides.last = l->heaves.last = -1;
    for (int n = 0; n < m->mats; n++) {
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n];
        if (l->z[m->size + 2 * n + 1] != 0.0 ||
            fabs(push_lb) > (m->law == SIM_NONE ? 0.0 : m->weight_limit_lb))
            engine_take_in(&l->slides, m, n - 1, n + 1);
        if (!engine_mat_rests(l, n) ||
            (m->tilt_ft && (l->tension_lb[n] != 0.0 || l->tension_lb[n + 1] != 0.0)))
            engine_take_in(&l->heaves, m, n - m->tail, n + m->tail);
    }
}

/* Whether a node will reach the ground in the step. Two that do so within one step lift their
 * neighbours otherwise together than one after the other, at every step alike that is longer than
 * what lies between them. */
static bool lands(const struct planar_engine *l, double h_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    double gentle_ft_s = GENTLE * sqrt(m->scene->g_ft_s2 * m->length_ft);
    for (int j = m->first; j <= m->last + 1; j++) {
        if (!m->contact[j] && v[2 * j] > gentle_ft_s && l->z[2 * j] + h_s * v[2 * j] > 0.0)
            return true;
    }
    return false;
}

/* Heights over a step of h_s in parts; speeds are then those of half a part before its end. Mats
 * rub with the mean of what the soil pushes with while they are kicked, from half a step before to
 * half a step after the step's beginning; what comes after that is for the next step. Returns the
 * largest change of a node's speed. */
static double heave_in_parts(struct planar_engine *l, bool after_parts, double first_kick_s,
                             double h_s)
{
    struct model *m = &l->model;
    double *p = l->z, *v = l->z + m->size;
    double part_s = h_s / LANDING_PARTS, jolt_ft_s = 0.0, done_s = 0.5 * part_s - first_kick_s;
    double early = fmax(0.0, 0.5 + done_s / h_s); /* share of the mean that was before this step */
    for (int j = m->first; j <= m->last + 1; j++) {
        bool known = after_parts && j >= l->rub_first && j <= l->rub_last;
        l->rub_lb[j] = known ? l->rub_next_lb[j] : early * fmax(0.0, engine_soil_lb(m, l->z, j));
        l->rub_next_lb[j] = 0.0;
    }
    for (int k = 0; k < LANDING_PARTS; k++) {
        double kick_s = k == 0 ? first_kick_s : part_s;
        if (k > 0)
            model_sample_shape(m, l->z);
        if (k > 0 && l->brace_heaves)
            l->brace_heaves(l);
        jolt_ft_s = fmax(jolt_ft_s, engine_kick_heaves(l, kick_s));
        double now_s = fmax(0.0, fmin(kick_s, 0.5 * h_s - done_s));
        for (int j = m->first; j <= m->last + 1; j++) {
            double push_lb = fmax(0.0, engine_soil_lb(m, l->z, j));
            l->rub_lb[j] += now_s / h_s * push_lb;
            l->rub_next_lb[j] += (kick_s - now_s) / h_s * push_lb;
            p[2 * j] += part_s * v[2 * j];
        }
        done_s += kick_s;
    }
    l->rub_first = m->first;
    l->rub_last = m->last + 1;
    return jolt_ft_s;
}

/* A march under way. */
struct under_way {
    struct planar_engine *l;
    struct march *march;
    const struct sim_options *options;
    struct sim_wheel wheel;
    struct sim_touch touch[SIM_TOUCH_MAX];
    int count;
    bool prunes, divides, heaves;
    double before_s; /* step of the heights, the last one */
};

static void begin_march(struct under_way *way)
{
    struct planar_engine *l = way->l;
    double h = way->march->h_s;
    way->prunes = !way->options->no_prune && element_rests(&l->model.elements);
    way->divides = !way->options->single;
    way->before_s = h;
    l->closing_step_s = way->divides ? h : 0.0;
    l->rub_share = 1.0;
    l->in_parts = false;
    begin(l, way->prunes);
    sim_wheel_start(&way->wheel, l->scene);
    if (l->gear) {
        gear_start(l->gear, h);
        l->model.wheel_load_lb = 0.0; /* the gear's is with its axles */
    }
    take(l, way->march, 0.0);
}

/* Step i, from the kick before it to the one after it. */
static double from_s(const struct march *march, uint64_t i)
{
    return i == 0 ? 0.0 : ((double)i - 0.5) * march->h_s;
}

static double to_s(const struct march *march, uint64_t i)
{
    return ((double)i + 0.5) * march->h_s;
}

/* Where the wheel is, and which mats move. */
static void step_wheel(struct under_way *way, uint64_t i)
{
    struct planar_engine *l = way->l;
    way->count = engine_span(l, &way->wheel, from_s(way->march, i), to_s(way->march, i),
                             way->touch);
    model_ride(&l->model, under_wheel(way->touch, way->count));
    if (way->prunes) {
        engine_follow_slides(l, way->touch, way->count);
        engine_follow_heaves(l);
        engine_slide_what_heaves(l);
    }
    way->heaves = l->heaves.last >= l->heaves.first;
}

/* Forces at the present positions, and what they do to the heights. */
static void step_vertical(struct under_way *way, uint64_t i)
{
    struct planar_engine *l = way->l;
    struct march *march = way->march;
    struct model *m = &l->model;
    double h = march->h_s, kick_s = to_s(march, i) - from_s(march, i);
    if (l->mods)
        engine_brace_slides(l, way->touch, way->count, kick_s);
    engine_stretch_joints(l);
    if (way->heaves) {
        model_look_at(m, l->heaves.first, l->heaves.last);
        model_sample_shape(m, l->z);
        if (l->brace_heaves)
            l->brace_heaves(l);
    }
    l->in_parts = way->heaves && way->divides && lands(l, h);
    if (l->in_parts) {
        double part_s = h / LANDING_PARTS;
        double first_s = 0.5 * ((i > 0 ? way->before_s : 0.0) + part_s);
        march->jolt_ft_s = fmax(march->jolt_ft_s, heave_in_parts(l, way->before_s < h, first_s, h));
        way->before_s = part_s;
        l->rub_share = 0.5 * (part_s + h) / h; /* of the next step's mean */
    } else if (way->heaves) {
        /* speeds lie half a part before the step, where the last one was divided */
        double part_s = way->before_s < h ? 0.5 * (way->before_s + h) : kick_s;
        l->rub_share = way->before_s < h ? part_s / h : 1.0;
        march->jolt_ft_s = fmax(march->jolt_ft_s, engine_kick_heaves(l, part_s));
        way->before_s = h;
    } else {
        way->before_s = h;
    }
}

/* What they do along the runway; then everything moves. */
static void step_along(struct under_way *way, uint64_t i)
{
    struct planar_engine *l = way->l;
    struct march *march = way->march;
    struct model *m = &l->model;
    double h = march->h_s, *p = l->z, *v = l->z + m->size;
    march->events += engine_kick_slides(l, way->touch, way->count,
                                        to_s(march, i) - from_s(march, i));
    for (int n = l->slides.first; n <= l->slides.last; n++)
        p[2 * n + 1] += h * v[2 * n + 1];
    for (int j = m->first; way->heaves && !l->in_parts && j <= m->last + 1; j++)
        p[2 * j] += h * v[2 * j];
    int live = l->slides.last - l->slides.first + 1;
    march->awake_s += live * h;
    march->mats_max = live > march->mats_max ? live : march->mats_max;
    march->done = i + 1;
}

/* What is wanted of the step that ends at t_s. False: the march ends with it. */
static bool look(struct under_way *way, uint64_t i, double t_s)
{
    struct march *march = way->march;
    bool due = i % LOOK_STEPS == 0 || i + 1 == march->steps;
    if (due && !sound(way->l, march, t_s))
        return false;
    if (i % LOOK_STEPS == 0 && way->options->overrun_ft > 0.0)
        note_overrun(way->l, march, way->options->overrun_ft);
    if (march->record.next_s <= t_s)
        take(way->l, march, t_s);
    return true;
}

static void finish(struct under_way *way)
{
    struct planar_engine *l = way->l;
    const double *v = l->z + l->model.size;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        way->march->speed_end_ft_s = fmax(way->march->speed_end_ft_s, fabs(v[2 * n + 1]));
    if (l->mods) {
        struct mods_view view = engine_view(l);
        way->march->mods = mods_finish(l->mods, &view);
    }
}

static void engine_march(struct planar_engine *l, struct march *march,
                         const struct sim_options *options)
{
    struct under_way way = {.l = l, .march = march, .options = options};
    double begin_s = monotonic_s();
    begin_march(&way);
    for (uint64_t i = 0; i < march->steps; i++) {
        double t_s = (double)(i + 1) * march->h_s * (i + 1 == march->steps ? 1.0 + 1e-11 : 1.0);
        step_wheel(&way, i);
        step_vertical(&way, i);
        step_along(&way, i);
        if (!look(&way, i, t_s))
            break;
        if (i % STEPS_BETWEEN_ASKING == 0 && way.options->go_on &&
            !way.options->go_on(way.options->go_on_ctx, march->number,
                                (double)i / (double)march->steps)) {
            march->status = SIM_INTERRUPTED;
            march->mat = way.l->slides.first + 1;
            march->t_s = t_s;
            break;
        }
    }
    finish(&way);
    march->ms = 1e3 * (monotonic_s() - begin_s);
}

/* ---- the runs, and their error ---- */

#define STEP_SHARE     0.25 /* of the stability limit, when the step is not given */
#define HOP_SHARE      0.25 /* of a mat the aircraft may cross in a step */
/* the scheme's limit times the fastest rate; 2 for an oscillation, less with damping */
#define STABLE         1.8
#define LEAST_STEPS    1000.0
#define MOST_STEPS     1e8
#define MOST_SHORTENED 4
/* times the difference of two marches: of first order the finer one's error is as large as that */
#define CAUTION        2.0
/* between steps of two marches. Not 2: the shorter steps would end wherever the longer ones do, and
 * every other switch would be sampled at the same moment in both */
#define STEP_RATIO     1.9
#define BETWEEN_RATIO  2.6  /* of a march more to the finer of the two: between coarse and rough */
#define BESIDE_RATIO   1.37 /* the same, of another where the answer is sensitive */
#define SENSITIVE      1e-3 /* an estimate of so much of the largest movement or lift */
#define DOUBT          1.5  /* times what four marches are apart by, where chance decides it */

static void drop(struct march *march)
{
    sim_record_free(&march->record);
    free(march->mods);
    *march = (struct march){0};
}

/* What it held is another's now. */
static void leave(struct march *march)
{
    march->record = (struct sim_record){0};
    march->mods = NULL;
}

static void start_march(struct planar_engine *l, struct march *march,
                        const struct sim_options *options, uint64_t steps,
                        struct sim_result *result)
{
    *march = (struct march){.steps = steps,
                            .h_s = sim_scene_end_s(l->scene) / (double)steps,
                            .number = ++result->passes};
    sim_record_make(&march->record, l->scene, options);
    engine_march(l, march, options);
    result->rhs += march->done;
}

static double *copy_of(const double *from, size_t count)
{
    double *copy = xcalloc(count + 1, sizeof *copy);
    memcpy(copy + 1, from, count * sizeof *copy);
    return copy;
}

static void answer(struct planar_engine *l, struct march *fine, const struct march *coarse,
                   struct sim_result *result)
{
    result->dt_s = fine->h_s;
    result->checked_dt_s = coarse->h_s;
    result->pass_ms = fine->ms;
    result->steps = fine->done;
    result->rejected = result->rhs - fine->done;
    result->events = fine->events;
    result->mats_max = fine->mats_max;
    result->mats_mean = fine->awake_s / ((double)fine->done * fine->h_s);
    result->crest_deg = fine->crest_deg;
    result->crest_joint = fine->crest_joint;
    result->sag_deg = fine->sag_deg;
    result->sag_joint = fine->sag_joint;
    result->overruns = fine->overruns;
    result->first_crest = fine->first_crest;
    result->first_crest_wheel = fine->first_crest_wheel;
    memcpy(result->overrun, fine->overrun, sizeof result->overrun);
    size_t joints = (size_t)l->model.mats + 1;
    result->push_lb = copy_of(l->push_lb, joints);
    result->pull_lb = copy_of(l->pull_lb, joints);
    result->rise_ft = copy_of(l->rise_ft, joints);
    if (fine->mods && coarse->mods)
        fine->mods->error_lb = CAUTION * mods_difference_lb(fine->mods, coarse->mods);
    result->mods = fine->mods;
    fine->mods = NULL;
    pass_deliver(&l->model, l->z, &fine->record, fine->max_lift_ft, fine->speed_end_ft_s, result);
}

/* How far two marches are apart. */
static struct pass_difference difference_of(const struct march *a, const struct march *b)
{
    return (struct pass_difference){sim_record_difference(&a->record, &b->record),
                                    fmax(sim_record_lift_difference(&a->record, &b->record),
                                         fabs(a->max_lift_ft - b->max_lift_ft))};
}

/* Whether two complete marches say the same. */
static bool agree(const struct planar_engine *l, const struct march *coarse,
                  const struct march *fine)
{
    struct pass_difference apart = difference_of(coarse, fine);
    double threshold = pass_bow_threshold_ft(l->scene),
           lift = fmin(coarse->max_lift_ft, fine->max_lift_ft);
    return apart.u.u_ft <= PASS_DISAGREEMENT * sim_record_peak(&fine->record).u_ft +
                               1e-9 * l->model.length_ft &&
           apart.lift_ft <= PASS_DISAGREEMENT * fmax(lift, threshold) &&
           (coarse->max_lift_ft > threshold) == (fine->max_lift_ft > threshold);
}

static bool complete(const struct march *march)
{
    return march->done > 0 && march->status == SIM_OK;
}

static void widen(struct sim_result *result, struct pass_difference apart)
{
    result->error_u_ft = fmax(result->error_u_ft, apart.u.u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, apart.lift_ft);
}

/* Sampled switches fall differently at every step, so two marches can be as close as they like by
 * chance; where the march before those two says the same, its differences count as well. */
static void state_error(const struct planar_engine *l, const struct march *rough,
                        const struct march *coarse, const struct march *fine,
                        struct pass_difference apart, struct sim_result *result)
{
    result->error_u_ft = CAUTION * apart.u.u_ft;
    /* a node that lands has done so up to a step before it is seen to: that far it is off, whatever
     * the marches say of each other */
    result->error_lift_ft = fmax(CAUTION * apart.lift_ft, fine->h_s * fine->jolt_ft_s);
    if (!complete(rough))
        return;
    struct pass_difference before = difference_of(rough, coarse);
    if (agree(l, rough, coarse))
        widen(result, before);
}

/* A march more. What the march before left in `l` is the answer's, and stays. */
static void march_aside(struct planar_engine *l, struct march *march,
                        const struct sim_options *options, uint64_t steps,
                        struct sim_result *result)
{
    double *kept = xmalloc(l->stored * sizeof *kept);
    memcpy(kept, l->z, l->stored * sizeof *kept);
    start_march(l, march, options, steps, result);
    memcpy(l->z, kept, l->stored * sizeof *kept);
    free(kept);
}

/* Three marches that are close by chance still happen, one time in a hundred: a fourth between
 * them, and the worst pair of all four that say the same. */
static void weigh_pairs(struct planar_engine *l, const struct sim_options *options,
                        const struct march *rough, const struct march *coarse,
                        const struct march *fine, struct sim_result *result)
{
    struct march between = {0};
    uint64_t steps = (uint64_t)ceil((double)fine->steps / BETWEEN_RATIO);
    if (sim_scene_end_s(l->scene) / (double)steps > result->dt_limit_s)
        return;
    march_aside(l, &between, options, steps, result);
    if (complete(&between)) {
        const struct march *const others[] = {fine, coarse, rough};
        for (int i = 0; i < 3; i++) {
            struct pass_difference apart = {0};
            if (complete(others[i]))
                apart = difference_of(&between, others[i]);
            if (complete(others[i]) && agree(l, &between, others[i]))
                widen(result, apart);
        }
        if (complete(rough)) {
            if (agree(l, rough, fine))
                widen(result, difference_of(rough, fine));
        }
    }
    drop(&between);
}

/* Where the estimate is not small beside what moves, switches decide much, and a march more, at
 * another step, says how much. */
static void doubt(struct planar_engine *l, const struct sim_options *options,
                  const struct march *fine, struct sim_result *result)
{
    struct march beside = {0};
    if (result->error_u_ft <= SENSITIVE * sim_record_peak(&fine->record).u_ft &&
        result->error_lift_ft <= SENSITIVE * fine->max_lift_ft)
        return;
    uint64_t steps = (uint64_t)ceil((double)fine->steps / BESIDE_RATIO);
    march_aside(l, &beside, options, steps, result);
    if (complete(&beside)) {
        struct pass_difference apart = difference_of(&beside, fine);
        result->error_u_ft = DOUBT * fmax(result->error_u_ft, CAUTION * apart.u.u_ft);
        result->error_lift_ft = DOUBT * fmax(result->error_lift_ft, CAUTION * apart.lift_ft);
    }
    drop(&beside);
}

/* No shorter step decides: the marches are the runs of the spread. */
static void state_spread(const struct planar_engine *l, const struct march *rough,
                         const struct march *coarse, const struct march *fine,
                         struct sim_result *result)
{
    const struct march *others[] = {coarse, rough};
    double threshold = pass_bow_threshold_ft(l->scene);
    double most_u_ft = PASS_DISAGREEMENT * sim_record_peak(&fine->record).u_ft,
           most_lift_ft = PASS_DISAGREEMENT * fmax(fine->max_lift_ft, threshold);
    result->spread_runs = 1;
    result->spread_waves = fine->max_lift_ft > threshold;
    for (int i = 0; i < 2; i++) {
        if (!complete(others[i]))
            continue;
        struct pass_difference apart = difference_of(fine, others[i]);
        divergence_find(result, &fine->record, &others[i]->record, most_u_ft, most_lift_ft);
        result->error_u_ft = fmax(result->error_u_ft, CAUTION * apart.u.u_ft);
        result->error_lift_ft = fmax(result->error_lift_ft, CAUTION * apart.lift_ft);
        result->spread_runs++;
        result->spread_waves += others[i]->max_lift_ft > threshold;
    }
}

static uint64_t fewer(uint64_t steps)
{
    return (uint64_t)ceil((double)steps / STEP_RATIO);
}

/* Marches at a step and at a longer one, with shorter ones until two say the same. `rough` has been
 * run before them, or is empty. */
static void run_pairs(struct planar_engine *l, const struct sim_options *options, uint64_t steps,
                      struct march *rough, struct sim_result *result)
{
    struct march coarse = {0}, fine = {0};
    struct pass_difference apart = {0};
    start_march(l, &coarse, options, fewer(steps), result);
    for (int shortened = 0;; shortened++) {
        if (coarse.status == SIM_INTERRUPTED) {
            sim_result_end(result, coarse.status, coarse.mat, coarse.t_s);
            fine = coarse;
            leave(&coarse);
            break;
        }
        start_march(l, &fine, options, steps, result);
        if (fine.status == SIM_INTERRUPTED) {
            sim_result_end(result, fine.status, fine.mat, fine.t_s);
            break;
        }
        const struct march *failed = fine.status != SIM_OK   ? &fine
                                   : coarse.status != SIM_OK ? &coarse
                                                             : NULL;
        if (fine.status != SIM_OK && fine.status == coarse.status) {
            sim_result_end(result, fine.status, fine.mat, fine.t_s);
            break;
        }
        apart = failed ? apart : difference_of(&coarse, &fine);
        if (!failed && agree(l, &coarse, &fine)) {
            state_error(l, rough, &coarse, &fine, apart, result);
            weigh_pairs(l, options, rough, &coarse, &fine, result);
            doubt(l, options, &fine, result);
            break;
        }
        if (options->dt_s > 0.0 || shortened == MOST_SHORTENED ||
            STEP_RATIO * (double)steps > MOST_STEPS) {
            if (failed)
                sim_result_end(result, failed->status, failed->mat, failed->t_s);
            else if (options->dt_s > 0.0)
                sim_result_end(result, SIM_UNSTABLE, apart.u.mat, apart.u.t_s);
            else
                state_spread(l, rough, &coarse, &fine, result);
            break;
        }
        drop(rough);
        *rough = coarse;
        coarse = fine;
        steps = (uint64_t)ceil(STEP_RATIO * (double)steps);
        leave(&fine);
    }
    answer(l, &fine, &coarse, result);
    drop(&coarse);
    drop(&fine);
}

/* The step and two longer ones; the longest only where that is stable. */
static void run_checked(struct planar_engine *l, const struct sim_options *options, uint64_t steps,
                        struct sim_result *result)
{
    struct march rough = {0};
    uint64_t fewest = fewer(fewer(steps));
    bool stable = sim_scene_end_s(l->scene) / (double)fewest <= result->dt_limit_s;
    if (stable)
        start_march(l, &rough, options, fewest, result);
    if (rough.status == SIM_INTERRUPTED) {
        sim_result_end(result, rough.status, rough.mat, rough.t_s);
        answer(l, &rough, &rough, result);
    } else {
        run_pairs(l, options, steps, &rough, result);
    }
    drop(&rough);
}

static double step_limit_s(struct planar_engine *l, double hop_s)
{
    struct model *m = &l->model;
    model_start(m, l->z);
    double rate = model_fastest_rate(m, l->z, MODEL_STAGGERED);
    if (l->mods)
        rate = sqrt(rate * rate + mods_rate2(l->mods, m->mass_slug, m->inertia));
    return fmin(rate > 0.0 ? STABLE / rate : HUGE_VAL, hop_s);
}

static enum mr_status run_with(struct planar_engine *l, const struct sim_options *options,
                               struct sim_result *result, struct error *error)
{
    struct sim_wheel wheel;
    double end_s = sim_scene_end_s(l->scene);
    sim_wheel_start(&wheel, l->scene);
    /* INFINITY for an aircraft that stands */
    double hop_s = l->scene->length_ft / sim_wheel_fastest_ft_s(&wheel);
    result->dt_limit_s = step_limit_s(l, hop_s);
    double h = options->dt_s > 0.0
                 ? options->dt_s
                 : fmin((options->single ? 2.0 : 1.0) * STEP_SHARE * result->dt_limit_s,
                        fmin(HOP_SHARE * hop_s, end_s / LEAST_STEPS));
    double steps = ceil(end_s / h * (1.0 - 1e-12));
    if (h > result->dt_limit_s) {
        result->dt_s = h;
        sim_result_end(result, SIM_UNSTABLE, sim_wheel_first_mat(&wheel), 0.0);
        return MR_OK;
    }
    if (!(steps <= MOST_STEPS))
        return error_set(
            error, MR_USAGE,
            "too many steps: %s: %g s in steps of %g s; give a shorter tend, a larger dt or "
            "solver implicit",
            sim_scene_name(l->scene), end_s, h);
    if (options->single) {
        struct march only = {0};
        start_march(l, &only, options, (uint64_t)steps, result);
        result->first_crest = only.first_crest;
        result->first_crest_wheel = only.first_crest_wheel;
        if (only.status != SIM_OK)
            sim_result_end(result, only.status, only.mat, only.t_s);
        result->t_end_s = fmin(result->t_end_s, (double)only.done * only.h_s);
        answer(l, &only, &only, result);
        drop(&only);
        return error->status;
    }
    bool room = 2.0 * h <= result->dt_limit_s; /* the check at double the step is stable too */
    run_checked(l, options, 2 * (uint64_t)ceil(room ? steps / 2.0 : steps), result);
    return MR_OK;
}

enum mr_status landing_run(const struct sim_scene *scene, const struct sim_options *options,
                           struct sim_result *result, struct error *error)
{
    struct planar_engine l = {0};
    double begin_s = monotonic_s();
    if (engine_make(&l, scene, result, error) == MR_OK) {
        result->solver = "staggered";
        result->mats = scene->mats;
        result->t_end_s = sim_scene_end_s(scene);
        sim_result_note(result, "error estimate: the largest difference between runs at 1, 1.9, "
                                "2.6 and 3.6 times the step, twice that of the first two");
        if (l.mods)
            mods_describe(l.mods, result);
        run_with(&l, options, result, error);
        result->run_ms = 1e3 * (monotonic_s() - begin_s);
    }
    engine_free(&l);
    return error->status;
}
