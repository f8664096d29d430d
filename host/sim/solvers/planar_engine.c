#include "host/sim/solvers/planar_engine.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/xmalloc.h"
#include "host/sim/elements/law.h"
#include "host/sim/models/kernel.h"

static void engine_load_heaves(struct planar_engine *l);

static void engine_brace_heaves(struct planar_engine *l);

/* ---- memory ---- */

static void lay_ground(struct planar_engine *l)
{
    struct model *m = &l->model;
    const double *ground = l->scene->ground_ft.values;
    for (int n = 0; n < m->mats; n++) {
        l->tilt_ft[n] = ground ? ground[n] - ground[n + 1] : 0.0;
        double s = l->tilt_ft[n] / m->length_ft;
        l->rest_cos[n] = sqrt(1.0 - s * s);
    }
    model_lay(m, l->tilt_ft);
}

/* Arrays of a landing; the model is made. */
static void lay_out(struct planar_engine *l)
{
    struct model *m = &l->model;
    size_t length = 2 * (size_t)m->size, joints = (size_t)m->mats + 2;
    l->stored = 2 * length + 17 * joints;
    double *storage = xcalloc(l->stored, sizeof *storage);
    l->z = storage;
    l->accel = storage + length;
    l->u = storage + 2 * length;
    l->v = l->u + joints;
    l->gap0_ft = l->v + joints;
    l->hold_lb = l->gap0_ft + joints;
    l->give_ft = l->hold_lb + joints;
    l->reach_ft = l->give_ft + joints;
    l->tension_lb = l->reach_ft + joints;
    l->height = l->tension_lb + joints;
    l->push_lb = l->height + joints;
    l->pull_lb = l->push_lb + joints;
    l->rise_ft = l->pull_lb + joints;
    l->tilt_ft = l->rise_ft + joints;
    l->rest_cos = l->tilt_ft + joints;
    l->rub_lb = l->rest_cos + joints;
    l->rub_next_lb = l->rub_lb + joints;
    lay_ground(l);
    bool braced = l->mods && (l->mods->banded || l->mods->stiffened);
    if (braced || l->gear) {
        l->brace_heaves = l->gear ? engine_load_heaves : engine_brace_heaves;
        l->brace_lb = l->rub_next_lb + joints;
        l->brace_lb_ft = l->brace_lb + joints;
        model_brace(m, l->brace_lb, l->brace_lb_ft);
    }
    l->slack_ft = m->slack_ft;
    model_lend(m, l->tension_lb);
    bool gritty = false;
    for (int j = 0; j <= m->mats; j++) {
        l->gap0_ft[j] = sim_scene_joint(&l->scene->gap0_ft, j + 1);
        l->hold_lb[j] = -sim_scene_joint(&l->scene->grit_lb, j + 1);
        l->give_ft[j] = -l->hold_lb[j] / m->kl;
        gritty = gritty || l->hold_lb[j] < 0.0;
    }
    l->joints = joint_law(l->slack_ft, gritty);
}

enum mr_status engine_make(struct planar_engine *l, const struct sim_scene *scene,
                           struct sim_result *result, struct error *error)
{
    l->scene = scene;
    if (scene->friction > 0.0 &&
        (scene->friction_law == SIM_TANH || scene->friction_law == SIM_SIGN))
        return error_set(
            error, MR_USAGE,
            "not available: %s: friction tanh or sign with solver staggered; give stick, or "
            "solver event",
            sim_scene_name(scene));
    if (model_make(&l->model, scene, true, error) != MR_OK)
        return error->status;
    if (result) /* before the landing takes over what it has of its own */
        model_describe(&l->model, result);
    l->mods = mods_make(scene);
    l->gear = gear_make(scene);
    lay_out(l);
    return MR_OK;
}

void engine_free(struct planar_engine *l)
{
    mods_free(l->mods);
    gear_free(l->gear);
    model_free(&l->model);
    free(l->z);
}

/* ---- the parts that move ---- */

#define CALM     1e-6 /* of sqrt(g L): on uneven ground a node slower than that is at rest */
#define GUARD    4    /* mats at rest that the heaving part keeps at its ends */
#define CHUNK    8    /* mats that it grows by, at least */
#define PATIENCE 16   /* steps before a part may shrink */
/* steps before it leaves the next mat: one for its damper, one for the grit, one more */
#define SETTLING 3
#define AIR      1e-3  /* of L: a node that is so high is held by its mats, not by the ground */
#define QUIET    1e-13 /* of L for heights, of sqrt(g L) for their rates: at rest */

void engine_take_in(struct part *part, const struct model *m, int low, int high)
{
    low = low < 0 ? 0 : low;
    high = high > m->mats - 1 ? m->mats - 1 : high;
    if (part->last < part->first)
        *part = (struct part){low, high, 0, 0};
    if (low < part->first) {
        part->first = low;
        part->quiet_first = 0;
    }
    if (high > part->last) {
        part->last = high;
        part->quiet_last = 0;
    }
}

void engine_follow_slides(struct planar_engine *l, const struct sim_touch *touch, int count)
{
    struct part *s = &l->slides;
    const double *v = l->z + l->model.size;
    for (int i = 0; i < count; i++) {
        bool idle = s->last - s->first <= 2 && s->quiet_first >= PATIENCE &&
                    s->quiet_last >= PATIENCE;
        if (idle)
            s->last = s->first - 1; /* go there instead of stretching */
        engine_take_in(s, &l->model, touch[i].mat - 2, touch[i].mat);
    }
    if (s->last < s->first)
        return;
    if (v[2 * s->first + 1] != 0.0 || v[2 * s->last + 1] != 0.0)
        engine_take_in(s, &l->model, v[2 * s->first + 1] != 0.0 ? s->first - 1 : s->first,
                       v[2 * s->last + 1] != 0.0 ? s->last + 1 : s->last);
    bool still_first = v[2 * s->first + 1] == 0.0 && v[2 * s->first + 3] == 0.0;
    bool still_last = v[2 * s->last + 1] == 0.0 && s->last > 0 && v[2 * s->last - 1] == 0.0;
    s->quiet_first = still_first ? s->quiet_first + 1 : 0;
    s->quiet_last = still_last ? s->quiet_last + 1 : 0;
    if (s->quiet_first >= PATIENCE && s->last - s->first > 2) {
        s->first++;
        s->quiet_first = PATIENCE - SETTLING;
    }
    if (s->quiet_last >= PATIENCE && s->last - s->first > 2) {
        s->last--;
        s->quiet_last = PATIENCE - SETTLING;
    }
}

/* On uneven ground a node under compression comes to rest off its settled height. One in the air
 * stays with the part that heaves, however still it is: a wave that stands is as long as it is
 * because it stands, and outside mats count as flat. */
static bool node_rests(const struct planar_engine *l, int node)
{
    const struct model *m = &l->model;
    if (m->tilt_ft)
        return fabs(l->z[m->size + 2 * node]) <= CALM * sqrt(m->scene->g_ft_s2 * m->length_ft) &&
               l->z[2 * node] >= -AIR * m->length_ft;
    return fabs(l->z[2 * node] - m->rest_y_ft) <= QUIET * m->length_ft &&
           fabs(l->z[m->size + 2 * node]) <= QUIET * sqrt(m->scene->g_ft_s2 * m->length_ft);
}

bool engine_mat_rests(const struct planar_engine *l, int n)
{
    return node_rests(l, n) && node_rests(l, n + 1);
}

/* On uneven ground every joint whose force changes lifts or presses its mats. */
static void heave_what_slides(struct planar_engine *l, int chunk)
{
    const double *v = l->z + l->model.size;
    int first = l->slides.first, last = l->slides.last;
    while (first <= last && v[2 * first + 1] == 0.0)
        first++;
    while (last > first && v[2 * last + 1] == 0.0)
        last--;
    if (first <= last)
        engine_take_in(&l->heaves, &l->model, first - chunk, last + chunk);
}

/* Flat mats at rest stay so: the part that heaves begins with what is not, or carries the wheel,
 * and keeps GUARD mats at rest at its ends, so that what it holds back there is below QUIET. */
void engine_follow_heaves(struct planar_engine *l)
{
    struct model *m = &l->model;
    struct part *h = &l->heaves;
    /* what is loaded at once: as window.c */
    int chunk = m->tail > GUARD + CHUNK ? m->tail - GUARD : CHUNK;
    if (m->wheel_load_lb > 0.0 && m->span.mat >= 0)
        engine_take_in(h, m, m->span.mat - m->tail, m->span.mat + m->tail);
    if (m->tilt_ft)
        heave_what_slides(l, GUARD);
    if (h->last < h->first)
        return;
    bool first = h->first == 0, last = h->last == m->mats - 1;
    for (int k = 0; k < GUARD && !first; k++)
        first = h->first + k <= h->last && !engine_mat_rests(l, h->first + k);
    for (int k = 0; k < GUARD && !last; k++)
        last = h->last - k >= h->first && !engine_mat_rests(l, h->last - k);
    if (first && h->first > 0)
        engine_take_in(h, m, h->first - chunk, h->last);
    if (last && h->last < m->mats - 1)
        engine_take_in(h, m, h->first, h->last + chunk);
    if (++h->quiet_first >= PATIENCE) {
        h->quiet_first = 0;
        int low = h->first, high = h->last;
        while (low <= high && engine_mat_rests(l, low))
            low++;
        while (high >= low && engine_mat_rests(l, high))
            high--;
        bool loaded = m->wheel_load_lb > 0.0 && m->span.mat >= 0;
        if (low > high && !loaded)
            h->last = h->first - 1;
        else if (low <= high) {
            int from = low - chunk, to = high + chunk;
            if (loaded) {
                from = m->span.mat - m->tail < from ? m->span.mat - m->tail : from;
                to = m->span.mat + m->tail > to ? m->span.mat + m->tail : to;
            }
            h->first = from > h->first ? from : h->first;
            h->last = to < h->last ? to : h->last;
        }
    }
}

/* Turning pulls at the joints of profile `full`, and heaving changes the soil's hold on the
 * mats. */
void engine_slide_what_heaves(struct planar_engine *l)
{
    const struct model *m = &l->model;
    if ((m->full || m->soil_normal) && l->heaves.last >= l->heaves.first)
        engine_take_in(&l->slides, m, l->heaves.first - 1, l->heaves.last + 1);
}

/* ---- tensions ---- */

/* What a mat's turning takes from its length on either side, and its rate. */
struct shortening {
    double ft, ft_s;
};

static inline struct shortening shortening_of(const struct planar_engine *l, int n)
{
    const struct model *m = &l->model;
    if (!m->full || n < l->heaves.first || n > l->heaves.last)
        return (struct shortening){0.0, 0.0};
    const double *p = l->z, *v = l->z + m->size;
    struct kernel_mat mat = m->tilt_ft ? kernel_tilted_mat(m, p, v, n, 1.0 / m->length_ft)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
    return (struct shortening){m->half_ft * (l->rest_cos[n] - mat.c), m->half_ft * mat.w * mat.s};
}

/* The rate that a joint's damper has, when the joint was open a step ago: what of the step it was
 * closed for has moved it, not the whole step. Else the damper brakes what lies before its slack,
 * by the same amount at every step that is longer than that. */
LAW_INLINE double damped_rate_ft_s(double g_ft, double rate_ft_s, double slack_ft, double step_s)
{
    double over_ft = g_ft < 0.0 ? g_ft : fmax(0.0, g_ft - slack_ft);
    bool closing = over_ft * rate_ft_s > 0.0;
    return closing && fabs(over_ft) < fabs(rate_ft_s) * step_s ? over_ft / step_s : rate_ft_s;
}

LAW_INLINE void stretch(struct planar_engine *l, enum joint_law law)
{
    const struct model *m = &l->model;
    const double *p = l->z, *v = l->z + m->size;
    const struct joint joint = {m->kl, m->cl, l->slack_ft};
    struct shortening left, right = shortening_of(l, l->slides.first - 1);
    for (int j = l->slides.first; j <= l->slides.last + 1; j++) {
        left = right; /* also past an end that pulls nothing */
        right = shortening_of(l, j);
        if ((j == 0 && m->left_free) || (j == m->mats && m->right_free)) {
            l->tension_lb[j] = 0.0;
            continue;
        }
        double u_l = j > 0 ? p[2 * j - 1] : 0.0, u_r = j < m->mats ? p[2 * j + 1] : 0.0;
        double v_l = j > 0 ? v[2 * j - 1] : 0.0, v_r = j < m->mats ? v[2 * j + 1] : 0.0;
        double g = l->gap0_ft[j] + (u_r - u_l) + left.ft + right.ft,
               rate = v_r - v_l + left.ft_s + right.ft_s;
        if (law == JOINT_SLACK && l->closing_step_s > 0.0)
            rate = damped_rate_ft_s(g, rate, l->slack_ft, l->closing_step_s);
        struct joint_grit grit = {l->hold_lb[j], l->give_ft[j], l->reach_ft[j]};
        struct joint_pull pulled = joint_pull_one(law, &joint, g, joint.cl_lb_s_ft * rate, grit);
        double t_lb = pulled.lb;
        if (l->mods && mods_is_torn(l->mods, j + 1))
            t_lb = fmin(0.0, t_lb);
        if (law == JOINT_GRIT)
            l->reach_ft[j] = pulled.reach_ft;
        l->tension_lb[j] = t_lb;
        l->pull_lb[j] = t_lb > l->pull_lb[j] ? t_lb : l->pull_lb[j];
        l->push_lb[j] = -t_lb > l->push_lb[j] ? -t_lb : l->push_lb[j];
    }
}

/* Every law that occurs gets a loop of its own. */
void engine_stretch_joints(struct planar_engine *l)
{
    if (l->joints == JOINT_LINEAR)
        stretch(l, JOINT_LINEAR);
    else if (l->joints == JOINT_SLACK)
        stretch(l, JOINT_SLACK);
    else
        stretch(l, JOINT_GRIT);
    if (l->mods && l->mods->jointed) {
        struct mods_view view = engine_view(l);
        mods_pull_joints(l->mods, &view, l->slides.first + 1, l->slides.last + 2);
    }
}

/* ---- speeds ---- */

/* times that a step is taken again as the soil lets go of nodes or holds others */
#define MOST_CONTACTS 8

/* Bands and cleats before a kick; a riveted mat that its band moves is taken in. */
void engine_brace_slides(struct planar_engine *l, const struct sim_touch *touch, int count,
                         double h_s)
{
    struct mods *mods = l->mods;
    const struct model *m = &l->model;
    struct mods_view view = engine_view(l);
    if (mods->cleated) {
        mods_press_cleats(mods, touch, count);
        mods_wear_cleats(mods, &view, h_s, l->slides.first + 1, l->slides.last + 1);
    }
    if (!mods->banded)
        return;
    mods_pull_bands(mods, &view, touch, count);
    for (int c = 0; c < mods->braces; c++) {
        int n = mods->brace_mat[c] - 1;
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n] + mods->carried_lb[c];
        double limit_lb = m->law == SIM_NONE ? 0.0
                                             : m->weight_limit_lb + mods_cleat_lb(mods, n + 1);
        if ((n < l->slides.first || n > l->slides.last) && fabs(push_lb) > limit_lb)
            engine_take_in(&l->slides, m, n - 1, n + 1);
    }
}

/* The bands hold waves down, and stiffeners bend: forces on nodes and moments on joints of the
 * heaving part. */
static void engine_brace_heaves(struct planar_engine *l)
{
    const struct model *m = &l->model;
    struct mods_heave heave = {.z = l->z,
                               .tilt_ft = m->tilt_ft,
                               .ground_ft = l->scene->ground_ft.values,
                               .mats = m->mats,
                               .length_ft = m->length_ft,
                               .rest_y_ft = m->rest_y_ft,
                               .first = l->heaves.first,
                               .last = l->heaves.last,
                               .down_lb = l->brace_lb,
                               .moment_lb_ft = l->brace_lb_ft};
    mods_brace_heave(l->mods, &heave);
}

double engine_soil_lb(const struct model *m, const double *z, int node)
{
    return kernel_soil_lb(m, z, z + m->size, node);
}

/* What the soil pushes a node with while its mats are kicked, in a step in parts and in the one
 * after it. */
static double rubbing_lb(const struct planar_engine *l, int node)
{
    if (l->in_parts)
        return l->rub_lb[node];
    double now_lb = fmax(0.0, engine_soil_lb(&l->model, l->z, node));
    bool known = node >= l->rub_first && node <= l->rub_last;
    return known ? l->rub_next_lb[node] + l->rub_share * now_lb : now_lb;
}

/* What the soil holds a heaving mat with: the reaction that its nodes have just been kicked with,
 * dampers at the end of the step. A foot that lands faster than the step can follow so rubs with
 * the impulse it lands with. */
static double soil_limit_lb(const struct planar_engine *l, int n)
{
    const struct model *m = &l->model;
    const double *z = l->z;
    if (l->in_parts || l->rub_share < 1.0)
        return m->friction * (rubbing_lb(l, n) + rubbing_lb(l, n + 1));
    const double *v = z + m->size;
    return m->friction *
           (fmax(0.0, kernel_soil_lb(m, z, v, n)) + fmax(0.0, kernel_soil_lb(m, z, v, n + 1)));
}

/* A mat under the gear: the ground holds it, up to the Coulomb limit of its load beside its own. */
static void step_geared(struct planar_engine *l, int n, double thrust_lb, double limit_lb,
                        double h_s)
{
    const struct model *m = &l->model;
    const struct gear *gear = l->gear;
    double *v = &l->z[m->size + 2 * n + 1];
    bool grounded = n < l->heaves.first || n > l->heaves.last || m->contact[n] || m->contact[n + 1];
    struct element_step step = element_step(&gear->others, (struct element_mat){*v, grounded}, h_s,
                                            m->mass_slug);
    if (!m->soil_normal && m->law != SIM_NONE)
        limit_lb += m->friction * l->scene->wheel_load_lb * gear->share[n + 1];
    *v = gear_speed_ft_s(l->gear, n + 1, step.keep * *v, thrust_lb + step.push_lb, limit_lb,
                         step.as_if_s);
}

KERNEL_INLINE unsigned kick(struct planar_engine *l, const struct sim_touch *touch, int count,
                            double h_s, bool cleated, bool elements, bool geared)
{
    const struct model *m = &l->model;
    double *v = l->z + m->size, *thrust = l->u; /* spare until outputs are taken */
    unsigned stops = 0;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        thrust[n] = l->tension_lb[n + 1] - l->tension_lb[n];
    for (int i = 0; i < count; i++)
        thrust[touch[i].mat - 1] += touch[i].thrust_lb;
    for (int c = 0; l->mods && c < l->mods->braces; c++)
        /* those outside are not looked at */
        thrust[l->mods->brace_mat[c] - 1] += l->mods->carried_lb[c];
    for (int n = l->slides.first; n <= l->slides.last; n++) {
        double limit = m->weight_limit_lb;
        if (m->soil_normal && n >= l->heaves.first && n <= l->heaves.last)
            limit = soil_limit_lb(l, n);
        for (int i = 0; i < count && !m->soil_normal && m->wheel_load_lb > 0.0; i++) {
            if (touch[i].mat - 1 == n)
                limit += m->friction * m->wheel_load_lb * touch[i].load_share;
        }
        if (cleated)
            limit += mods_raised_cleat_lb(l->mods, n + 1, l->z[2 * n], l->z[2 * n + 2]);
        if (m->law == SIM_NONE)
            limit = 0.0;
        if (geared && l->gear->share[n + 1] > 0.0) {
            step_geared(l, n, thrust[n], limit, h_s);
        } else if (elements) {
            struct element_mat mat = {v[2 * n + 1], n < l->heaves.first || n > l->heaves.last ||
                                                        m->contact[n] || m->contact[n + 1]};
            struct element_step step = element_step(geared ? &l->gear->others : &m->elements, mat,
                                                    h_s, m->mass_slug);
            v[2 * n + 1] = friction_speed_ft_s(step.keep * mat.v_ft_s, thrust[n] + step.push_lb,
                                               limit, step.as_if_s, m->mass_slug, &stops);
        } else {
            v[2 * n + 1] = friction_speed_ft_s(v[2 * n + 1], thrust[n], limit, h_s, m->mass_slug,
                                               &stops);
        }
    }
    return stops;
}

static __attribute__((noinline)) unsigned kick_geared(struct planar_engine *l,
                                                      const struct sim_touch *touch, int count,
                                                      double h_s, bool cleated)
{
    model_ride(&l->model, l->gear->lead_mat - 1); /* whose waves are noted */
    if (l->gear->others.count > 0)
        return cleated ? kick(l, touch, count, h_s, true, true, true)
                       : kick(l, touch, count, h_s, false, true, true);
    return cleated ? kick(l, touch, count, h_s, true, false, true)
                   : kick(l, touch, count, h_s, false, false, true);
}

/* Runways without cleats get a loop without, and so do those without elements. */
unsigned engine_kick_slides(struct planar_engine *l, const struct sim_touch *touch, int count,
                            double h_s)
{
    bool cleated = l->mods && l->mods->cleated;
    if (l->model.elements.count > 0 && l->gear)
        return kick_geared(l, touch, count, h_s, cleated);
    if (l->model.elements.count > 0)
        return cleated ? kick(l, touch, count, h_s, true, true, false)
                       : kick(l, touch, count, h_s, false, true, false);
    return cleated ? kick(l, touch, count, h_s, true, false, false)
                   : kick(l, touch, count, h_s, false, false, false);
}

/* The soil pushes and never pulls, at the end of the step: let go of nodes that it would pull, hold
 * those that it would push. True when a node has changed. */
static bool settle_contacts(struct planar_engine *l, double h_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    bool changed = false;
    for (int j = m->first; j <= m->last + 1; j++) {
        double y_ft = l->z[2 * j];
        bool pushed = y_ft > 0.0 && m->kv * y_ft + m->cv * (v[2 * j] + h_s * l->accel[2 * j]) > 0.0;
        changed = changed || pushed != m->contact[j];
        m->contact[j] = pushed;
    }
    return changed;
}

double engine_kick_heaves(struct planar_engine *l, double h_s)
{
    const struct model *m = &l->model;
    double *v = l->z + m->size;
    consistent_heave(m, h_s, l->z, l->accel);
    for (int i = 0; i < MOST_CONTACTS && settle_contacts(l, h_s); i++)
        consistent_heave(m, h_s, l->z, l->accel);
    double jolt_ft_s = 0.0;
    for (int j = m->first; j <= m->last + 1; j++) {
        double change_ft_s = h_s * l->accel[2 * j];
        v[2 * j] += change_ft_s;
        if (m->contact[j] && fabs(change_ft_s) > jolt_ft_s)
            jolt_ft_s = fabs(change_ft_s);
    }
    return jolt_ft_s;
}

/* ---- gear ---- */

int engine_span(struct planar_engine *l, struct sim_wheel *wheel, double t0_s, double t1_s,
                struct sim_touch *touch)
{
    const struct model *m = &l->model;
    if (!l->gear)
        return sim_wheel_span(wheel, t0_s, t1_s, touch);
    int count = gear_span(l->gear, t0_s, t1_s, touch);
    for (int i = 0; i < l->gear->loaded_count && l->scene->wheel_load_lb > 0.0; i++) {
        int n = l->gear->loaded[i] - 1;
        engine_take_in(&l->heaves, m, n - m->tail, n + m->tail);
    }
    return count;
}

/* The gear's weight on the nodes of the heaving part, beside what modifications do. */
static void engine_load_heaves(struct planar_engine *l)
{
    const struct gear *gear = l->gear;
    if (l->mods && (l->mods->banded || l->mods->stiffened)) {
        engine_brace_heaves(l);
    } else {
        for (int j = l->heaves.first; j <= l->heaves.last + 1; j++)
            l->brace_lb[j] = 0.0;
    }
    for (int i = 0; i < gear->loaded_count; i++) {
        int n = gear->loaded[i] - 1;
        double half_lb = 0.5 * l->scene->wheel_load_lb * gear->share[n + 1];
        l->brace_lb[n] += half_lb;
        l->brace_lb[n + 1] += half_lb;
    }
}
