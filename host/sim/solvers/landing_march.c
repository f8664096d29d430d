#include <math.h>
#include <string.h>

#include "host/base/steady.h"
#include "host/sim/elements/soil.h"
#include "host/sim/solvers/landing_engine.h"

#define FOLDED_DEG           85.0
#define DEGREES              (180.0 / 3.14159265358979323846)
/* of an overrun's rise: lower, the wheel has left that wave, and the next is another */
#define OFF_WAVE_SHARE       0.5
#define SLIGHT_TURN          0.01 /* of a joint, in sines: smaller ones are not worth an arc sine */
#define STEPS_BETWEEN_ASKING 1024 /* whether to go on */
#define LOOK_STEPS           4    /* between looks at lifts and angles */
#define LANDING_PARTS        16   /* of a step in which a node lands */
#define GENTLE               1e-4 /* of sqrt(g L): what lands slower lifts nobody */

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
static double lift_ft(const struct landing *l, double back_s, int *node_from_1)
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
static void take(struct landing *l, struct march *march, double t_s)
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
static void note_shape(struct landing *l, struct march *march)
{
    const struct model *m = &l->model;
    const double *p = l->z;
    double left = 0.0;
    for (int j = l->heaves.first; j <= l->heaves.last + 1; j++) {
        double tilt = j <= l->heaves.last && m->tilt_ft ? m->tilt_ft[j] : 0.0;
        double right = j <= l->heaves.last ? (p[2 * j + 2] - p[2 * j] + tilt) / m->length_ft : 0.0;
        l->rise_ft[j] = -p[2 * j] > l->rise_ft[j] ? -p[2 * j] : l->rise_ft[j];
        if (l->parting) {
            right = j <= l->heaves.last ? landing_slope(l, j) : 0.0;
            if (l->parting->apart[j]) {
                l->rise_ft[j] = fmax(l->rise_ft[j], -l->parting->y_ft[j]);
                left = right; /* not a joint any more */
            }
        }
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
static void note_crest(const struct landing *l, struct march *march, double lift_ft)
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
static void note_overrun(const struct landing *l, struct march *march, double lift_ft)
{
    int mat = l->model.span.mat;
    if (march->first_crest == 0)
        note_crest(l, march, lift_ft);
    if (mat < 0)
        return;
    double left_ft = -l->z[2 * mat], right_ft = -parting_right_y_ft(l->parting, l->z, mat);
    int node = (left_ft > right_ft ? mat : mat + 1) + 1;
    bool meets = fmax(left_ft, right_ft) >= lift_ft;
    if (meets && !march->on_wave && march->overruns < SIM_OVERRUNS_MAX)
        march->overrun[march->overruns++] = node;
    march->on_wave = meets ||
                     (march->on_wave && fmax(left_ft, right_ft) >= OFF_WAVE_SHARE * lift_ft);
}

LAW_INLINE bool sound(struct landing *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    int mat = l->slides.first + 1, node;
    double sum = 0.0;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        sum += fabs(l->z[2 * n + 1]) + fabs(l->z[m->size + 2 * n + 1]);
    if (l->heaves.last >= l->heaves.first) {
        double angle = l->parting ? landing_worst_angle_deg(l, &mat)
                                  : model_worst_angle_deg(m, l->z, &mat);
        while (l->parting && angle > FOLDED_DEG && landing_topple(l, mat - 1, t_s))
            angle = landing_worst_angle_deg(l, &mat);
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

static void begin(struct landing *l, bool prunes)
{
    struct model *m = &l->model;
    model_start(m, l->z);
    l->slides = l->heaves = (struct part){0, m->mats - 1, 0, 0};
    for (int j = 0; j <= m->mats; j++)
        l->reach_ft[j] = joint_first_reach_ft(l->gap0_ft[j], l->slack_ft);
    memset(l->push_lb, 0, 3 * ((size_t)m->mats + 2) * sizeof *l->push_lb);
    if (l->mods)
        mods_reset(l->mods);
    if (l->parting)
        parting_reset(l->parting);
    if (!prunes)
        return;
    landing_stretch_joints(l);
    l->slides.last = l->heaves.last = -1;
    for (int n = 0; n < m->mats; n++) {
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n];
        if (l->z[m->size + 2 * n + 1] != 0.0 ||
            fabs(push_lb) > (m->law == SIM_NONE ? 0.0 : m->weight_limit_lb))
            landing_take_in(&l->slides, m, n - 1, n + 1);
        if (!landing_mat_rests(l, n) ||
            (m->tilt_ft && (l->tension_lb[n] != 0.0 || l->tension_lb[n + 1] != 0.0)))
            landing_take_in(&l->heaves, m, n - m->tail, n + m->tail);
    }
}

/* Whether a node will reach the ground in the step. Two that do so within one step lift their
 * neighbours otherwise together than one after the other, at every step alike that is longer than
 * what lies between them. */
static bool lands(const struct landing *l, double h_s)
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
static double heave_in_parts(struct landing *l, bool after_parts, double first_kick_s, double h_s)
{
    struct model *m = &l->model;
    double *p = l->z, *v = l->z + m->size;
    double part_s = h_s / LANDING_PARTS, jolt_ft_s = 0.0, done_s = 0.5 * part_s - first_kick_s;
    double early = fmax(0.0, 0.5 + done_s / h_s); /* share of the mean that was before this step */
    for (int j = m->first; j <= m->last + 1; j++) {
        bool known = after_parts && j >= l->rub_first && j <= l->rub_last;
        l->rub_lb[j] = known ? l->rub_next_lb[j] : early * fmax(0.0, landing_soil_lb(m, l->z, j));
        l->rub_next_lb[j] = 0.0;
    }
    for (int k = 0; k < LANDING_PARTS; k++) {
        double kick_s = k == 0 ? first_kick_s : part_s;
        if (k > 0)
            model_sample_shape(m, l->z);
        if (k > 0 && l->brace_heaves)
            l->brace_heaves(l);
        jolt_ft_s = fmax(jolt_ft_s, landing_kick_heaves(l, kick_s));
        double now_s = fmax(0.0, fmin(kick_s, 0.5 * h_s - done_s));
        for (int j = m->first; j <= m->last + 1; j++) {
            double push_lb = fmax(0.0, landing_soil_lb(m, l->z, j));
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
    struct landing *l;
    struct march *march;
    const struct sim_options *options;
    struct sim_wheel *wheel;
    struct sim_touch *touch; /* room for the wheel's parts */
    int count;
    bool prunes, divides, heaves;
    double before_s; /* step of the heights, the last one */
};

LAW_INLINE void set_out(struct under_way *way)
{
    struct landing *l = way->l;
    double h = way->march->h_s;
    way->prunes = !way->options->no_prune && element_rests(&l->model.elements);
    way->divides = !way->options->single && !l->parting;
    way->before_s = h;
    l->closing_step_s = way->divides ? h : 0.0;
    l->rub_share = 1.0;
    l->in_parts = false;
    begin(l, way->prunes);
    sim_wheel_start(way->wheel, l->scene);
    if (l->gear)
        landing_mount(l, way->wheel, h);
    take(l, way->march, 0.0);
}

/* Step i, from the kick before it to the one after it. */
LAW_INLINE double from_s(const struct march *march, uint64_t i)
{
    return i == 0 ? 0.0 : ((double)i - 0.5) * march->h_s;
}

LAW_INLINE double to_s(const struct march *march, uint64_t i)
{
    return ((double)i + 0.5) * march->h_s;
}

/* Where the wheel is, and which mats move. */
LAW_INLINE void ride(struct under_way *way, uint64_t i)
{
    struct landing *l = way->l;
    way->count = sim_wheel_span(way->wheel, from_s(way->march, i), to_s(way->march, i), way->touch);
    model_ride(&l->model, under_wheel(way->touch, way->count));
    if (way->prunes) {
        landing_follow_slides(l, way->touch, way->count);
        landing_follow_heaves(l);
        landing_slide_what_heaves(l);
    }
    way->heaves = l->heaves.last >= l->heaves.first;
}

/* Forces at the present positions, and what they do to the heights. */
LAW_INLINE void heave(struct under_way *way, uint64_t i)
{
    struct landing *l = way->l;
    struct march *march = way->march;
    struct model *m = &l->model;
    double h = march->h_s, kick_s = to_s(march, i) - from_s(march, i);
    if (l->mods)
        landing_brace_slides(l, way->touch, way->count, kick_s);
    landing_stretch_joints(l);
    if (l->parting)
        landing_part_joints(l, (double)i * h);
    if (way->heaves) {
        model_look_at(m, l->heaves.first, l->heaves.last);
        model_sample_shape(m, l->z);
        if (l->parting)
            landing_shape_ends(l);
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
        march->jolt_ft_s = fmax(march->jolt_ft_s, landing_kick_heaves(l, part_s));
        way->before_s = h;
    } else {
        way->before_s = h;
    }
}

/* What they do along the runway; then everything moves. */
LAW_INLINE void slide(struct under_way *way, uint64_t i)
{
    struct landing *l = way->l;
    struct march *march = way->march;
    struct model *m = &l->model;
    double h = march->h_s, *p = l->z, *v = l->z + m->size;
    march->events += landing_kick_slides(l, way->touch, way->count,
                                         to_s(march, i) - from_s(march, i));
    if (l->parting)
        landing_hold_back(l, l->gear ? &l->gear->line[0] : way->wheel, way->touch, way->count);
    for (int n = l->slides.first; n <= l->slides.last; n++)
        p[2 * n + 1] += h * v[2 * n + 1];
    for (int j = m->first; way->heaves && !l->in_parts && j <= m->last + 1; j++)
        p[2 * j] += h * v[2 * j];
    if (way->heaves && l->parting)
        landing_move_ends(l, h);
    int live = l->slides.last - l->slides.first + 1;
    march->awake_s += live * h;
    march->mats_max = live > march->mats_max ? live : march->mats_max;
    march->done = i + 1;
}

/* What is wanted of the step that ends at t_s. False: the march ends with it. */
LAW_INLINE bool look(struct under_way *way, uint64_t i, double t_s)
{
    struct march *march = way->march;
    const struct parting *parting = way->l->parting;
    /* mats that are apart turn fast: one could stand upright and beyond between two looks */
    bool due = i % LOOK_STEPS == 0 || i + 1 == march->steps || (parting && parting->count > 0);
    if (due && !sound(way->l, march, t_s))
        return false;
    if (i % LOOK_STEPS == 0 && way->options->overrun_ft > 0.0)
        note_overrun(way->l, march, way->options->overrun_ft);
    if (march->record.next_s <= t_s)
        take(way->l, march, t_s);
    return true;
}

LAW_INLINE void arrive(struct under_way *way)
{
    struct landing *l = way->l;
    const double *v = l->z + l->model.size;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        way->march->speed_end_ft_s = fmax(way->march->speed_end_ft_s, fabs(v[2 * n + 1]));
    if (l->mods) {
        struct mods_view view = landing_view(l);
        way->march->mods = mods_finish(l->mods, &view);
    }
}

LAW_INLINE void march_with(struct under_way *way)
{
    struct march *march = way->march;
    double begin_s = steady_s();
    set_out(way);
    for (uint64_t i = 0; i < march->steps; i++) {
        double t_s = (double)(i + 1) * march->h_s * (i + 1 == march->steps ? 1.0 + 1e-11 : 1.0);
        ride(way, i);
        heave(way, i);
        slide(way, i);
        if (!look(way, i, t_s))
            break;
        if (i % STEPS_BETWEEN_ASKING == 0 && way->options->go_on &&
            !way->options->go_on(way->options->go_on_ctx, march->number,
                                 (double)i / (double)march->steps)) {
            march->status = SIM_INTERRUPTED;
            march->mat = way->l->slides.first + 1;
            march->t_s = t_s;
            break;
        }
    }
    arrive(way);
    march->ms = 1e3 * (steady_s() - begin_s);
}

/* A gear of several axle lines gets a loop of its own. */
static void march_gear(struct landing *l, struct march *march, const struct sim_options *options)
{
    struct sim_touch touch[SIM_TOUCH_MAX];
    struct sim_wheel wheel;
    struct under_way way = {
        .l = l, .march = march, .options = options, .wheel = &wheel, .touch = touch};
    march_with(&way);
}

static void march_wheel(struct landing *l, struct march *march, const struct sim_options *options)
{
    struct sim_touch touch[SIM_WHEEL_TOUCHES];
    struct sim_wheel wheel;
    struct under_way way = {
        .l = l, .march = march, .options = options, .wheel = &wheel, .touch = touch};
    march_with(&way);
}

void landing_march(struct landing *l, struct march *march, const struct sim_options *options)
{
    (l->gear ? march_gear : march_wheel)(l, march, options);
}
